r"""Conserved quantities → discrete gradient → discrete vector field: the Discrete Multiplier Method (DMM).

The discrete gradient is made of *slopes*. Each expression u of (x, t) has slopes sᵢ such that

    u(t₁, x₁) − u(t₀, x₀) = Σ sᵢ Δxᵢ + s_t Δt      exactly, and symmetric under 0 ↔ 1:

a variable has slope 1; sums add; a product has mean(u)·s(v) + mean(v)·s(u); a power xⁿ has Σ x₀ʲ x₁ⁿ⁻¹⁻ʲ; an
elementary function φ has φ[u₀, u₁], its divided difference. One pass over ψ gives Λᵗ with Λᵗ·Δx = Δψ and no 0/0.

References: Wan, Bihlo, Nave, SIAM J. Numer. Anal. 55 (2017); McLachlan, Quispel, Robidoux, Phil. Trans. R. Soc. A
357 (1999). The scheme is (eq:twoSchemes) of the paper.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import cancel, together
from core.symbolic.expressions import TIME
from core.symbolic.zero_testing import is_zero

__all__ = ["DiscreteField", "DividedDifference", "Endpoints", "slopes"]


class DividedDifference(sympy.Function):
    """φ[a, b] of an elementary function φ, with φ[a, a] = φ'(a). Compiled as in `divided`."""

    nargs = 2
    phi: Any  # the sympy function
    template: str  # LaTeX in (A, B)

    @classmethod
    def eval(cls, a: Expr, b: Expr) -> Expr | None:
        """The derivative where both ends are equal, else None: leave unevaluated."""
        if a == b:
            u = sympy.Dummy()
            return cls.phi(u).diff(u).subs(u, a)
        return None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Derivative with respect to one end: φ[a, b, b], or by symmetry φ[b, a, a]."""
        a, b = self.args if argindex == 2 else reversed(self.args)
        return SECOND[type(self)](a, b)

    def _latex(self, printer: Any) -> str:
        ends = dict(zip("AB", map(printer.doprint, self.args), strict=True))
        return re.sub(
            "[AB]", lambda found: ends[found[0]], self.template
        )  # in one pass: the ends may contain these letters


class SecondDifference(sympy.Function):
    """φ[a, b, b], the derivative of φ[a, b] in b: for Newton's method only."""

    nargs = 2


def _differences() -> dict[Any, type[DividedDifference]]:
    mean, half = r"\left(\tfrac{A+B}{2}\right)", r"\left(\tfrac{B-A}{2}\right)"
    templates = {
        sympy.sin: rf"\cos{mean}\operatorname{{sinc}}{half}",
        sympy.cos: rf"-\sin{mean}\operatorname{{sinc}}{half}",
        sympy.tan: r"\frac{\operatorname{sinc}\left(B-A\right)}{\cos\left(A\right)\cos\left(B\right)}",
        sympy.exp: rf"e^{{(A+B)/2}}\operatorname{{sinhc}}{half}",
        sympy.log: r"\frac{\log\left(B\right)-\log\left(A\right)}{B-A}",
        sympy.sinh: rf"\cosh{mean}\operatorname{{sinhc}}{half}",
        sympy.cosh: rf"\sinh{mean}\operatorname{{sinhc}}{half}",
        sympy.tanh: r"\frac{\operatorname{sinhc}\left(B-A\right)}{\cosh\left(A\right)\cosh\left(B\right)}",
    }
    return {
        phi: type(f"{phi.__name__}_slope", (DividedDifference,), {"phi": phi, "template": text})
        for phi, text in templates.items()
    }


#: φ -> the class of φ[a, b].
DIFFERENCES = _differences()
#: The class of φ[a, b] -> the class of φ[a, b, b].
SECOND = {cls: type(f"{cls.__name__}_b", (SecondDifference,), {}) for cls in DIFFERENCES.values()}


@dataclass(frozen=True)
class Endpoints:
    """The symbols of a step from (t₀, x₀) to (t₁, x₁)."""

    variables: tuple[Symbol, ...]
    start: tuple[Symbol, ...]
    end: tuple[Symbol, ...]
    times: tuple[Symbol, Symbol]

    @classmethod
    def of(cls, variables: Sequence[Symbol], taken: set[str]) -> Endpoints:
        """Name the ends ``x_0, x_1, t_0, t_1``, with underscores added where such a name is taken."""
        tail = ""
        while any(f"{v}{tail}_{k}" in taken for v in (*variables, TIME) for k in "01"):
            tail += "_"
        ends = [tuple(Symbol(f"{v}{tail}_{k}") for v in (*variables, TIME)) for k in "01"]
        return cls(tuple(variables), ends[0][:-1], ends[1][:-1], (ends[0][-1], ends[1][-1]))

    @property
    def at_start(self) -> dict[Symbol, Expr]:
        """Variables and time -> their values at the start."""
        return {**dict(zip(self.variables, self.start, strict=True)), TIME: self.times[0]}

    @property
    def at_end(self) -> dict[Symbol, Expr]:
        """Variables and time -> their values at the end."""
        return {**dict(zip(self.variables, self.end, strict=True)), TIME: self.times[1]}

    @property
    def at_middle(self) -> dict[Symbol, Expr]:
        """Variables and time -> the mean of their values at both ends: symmetric, hence of second order."""
        end = self.at_end
        return {v: (a + end[v]) / 2 for v, a in self.at_start.items()}


def slopes(expression: Expr, ends: Endpoints) -> tuple[Expr, ...]:
    """Slopes of `expression` in its variables and, last, in time.

    Returns
    -------
    tuple of d + 1 expressions in `ends` with Σ sᵢ (x₁ − x₀)ᵢ + s_t (t₁ − t₀) = u(t₁, x₁) − u(t₀, x₀).
    """
    return _Slopes(ends).of(expression)


class _Slopes:
    """The recursion of `slopes`, which treats every shared subexpression once."""

    def __init__(self, ends: Endpoints) -> None:
        self.start: Mapping[Symbol, Expr] = ends.at_start
        self.end: Mapping[Symbol, Expr] = ends.at_end
        self.inputs = (*ends.variables, TIME)
        self.known: dict[Expr, tuple[Expr, ...]] = {}

    def of(self, u: Expr) -> tuple[Expr, ...]:
        if u not in self.known:
            self.known[u] = self.derive(u)
        return self.known[u]

    def derive(self, u: Expr) -> tuple[Expr, ...]:
        if not u.free_symbols & set(self.inputs):
            return (sympy.Integer(0),) * len(self.inputs)
        if u.is_Symbol:
            return tuple(sympy.Integer(int(u == v)) for v in self.inputs)
        if u.is_Add:
            return tuple(sum(s) for s in zip(*map(self.of, u.args), strict=True))
        if u.is_Mul:
            left, right = u.as_two_terms()
            return self.product(left, right)
        if u.is_Pow:
            return self.power(u.base, u.exp)
        return self.chain(DIFFERENCES[u.func], u.args[0])

    def ends_of(self, u: Expr) -> tuple[Expr, Expr]:
        return u.xreplace(self.start), u.xreplace(self.end)

    def mean(self, u: Expr) -> Expr:
        a, b = self.ends_of(u)
        return (a + b) / 2

    def product(self, u: Expr, v: Expr) -> tuple[Expr, ...]:
        mean_u, mean_v = self.mean(u), self.mean(v)
        return tuple(mean_u * s + mean_v * r for r, s in zip(self.of(u), self.of(v), strict=True))

    def chain(self, difference: type[DividedDifference], u: Expr) -> tuple[Expr, ...]:
        outer = difference(*self.ends_of(u))
        return tuple(outer * s for s in self.of(u))

    def power(self, base: Expr, exponent: Expr) -> tuple[Expr, ...]:
        """Slopes of uᵖ: a sum of products if p is a small rational, those of exp(p log u) otherwise."""
        if exponent.is_Rational and abs(exponent.p) <= 64 and exponent.q <= 12:
            a, b = self.ends_of(base)
            outer = _power_slope(a, b, exponent)
            return tuple(outer * s for s in self.of(base))
        inner = self.of(exponent * sympy.log(base))
        difference = DIFFERENCES[sympy.exp]
        outer = difference(*self.ends_of(exponent * sympy.log(base)))
        return tuple(outer * s for s in inner)


def _power_slope(a: Expr, b: Expr, exponent: sympy.Rational) -> Expr:
    """(bᵖ − aᵖ)/(b − a) for rational p = n/q, through the q-th roots α, β: (βⁿ − αⁿ)/(β^q − α^q)."""
    n, q = int(exponent.p), int(exponent.q)
    alpha, beta = (u ** sympy.Rational(1, q) for u in (a, b))
    slope = _integer_power_slope(alpha, beta, abs(n)) / _factored_power_slope(alpha, beta, q)
    return slope if n > 0 else -slope / (alpha * beta) ** abs(n)


def _integer_power_slope(a: Expr, b: Expr, n: int) -> Expr:
    return sympy.Add(*(a**j * b ** (n - 1 - j) for j in range(n)))


def _factored_power_slope(a: Expr, b: Expr, n: int) -> Expr:
    """The same by (aⁿ − bⁿ) = (a^(n/2) + b^(n/2)) (a^(n/2) − b^(n/2)), which saves operations where n is even."""
    if n % 2 or n < 4:
        return _integer_power_slope(a, b, n)
    return (a ** (n // 2) + b ** (n // 2)) * _factored_power_slope(a, b, n // 2)


@dataclass(frozen=True)
class DiscreteField:
    """The DMM of one mode: the discrete gradient of its ψ, and the discrete field fᵗ.

    Parameters
    ----------
    field
        f, d expressions in the variables and t.
    conserved
        ψ, m ≤ d − 1 expressions.
    ends
        The symbols of the step.
    written
        What rewrites an expression for evaluation.
    """

    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    ends: Endpoints
    written: Callable[[Expr], Expr] = lambda u: u

    @cached_property
    def _all_slopes(self) -> tuple[tuple[Expr, ...], ...]:
        return tuple(slopes(psi, self.ends) for psi in self.conserved)

    @property
    def gradient(self) -> sympy.Matrix:
        """Λᵗ, the discrete gradient: (m, d) with Λᵗ (x₁ − x₀) = ψ(x₁) − ψ(x₀) at equal times."""
        return sympy.Matrix(len(self.conserved), len(self.field), [s for row in self._all_slopes for s in row[:-1]])

    @property
    def time_slope(self) -> sympy.Matrix:
        """s_t, (m, 1): zero where ψ does not depend on t."""
        return sympy.Matrix(len(self.conserved), 1, [row[-1] for row in self._all_slopes])

    @property
    def mean_field(self) -> sympy.Matrix:
        """f at the middle of the step, (d, 1): symmetric and of second order, but not conservative."""
        return sympy.Matrix([self.written(f).xreplace(self.ends.at_middle) for f in self.field])

    @cached_property
    def factor(self) -> Expr | None:
        """The c of f = c·n(∇ψ) where ψ fixes the orbit (m = d − 1, no t in ψ) and c has no pole, else None."""
        if len(self.conserved) != len(self.field) - 1 or any(psi.has(TIME) for psi in self.conserved):
            return None
        variables = self.ends.variables
        normal = generalised_cross(sympy.Matrix([[psi.diff(v) for v in variables] for psi in self.conserved]))
        candidates = [_ratio(f, n) for f, n in zip(self.field, normal, strict=True) if n != 0]
        regular = [c for c in candidates if not sympy.denom(c).free_symbols & {*variables, TIME}]
        for c in sorted(regular, key=sympy.count_ops):
            if all(is_zero(f - c * n) for f, n in zip(self.field, normal, strict=True)):
                return c
        return None

    @cached_property
    def expression(self) -> sympy.Matrix:
        """fᵗ itself, (d, 1), in the symbols of `ends`: what the paper prints, and LaTeX shows.

        c̄·n(Λᵗ) where ψ fixes the orbit, f̄ − Λᵗᵀ(ΛᵗΛᵗᵀ)⁻¹(Λᵗ f̄ + s_t) otherwise (the minimal-norm DMM).
        """
        if self.factor is not None:
            factor = self.written(self.factor)
            start, end = (factor.xreplace(at) for at in (self.ends.at_start, self.ends.at_end))
            return (start + end) / 2 * generalised_cross(self.gradient)
        if not self.conserved:
            return self.mean_field
        rows = self.gradient
        residual = rows * self.mean_field + self.time_slope
        return self.mean_field - rows.T * _inverse(rows * rows.T) * residual


def generalised_cross(rows: sympy.Matrix) -> sympy.Matrix:
    """The vector n, (d, 1), orthogonal to the d − 1 rows: signed maximal minors, (ψ_y, −ψ_x) in the plane."""
    d = rows.cols
    minors = []
    for i in range(d):
        others = rows[:, [j for j in range(d) if j != i]]
        minors.append((-1) ** i * others.det(method="berkowitz"))
    return sympy.Matrix(minors)


def _inverse(matrix: sympy.Matrix) -> sympy.Matrix:
    """Inverse by cofactors, of placeholders, so that sympy does not try to simplify the entries."""
    m = matrix.rows
    blank = sympy.Matrix(m, m, sympy.symbols(f"n:{m * m}"))
    inverse = blank.adjugate() / blank.det(method="berkowitz")
    return inverse.xreplace(dict(zip(blank, matrix, strict=True)))


def _ratio(f: Expr, n: Expr) -> Expr:
    """f/n with common factors cancelled; sympy treats functions of the variables as further variables."""
    return cancel(together(f / n))
