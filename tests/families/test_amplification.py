"""Systems that amplify small errors: a run that these spoil says so, and one that they do not spoil does not.

The fields are linear about known ways, with rates that are drawn, or chaotic; then two runs are compared.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import core
from tests.families.oracles import silent
from tests.levels import deep_but

METHODS = ("rk4", "taylor", "rk8", "gauss4")


def _settings(method, tau):
    return {} if method == "taylor" else {"tau": float(tau)}


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
        run = core.integrate(system, (0.0, end), method=method, **_settings(method, 10 ** rng.uniform(-3.0, -1.5)))
        off = np.abs(run.x[-1] - (np.cos(run.t[-1]), np.sin(run.t[-1]))).max()
        assert off < 1.0 or not silent(run), f"off by {off:.1e}: {system.values}, {end}, {run.tau}"
        spoilt += off >= 1.0
    assert spoilt > 0


@cache
def _swinging() -> core.PiecewiseSystem:
    law = ("a*cos(t)*(x - 2 - cos(3*t)) - 3*sin(3*t)",)
    return core.PiecewiseSystem("swinging", ("x",), law, law, "x - 5", parameters={"a": 1.0}, x0=(3.0,))


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
def test_errors_that_decay_first_and_then_grow_are_told(draws, method):
    for rng in draws(20):
        system, end = _swinging().with_parameters(a=float(rng.uniform(-40, 40))), float(rng.uniform(1, 20))
        run = core.integrate(system, (0.0, end), method=method, **_settings(method, 10 ** rng.uniform(-3.5, -1.7)))
        off = float(np.abs(run.x[-1, 0] - 2 - np.cos(3 * run.t[-1])))
        assert off < 1.0 or not silent(run), f"off by {off:.1e}: {system.values}, {end}, {run.tau}"


@cache
def _sliding() -> core.PiecewiseSystem:
    along = "k*(x - cos(t)) - sin(t)"
    return core.PiecewiseSystem(
        "sliding", ("x", "y"), (along, "1"), (f"1*({along})", "-1"), "y", parameters={"k": 1.0}, x0=(1.0, -0.1)
    )


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
def test_errors_that_grow_while_a_run_slides_or_goes_back_in_time_are_told(draws, method, way):
    for rng in draws(12):
        system, end = _sliding().with_parameters(k=way * float(10 ** rng.uniform(-0.3, 1.7))), float(rng.uniform(1, 12))
        start, options = (1.0, -0.1 if way > 0 else 50.0), _settings(method, 10 ** rng.uniform(-3.0, -1.7))
        run = core.integrate(system, (0.0, way * end), start, method=method, sliding="continue", **options)
        off = abs(float(run.x[-1, 0]) - np.cos(run.t[-1]))
        assert off < 1.0 or not silent(run), f"off by {off:.1e}: {system.values}, {end}, {options}"


@cache
def _in_step() -> core.PiecewiseSystem:
    """Two variables that begin alike, and whose difference grows: only rounding breaks the symmetry."""
    u, v = "(x - sin(t))", "(y - sin(t))"
    law = (f"p*{u} + q*{v} + cos(t)", f"q*{u} + p*{v} + cos(t)", "1")
    return core.PiecewiseSystem(
        "in step", ("x", "y", "z"), law, law, "z - 1.5", parameters={"p": 1.0, "q": 1.0}, x0=(0.0, 0.0, 0.0)
    )


@pytest.mark.parametrize("method", deep_but(("gauss4", "taylor"), METHODS))
def test_a_symmetry_that_rounding_breaks_is_told(draws, method):
    for rng in draws(40):
        p, q, end = float(rng.uniform(-8, 4)), float(rng.uniform(-8, 4)), float(rng.uniform(1, 15))
        options = _settings(method, 10 ** rng.uniform(-3.0, -1.8))
        run = core.integrate(_in_step().with_parameters(p=p, q=q), (0.0, end), method=method, **options)
        off = np.abs(run.x[-1, :2] - np.sin(run.t[-1])).max()
        assert off < 1.0 or not silent(run), f"off by {off:.1e}: {p}, {q}, {end}, {options}"


@cache
def _logistic() -> core.PiecewiseSystem:
    """The logistic map, applied whenever the other variable has come to 1."""
    way = ("1", "0")
    return core.PiecewiseSystem(
        "logistic", ("x", "y"), way, way, "x - 1", jump=("0", "r*y*(1 - y)"), parameters={"r": 4.0}, x0=(0.0, 0.3)
    )


def _most_amplified(r: float, y: float, count: int) -> float:
    """Power of ten by which a change of some iterate has been amplified in a later one, at most."""
    most = power = 0.0
    for _ in range(count):
        power = max(0.0, power + math.log10(abs(r * (1.0 - 2.0 * y)) or 1e-300))
        most, y = max(most, power), r * y * (1.0 - y)
    return most


@pytest.mark.parametrize("record", ["steps", "end"])
@pytest.mark.parametrize("method", deep_but(("taylor",), ("taylor", "rk8")))
def test_chaos_by_jumps_is_told_and_a_cycle_is_not(draws, method, record):
    for rng in draws(12):
        count, y, r = int(rng.integers(80, 400)), float(rng.uniform(0.1, 0.9)), float(rng.uniform(3.1, 4.0))
        run = core.integrate(_logistic().with_parameters(r=r), (0.0, count + 0.5), (0.0, y), 0.1, method, record=record)
        power, told = _most_amplified(r, y, count), "errors grow" in run.message
        assert told or power < 17, f"{run.message}: {r}, {y}, {count}, {power}"
        assert not told or power > 13, f"{run.message}: {r}, {y}, {count}, {power}"


_LORENZ = ("10*((y - c) - (x - c))", "(x - c)*(28 - (z - c)) - (y - c)", "(x - c)*(y - c) - 8/3*(z - c)")


@cache
def _lorenz() -> core.PiecewiseSystem:
    return core.PiecewiseSystem(
        "Lorenz", ("x", "y", "z"), _LORENZ, tuple(f"1*({f})" for f in _LORENZ), "x - c", parameters={"c": 0.0}
    )


@pytest.mark.parametrize("method", deep_but(("taylor",), ("taylor", "rk8")))
def test_of_two_runs_of_a_chaotic_system_that_differ_one_says_so(draws, method):
    for rng in draws(8):
        c = float(rng.choice([0.0, 10 ** rng.uniform(2, 9)]))
        start, end = c + rng.uniform(1, 20, 3), float(rng.uniform(10, 60))
        settings = ({"tau": 0.002}, {"tau": 0.0031}) if method == "rk8" else ({}, {"tolerance": 1e-13})
        runs = [
            core.integrate(_lorenz().with_parameters(c=c), (0.0, end), tuple(start.tolist()), method=method, **one)
            for one in settings
        ]
        apart = np.abs(runs[0].x[-1] - runs[1].x[-1]).max()
        assert apart < 12.0 or not all(map(silent, runs)), f"{apart:.2g} apart: {c}, {start}, {end}"
        if c == 0.0 and end < 18.0:
            assert "errors grow" not in runs[0].message


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
def test_where_small_errors_stay_small_nothing_is_said_of_them(draws, method):
    for rng in draws(12):
        system, end = _drawn(rng, (-1, -1)), float(rng.uniform(1, 12))
        run = core.integrate(system, (0.0, end), method=method, **_settings(method, 0.005))
        assert "errors grow" not in run.message, f"{run.message}: {system.values}, {end}"


ORDERLY = ("harmonic_oscillator", "elliptic_curve", "kepler", "bouncing_ball", "stick_slip", "relay_feedback")


@pytest.mark.parametrize("method", deep_but(METHODS[:2], METHODS))
@pytest.mark.parametrize("key", ORDERLY)
def test_a_long_run_that_is_not_chaotic_is_not_said_to_be(key, method):
    run = core.integrate(key, (0.0, 300.0), method=method, sliding="continue", **_settings(method, 0.01))
    assert "errors grow" not in run.message
