"""The schemes in as many digits as are wanted: what a compiled run should be, and orders that doubles do not show.

Written anew with mpmath. It shares the discrete field with `core`, and nothing of how that is compiled, how a step is
solved for or how a crossing is found. It is a thousand times slower, and expects no more than one crossing in a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import mpmath
import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

import core
from core.methods import ButcherTableau, Composition, Projected
from core.symbolic import DIFFERENCES, TIME, Side

__all__ = ["Met", "crossings_in_digits", "slopes_in_digits"]

Real: TypeAlias = Any  # mpmath.mpf, which has no types
Reals: TypeAlias = list[Real]
Step: TypeAlias = Callable[["_Side", Real, Reals, Real], Reals]

_MOST_ITERATIONS = 100


class Met(NamedTuple):
    """A crossing."""

    t: Real
    x: Reals


def crossings_in_digits(
    system: core.PiecewiseSystem, method: str, tau: float, count: int, digits: int = 34
) -> list[Met]:
    """Cross the surface so many times from x0 of the system, with steps of `tau`: paper, Algorithm 1.

    Parameters
    ----------
    method
        A key of METHODS, with a fixed step size.

    Raises
    ------
    ValueError
        If a step cannot be solved for, or has no one crossing in it where the sign of g changes.
    """
    with mpmath.workdps(digits):
        step = _step_of(method)
        sides = {sign: _Side(system, system.laws.sides[sign]) for sign in (-1, 1)}
        g = _compiled(system, [TIME, *system.laws.x], [system.laws.g])
        size, t, x, n = mpmath.mpf(tau), mpmath.mpf(0), [mpmath.mpf(v) for v in system.x0], 0
        sign, found = 1 if g(t, *x)[0] > 0 else -1, list[Met]()
        while len(found) < count:
            side, h = sides[sign], (n + 1) * size - t

            def height(part: Real, side: _Side = side, t: Real = t, x: Reals = x) -> Real:
                return g(t + part, *step(side, t, x, part))[0]

            if height(h) * sign > 0:
                n += 1
                t, x = n * size, step(side, t, x, h)
                continue
            part = _root(height, h, sign, h / 1000 if found and t == found[-1].t else mpmath.mpf(0))
            t, x, sign = t + part, step(side, t, x, part), -sign
            found.append(Met(t, x))
        return found


def slopes_in_digits(
    system: core.PiecewiseSystem, method: str, taus: Sequence[float], numbers: Sequence[int], digits: int = 34
) -> NDArray[np.float64]:
    """Orders of the crossing times, from runs whose step sizes are each the same part of the one before.

    Differences of neighbouring runs fall as their errors do, and need no solution to compare with.

    Parameters
    ----------
    taus
        A falling geometric sequence of n ≥ 3.
    numbers
        k numbers of crossings, increasing from 1.

    Returns
    -------
    (k, n − 2) slopes, from the coarsest three to the finest.
    """
    with mpmath.workdps(digits):
        runs = [crossings_in_digits(system, method, tau, numbers[-1], digits) for tau in taus]
        times = [[run[k - 1].t for run in runs] for k in numbers]
        gaps = [[float(mpmath.log(abs(a - b))) for a, b in pairwise(row)] for row in times]
    slopes: NDArray[np.float64] = -np.diff(gaps) / np.log(taus[0] / taus[1])
    return slopes


class _Side:
    """One side's f and discrete field, as functions of (t, *x) and of (t, *x, t1, *x1)."""

    def __init__(self, system: core.PiecewiseSystem, side: Side) -> None:
        self.d, self.m = len(side.field), len(side.conserved)
        x, ends = list(side.variables), side.discrete.ends
        at, between = [TIME, *x], [ends.times[0], *ends.start, ends.times[1], *ends.end]
        self.field = _compiled(system, at, side.field)
        self.slopes = _compiled(system, at, [f.diff(v) for f in side.field for v in x])
        self.normals = _compiled(system, at, [psi.diff(v) for psi in side.conserved for v in x])
        self.discrete = _compiled(system, between, list(side.discrete.expression))
        self.rows = _compiled(system, between, list(side.discrete.gradient))
        self.time_slope = _compiled(system, between, list(side.discrete.time_slope))


def _compiled(system: core.PiecewiseSystem, names: Sequence[Symbol], expressions: Sequence[Expr]) -> Any:
    """The function of these names; a parameter is the number that its double is."""
    values = zip(system.laws.p, system.parameter_array.tolist(), strict=True)
    numbers = {symbol: sympy.Rational(value) for symbol, value in values}
    differences = {cls.__name__: _difference(getattr(mpmath, phi.__name__)) for phi, cls in DIFFERENCES.items()}
    inserted = [sympy.sympify(e).xreplace(numbers) for e in expressions]
    return sympy.lambdify(list(names), inserted, [differences, "mpmath"], cse=True)


def _difference(phi: Callable[[Real], Real]) -> Callable[[Real, Real], Real]:
    """φ[a, b], which costs digits where a and b are close: there are more of them."""

    def divided(a: Real, b: Real) -> Real:
        if a == b:
            return mpmath.diff(phi, a)
        with mpmath.extradps(20):
            return (phi(b) - phi(a)) / (b - a)

    return divided


def _step_of(method: str) -> Step:
    """A step from the declaration of its method."""
    scheme = core.METHODS[method].scheme
    if isinstance(scheme, Projected):
        tableau = _Tableau.of(scheme.of)
        return lambda side, t, x, h: _arrived(x, _moved_onto_levels(side, t, x, h, _explicit(side, t, x, h, tableau)))
    if isinstance(scheme, ButcherTableau):
        tableau, change = _Tableau.of(scheme), _explicit if scheme.explicit else _implicit
        return lambda side, t, x, h: _arrived(x, change(side, t, x, h, tableau))
    weights = [_digits(w) for w in scheme.weights] if isinstance(scheme, Composition) else [mpmath.mpf(1)]
    return lambda side, t, x, h: _composed(side, t, x, h, weights)


def _digits(number: Expr) -> Real:
    """A number of a declaration, in the digits of here."""
    return mpmath.mpf(str(sympy.N(number, mpmath.mp.dps + 5)))


def _arrived(x: Reals, change: Reals) -> Reals:
    return [a + b for a, b in zip(x, change, strict=True)]


def _composed(side: _Side, t: Real, x: Reals, h: Real, weights: Sequence[Real]) -> Reals:
    for weight in weights:
        x, t = _dmm2(side, t, x, weight * h), t + weight * h
    return x


def _dmm2(side: _Side, t: Real, x: Reals, h: Real) -> Reals:
    """Solve Δ = h fᵗ(x, x + Δ) with half the slope of f in the middle for that of fᵗ: an error of h² a time."""
    change = [h * f for f in side.field(t, *x)]
    middle = [a + b / 2 for a, b in zip(x, change, strict=True)]
    slopes = np.array([float(s) for s in side.slopes(t + h / 2, *middle)]).reshape(side.d, side.d)
    matrix = np.eye(side.d) - float(h) / 2 * slopes
    last = mpmath.inf
    for _ in range(_MOST_ITERATIONS):
        end = [a + b for a, b in zip(x, change, strict=True)]
        left = [a - h * f for a, f in zip(change, side.discrete(t, *x, t + h, *end), strict=True)]
        correction = _solved(matrix, left)
        change = [a - b for a, b in zip(change, correction, strict=True)]
        size = max(map(abs, correction))
        if size <= 100 * mpmath.eps * max(map(abs, x)) and size >= last / 2:
            return [a + b for a, b in zip(x, change, strict=True)]
        last = size
    raise ValueError(f"a step of {float(h):g} at t = {float(t):g} cannot be solved for: shorter steps may do")


def _solved(matrix: NDArray[np.float64], left: Reals) -> Reals:
    """Solve a small system to the digits of a double: what is iterated gains as many each time."""
    size = max(map(abs, left)) or mpmath.mpf(1)
    return [size * mpmath.mpf(v) for v in np.linalg.solve(matrix, [float(v / size) for v in left]).tolist()]


class _Tableau(NamedTuple):
    nodes: Reals
    rows: list[Reals]
    weights: Reals

    @classmethod
    def of(cls, scheme: ButcherTableau) -> _Tableau:
        rows = [[_digits(a) for a in row] for row in scheme.rows]
        return cls([mpmath.fsum(row) for row in rows], rows, [_digits(b) for b in scheme.weights])


def _explicit(side: _Side, t: Real, x: Reals, h: Real, tableau: _Tableau) -> Reals:
    slopes: list[Reals] = []
    for node, row in zip(tableau.nodes, tableau.rows, strict=True):
        slopes.append(side.field(t + node * h, *_moved(x, h, row, slopes)))
    return _combined(h, tableau.weights, slopes, side.d)


def _implicit(side: _Side, t: Real, x: Reals, h: Real, tableau: _Tableau) -> Reals:
    """Iterate the stages until they no longer change: a factor of h a time."""
    slopes = [side.field(t, *x)] * len(tableau.rows)
    for _ in range(_MOST_ITERATIONS):
        new = [
            side.field(t + node * h, *_moved(x, h, row, slopes))
            for node, row in zip(tableau.nodes, tableau.rows, strict=True)
        ]
        size = max(abs(a - b) for k, m in zip(new, slopes, strict=True) for a, b in zip(k, m, strict=True))
        slopes = new
        if size * h <= 10 * mpmath.eps * max(map(abs, x)):
            return _combined(h, tableau.weights, slopes, side.d)
    raise ValueError(f"a step of {float(h):g} at t = {float(t):g} cannot be solved for: shorter steps may do")


def _moved(x: Reals, h: Real, row: Reals, slopes: Sequence[Reals]) -> Reals:
    return [a + h * mpmath.fsum(r * s[i] for r, s in zip(row, slopes, strict=False)) for i, a in enumerate(x)]


def _combined(h: Real, weights: Reals, slopes: Sequence[Reals], d: int) -> Reals:
    return [h * mpmath.fdot(weights, [s[i] for s in slopes]) for i in range(d)]


def _moved_onto_levels(side: _Side, t: Real, x: Reals, h: Real, change: Reals) -> Reals:
    """Move an increment along Λᵗ until Λᵗ Δ + h s_t = 0; ∇ψ at its end tells how far, as Newton's method would."""
    d, m = range(side.d), range(side.m)
    for _ in range(_MOST_ITERATIONS):
        end = [a + b for a, b in zip(x, change, strict=True)]
        rows, normals = side.rows(t, *x, t + h, *end), side.normals(t + h, *end)
        still = side.time_slope(t, *x, t + h, *end)
        left = [mpmath.fdot((rows[j * side.d + i], change[i]) for i in d) + h * still[j] for j in m]
        if max(map(abs, left)) <= 100 * mpmath.eps:
            return change
        matrix = [
            [float(mpmath.fdot((normals[j * side.d + i], rows[k * side.d + i]) for i in d)) for k in m] for j in m
        ]
        share = _solved(np.array(matrix), left)
        change = [a - mpmath.fdot((share[k], rows[k * side.d + i]) for k in m) for i, a in zip(d, change, strict=True)]
    raise ValueError(f"a step of {float(h):g} at t = {float(t):g} cannot be moved onto the level")


def _root(height: Callable[[Real], Real], h: Real, sign: int, after: Real) -> Real:
    """Where in a step the surface is: secants, and halves where one leads astray."""
    a, b = after, h
    p, q = (a, height(a)), (b, height(b))
    if p[1] * sign < 0:
        raise ValueError(f"a step of {float(h):g} has more than one crossing in it, or none: shorter steps may do")
    for _ in range(_MOST_ITERATIONS):
        part = q[0] - q[1] * (q[0] - p[0]) / (q[1] - p[1]) if q[1] != p[1] else a
        if not a < part < b:
            part = (a + b) / 2
        p, q = q, (part, height(part))
        a, b = (part, b) if q[1] * sign > 0 else (a, part)
        if abs(q[0] - p[0]) <= mpmath.sqrt(mpmath.eps) * h:  # the next would err by its square
            return q[0] - q[1] * (q[0] - p[0]) / (q[1] - p[1]) if q[1] != p[1] else q[0]
    raise ValueError(f"the surface was not found in a step of {float(h):g}")
