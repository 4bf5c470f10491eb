"""Runge-Kutta methods: a tableau is all there is to one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr, Float, Integer, Poly, Rational, Symbol, sqrt, symbols

from core.codegen.printing import fma
from core.codegen.step import StepCode
from core.methods.base import Method, Scheme, written_sum
from core.methods.dop853 import ROWS, WEIGHTS
from core.symbolic.expressions import TIME
from core.symbolic.mode import Mode

__all__ = ["CLASSICAL", "DOP853", "GAUSS4", "RK2", "RK4", "RK8", "ButcherTableau"]

#: Bound on the rounding of a product of coefficients.
_ROUNDING = 1e-15


@dataclass(frozen=True)
class ButcherTableau(Scheme):
    """kᵢ = f(t + cᵢ h, x + h Σ aᵢⱼ kⱼ), Δ = h Σ bᵢ kᵢ, with cᵢ = Σ aᵢⱼ.

    Attributes
    ----------
    rows
        aᵢⱼ for each stage, exact or to thirty digits. A row may omit its last zeros.
    weights
        bᵢ.
    order, symmetric
        As in `Scheme`.
    source
        Source of the coefficients, in words; empty if they are few enough to be displayed.
    """

    rows: tuple[tuple[Expr, ...], ...]
    weights: tuple[Expr, ...]
    order: int
    symmetric: bool = False
    family = "Runge–Kutta"
    source: str = ""

    @cached_property
    def nodes(self) -> tuple[Expr, ...]:
        """cᵢ."""
        return tuple(sum(row, Integer(0)) for row in self.rows)

    @cached_property
    def in_floats(self) -> tuple[list[float], list[list[float]], list[float]]:
        """Nodes, rows and weights, rounded to doubles."""
        return [*map(float, self.nodes)], [[*map(float, row)] for row in self.rows], [*map(float, self.weights)]

    @cached_property
    def explicit(self) -> bool:
        """Whether each stage depends on earlier ones only."""
        return not any(a for i, row in enumerate(self.rows) for a in row[i:])

    @cached_property
    def symplectic(self) -> bool:
        """Whether bᵢaᵢⱼ + bⱼaⱼᵢ = bᵢbⱼ: then every quadratic conserved quantity is kept (Cooper 1987)."""
        _, rows, b = self.in_floats
        a = [[*row, *[0.0] * (len(b) - len(row))] for row in rows]
        pairs = [(i, j) for i in range(len(b)) for j in range(len(b))]
        return all(abs(b[i] * a[i][j] + b[j] * a[j][i] - b[i] * b[j]) < _ROUNDING for i, j in pairs)

    def keeps(self, mode: Mode) -> bool:
        """Whether all conserved quantities are linear in the state, or, for a symplectic tableau, quadratic."""
        return all(_is_polynomial(psi, mode.variables, 2 if self.symplectic else 1) for psi in mode.conserved)

    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write one step: stage by stage if explicit, else all stages by Newton's method."""
        return self._write_explicit(step) if self.explicit else self._write_implicit(step)

    def _write_explicit(self, step: StepCode) -> Sequence[Expr]:
        slopes: list[Sequence[Expr]] = []
        for node, row in zip(self.nodes, self.rows, strict=True):
            at = step.t + _short(node) * step.h if node else step.t
            slopes.append(step.field(at, _weighted(step.h, row, slopes) if slopes else None))
        return _weighted(step.h, self.weights, slopes)

    def _write_implicit(self, step: StepCode) -> Sequence[Expr]:
        """Solve for all h kᵢ at once."""
        d, stages = len(step.x), len(self.rows)
        unknowns = symbols(f"d:{stages * d}")
        parts = [unknowns[i * d : (i + 1) * d] for i in range(stages)]
        residuals: list[Expr] = []
        for node, row, own in zip(self.nodes, self.rows, parts, strict=True):
            moved = _combined(row, parts, d)
            slopes = step.field_at(step.t + _short(node) * step.h, moved)
            residuals += [u - step.h * f for u, f in zip(own, slopes, strict=True)]
        step.solve(residuals, stages=stages)
        return _combined(self.weights, parts, d)


def _is_polynomial(psi: Expr, x: Sequence[Symbol], degree: int) -> bool:
    """Whether ψ is a polynomial in the state, of this degree at most, and does not depend on time."""
    return not psi.has(TIME) and psi.is_polynomial(*x) and bool(Poly(psi, *x).total_degree() <= degree)


def _short(number: Expr) -> Expr:
    """Round a decimal number to a double; keep an exact one."""
    return Float(float(number)) if number.has(Float) else number


def _weighted(h: Symbol, weights: Sequence[Expr], slopes: Sequence[Sequence[Expr]]) -> list[Expr]:
    """h Σ bₖ kₖ; the slope evaluated last is added last, so that only one operation waits for it."""
    used = [(_short(b), slope) for b, slope in zip(weights, slopes, strict=False) if b]
    if all(b.is_Rational for b, _ in used):  # sum with integer weights, exact for constant slopes
        whole = math.lcm(*(int(b.q) for b, _ in used))
        return [h / whole * sum(b * whole * slope[i] for b, slope in used) for i in range(len(slopes[0]))]
    sums = [Integer(0)] * len(slopes[0])
    for b, slope in used:
        sums = [fma(b, k, total) if total else b * k for k, total in zip(slope, sums, strict=True)]
    return [h * total for total in sums]


def _combined(weights: Sequence[Expr], parts: Sequence[Sequence[Symbol]], d: int) -> list[Expr]:
    """Σ bₖ uₖ over the unknowns of all stages."""
    return [sum((_short(b) * part[i] for b, part in zip(weights, parts, strict=False)), Integer(0)) for i in range(d)]


def _decimals(texts: Sequence[str]) -> tuple[Expr, ...]:
    return tuple(Float(text, 40) if "." in text else Integer(text) for text in texts)


_HALF = Rational(1, 2)

RK2 = Method(
    "rk2",
    ButcherTableau(((), (_HALF,)), (Integer(0), Integer(1)), 2),
    "Explicit midpoint rule, order 2: the method of comparison in the paper; it does not conserve ψ in general.",
)

CLASSICAL = ButcherTableau(
    ((), (_HALF,), (Integer(0), _HALF), (Integer(0), Integer(0), Integer(1))),
    (Rational(1, 6), Rational(1, 3), Rational(1, 3), Rational(1, 6)),
    4,
)

RK4 = Method(
    "rk4",
    CLASSICAL,
    "Classical Runge–Kutta method, order 4: explicit; in general it does not conserve ψ.",
)

DOP853 = ButcherTableau(
    tuple(map(_decimals, ROWS)),
    _decimals(WEIGHTS),
    8,
    source="Its weights are those of DOP853 (Hairer, Nørsett, Wanner, Solving ODEs I, II.5).",
)

RK8 = Method(
    "rk8",
    DOP853,
    "Explicit method of Dormand and Prince, order 8; in general it does not conserve ψ.",
)

#: Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3 and VI.4: symmetric, symplectic.
GAUSS4 = Method(
    "gauss4",
    ButcherTableau(
        (
            (Rational(1, 4), written_sum(Rational(1, 4), -sqrt(3) / 6)),
            (written_sum(Rational(1, 4), sqrt(3) / 6), Rational(1, 4)),
        ),
        (_HALF, _HALF),
        4,
        symmetric=True,
    ),
    "Gauss method of two stages, order 4: implicit, symplectic; conserves linear and quadratic ψ only.",
)
