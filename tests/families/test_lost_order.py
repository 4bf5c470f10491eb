"""Fields with a root or a logarithm that ends just behind the surface: a step from there does not keep its order."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad

import core
from tests.levels import deep_but

METHODS = deep_but(("rk4", "rk8"), ("rk4", "rk8", "gauss4"))


class Case(NamedTuple):
    """A system of one variable, and when it is where."""

    system: core.PiecewiseSystem
    after: float
    """Time from x = 0 to x = 1, by quadrature; from x = -1 to x = 0 it is 1."""
    speed: float
    """The largest on the way."""

    def run(self, method: str, tau: float) -> tuple[core.Trajectory, float]:
        """A run, and its error as part of the longest step."""
        run = core.integrate(self.system, (0.0, 1.0 + self.after), method=method, tau=tau)
        return run, abs(float(run.x[-1, 0]) - 1.0) / (self.speed * tau)


def past_a_border(rng: np.random.Generator, s: float) -> Case:
    """x' = 1 | b + c (x + s)^q or b − c log(x + s), of which no derivative is bounded at x = −s."""
    b, q = (round(float(rng.uniform(*ends)), 3) for ends in ((0.5, 2.0), (0.3, 0.9)))
    root = bool(rng.random() < 0.5)
    c = round(float(rng.uniform(-0.4, 0.8) if root else rng.uniform(0.01, 0.05)) * b, 3)
    text = f"{b} + ({c})*(x + s)**{q}" if root else f"{b} - {c}*log(x + s)"

    def speed(x: float) -> float:
        return float(b + c * (x + s) ** q if root else b - c * np.log(x + s))

    # By z² = x + s: of that the integrand has no singularity at z = 0.
    after = quad(lambda z: 2 * z / speed(z * z - s), s**0.5, (1 + s) ** 0.5, epsabs=1e-13, epsrel=1e-13, limit=400)[0]
    system = core.PiecewiseSystem("Border", ("x",), ("1",), (text,), "x", parameters={"s": s}, x0=(-1.0,))
    return Case(system, float(after), max(1.0, speed(0.0), speed(1.0)))


@pytest.mark.parametrize("method", METHODS)
def test_a_step_whose_error_does_not_fall_as_its_order_says_is_told(draws, method):
    told = 0
    for rng in draws(24):
        case = past_a_border(rng, s=float(10 ** rng.uniform(-9, -3)))
        run, error = case.run(method, tau=case.after / 10 ** rng.uniform(1.5, 3.3))
        said = "too long for" in run.warning  # this field, or its order
        told += said
        # An order of p/2 or more is not told: of 100 cases the largest error was 1.2e-4 of the longest step.
        silent = run.status is core.Status.COMPLETED and not said
        assert not silent or error < 1e-3, f"off by {error:.1e} of a step: {case.system.law_arguments()}"
    assert told, "no case loses its order"


def through_a_root(rng: np.random.Generator) -> Case:
    """x' = a + b |x|^p, through x = 0, where its derivative is not bounded: steps beside it may have no solution."""
    p, power = ((1 / 3, "(1/3)"), (0.5, "(1/2)"), (2 / 3, "(2/3)"))[int(rng.integers(3))]
    a, b = (round(float(rng.uniform(*ends)), 3) for ends in ((0.2, 1.0), (0.5, 3.0)))
    after = quad(lambda u: u ** (1 / p - 1) / (p * (a + b * u)), 0.0, 1.0, epsabs=1e-14, epsrel=1e-13)[0]  # u = x^p
    field = (f"({a} + {b}*abs(x)**{power})*{after!r}",)  # so that x = -1 is left at t = 0, and x = 0 met at t = 1
    return Case(core.PiecewiseSystem.from_field(("x",), field, x0=(-1.0,)), 1.0, (a + b) * after)


@pytest.mark.parametrize("method", METHODS)
def test_a_step_through_a_root_is_told_though_others_have_no_solution(draws, method):
    told = 0
    for rng in draws(16):
        case = through_a_root(rng)
        run, error = case.run(method, tau=1.0 / 10 ** rng.uniform(1.3, 2.5))
        said = "too long for" in run.warning
        told += said
        silent = run.status is core.Status.COMPLETED and not said
        assert not silent or error < 1e-3, f"off by {error:.1e} of a step: {case.system.law_arguments()}"
    assert told, "no case loses its order"


@pytest.mark.parametrize("tau", [0.04, 0.02, 0.01])
def test_a_step_to_a_root_that_has_no_halves_hides_no_step_from_there(tau):
    """Of the step to x = 0 two halves have no solution with the field of x > 0: a stage is beyond."""
    system = core.PiecewiseSystem.from_field(("x",), ("-2.481*abs(x)**(1/3) - 0.972",), x0=(0.678,))
    run = core.integrate(system, (0.0, 0.349), tau=tau, method="rk8")
    assert run.crossing_count == 1
    assert "too long for rk8 to keep its order" in run.warning


@pytest.mark.parametrize("method", [*METHODS, "rk2"])
def test_a_step_far_from_the_border_is_not_said_to_lose_its_order(draws, method):
    for rng in draws(12):
        case = past_a_border(rng, s=float(rng.uniform(0.3, 1.0)))
        run, _ = case.run(method, tau=case.after / 10 ** rng.uniform(1.5, 3.3))
        assert "order" not in run.warning, run.message
