"""Whether steps are short enough for the field is told truly, beside crossings that are perturbed, too."""

import numpy as np
import pytest

import core

FIXED = [name for name, method in core.METHODS.items() if not method.adaptive]


@pytest.mark.parametrize("method", ["dmm2", "rk4", "gauss4"])
@pytest.mark.parametrize(("key", "end"), [("harmonic_oscillator", 80.0), ("harmonic_oscillator", -80.0)])
def test_steps_to_perturbed_crossings_which_overlap_with_those_behind_are_not_called_too_long(key, end, method):
    for tau in (0.01, 0.02, 0.05):
        run = core.integrate(core.CATALOGUE[key], (0.0, end), tau=tau, method=method, perturbation_order=1)
        assert len(run.crossings) > 20
        assert "too long" not in run.message, run.message


@pytest.mark.parametrize("seed", range(24))
def test_a_perturbation_of_the_crossings_alone_makes_no_step_too_long_for_the_field(seed):
    draw = np.random.default_rng(seed)
    system = core.CATALOGUE[("harmonic_oscillator", "damped_oscillator", "diode_circuit", "two_walls")[seed % 4]]
    options = {"tau": 10 ** draw.uniform(-2.5, -1.0), "method": FIXED[seed % len(FIXED)]}
    end, scale = draw.choice([20.0, -20.0]), draw.choice([1.0, -1.0])
    plain = core.integrate(system, (0.0, end), **options)
    for order in (0.5, 1, 2):
        run = core.integrate(system, (0.0, end), perturbation_order=order, perturbation_scale=scale, **options)
        assert "too long for this field" in plain.message or "too long for this field" not in run.message, run.message


@pytest.mark.parametrize("key", ["gene_ring", "henon_heiles"])
def test_a_step_that_ends_beyond_the_surface_by_a_perturbation_is_not_called_too_long_for_the_surface(key):
    options = {"tau": 0.1376, "method": "gauss4"}
    plain = core.integrate(core.CATALOGUE[key], (0.0, 40.0), **options)
    run = core.integrate(core.CATALOGUE[key], (0.0, 40.0), perturbation_order=1, **options)
    assert "too long" not in plain.message
    assert "too long" not in run.message, run.message


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_push_that_the_rest_of_a_step_after_the_last_crossing_meets_or_leaps_over_is_told(method: str) -> None:
    pushed = ("v", "0.5 + 221.68*exp(-100000*(x - 0.38)**2)")
    system = core.PiecewiseSystem("Pushed", ("x", "v"), pushed, pushed, "x - 0.3", x0=(-0.966, 0.297))
    run = core.integrate(system, (0.0, 4.5), method=method, tau=0.5)
    assert run.crossing_count == 1
    assert abs(run.x[-1, 1] - 3.329) > 0.3, "by SciPy's DOP853 with steps up to 1e-5"
    assert "too long" in run.warning
