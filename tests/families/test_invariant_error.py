"""The error of ψ that a run reports holds what was lost on the last, partial step before every crossing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

import core
from tests.levels import deep_but

_COLUMNS = 7
_DIGITS = 40
#: What ψ may be off by in double-double, and its arguments by their last digit, relative to its terms.
_ROUNDING = 64 * 2.0**-52


@dataclass(frozen=True)
class Family:
    """Fields and ψ with one letter of each parameter a side: k becomes km and kp."""

    field: tuple[str, str]
    psi: str
    parameters: str
    terms: Any
    """(numbers of one side, t, x, v) -> the terms of ψ, in mpmath."""


FAMILIES = {
    "oscillators": Family(
        ("v", "-k*(x - c)"), "(v**2 + k*(x - c)**2)/2", "kc",
        lambda n, t, x, v: (v**2 / 2, n["k"] * (x - n["c"]) ** 2 / 2),
    ),
    "quartic": Family(
        ("v", "c - k*x**3"), "v**2/2 - c*x + k*x**4/4", "kc",
        lambda n, t, x, v: (v**2 / 2, -n["c"] * x, n["k"] * x**4 / 4),
    ),
    "damped": Family(
        ("v", "-k*(x - c) - d*v"), "(v**2 + d*(x - c)*v + k*(x - c)**2)*exp(d*t)/2", "kcd",
        lambda n, t, x, v: tuple(
            term * mpmath.exp(n["d"] * t) / 2
            for term in (v**2, n["d"] * (x - n["c"]) * v, n["k"] * (x - n["c"]) ** 2)
        ),
    ),
}  # fmt: skip


@cache
def _system(name: str) -> core.PiecewiseSystem:
    family = FAMILIES[name]

    def sided(text: str, s: str) -> str:
        return "".join(c + s if c in family.parameters and text[i : i + 3] != "exp" else c for i, c in enumerate(text))

    f = {s: tuple(sided(u, s) for u in family.field) for s in "mp"}
    psi = {s: (sided(family.psi, s),) for s in "mp"}
    values = {letter + s: 1.0 for letter in family.parameters for s in "mp"}
    return core.PiecewiseSystem(name, ("x", "v"), f["m"], f["p"], "x", psi["m"], psi["p"], values)


def drawn(rng: np.random.Generator, name: str) -> tuple[core.PiecewiseSystem, tuple[float, float], float, float]:
    """A soft side and a stiff one, a start, an end time, and a step size: for the stiff side often too large."""
    soft, stiff = 10 ** rng.uniform(-0.5, 0.5), 10 ** rng.uniform(0.0, 8.0)
    values = dict(zip(("km", "kp"), rng.permutation([soft, stiff]), strict=True))
    values |= {"cm": rng.uniform(-0.1, 1.0), "cp": -rng.uniform(-0.1, 1.0)}  # pulled back to the surface, most of them
    values |= {"dm": rng.uniform(0, 1), "dp": rng.uniform(0, 1)} if name == "damped" else {}
    sign = 1 if values["kp"] < values["km"] else -1
    x0 = (float(sign * rng.uniform(0.1, 1.0)), float(rng.normal()))
    tau = float(10 ** rng.uniform(-3.5, -1.5))
    return _system(name).with_parameters(**values), x0, min(20.0, 4000 * tau), tau


def exit_errors(run: core.Trajectory, name: str) -> tuple[np.ndarray, np.ndarray]:
    """ψ of the side left at each crossing less its level at the entry, and its round-off; both (k,)."""
    family, crossings = FAMILIES[name], run.crossings
    sides = [run.side[0], *crossings.side]
    errors, rounding = [], []
    with mpmath.workdps(_DIGITS):
        for k in range(len(crossings)):
            s = "m" if sides[k] < 0 else "p"
            numbers = {letter: mpmath.mpf(run.system.values[letter + s]) for letter in family.parameters}
            entry = family.terms(numbers, *map(mpmath.mpf, (run.entered_t[k], *run.entered_x[k])))
            end = family.terms(numbers, *map(mpmath.mpf, (crossings.t[k], *crossings.surface[k])))
            errors.append(float(mpmath.fsum(end) - mpmath.fsum(entry)))
            rounding.append(_ROUNDING * float(sum(map(abs, (*entry, *end)))) * (1 + float(crossings.t[k])))
    return np.array(errors), np.array(rounding)


def reported(run: core.Trajectory) -> float:
    """The largest error of ψ that a run tells of, along the way and at its crossings."""
    error = run.conserved_error()
    return float(np.nanmax(np.abs(error))) if error.size else 0.0


def hidden(run: core.Trajectory, name: str, told: float) -> str:
    """Which exit lost more of ψ than was told; "" where none did."""
    errors, rounding = exit_errors(run, name)
    more = np.abs(errors) * (1 - 1e-6) - rounding - told
    if not len(more) or not more.max() > 0:
        return ""
    k = int(more.argmax())
    return (
        f"crossing {k} of {len(errors)}, t = {run.crossings.t[k]:.12g}: psi lost {errors[k]:.3e}, told {told:.3e}\n"
        f"{name}: with_parameters(**{dict(run.system.values)}), x0 = {run.x[0].tolist()}, tau = {run.tau!r}\n"
        f"{run.method} -> {run.message}"
    )


METHODS = {
    "oscillators": ("dmm2", "dmm8", "rk2", "rk4", "rk8", "prk8", "taylor"), "quartic": ("dmm2", "rk4", "prk8"),
    "damped": ("dmm2", "rk4"),
}  # fmt: skip
QUICK = [
    ("oscillators", "dmm2"),
    ("oscillators", "rk4"),
    ("oscillators", "taylor"),
    ("quartic", "prk8"),
    ("damped", "rk4"),
]
CASES = [(name, method) for name, methods in METHODS.items() for method in methods]


def _run(rng: np.random.Generator, name: str, method: str, **how: Any) -> core.Trajectory:
    system, x0, t_end, tau = drawn(rng, name)
    return core.integrate(system, (0.0, t_end), x0, tau, method, max_crossings=200, **how)


@pytest.mark.parametrize(("name", "method"), deep_but(QUICK, CASES))
@pytest.mark.parametrize("record", ["steps", "crossings"])
def test_what_psi_lost_on_the_way_into_a_crossing_is_reported(draws, name, method, record):
    for rng in draws(6):
        run = _run(rng, name, method, record=record)
        found = hidden(run, name, reported(run))
        assert not found, found


@pytest.mark.parametrize(("name", "method"), deep_but(QUICK, CASES))
def test_the_envelope_holds_what_psi_lost_on_the_way_into_a_crossing(draws, name, method):
    for rng in draws(6):
        run = _run(rng, name, method, record="crossings", envelope=_COLUMNS)
        found = hidden(run, name, float(np.nanmax(np.abs(run.envelope), initial=0.0)))
        assert not found, found


def test_a_step_that_a_stiff_spring_makes_nonsense_of_shows_in_the_error_of_psi():
    system = _system("oscillators").with_parameters(km=1e8, cm=0.0, kp=1.0, cp=1.0)
    run = core.integrate(system, (0.0, 20.0), (-1.5e-4, 1.0), 1e-3, "rk4", max_crossings=200)
    found = hidden(run, "oscillators", reported(run))
    assert not found, found
