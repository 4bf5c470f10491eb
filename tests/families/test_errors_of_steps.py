"""Oscillators, forced or free, in steps of any size: a run that these lead off the solution says so; others do not.

The oracle is SciPy's DOP853, over fields that are continuous across the surface, or the same on both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import core
from tests.families.oracles import silent
from tests.levels import deep_but

METHODS = deep_but(("rk4",), ("rk2", "rk4", "gauss4"))
OFF, NEAR = 0.25, 0.04  # of the range of the state; a tenth is told, and halved steps tell it within a factor of 2


class Case(NamedTuple):
    """x'' = a force."""

    text: Callable[[str], str]
    """The force as a law, given a text for |x|."""
    force: Callable[[float, NDArray], float]
    forced: bool
    frequency: float


def duffing(rng: np.random.Generator) -> Case:
    """A hardening spring, or two wells, driven."""
    k, c, d, a, w = rng.uniform(-1, 1), 10 ** rng.uniform(-1, 0.5), rng.uniform(0, 0.2), rng.uniform(0.2, 3), 1.3
    return Case(
        lambda _: f"-({k})*x - {c}*x**3 - {d}*v + {a}*cos({w}*t)",
        lambda t, u: -k * u[0] - c * u[0] ** 3 - d * u[1] + a * np.cos(w * t), True, 1 + w,
    )  # fmt: skip


def two_springs(rng: np.random.Generator) -> Case:
    """Another stiffness on either side of x = 0, driven."""
    k, c, a, w = rng.uniform(1, 4), rng.uniform(0.2, 3), rng.uniform(0.2, 3), 10 ** rng.uniform(-0.3, 0.3)
    return Case(
        lambda size: f"-{k}*x - {c}*{size} + {a}*cos({w}*t)",
        lambda t, u: -k * u[0] - c * abs(u[0]) + a * np.cos(w * t), True, 2 + w,
    )  # fmt: skip


def pendulum(_: np.random.Generator) -> Case:
    """A pendulum, which swings or turns over."""
    return Case(lambda _: "-sin(x)", lambda _, u: -np.sin(u[0]), False, 1.0)


def van_der_pol(rng: np.random.Generator) -> Case:
    """A self-excited oscillator."""
    m = 10 ** rng.uniform(-1, 0.7)
    return Case(lambda _: f"{m}*(1 - x**2)*v - x", lambda _, u: m * (1 - u[0] ** 2) * u[1] - u[0], False, 1 + m)


def _solution(case: Case, start: NDArray, end: float, tolerance: float) -> Callable[..., NDArray]:
    """States at times to somewhat beyond the end."""
    return solve_ivp(
        lambda t, u: (u[1], case.force(t, u)), (0.0, 1.3 * end), start, "DOP853",
        dense_output=True, rtol=tolerance, atol=tolerance,
    ).sol  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("family", [duffing, two_springs, pendulum, van_der_pol])
def test_errors_of_the_steps_are_told_where_they_lead_a_run_off_the_solution(draws, family, method):
    for rng in draws(6):
        case, start, end = family(rng), rng.uniform((-1.5, 0.1), (1.5, 1.5)), float(rng.uniform(3, 50))
        tau = float(10 ** rng.uniform(-2, -0.3)) / case.frequency
        system = core.PiecewiseSystem(
            "Oscillator", ("x", "v"), ("v", case.text("(-x)")), ("v", case.text("x")), "x", x0=tuple(start.tolist())
        )
        run = core.integrate(system, (0.0, end), method=method, tau=tau)
        exact = [_solution(case, start, end, tolerance) for tolerance in (1e-11, 1e-9)]
        size = np.ptp(exact[0](np.linspace(0, end, 400)), axis=1)
        if (np.abs(exact[0](end) - exact[1](end)) > 1e-3 * size).any():
            continue  # chaotic beyond what the oracle can tell
        rows = np.linspace(0, len(run.t) - 1, 200).astype(int)
        off = np.abs((exact[0](run.t[rows]).T - run.x[rows]) / size)
        around = np.full(1, end) if case.forced else end * np.linspace(0.75, 1.25, 6001)
        away = np.abs((exact[0](around).T - run.x[-1]) / size).max(axis=1).min()
        drawn = f"{system.law_arguments()}, {method}, tau = {tau}, end = {end}"
        assert away < OFF or not silent(run), f"off by {away:.2g} of the range: {drawn}"
        assert off.max() > NEAR or "errors of the steps" not in run.warning, f"off by {off.max():.2g}: {drawn}"
