"""A state that rests for a moment is no reason to call a step too long; one that is too long is told all the same."""

from __future__ import annotations

import numpy as np
import pytest

import core

METHODS = ("rk2", "rk4", "gauss4")


def forced(field: str) -> core.PiecewiseSystem:
    """x'' = a given force, from rest, far from its surface."""
    return core.PiecewiseSystem("Forced", ("x", "v"), ("v", field), ("v", field), "x - 1e6", x0=(0.0, 0.0))


def from_rest(rng: np.random.Generator) -> tuple[core.PiecewiseSystem, float]:
    """A force that is 0 at the start, where the velocity is 0, too; with its frequency."""
    w, k, a = 10 ** rng.uniform(-1, 1), rng.integers(1, 5), rng.normal()
    fields = (
        f"{a}*({w}*t)**{k}/(1 + ({w}*t)**{k})",
        f"{a}*sin({w}*t)**{k}",
        f"-{w**2}*x + {a}*(1 - cos({w}*t))",
    )
    return forced(str(rng.choice(fields))), float(w)


def coarse(rng: np.random.Generator) -> tuple[core.PiecewiseSystem, float, float]:
    """An oscillator under a force that is faster than it, or acts in pulses; with both frequencies."""
    w, a, k, c = 10 ** rng.uniform(-1, 1), rng.normal(), rng.integers(1, 4), 10 ** rng.uniform(0, 2.5)
    fast = w * rng.uniform(0.2, 8)
    fields = (
        f"-{w**2}*x + {a}*sin({fast}*t)**{k}",
        f"-{w**2}*x - {a}*x**3 + {a}*cos({fast}*t)",
        f"-{w**2}*x + {a}*exp(-{c}*sin({w}*t)**2)",
    )
    return forced(str(rng.choice(fields))), float(w), float(max(fast, w * np.sqrt(c)))


@pytest.mark.parametrize("method", METHODS)
def test_no_step_is_called_too_long_as_the_state_rests_where_it_begins(draws, method):
    for rng in draws(20):
        system, w = from_rest(rng)
        tau = 10 ** rng.uniform(-4, -2) / w
        run = core.integrate(system, (0.0, 20.0 / w), method=method, tau=tau)
        assert "too long" not in run.warning, f"{system.law_arguments()}, tau = {tau}: {run.warning}"


@pytest.mark.parametrize("method", METHODS)
def test_a_run_from_rest_whose_steps_are_far_too_long_says_so(draws, method):
    for rng in draws(15):
        system, w, fastest = coarse(rng)
        tau = 10 ** rng.uniform(-1.3, 0.3) / w
        run = core.integrate(system, (0.0, 8.0 / w), method=method, tau=tau)
        exact = core.integrate(system, (0.0, 8.0 / w), method="rk8", tau=2e-3 / fastest).x[-1]
        away = np.abs((run.x[-1] - exact) / np.abs(run.x).max(axis=0)).max()
        assert away < 0.2 or run.warning or run.status is not core.Status.COMPLETED, (
            f"{system.law_arguments()}, tau = {tau}: off by {away:.2g} of its largest"
        )
