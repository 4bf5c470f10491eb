"""Surfaces that are met at a root of odd order, or nearly so, written so that their terms cancel.

Where rounding of g decides when such a surface is met, a run says so; the exact time is known.
"""

from __future__ import annotations

import math

import pytest

import core
from tests.families.oracles import silent
from tests.levels import deep_but

#: Functions of u = x - c whose only root is 0, of order 3 or 5 but for a slope s; a factor multiplies all terms.
SLOW = {
    "expanded": "a*(x**3 - 3*c*x**2 + 3*c**2*x - c**3 + s*(x - c))",
    "exponential": "a*(exp(x - c) - 1 - (x - c) - (x - c)**2/2 + s*(x - c))",
    "sine": "a*((x - c) - sin(x - c) + s*(x - c))",
    "logarithm": "a*(log(1 + (x - c)**2)*(x - c) + s*(x - c))",
    "fifth": "a*(sin(x - c) - (x - c) + (x - c)**3/6 + s*(x - c))",
    "plain": "a*((x - c)**3 + s*(x - c))",
}


def _system(kind, p):
    return core.PiecewiseSystem("slow", ("x",), ("v",), ("2*v",), SLOW[kind], parameters=p | {"v": 1.0}, x0=(0.0,))


@pytest.mark.parametrize("method", deep_but(("taylor", "rk4"), ("taylor", "rk4", "gauss4")))
@pytest.mark.parametrize("kind", SLOW)
def test_a_crossing_whose_time_rounding_decides_is_told(draws, kind, method):
    for rng in draws(12):
        s = float(rng.choice([0.0, 10 ** rng.uniform(-12, 0)]))
        p = {"a": float(10 ** rng.uniform(-3, 3) * rng.choice([-1, 1])), "c": float(rng.uniform(0.5, 1.5)), "s": s}
        run = core.integrate(_system(kind, p), (0.0, 2.0), method=method, tau=0.1)
        before, after = (1.0, 2.0) if p["a"] > 0 else (2.0, 1.0)
        exact = p["c"] + after * (2.0 - p["c"] / before)
        off = abs(float(run.x[-1, 0]) - exact)
        assert off < 1e-7 or not silent(run), f"off by {off:.1e}: {SLOW[kind]}, {p}, {run.crossings.t}"


@pytest.mark.parametrize("kind", SLOW)
def test_a_crossing_that_rounding_does_not_move_is_not_said_to_be_slow(draws, kind):
    for rng in draws(12):
        p = {"a": float(10 ** rng.uniform(-3, 3)), "c": float(rng.uniform(0.5, 1.5)), "s": float(rng.uniform(0.1, 2))}
        run = core.integrate(_system(kind, p), (0.0, 2.0), method="rk4", tau=0.01)
        assert "met slowly" not in run.message, f"{run.message}: {p}"


@pytest.mark.parametrize("method", deep_but(("taylor", "rk4"), ("taylor", "rk4", "rk8")))
def test_a_surface_that_the_state_relaxes_to_is_met_in_time_or_told(draws, method):
    law = ("k*(1 - x)",)
    system = core.PiecewiseSystem("relaxing", ("x",), law, law, "x - c", parameters={"k": 1.0, "c": 0.5}, x0=(0.0,))
    for rng in draws(12):
        k, c = float(rng.uniform(0.5, 2.0)), 1.0 - float(10 ** rng.uniform(-15.5, -1.0))
        run = core.integrate(system.with_parameters(k=k, c=c), (0.0, 80.0), method=method, tau=0.02)
        exact = -math.log1p(-c) / k
        off = abs(float(run.crossings.t[0]) - exact) if len(run.crossings) else math.inf
        assert off < 1e-5 * exact or not silent(run), f"off by {off:.1e}: k = {k}, 1 - c = {1 - c}"
