"""Fields and surfaces with a feature that is narrow beside a step: seen, or warned of.

The runs have up to a hundred steps. Of longer ones some steps alone are looked
into, and what happens once may be missed.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from tests.families.oracles import silent

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
