"""Schemes in as many digits as are wanted, from their declarations: what compiled runs should be.

It shares the discrete field with `core`, and nothing of how that is compiled, how a step is solved for or how a
crossing is found. It is a thousand times slower, and expects no more than one crossing in a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import mpmath
import numpy as np
import sympy

import core
from core.methods import ButcherTableau, Composition, Projected
from core.symbolic.expressions import TIME
from core.symbolic.multiplier import DIFFERENCES

Reals = list[Any]
Step = Callable[[Any, Reals, Any], Reals]

DIGITS = 34
#: Of residuals, and of the time of a crossing.
TOLERANCE = 1e-25


class Met(NamedTuple):
    """A crossing."""

    t: Any
    x: Reals


def crossings_in_digits(system: core.PiecewiseSystem, method: str, tau: float, count: int) -> list[Met]:
    """The first crossings of a run from x0 of the system: paper, Algorithm 1."""
    with mpmath.workdps(DIGITS):
        steps = {sign: _step(core.METHODS[method].scheme, _Functions(system, sign)) for sign in (-1, 1)}
        g = _function(system, [TIME, *system.laws.x], [system.laws.g])
        size, t, x, n = mpmath.mpf(tau), mpmath.mpf(0), [mpmath.mpf(v) for v in system.x0], 0
        sign, found = 1 if g(t, *x)[0] > 0 else -1, list[Met]()
        while len(found) < count:
            h = (n + 1) * size - t

            def height(part: Any, step: Step = steps[sign], t: Any = t, x: Reals = x) -> Any:
                return g(t + part, *step(t, x, part))[0]

            if height(h) * sign > 0:
                n, t, x = n + 1, t + h, steps[sign](t, x, h)
                continue
            after = h / 1000 if found and t == found[-1].t else mpmath.mpf(0)
            part = mpmath.findroot(height, (after, h), solver="anderson", tol=TOLERANCE, verify=False)
            t, x, sign = t + part, steps[sign](t, x, part), -sign
            found.append(Met(t, x))
        return found


def slopes_in_digits(
    system: core.PiecewiseSystem, method: str, taus: Sequence[float], numbers: Sequence[int]
) -> np.ndarray:
    """Orders of the times of k crossings, from n ≥ 3 step sizes, each the same part of the one before: (k, n − 2).

    Differences of neighbouring runs fall as their errors do, and need no solution to compare with.
    """
    runs = [crossings_in_digits(system, method, tau, numbers[-1]) for tau in taus]
    times = [[run[k - 1].t for run in runs] for k in numbers]
    gaps = [[float(mpmath.log(abs(a - b))) for a, b in pairwise(row)] for row in times]
    return -np.diff(gaps) / np.log(taus[0] / taus[1])


class _Functions:
    """One side's f and discrete field, as functions of (t, *x) and of (t, *x, t1, *x1)."""

    def __init__(self, system: core.PiecewiseSystem, sign: int) -> None:
        side = system.laws.modes[sign]
        discrete, ends = side.discrete, side.discrete.ends
        between = [ends.times[0], *ends.start, ends.times[1], *ends.end]
        self.m = len(side.conserved)
        self.field = _function(system, [TIME, *side.variables], side.field)
        self.discrete_field = _function(system, between, list(discrete.expression))
        self.gradient = _function(system, between, list(discrete.gradient))
        self.time_slope = _function(system, between, list(discrete.time_slope))


def _function(system: core.PiecewiseSystem, names: Sequence[sympy.Symbol], expressions: Sequence[sympy.Expr]) -> Any:
    """The function of these names; a parameter is the number that its double is."""
    values = zip(system.laws.p, system.parameter_array.tolist(), strict=True)
    numbers = {symbol: sympy.Rational(value) for symbol, value in values}
    differences = {cls.__name__: _difference(getattr(mpmath, phi.__name__)) for phi, cls in DIFFERENCES.items()}
    inserted = [sympy.sympify(e).xreplace(numbers) for e in expressions]
    return sympy.lambdify(list(names), inserted, [differences, "mpmath"], cse=True)


def _difference(phi: Callable[[Any], Any]) -> Callable[[Any, Any], Any]:
    """φ[a, b], which costs digits where a and b are close: there are more of them."""

    def divided(a: Any, b: Any) -> Any:
        if a == b:
            return mpmath.diff(phi, a)
        with mpmath.extradps(20):
            return (phi(b) - phi(a)) / (b - a)

    return divided


def _step(scheme: core.methods.Scheme, side: _Functions) -> Step:
    """(t, x, h) -> the state after a step."""
    if isinstance(scheme, ButcherTableau):
        tableau = _Tableau.of(scheme)
        return lambda t, x, h: _sum(x, tableau.increment(side, t, x, h))
    if isinstance(scheme, Projected):
        tableau = _Tableau.of(scheme.of)
        return lambda t, x, h: _sum(x, _moved_onto_levels(side, t, x, h, tableau.increment(side, t, x, h)))
    weights = [_real(w) for w in scheme.weights] if isinstance(scheme, Composition) else [mpmath.mpf(1)]
    return lambda t, x, h: _composed(side, t, x, h, weights)


def _composed(side: _Functions, t: Any, x: Reals, h: Any, weights: Reals) -> Reals:
    for weight in weights:
        x, t = _dmm2(side, t, x, weight * h), t + weight * h
    return x


def _dmm2(side: _Functions, t: Any, x: Reals, h: Any) -> Reals:
    """Solve x₁ = x + h fᵗ(t, x, t + h, x₁)."""

    def residual(*end: Any) -> Reals:
        return [b - a - h * f for a, b, f in zip(x, end, side.discrete_field(t, *x, t + h, *end), strict=True)]

    return _root(residual, _sum(x, [h * f for f in side.field(t, *x)]))


class _Tableau(NamedTuple):
    nodes: Reals
    rows: list[Reals]
    weights: Reals
    explicit: bool

    @classmethod
    def of(cls, scheme: ButcherTableau) -> _Tableau:
        rows = [[_real(a) for a in row] for row in scheme.rows]
        return cls([mpmath.fsum(row) for row in rows], rows, [_real(b) for b in scheme.weights], scheme.explicit)

    def increment(self, side: _Functions, t: Any, x: Reals, h: Any) -> Reals:
        stages = self._explicit(side, t, x, h) if self.explicit else self._implicit(side, t, x, h)
        return _weighted(h, self.weights, stages)

    def _explicit(self, side: _Functions, t: Any, x: Reals, h: Any) -> list[Reals]:
        stages: list[Reals] = []
        for node, row in zip(self.nodes, self.rows, strict=True):
            stages.append(side.field(t + node * h, *(_sum(x, _weighted(h, row, stages)) if stages else x)))
        return stages

    def _implicit(self, side: _Functions, t: Any, x: Reals, h: Any) -> list[Reals]:
        d = len(x)

        def residual(*values: Any) -> Reals:
            stages = [values[i : i + d] for i in range(0, len(values), d)]
            wanted = [
                side.field(t + node * h, *_sum(x, _weighted(h, row, stages)))
                for node, row in zip(self.nodes, self.rows, strict=True)
            ]
            return [a - b for k, f in zip(stages, wanted, strict=True) for a, b in zip(k, f, strict=True)]

        values = _root(residual, side.field(t, *x) * len(self.rows))
        return [values[i : i + d] for i in range(0, len(values), d)]


def _moved_onto_levels(side: _Functions, t: Any, x: Reals, h: Any, increment: Reals) -> Reals:
    """Move an increment Δ along Λᵗ until Λᵗ Δ + h s_t = 0."""
    ends = (t, *x, t + h, *_sum(x, increment))
    directions = np.reshape(side.gradient(*ends), (side.m, len(x)))

    def moved(shares: Sequence[Any]) -> Reals:
        return list(np.array(increment) - np.array(shares) @ directions)

    def residual(*shares: Any) -> Reals:
        change = moved(shares)
        ends = (t, *x, t + h, *_sum(x, change))
        rows = np.reshape(side.gradient(*ends), directions.shape)
        return list(rows @ change + h * np.array(side.time_slope(*ends)))

    return moved(_root(residual, [mpmath.mpf(0)] * side.m))


def _root(residual: Callable[..., Reals], start: Reals) -> Reals:
    """Where all residuals vanish, by Newton's method."""
    return list(mpmath.findroot(residual, start, tol=TOLERANCE))


def _real(number: sympy.Expr) -> Any:
    """A number of a declaration, in all digits."""
    return mpmath.mpf(str(sympy.N(number, DIGITS + 5)))


def _sum(x: Reals, change: Sequence[Any]) -> Reals:
    return [a + b for a, b in zip(x, change, strict=True)]


def _weighted(h: Any, weights: Reals, stages: Sequence[Sequence[Any]]) -> Reals:
    """h Σ bₖ kₖ."""
    return [
        h * mpmath.fsum(b * k for b, k in zip(weights, column, strict=False)) for column in zip(*stages, strict=True)
    ]
