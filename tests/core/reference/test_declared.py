"""reference_solution(): the right oracle for a declared system."""

import numpy as np
import pytest

import core


def test_the_papers_systems_have_exact_solutions():
    t, x = core.reference_solution(core.CATALOGUE["elliptic_curve"]).crossing(30)
    assert t == pytest.approx(28.125879443188465221, abs=2e-14)
    assert x == pytest.approx([-0.44504186791262880858, -0.89550976309855955276], abs=4e-15) or x == pytest.approx(
        [-0.44504186791262880858, 0.89550976309855955276], abs=4e-15
    )
    t, _ = core.reference_solution(core.CATALOGUE["harmonic_oscillator"]).crossing(3)
    assert t == pytest.approx(np.pi / 4 + np.pi / np.sqrt(3) + np.pi, rel=4e-16)


def test_parameter_values_are_those_of_the_system():
    system = core.CATALOGUE["harmonic_oscillator"].with_parameters(omega2_plus=4.0)
    t, _ = core.reference_solution(system, (1.0, 0.5)).crossing(1)
    # x = cos 2t + sin 2t / 4: y vanishes where tan 2t = 1/4
    assert t == pytest.approx(np.arctan2(0.25, 1.0) / 2, rel=1e-15)


def test_others_are_integrated_by_scipy_and_say_so():
    system = core.PiecewiseSystem("forced", ("x", "y"), ("y", "-x + sin(t)"), ("y", "-x"), "x", x0=(1.0, 0.1))
    solution = core.reference_solution(system)
    assert "SciPy" in solution.name
    assert np.isfinite(solution.state(5.0)).all()


def test_systems_that_jump_have_none():
    system = core.PiecewiseSystem("ball", ("y", "v"), ("v", "-1"), ("v", "-1"), "y", x0=(1, 0), jump=("0", "-v"))
    with pytest.raises(ValueError, match="jumps"):
        core.reference_solution(system)
