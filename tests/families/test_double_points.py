"""Slides to where g = 0 crosses itself: there the surface ceases to attract, and solutions leave it to both sides."""

from __future__ import annotations

from functools import cache

import pytest

import core
from tests.families.oracles import silent

METHODS = ("rk2", "rk4", "rk8", "gauss4", "taylor")


@cache
def _crossing_itself(g: str) -> core.PiecewiseSystem:
    """The y axis attracts for y < 0 and repels for y > 0."""
    return core.PiecewiseSystem(
        "double point", ("x", "y"), ("-a + c*cos(y)", "b"), ("a + c*cos(y)", "b + 0.1*x"), g,
        parameters={"a": 1.0, "b": 1.0, "c": 0.1}, x0=(0.1, -1.0),
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("g", ["x*y", "sin(x)*sin(y)", "x*(exp(y) - 1)"])
def test_no_slide_goes_on_beyond_a_double_point_in_silence(draws, g, method):
    slid = 0
    for rng in draws(20):
        a, b, c = rng.uniform(0.3, 2.0), rng.uniform(0.3, 2.0), rng.uniform(-0.15, 0.15)
        start = float(rng.uniform(-0.3, 0.3)), -float(rng.uniform(0.3, 2.0))
        system = _crossing_itself(g).with_parameters(a=float(a), b=float(b), c=float(c))
        settings = {} if method == "taylor" else {"tau": float(10 ** rng.uniform(-3, -1))}
        run = core.integrate(system, (0.0, 8.0), start, method=method, sliding="continue", **settings)
        if not len(run.crossings) or run.crossings.kind[0] != "sliding":  # it has passed y = 0 beside the y axis
            continue
        slid += 1
        # It may end before that place, where it says so, and not beyond.
        assert not silent(run), f"{system.values}, {start}, {settings}: {run.message}"
        assert run.x[-1, 1] < 1e-3, f"{system.values}, {start}, {settings}: {run.message}"
    assert slid > 10
