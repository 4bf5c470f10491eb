"""A dip of a height between two places is found by bounds, and none is where there is none."""

import numpy as np
import pytest
import sympy

import core
from core.diagnostics.boxes import Way
from core.diagnostics.doubtful_steps import doubtful_steps
from core.diagnostics.narrow_features import dips_between
from core.symbolic.expressions import TIME

X, Y = sympy.symbols("x y")
SYMBOLS = (TIME, X, Y)


def circle(count, radius=1.0):
    """Places on a circle about the origin, in one step."""
    t = np.linspace(0.0, 6.0, count)[None]
    states = radius * np.stack([np.cos(t), np.sin(t)], axis=2)
    return Way(t, states, radius * np.stack([-np.sin(t), np.cos(t)], axis=2))


def dips(height, way):
    wanted = np.ones((1, way.times.shape[1] - 1), dtype=bool)
    dips = dips_between(height, SYMBOLS, way, np.empty(0), wanted)
    assert not (dips.found[0] and dips.none.any())
    return bool(dips.found[0]), bool(dips.none.all())


@pytest.mark.parametrize("width", 10.0 ** np.arange(-7, 0))
@pytest.mark.parametrize("along", [TIME, X, Y])
def test_a_pulse_is_found_that_is_much_narrower_than_the_distance_of_the_places(width, along):
    pulse, way = sympy.exp(-(((along - 0.4321) / width) ** 2)), circle(1000)
    assert dips(sympy.Rational(1, 2) - pulse, way) == (True, False)
    assert dips(sympy.Rational(3, 2) - pulse, way) == (False, True), "bounds tell that there is none"


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-7])
def test_a_way_beside_a_surface_that_its_chords_cut_does_not_dip(gap):
    found, none = dips(X**2 + Y**2 - 1, circle(60, 1.0 + gap))
    assert not found
    assert none == (gap > 1e-5), "or stays in doubt"
    assert dips(X**2 + Y**2 - 1, circle(60, 1.0 - 1e-5))[0]


def test_steps_in_doubt_are_those_that_bounds_do_not_clear():
    field, g = ("1", "0*x"), "1/2 - exp(-((x - pi)/w)**2)"
    system = core.PiecewiseSystem("pulse", ("x", "y"), field, field, g, parameters={"w": 1e-6}, x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 20.0), method="rk4", tau=0.01)
    assert doubtful_steps(run).tolist() == [314]
    assert not len(doubtful_steps(core.integrate(system, (0.0, 3.0), method="rk4", tau=0.01)))
    assert not len(doubtful_steps(core.integrate(system, (0.0, 20.0), method="rk4", tau=0.01, record="end")))
