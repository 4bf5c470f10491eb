"""Quotients near a common zero of numerator and denominator: runs that pass it, or stay near it, lose no digits."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import mpmath
import numpy as np
import pytest

import core
from core import Status
from tests.levels import QUICK_METHODS, deep_but

#: Functions, as text and in many digits, with their Taylor coefficients at 0 up to the third.
FUNCTIONS = {
    "sin({u})": (mpmath.sin, (0, 1, 0, "-1/6")),
    "cos({u})": (mpmath.cos, (1, 0, "-1/2", 0)),
    "exp({u})": (mpmath.exp, (1, 1, "1/2", "1/6")),
    "sinh({u})": (mpmath.sinh, (0, 1, 0, "1/6")),
    "cosh({u})": (mpmath.cosh, (1, 0, "1/2", 0)),
    "tan({u})": (mpmath.tan, (0, 1, 0, "1/3")),
    "tanh({u})": (mpmath.tanh, (0, 1, 0, "-1/3")),
    "log(1 + {u})": (lambda u: mpmath.log(1 + u), (0, 1, "-1/2", "1/3")),
    "sqrt(1 + {u})": (lambda u: mpmath.sqrt(1 + u), (1, "1/2", "-1/8", "1/16")),
    "1/(1 - {u})": (lambda u: 1 / (1 - u), (1, 1, 1, 1)),
}
#: What may stand below: it vanishes as its argument does.
BELOW = {"{u}": lambda u: u, "sin({u})": mpmath.sin, "(exp({u}) - 1)": mpmath.expm1, "tanh({u})": mpmath.tanh}
#: Digits of the oracle: at a distance of 1e-15 a quotient of order 4 loses 60 of them.
_DIGITS = 120
#: Of Gauss's quadrature: exact to rounding for quotients that are analytic to at least a piece's length beyond it.
NODES, WEIGHTS = (part.tolist() for part in np.polynomial.legendre.leggauss(24))


def number(c: int | str) -> mpmath.mpf:
    above, _, below = str(c).partition("/")
    return mpmath.mpf(int(above)) / int(below or 1)


@dataclass(frozen=True)
class Case:
    """y' = quotient of the inner function b (s − a), with s = x or t; x' = v, and x − v t is conserved."""

    text: str
    above: str
    below: str
    order: int
    by_time: bool
    a: float
    b: float

    def declared(self, v: float, x: float) -> core.PiecewiseSystem:
        """The system with a speed v, from a place x."""
        f, psi = ("v", self.text), ("x - v*t",)
        values = {"a": self.a, "b": self.b, "v": v}
        return core.PiecewiseSystem("Near", ("x", "y"), f, f, "y + 1000", psi, psi, values, x0=(x, 0.0))

    def value(self, s: mpmath.mpf) -> mpmath.mpf:
        """The quotient in many digits."""
        u = mpmath.mpf(self.b) * (s - mpmath.mpf(self.a))
        function, coefficients = FUNCTIONS[self.above]
        part = mpmath.fsum(number(c) * u**k for k, c in enumerate(coefficients[: self.order]))
        return (function(u) - part) / BELOW[self.below](u) ** self.order

    def integral(self, start: float, speed: float, length: float) -> float:
        """∫ of the quotient over a time, of which the argument moves from `start` with a speed."""
        with mpmath.workdps(_DIGITS):
            zero = (mpmath.mpf(self.a) - mpmath.mpf(start)) / speed
            # Pieces end at the zero, if it is among them; Gauss's nodes are inside, so that none is the zero.
            ends = [mpmath.mpf(0), *([zero] if 0 < zero < length else []), mpmath.mpf(length)]
            parts = []
            for begin, end in itertools.pairwise(ends):
                middle, half = (begin + end) / 2, (end - begin) / 2
                for node, weight in zip(NODES, WEIGHTS, strict=True):
                    parts.append(weight * half * self.value(start + speed * (middle + node * half)))
            return float(mpmath.fsum(parts))


def drawn(rng: np.random.Generator) -> Case:
    above, below, order = str(rng.choice(list(FUNCTIONS))), str(rng.choice(list(BELOW))), int(rng.integers(1, 5))
    by_time = bool(rng.integers(2))
    u = f"(b*({'t' if by_time else 'x'} - a))"
    part = " - ".join(f"({c})*{u}**{k}" for k, c in enumerate(FUNCTIONS[above][1][:order]) if c != 0) or "0"
    text = f"({above.format(u=u)} - {part})/{below.format(u=u)}**{order}"
    a, b = (float(rng.uniform(low, high)) for low, high in ((0.3, 0.9), (0.3, 1.4)))
    return Case(text, above, below, order, by_time, a, b)


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, tuple(core.METHODS)))
def test_a_run_that_stays_near_the_zero_of_a_quotient_keeps_its_digits(draws, method):
    for rng in draws(3 if method == "taylor" else 6):  # whose series of such quotients take long to compile
        case, away = drawn(rng), 10.0 ** rng.uniform(-15, -3) * rng.choice([-1, 1])
        length = abs(away) * rng.uniform(0.5, 3.0)
        v = 1.0 if case.by_time else float(rng.choice([-1, 1]) * rng.uniform(0.5, 2.0))
        start = case.a + away
        span = (start, start + length) if case.by_time else (0.0, length)
        system = case.declared(v, 0.3 if case.by_time else start)
        step = {} if method == "taylor" else {"tau": (span[1] - span[0]) / 4}
        run = core.integrate(system, span, method=method, **step)
        right = case.integral(start, v, span[1] - span[0])
        about = f"{case}, {away} away, {v}: {run.message}"
        assert run.status is Status.COMPLETED, about
        # The state is rounded; and the quotient may vanish as fast as the error of order 2 does.
        least = length * (1e-14 + step.get("tau", 0.0) ** 2)
        close = math.isclose(run.x[-1, 1], right, rel_tol=1e-7, abs_tol=least)
        assert close, f"{about} {run.x[-1, 1]}, not {right}"


@pytest.mark.parametrize("method", ["rk8", "gauss4", "prk8", "taylor"])
def test_a_run_that_passes_near_the_zero_of_a_quotient_keeps_its_digits(draws, method):
    for rng in draws(6):
        case, tau = drawn(rng), 0.4 / int(rng.integers(10, 60))
        start = case.a - 0.4 + 10.0 ** rng.uniform(-15, -2) * rng.choice([-1, 1])
        span = (start, start + 0.7) if case.by_time else (0.0, 0.7)
        step = {} if method == "taylor" else {"tau": tau}
        run = core.integrate(case.declared(1.0, 0.2 if case.by_time else start), span, method=method, **step)
        right = case.integral(start, 1.0, span[1] - span[0])
        about = f"{case}, tau = {tau}, from {start}: {run.message}"
        assert run.status is Status.COMPLETED, about
        assert run.message.count(".") <= 2, about
        assert abs(run.x[-1, 1] - right) < (1e-6 if method == "gauss4" else 1e-10), (
            f"{about} {run.x[-1, 1]}, not {right}"
        )


#: A quotient that keeps its digits near its zero, so that it is evaluated as it is written, beside the zero.
STEADY = Case("tan((b*(x - a)))/tanh((b*(x - a)))", "tan({u})", "tanh({u})", 1, by_time=False, a=0.5, b=0.41)


@pytest.mark.parametrize("before", [4.0, 3.5, 3.25])
@pytest.mark.parametrize("method", deep_but(["dmm2", "dmm4"], ["dmm2", "dmm4", "dmm6", "prk8"]))
def test_a_step_may_begin_end_or_have_its_middle_at_the_zero(draws, method, before):
    for rng in draws(3):
        tau = 2.0 ** -int(rng.integers(7, 11))
        for case in (STEADY, replace(drawn(rng), a=float(rng.integers(20, 58)) / 64)):
            start = case.a - before * tau
            span = (start, start + 8 * tau) if case.by_time else (0.0, 8 * tau)
            run = core.integrate(case.declared(1.0, 0.3 if case.by_time else start), span, method=method, tau=tau)
            about = f"{case}, tau = {tau}, from {start}: {run.message}"
            assert run.status is Status.COMPLETED, about
            # Of order 2: 8τ · τ²/12 times the second derivative of the quotient, which is below 12.
            assert abs(run.x[-1, 1] - case.integral(start, 1.0, 8 * tau)) < 8 * tau**3, about
