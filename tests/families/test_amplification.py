"""Systems that amplify small errors: a run that these spoil says so, and one that they do not spoil does not.

About a known way, p(t), the fields are linear; the rates are drawn. On each side of a surface the way is the same.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import core
from tests.families.oracles import silent
from tests.levels import deep_but

METHODS = ("rk4", "taylor", "rk8", "gauss4")


@cache
def _about_a_way(signs: tuple[int, int]) -> core.PiecewiseSystem:
    """Rates ±k along two directions about (cos t, sin t), turned by an angle; the surface is met on the way."""
    u, v = "(x - cos(t))", "(y - sin(t))"
    along, aside = f"(c*{u} + s*{v})", f"(c*{v} - s*{u})"
    first, second = (f"{'-' * (sign < 0)}k{k}*" for k, sign in enumerate(signs))
    law = (f"{first}{along}*c - {second}{aside}*s - sin(t)", f"{first}{along}*s + {second}{aside}*c + cos(t)")
    return core.PiecewiseSystem(
        "about a way", ("x", "y"), law, tuple(f"1*({one})" for one in law), "x - b",
        parameters={"k0": 1.0, "k1": 1.0, "c": 1.0, "s": 0.0, "b": 5.0}, x0=(1.0, 0.0),
    )  # fmt: skip


def _drawn(rng, signs):
    angle, b = rng.uniform(0, 2 * np.pi), float(rng.choice([5.0, rng.uniform(-0.8, 0.8)]))
    rates = {f"k{k}": float(10 ** rng.uniform(-0.5, 1.9)) for k in range(2)}
    return _about_a_way(signs).with_parameters(**rates, c=float(np.cos(angle)), s=float(np.sin(angle)), b=b)


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
@pytest.mark.parametrize("signs", [(1, 1), (1, -1)])
def test_a_run_that_small_errors_have_spoilt_says_so(draws, signs, method):
    spoilt = 0
    for rng in draws(12):
        system, end = _drawn(rng, signs), float(rng.uniform(1, 12))
        settings = {} if method == "taylor" else {"tau": float(10 ** rng.uniform(-3.0, -1.5))}
        run = core.integrate(system, (0.0, end), method=method, **settings)
        off = np.abs(run.x[-1] - (np.cos(run.t[-1]), np.sin(run.t[-1]))).max()
        assert off < 1.0 or not silent(run), f"off by {off:.1e}: {system.values}, {end}, {settings}"
        spoilt += off >= 1.0
    assert spoilt > 0


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
def test_where_small_errors_stay_small_nothing_is_said_of_them(draws, method):
    for rng in draws(12):
        system, end = _drawn(rng, (-1, -1)), float(rng.uniform(1, 12))
        settings = {} if method == "taylor" else {"tau": 0.005}
        run = core.integrate(system, (0.0, end), method=method, **settings)
        assert "errors grow" not in run.message, f"{run.message}: {system.values}, {end}"


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
@pytest.mark.parametrize(
    "key", ["harmonic_oscillator", "elliptic_curve", "kepler", "bouncing_ball", "stick_slip", "relay_feedback"]
)
def test_a_long_run_that_is_not_chaotic_is_not_said_to_be(key, method):
    settings = {} if method == "taylor" else {"tau": 0.01}
    run = core.integrate(key, (0.0, 300.0), method=method, sliding="continue", **settings)
    assert "errors grow" not in run.message
