"""Fields and surfaces with a feature that is narrow beside a step: seen, or warned of.

Of a run that does not record its steps some alone are looked into, and what
happens once may be missed.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import erf

import core
from tests.families.oracles import silent
from tests.levels import QUICK_METHODS, deep_but

_END = 5.0

#: What acts on a point that passes x = c, of width b and strength a: text, and the same in numpy.
FORCES = {
    "wall": ("a*tanh((x - c)/b)", lambda x, a, b, c: a * np.tanh((x - c) / b)),
    "bump": ("a*exp(-((x - c)/b)**2)", lambda x, a, b, c: a * np.exp(-(((x - c) / b) ** 2))),
    "barrier": ("a*(x - c)/b*exp(-((x - c)/b)**2)", lambda x, a, b, c: a * (x - c) / b * np.exp(-(((x - c) / b) ** 2))),
    "pole": ("a/(1 + ((x - c)/b)**2)", lambda x, a, b, c: a / (1 + ((x - c) / b) ** 2)),
}
#: What changes sign beside x = c, at a width b.
HEIGHTS = {
    "spike": ("x - 5 + a*exp(-((x - c)/b)**2)", lambda x, a, b, c: x - 5 + a * np.exp(-(((x - c) / b) ** 2))),
    "pole": ("x - 5 + a/(1 + ((x - c)/b)**2)", lambda x, a, b, c: x - 5 + a / (1 + ((x - c) / b) ** 2)),
}


@cache
def _pushed(kind: str) -> core.PiecewiseSystem:
    field = ("v", FORCES[kind][0] + " - s*v")  # friction: no ψ would show what was missed
    return core.PiecewiseSystem(
        "pushed", ("x", "v"), field, field, "x - 40", parameters={"a": 1.0, "b": 0.5, "c": 2.0, "s": 0.1}, x0=(0.0, 1.0)
    )


@cache
def _passing(kind: str) -> core.PiecewiseSystem:
    return core.PiecewiseSystem(
        "passing", ("x", "v"), ("v", "0*x"), ("v", "0*x"), HEIGHTS[kind][0],
        parameters={"a": 6.0, "b": 0.5, "c": 2.0}, x0=(0.0, 1.0),
    )  # fmt: skip


def _pushed_to(kind: str, a: float, b: float, c: float, s: float) -> np.ndarray:
    """Where SciPy's DOP853 takes the point, by steps of a fifth of the width."""
    field = lambda t, y: (y[1], FORCES[kind][1](y[0], a, b, c) - s * y[1])  # noqa: E731
    return solve_ivp(field, (0.0, _END), (0.0, 1.0), "DOP853", rtol=1e-12, atol=1e-12, max_step=0.2 * b).y[:, -1]


def _settings(method: str, width: float) -> dict[str, float]:
    return {} if method == "taylor" else {"tau": 4.0 * width}


@pytest.mark.parametrize("method", ["taylor", "rk4", "rk8"])
@pytest.mark.parametrize("kind", FORCES)
def test_a_force_that_acts_within_a_step_is_felt_or_warned_of(draws, kind, method):
    for rng in draws(4):
        p = {"a": rng.normal(), "b": 10 ** rng.uniform(-1.8, 0.0), "c": rng.uniform(1, 3), "s": rng.uniform(0, 0.2)}
        p["a"] *= 0.2 / min(p["b"], 0.3)  # a push that matters however short
        system = _pushed(kind).with_parameters(**{n: float(v) for n, v in p.items()})
        right, *others = (_pushed_to(kind, **p | {"a": a * p["a"]}) for a in (1.0, 0.9, 1.1))
        run = core.integrate(system, (0.0, _END), method=method, **_settings(method, p["b"]))
        # A step that gives no warning is right to a tenth of what the force does: so is what comes of it.
        spread = max(np.abs(other - right).max() for other in others)
        off, allowed = np.abs(run.x[-1] - right).max(), 1e-6 if method == "taylor" else 0.3 + 3 * spread
        assert off <= allowed * (1 + np.abs(right).max()) or not silent(run), f"off by {off}: {system.values}, {right}"


@cache
def _beside_a_pole(wall: float) -> core.PiecewiseSystem:
    return core.PiecewiseSystem(
        "beside a pole", ("x", "y"), ("1/((x - a)**2 + b**2)", "-100*y + s"), ("1", "0"), f"x - {wall}",
        parameters={"a": 1.0, "b": 0.1, "s": 0.0}, x0=(0.0, 1.0),
    )  # fmt: skip


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS[1:3], ("rk2", "rk4", "rk8", "gauss4", "prk8")))
def test_one_step_of_many_that_leaps_over_a_fast_stretch_is_warned_of(draws, method):
    for rng in draws(12):
        p = {"a": rng.uniform(0.5, 2.0), "b": 10 ** rng.uniform(-3, -0.5), "s": rng.uniform(-1, 1)}
        system = _beside_a_pole(float(rng.choice([5.0, 50.0, 1e9]))).with_parameters(
            **{n: float(v) for n, v in p.items()}
        )
        way, end = lambda x, p=p: (x - p["a"]) ** 3 / 3 + p["b"] ** 2 * (x - p["a"]), rng.uniform(3, 5)
        right = brentq(lambda x, way=way, end=end: way(x) - way(0.0) - end, 0.0, 10.0, xtol=1e-13)
        run = core.integrate(system, (0.0, end), method=method, tau=float(10 ** rng.uniform(-3.3, -1.7)))
        assert abs(run.x[-1, 0] - right) < 0.1 * right or not silent(run), f"{run.x[-1]}, not {right}: {p}, {run.tau}"


@pytest.mark.parametrize("method", ["taylor", "rk4"])
@pytest.mark.parametrize("kind", HEIGHTS)
def test_a_surface_that_is_met_within_a_step_is_seen_or_warned_of(draws, kind, method):
    for rng in draws(6):
        p = {"a": rng.uniform(2, 8), "b": 10 ** rng.uniform(-1.8, -0.5), "c": rng.uniform(1, 3)}
        system = _passing(kind).with_parameters(**{n: float(v) for n, v in p.items()})
        x = np.linspace(0.0, 6.0, 60001)
        crossings = int(np.abs(np.diff(HEIGHTS[kind][1](x, **p) > 0.0)).sum())
        run = core.integrate(system, (0.0, 6.0), method=method, **_settings(method, p["b"]))
        assert len(run.crossings) == crossings or not silent(run), f"{len(run.crossings)} of {crossings}: {p}"


#: A point that moves ever slower, x = 3 sin t: its cubic between two places is not the way itself.
_SLOWING = ("v", "-x")


def _met(kind: str, p: dict[str, float], end: float) -> int:
    """How often a point that moves from x = 0 to `end` meets a surface, at places as dense as it is narrow."""
    near = p["c"] + p["b"] * np.sinh(np.linspace(-20.0, 20.0, 40001))
    x = np.sort(np.concatenate([np.linspace(0.0, end, 10001), near[(near > 0.0) & (near < end)]]))
    return int(np.abs(np.diff(HEIGHTS[kind][1](x, **p) > 0.0)).sum())


@pytest.mark.parametrize("method", deep_but(("taylor", "rk4"), ("taylor", "dmm2", "rk2", "rk4", "rk8", "gauss4")))
@pytest.mark.parametrize("kind", HEIGHTS)
@pytest.mark.parametrize("what", ["surface", "moving surface", "event"])
def test_what_is_narrower_than_the_distance_of_all_places_is_seen_or_warned_of(draws, kind, method, what):
    for rng in draws(6):
        p = {"a": rng.uniform(2, 8), "b": 10 ** rng.uniform(-7.0, -1.0), "c": rng.uniform(0.5, 1.4)}
        height = HEIGHTS[kind][0]
        if what == "moving surface":
            field, met = ("1", "0*x"), _met(kind, p, 1.5)
            height = height.replace("(x - c)", "(t - c)").replace("x - 5", "t - 5 + v - 3")
        else:
            p["c"] *= 2.0
            field, met = _SLOWING, _met(kind, p, 3.0 * np.sin(1.5))
        g, events = ("x - 40", (height,)) if what == "event" else (height, ())
        system = core.PiecewiseSystem(
            "narrow", ("x", "v"), field, field, g, parameters={n: float(v) for n, v in p.items()}, x0=(0.0, 3.0)
        )
        settings = {} if method == "taylor" else {"tau": float(10 ** rng.uniform(-2.0, -0.7))}
        run = core.integrate(system, (0.0, 1.5), method=method, events=events, **settings)
        found = len(run.events.t) if what == "event" else len(run.crossings)
        assert found == met or not silent(run), f"{found} of {met}: {p}, {settings}"


#: A push of one, as a function of z = (x − c)/b or (t − c)/b: its text, to be divided by b, and what is past at z.
PUSHES = {
    "normal": ("exp(-({z})**2)/sqrt(pi)", lambda z: 0.5 * (1.0 + erf(z))),
    "pole": ("1/(pi*(1 + ({z})**2))", lambda z: 0.5 + np.arctan(z) / np.pi),
    "wall": ("(1 - tanh({z})**2)/2", lambda z: 0.5 * (1.0 + np.tanh(z))),
}


@pytest.mark.parametrize("method", deep_but(("taylor", "rk4"), ("taylor", "rk2", "rk4", "rk8", "gauss4")))
@pytest.mark.parametrize("kind", PUSHES)
def test_a_push_that_is_narrower_than_the_distance_of_all_places_is_felt_or_warned_of(draws, kind, method):
    text, past = PUSHES[kind]
    for rng in draws(6):
        b, c, k = 10 ** rng.uniform(-7.0, -1.5), rng.uniform(0.4, 1.2), float(rng.choice([-1.0, 0.3, 1.0]))
        along, drift = str(rng.choice(["x", "t"])), float(rng.choice([0.0, 1.0]))
        push = f"{drift}*cos(x) + k/b*{text.format(z=f'({along} - c)/b')}"
        system = core.PiecewiseSystem(
            "kicked", ("x", "y"), ("1", push), ("1", push), "x - 40",
            parameters={"k": k, "b": float(b), "c": float(c)}, x0=(0.0, 0.0),
        )  # fmt: skip
        settings = {} if method == "taylor" else {"tau": float(10 ** rng.uniform(-2.2, -0.8))}
        run = core.integrate(system, (0.0, 1.5), method=method, **settings)
        right = drift * np.sin(1.5) + k * (past((1.5 - c) / b) - past(-c / b))
        off, allowed = abs(run.x[-1, 1] - right), 1e-6 if method == "taylor" else 0.1
        assert off < allowed or not silent(run), f"off by {off}: {system.values}, {along}, {drift}, {settings}"


@pytest.mark.parametrize("shape", ["cos(t)", "x"])
def test_a_symmetric_method_that_damps_nothing_is_warned_of_where_the_solution_decays_at_once(draws, shape):
    right, drift = (np.cos, "-sin(t)") if shape == "cos(t)" else (lambda t: t, "1")
    for rng in draws(6):
        k, tau = 10 ** rng.uniform(2.0, 13.0), float(10 ** rng.uniform(-2.5, -1.3))
        field = ("1", f"-k*(y - {shape}) + {drift}")
        system = core.PiecewiseSystem(
            "stiff", ("x", "y"), field, field, "x - 9", parameters={"k": float(k)}, x0=(0.0, 2.0)
        )
        run = core.integrate(system, (0.0, 2.0), method="gauss4", tau=tau)
        assert abs(run.x[-1, 1] - right(2.0)) < 1e-2 or not silent(run), f"{run.x[-1]}: {k}, {tau}"
