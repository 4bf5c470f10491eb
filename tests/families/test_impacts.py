"""Impacts: on tables that move, wavy floors and round walls, with every bounce where the exact motion has it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

import core
from core import Status
from tests.families.oracles import Array, Hybrid, Real, contradiction, mistake, trusted
from tests.levels import deep_but

_TABLE = " + ".join(f"a{k}*sin(w{k}*t + p{k})" for k in range(3))
_SPEED = " + ".join(f"a{k}*w{k}*cos(w{k}*t + p{k})" for k in range(3))
_HARMONICS = [f"{stem}{k}" for k in range(3) for stem in "awp"]
_FALL, _ENERGY = ("v", "-gravity"), ("v**2/2 + gravity*y",)
_STEP = 0.01


@dataclass(frozen=True)
class Case:
    """Numbers for one run, and its exact motion."""

    system: core.PiecewiseSystem
    exact: Hybrid
    x0: tuple[float, ...]
    t0: float
    span: float


def _system(
    name: str, f: tuple[str, ...], g: str, psi: tuple[str, ...], jump: tuple[str, ...], names: list[str]
) -> Any:
    variables = ("y", "v") if len(f) == 2 else ("x", "y", "u", "v")
    return core.PiecewiseSystem(name, variables, f, f, g, psi, psi, dict.fromkeys(names, 1.0), jump=jump)


def _real(**values: float) -> dict[str, Any]:
    return {name: Real(float(v)) for name, v in values.items()}


def _harmonics(rng: np.random.Generator, top: float = 8.0) -> dict[str, float]:
    """Up to three harmonics of a table, the accelerations of which do not exceed a few times gravity."""
    count, values = rng.integers(1, 4), {}
    for k in range(3):
        w = np.exp(rng.uniform(np.log(0.3), np.log(top)))
        a = (k < count) * rng.uniform(0.05, 1.5) / max(1.0, w**1.5 / 2.0)
        values |= {f"a{k}": a, f"w{k}": w, f"p{k}": rng.uniform(-7.0, 7.0)}
    return {n: float(v) for n, v in values.items()}


def _table(p: dict[str, Any]) -> Callable[[Array], Array]:
    return lambda t: sum(p[f"a{k}"] * np.sin(p[f"w{k}"] * t + p[f"p{k}"]) for k in range(3))


def _table_speed(p: dict[str, Any]) -> Callable[[Array], Array]:
    return lambda t: sum(p[f"a{k}"] * p[f"w{k}"] * np.cos(p[f"w{k}"] * t + p[f"p{k}"]) for k in range(3))


def _fall(gravity: Any, drag: Any = 0.0) -> Callable[[int, Any, Array], Callable[[Array], Array]]:
    """v' = −gravity − drag·v."""

    def flow(_side: int, t0: Any, x0: Array) -> Callable[[Array], Array]:
        y, v = x0
        if drag == 0.0:
            return lambda t: np.stack([y + (t - t0) * (v - gravity * (t - t0) / 2), v - gravity * (t - t0)], -1)
        limit = gravity / drag

        def flight(t: Array) -> Array:
            lost = -np.expm1(-drag * (t - t0))
            return np.stack([y - limit * (t - t0) + (v + limit) / drag * lost, v - (v + limit) * lost], -1)

        return flight

    return flow


def _on_table(rng: np.random.Generator, system: Any, p: dict[str, float], jump: Any, drag: float = 0.0) -> Case:
    q = _real(**p)
    table = _table(q)
    fastest = max(p[f"w{k}"] for k in range(3) if p[f"a{k}"])
    exact = Hybrid(
        _fall(q["gravity"], Real(drag)), lambda t, x: x[:, 0] - table(t), 0.02 * min(1.0, 6.0 / fastest), jump(q)
    )
    t0 = float(rng.choice([0.0, rng.uniform(-30.0, 30.0), 10 ** rng.uniform(2.0, 4.0)]))
    x0 = (float(table(Real(t0)) + rng.uniform(0.2, 3.0)), float(rng.normal()))
    return Case(system.with_parameters(**p), exact, x0, t0, rng.uniform(10.0, 40.0))


# The families --------------------------------------------------------------------------------------------------------


@cache
def _moving_system() -> Any:
    jump = ("y", f"{_SPEED} - restitution*(v - ({_SPEED}))")
    return _system("Table", _FALL, f"y - ({_TABLE})", _ENERGY, jump, ["gravity", "restitution", *_HARMONICS])


def moving_table(rng: np.random.Generator) -> Case:
    p = _harmonics(rng) | {"gravity": float(rng.uniform(0.3, 3.0)), "restitution": float(rng.uniform(0.2, 1.0))}
    return _on_table(rng, _moving_system(), p, _bounce)


def _bounce(q: dict[str, Any]) -> Callable[[Any, Array], Array]:
    speed = _table_speed(q)
    return lambda t, x: np.array([x[0], speed(t) - q["restitution"] * (x[1] - speed(t))])


@cache
def _drag_system() -> Any:
    jump = ("y", f"{_SPEED} - restitution*(v - ({_SPEED}))")
    names = ["gravity", "drag", "restitution", *_HARMONICS]
    return _system("Drag", ("v", "-gravity - drag*v"), f"y - ({_TABLE})", ("v + drag*y + gravity*t",), jump, names)


def table_with_drag(rng: np.random.Generator) -> Case:
    p = _harmonics(rng) | {"gravity": float(rng.uniform(0.3, 3.0)), "restitution": float(rng.uniform(0.2, 1.0))}
    p["drag"] = float(rng.uniform(0.05, 1.0))
    return _on_table(rng, _drag_system(), p, _bounce, p["drag"])


@cache
def _reversed_system() -> Any:
    names = ["gravity", "restitution", *_HARMONICS]
    return _system("Reversed", _FALL, f"y - ({_TABLE})", _ENERGY, ("y", "-restitution*v"), names)


def speed_reversed(rng: np.random.Generator) -> Case:
    """The jump keeps g exactly, whatever the table's speed."""
    p = _harmonics(rng, 3.0) | {"gravity": float(rng.uniform(0.5, 3.0)), "restitution": float(rng.uniform(0.6, 1.0))}
    p |= {f"a{k}": 0.05 * p[f"a{k}"] for k in range(3)}
    jump = lambda q: lambda t, x: np.array([x[0], -q["restitution"] * x[1]])  # noqa: E731
    return _on_table(rng, _reversed_system(), p, jump)


@cache
def _lifted_system() -> Any:
    names = ["gravity", "restitution", "lift", *_HARMONICS]
    return _system("Lifted", _FALL, f"y - ({_TABLE})", _ENERGY, ("y + lift", "restitution*v"), names)


def lifted_off(rng: np.random.Generator) -> Case:
    """The jump leaves the surface on purpose."""
    p = _harmonics(rng) | {"gravity": float(rng.uniform(0.3, 3.0)), "restitution": float(rng.uniform(-0.8, 0.3))}
    p["lift"] = float(rng.uniform(0.3, 2.0))
    jump = lambda q: lambda t, x: np.array([x[0] + q["lift"], q["restitution"] * x[1]])  # noqa: E731
    return _on_table(rng, _lifted_system(), p, jump)


def _throw(gx: Any, gy: Any) -> Callable[[int, Any, Array], Callable[[Array], Array]]:
    def flow(_side: int, t0: Any, z: Array) -> Callable[[Array], Array]:
        def flight(t: Array) -> Array:
            s = t - t0
            x, y = z[0] + s * (z[2] - gx * s / 2), z[1] + s * (z[3] - gy * s / 2)
            return np.stack([x, y, z[2] - gx * s, z[3] - gy * s], -1)

        return flight

    return flow


_TILTED, _TILTED_ENERGY = ("u", "v", "-gx", "-gy"), ("(u**2 + v**2)/2 + gx*x + gy*y",)


def _reflection(slope_x: str, slope_y: str) -> tuple[str, ...]:
    """What a wall with this normal makes of the velocity."""
    part = f"(1 + restitution)*(u*({slope_x}) + v*({slope_y}))/(({slope_x})**2 + ({slope_y})**2)"
    return ("x", "y", f"u - {part}*({slope_x})", f"v - {part}*({slope_y})")


def _reflected(normal: Callable[[Array], tuple[Any, Any]], restitution: Any) -> Callable[[Any, Array], Array]:
    def jump(_t: Any, z: Array) -> Array:
        nx, ny = normal(z)
        part = (1 + restitution) * (z[2] * nx + z[3] * ny) / (nx * nx + ny * ny)
        return np.array([z[0], z[1], z[2] - part * nx, z[3] - part * ny])

    return jump


@cache
def _wavy_system() -> Any:
    names = ["gx", "gy", "restitution", "a", "k", "p"]
    jump = _reflection("-a*k*cos(k*x + p)", "1")
    return _system("Wavy", _TILTED, "y - a*sin(k*x + p)", _TILTED_ENERGY, jump, names)


def wavy_floor(rng: np.random.Generator) -> Case:
    p = {"gx": rng.uniform(-0.2, 0.2), "gy": rng.uniform(0.3, 3.0), "restitution": rng.uniform(0.5, 1.0)}
    p |= {"k": rng.uniform(0.3, 5.0), "p": rng.uniform(-1000.0, 1000.0)}
    p["a"] = rng.uniform(0.05, 0.6) / p["k"]
    q = _real(**p)
    exact = Hybrid(
        _throw(q["gx"], q["gy"]), lambda t, z: z[:, 1] - q["a"] * np.sin(q["k"] * z[:, 0] + q["p"]), 0.004,
        _reflected(lambda z: (-q["a"] * q["k"] * np.cos(q["k"] * z[0] + q["p"]), Real(1.0)), q["restitution"]),
    )  # fmt: skip
    x0 = (rng.normal(), p["a"] + rng.uniform(0.1, 2.0), rng.normal(), rng.normal())
    return Case(_wavy_system().with_parameters(**p), exact, tuple(map(float, x0)), 0.0, rng.uniform(5.0, 20.0))


@cache
def _round_system() -> Any:
    jump = _reflection("x/a**2", "y/b**2")
    return _system(
        "Ellipse", _TILTED, "1 - x**2/a**2 - y**2/b**2", _TILTED_ENERGY, jump, ["gx", "gy", "restitution", "a", "b"]
    )


def elliptic_wall(rng: np.random.Generator) -> Case:
    p = {"gx": rng.normal() / 3, "gy": rng.normal() / 3, "restitution": rng.uniform(0.7, 1.0)}
    p |= {"a": rng.uniform(0.5, 3.0), "b": rng.uniform(0.5, 3.0)}
    q = _real(**p)
    height = lambda t, z: 1 - (z[:, 0] / q["a"]) ** 2 - (z[:, 1] / q["b"]) ** 2  # noqa: E731
    jump = _reflected(lambda z: (z[0] / q["a"] ** 2, z[1] / q["b"] ** 2), q["restitution"])
    x0 = (0.5 * p["a"] * rng.uniform(-1, 1), 0.5 * p["b"] * rng.uniform(-1, 1), rng.normal(), rng.normal())
    exact = Hybrid(_throw(q["gx"], q["gy"]), height, 0.01, jump)
    return Case(_round_system().with_parameters(**p), exact, tuple(map(float, x0)), 0.0, rng.uniform(5.0, 20.0))


# The claims ----------------------------------------------------------------------------------------------------------


def judged(case: Case, method: str) -> tuple[str, str, Any]:
    """What is wrong with a run, up to where it stopped; whether it stopped too early; and the run."""
    tau = None if method == "taylor" else _STEP
    span = (case.t0, case.t0 + case.span)
    run = core.integrate(case.system, span, case.x0, tau, method)
    error = 1e-10 if case.system.name != "Drag" else 1e-7
    exact = trusted(case.exact, case.t0, case.x0, case.t0 + case.span, error)
    rounding = 2e-13 * (1.0 + abs(case.t0) + np.abs(run.x).max())
    found = mistake(run, exact) or contradiction(run, case.exact.height, rounding)
    early = "stopped, though the exact motion goes on" if not exact.why and run.status is not Status.COMPLETED else ""
    values = {n: float(v) for n, v in case.system.values.items()}
    setting = f"{case.system.name}: integrate(system.with_parameters(**{values}), {span}, {case.x0}, {tau}, {method!r})"
    words = f"\n{setting}\n-> {run.message}"
    return found and found + words, early and early + words, run


FAMILIES = [
    (moving_table, ("prk8", "dmm2", "rk4", "taylor")),
    (table_with_drag, ("rk8", "taylor")),
    (speed_reversed, ("dmm8", "taylor")),
    (lifted_off, ("prk8", "rk4")),
    (wavy_floor, ("prk8", "taylor")),
    (elliptic_wall, ("dmm2", "taylor")),
]


@pytest.mark.parametrize(("family", "methods"), deep_but([moving_table, wavy_floor, elliptic_wall], FAMILIES))
def test_every_impact_is_where_the_exact_motion_has_it_and_runs_go_on_as_long(draws, family, methods):
    for k, rng in enumerate(draws(9 * len(methods))):
        found, early, _ = judged(family(rng), methods[k % len(methods)])
        assert not found, found
        assert not early, early


@pytest.mark.parametrize("method", ["prk8", "dmm2", "rk4", "taylor"])
def test_a_ball_does_not_fall_through_a_table_that_swings(method):
    values = {"gravity": 1.0, "restitution": 0.5, "a0": 1.5, "w0": 1.0, "p0": 0.0, "a1": 0.0, "a2": 0.0}
    tau = None if method == "taylor" else _STEP
    run = core.integrate(_moving_system().with_parameters(**values), (0.0, 50.0), (1.0, 0.0), tau, method)
    height = run.x[:, 0].astype(Real) - Real(1.5) * np.sin(run.t.astype(Real))
    assert height.min() > -1e-12, f"{float(height.min())} below the table. {run.message}"
