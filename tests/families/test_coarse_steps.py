"""Coarse steps: crossings that fall between two looks, and steps whose equations have more than one solution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

import core
from core import Status
from tests.families.flights import accelerated, real
from tests.families.oracles import Hybrid, silent
from tests.families.test_fast_surfaces import Case, rotation, straight
from tests.families.test_fast_surfaces import judged as judged_at
from tests.levels import QUICK_METHODS, deep_but

_FIXED = ("dmm2", "dmm4", "dmm6", "dmm8", "rk2", "rk4", "rk8", "prk8")

# Crossings between two looks -----------------------------------------------------------------------------------------


@cache
def _periodic_system() -> core.PiecewiseSystem:
    f, psi = ("v", "a"), ("v**2/2 - a*y",)
    values = {"a": 1.0, "k": 2.0, "w": 3.0, "p": 4.0, "c": 0.5}
    return core.PiecewiseSystem("Periodic", ("y", "v"), f, f, "cos(k*y + w*t + p) + c", psi, psi, values)


def stroboscopic(rng: np.random.Generator) -> tuple[Case, float]:
    """Uniform motion through a wave, by steps of (nearly) a whole number of its periods."""
    speed = float(rng.uniform(0.3, 3.0))
    p = {"a": 0.0, "k": rng.uniform(1, 20), "w": rng.choice([0.0, rng.normal() * 5]), "p": rng.choice([0, np.pi])}
    p |= {"c": rng.uniform(-0.95, 0.95), "p": p["p"] + rng.choice([0.01, 0.2]) * rng.normal()}  # at or near its crest
    q, rate = real(**p), abs(p["k"] * speed + p["w"]) + 1e-3
    off = rng.choice([0.0, 1e-6, 1e-3]) * rng.normal()
    tau = float(2 * np.pi / rate * rng.integers(1, 4) * (1 + off))
    exact = Hybrid(
        accelerated({-1: q["a"], 1: q["a"]}),
        lambda t, x: np.cos(q["k"] * x[:, 0] + q["w"] * t + q["p"]) + q["c"], 0.1 / rate,
    )  # fmt: skip
    return Case(_periodic_system().with_parameters(**p), exact, (0.0, speed), 20.3 * tau, rate), tau


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, _FIXED))
def test_steps_in_time_with_a_wave_do_not_pass_its_crossings_in_silence(draws, method):
    for rng in draws(6):
        case, tau = stroboscopic(rng)
        found, _, run = judged_at(case, method, tau)
        assert not (found and silent(run)), found


COARSE: dict[str, tuple[Callable[[np.random.Generator], Case], str]] = {
    **{kind: (lambda rng, kind=kind: straight(rng, kind), "rk4") for kind in ("polynomial", "log", "product")},
    "wave": (lambda rng: straight(rng, "wave"), "dmm4"), "moving": (lambda rng: straight(rng, "moving"), "dmm2"),
    "root": (lambda rng: straight(rng, "root"), "rk8"), "rotation": (rotation, "rk8"),
}  # fmt: skip


@pytest.mark.parametrize("name", deep_but(["polynomial", "wave", "moving", "rotation"], COARSE))
def test_crossings_that_fall_in_pairs_between_looks_are_found_or_spoken_of(draws, name):
    family, method = COARSE[name]
    for rng in draws(8):
        case = family(rng)
        found, _, run = judged_at(case, method, float(rng.uniform(0.02, 1.0) * case.t_end))
        assert not (found and silent(run)), found


def test_a_hundred_crossings_between_steps_of_one_are_not_passed_in_silence():
    system = core.PiecewiseSystem("Straight", ("x",), ("1",), ("1",), "cos(2*pi*x) + 0.2", x0=(0.03,))
    for method in ("rk2", "rk4", "rk8"):
        run = core.integrate(system, (0.0, 50.0), tau=1.0, method=method)
        assert len(run.crossings) == 100 or not silent(run), f"{method}: {len(run.crossings)} found. {run.message}"


# The branch of an implicit step --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Law:
    """x' = s y, y' = −V'(x), stepped by s (y₀ + y₁)/2 and the divided difference of V."""

    field: tuple[str, str]
    psi: str
    speed: float
    parameters: tuple[str, ...]
    slope: Callable[..., tuple[float, float]]
    """(x₀, x₁, parameters) -> −(V(x₁) − V(x₀))/(x₁ − x₀), and its derivative in x₁."""


def _elliptic(x0: float, x1: float, a: float) -> tuple[float, float]:
    return x1 * x1 + x1 * x0 + x0 * x0 + a, 2 * x1 + x0


def _quartic(x0: float, x1: float, k: float, c: float) -> tuple[float, float]:
    cubes = x1**3 + x1**2 * x0 + x1 * x0**2 + x0**3
    return -k * (x0 + x1) / 2 - c * cubes / 4, -k / 2 - c * (3 * x1**2 + 2 * x1 * x0 + x0**2) / 4


def _pendulum(x0: float, x1: float, k: float) -> tuple[float, float]:
    m, d = (x0 + x1) / 2, (x1 - x0) / 2
    sinc = math.sin(d) / d if abs(d) > 1e-4 else 1 - d * d / 6
    turn = (d * math.cos(d) - math.sin(d)) / d**2 if abs(d) > 1e-4 else -d / 3
    return -k * math.sin(m) * sinc, -k * (math.cos(m) * sinc + math.sin(m) * turn) / 2


def _harmonic(x0: float, x1: float, k: float) -> tuple[float, float]:
    return -k * (x0 + x1) / 2, -k / 2


LAWS = {
    "elliptic": Law(("2*y", "3*x**2 + a"), "y**2 - x**3 - a*x", 2.0, ("a",), _elliptic),
    "quartic": Law(("y", "-k*x - c*x**3"), "y**2/2 + k*x**2/2 + c*x**4/4", 1.0, ("k", "c"), _quartic),
    "pendulum": Law(("y", "-k*sin(x)"), "y**2/2 - k*cos(x)", 1.0, ("k",), _pendulum),
    "harmonic": Law(("y", "-k*x"), "y**2/2 + k*x**2/2", 1.0, ("k",), _harmonic),
}  # fmt: skip

_SUZUKI = 1 / (4 - 4 ** (1 / 3))
#: s17odr8a of Kahan and Li (1997).
_KAHAN_LI = (
    0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
    -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887,
)  # fmt: skip


def _weights(method: str) -> tuple[float, ...]:
    half = {"dmm2": (), "dmm4": (_SUZUKI,) * 2, "dmm8": _KAHAN_LI}[method]
    return (*half, 1 - 2 * math.fsum(half), *reversed(half))


class Folds(Exception):  # noqa: N818 - not an error: an answer
    """The branch from h = 0 ends before this h."""


def _substep(law: Law, p: tuple[float, ...], start: tuple[float, float], h: float, guess: float) -> Any:
    """x₁ next to a guess, y₁, and how far from a fold: x₁ − x₀ = h s (y₀ + y₁)/2, y₁ = y₀ + h·slope."""
    x0, y0 = start
    x1 = guess
    for _ in range(50):
        slope, derivative = law.slope(x0, x1, *p)
        steep = 1 - h * h * law.speed * derivative / 2
        change = (x1 - x0 - h * law.speed * (y0 + h * slope / 2)) / steep if steep else math.inf
        x1 -= change
        if not abs(change) > 1e-15 * max(abs(x1), 1e-3):
            break
        if not math.isfinite(x1):
            raise Folds
    slope, derivative = law.slope(x0, x1, *p)
    return x1, y0 + h * slope, 1 - h * h * law.speed * derivative / 2


def continued(law: Law, p: tuple[float, ...], start: tuple[float, float], h: float, method: str) -> tuple[float, float]:
    """The step's solution on the branch that leaves the start at h = 0; Folds where that ends before h."""
    weights = _weights(method)
    stages, s, ds = [start[0]] * len(weights), 0.0, 1e-3
    while s < 1.0:
        trial = min(1.0, s + ds)
        try:
            found, point, closest = [], start, 1.0
            for w, guess in zip(weights, stages, strict=True):
                x, y, room = _substep(law, p, point, w * h * trial, guess)
                point, closest = (x, y), min(closest, room)
                found.append(x)
            jumped = max(abs(a - b) for a, b in zip(found, stages, strict=True)) > 0.01 * (1 + max(map(abs, stages)))
            if closest <= 0.0 or jumped:
                raise Folds
        except (Folds, OverflowError):
            ds /= 2
            if ds < 1e-9:
                raise Folds from None
            continue
        s, stages, ds = trial, found, min(1.5 * ds, 0.03)
    return point


@cache
def _law_system(name: str) -> core.PiecewiseSystem:
    law = LAWS[name]
    values = dict.fromkeys(law.parameters, 1.0)
    return core.PiecewiseSystem(name, ("x", "y"), law.field, law.field, "x + 1e9", (law.psi,), (law.psi,), values)


def branch_case(rng: np.random.Generator, name: str) -> tuple[dict[str, float], tuple[float, float], float]:
    """Parameters, a start, and a step size from well below to well beyond where the branch may end."""
    p = {
        q: float(rng.choice([-1, 1]) * rng.uniform(0.3, 3) if q == "a" else rng.uniform(0.3, 3))
        for q in LAWS[name].parameters
    }
    return p, (float(rng.normal() * 1.5), float(rng.normal() * 1.5)), float(10 ** rng.uniform(-1.0, 0.8))


def off_branch(name: str, method: str, p: dict[str, float], start: tuple[float, float], h: float) -> tuple[str, Any]:
    """How one step of size h is not the continuous one; "" where it is or where the run did not complete."""
    run = core.integrate(_law_system(name).with_parameters(**p), (0.0, h), start, h, method)
    try:
        end = continued(LAWS[name], tuple(p.values()), start, h, method)
    except Folds:
        found = "the branch from h = 0 has ended, and a step was taken on another"
    else:
        off = float(np.abs(run.x[-1] - end).max())
        found = f"the step ends at {run.x[-1].tolist()}, not {end}" if off > 1e-7 * (1 + max(map(abs, end))) else ""
    if run.status is not Status.COMPLETED:
        return "", run
    return found and f"{found}\n{name}, {p}, x0 = {start}, tau = {h!r}, {method} -> {run.message}", run


BRANCHES = [("elliptic", "dmm2"), ("elliptic", "dmm4"), ("elliptic", "dmm8"), ("quartic", "dmm2"), ("quartic", "dmm4"),
            ("pendulum", "dmm2"), ("pendulum", "dmm4"), ("harmonic", "dmm2")]  # fmt: skip


@pytest.mark.parametrize(("name", "method"), deep_but([("elliptic", "dmm2"), ("pendulum", "dmm4")], BRANCHES))
def test_a_step_is_the_one_continuous_from_no_step_or_the_run_says_why_not(draws, name, method):
    for rng in draws(40):
        found, run = off_branch(name, method, *branch_case(rng, name))
        assert not (found and silent(run)), found


@pytest.mark.parametrize(("name", "method"), deep_but([("elliptic", "dmm2"), ("pendulum", "dmm4")], BRANCHES))
def test_small_steps_are_taken(draws, name, method):
    for rng in draws(10):
        p, start, h = branch_case(rng, name)
        try:
            continued(LAWS[name], tuple(p.values()), start, 2 * h, method)
        except Folds:
            continue
        found, run = off_branch(name, method, p, start, h / 4)
        assert not found, found
        assert run.status is Status.COMPLETED, f"{name}, {p}, x0 = {start}, tau = {h / 4!r}, {method} -> {run.message}"
