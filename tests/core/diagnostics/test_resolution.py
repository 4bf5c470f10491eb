"""Whether steps are short enough for the field is told truly, beside crossings that are perturbed, too."""

import pytest

import core


@pytest.mark.parametrize("method", ["dmm2", "rk4", "gauss4"])
@pytest.mark.parametrize(("key", "end"), [("harmonic_oscillator", 80.0), ("harmonic_oscillator", -80.0)])
def test_steps_to_perturbed_crossings_which_overlap_with_those_behind_are_not_called_too_long(key, end, method):
    for tau in (0.01, 0.02, 0.05):
        run = core.integrate(core.CATALOGUE[key], (0.0, end), tau=tau, method=method, perturbation_order=1)
        assert len(run.crossings) > 20
        assert "too long" not in run.message, run.message


def test_a_step_that_a_perturbation_has_made_too_long_is_named_with_its_length():
    run = core.integrate(core.CATALOGUE["harmonic_oscillator"], (0.0, 80.0), tau=0.2, perturbation_order=1)
    assert "A step of 0.4 is too long for this field" in run.message
