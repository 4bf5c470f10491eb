"""METHODS: each a name, an order, what it keeps, and how its step is written. A new integrator is one function here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from scipy.integrate import DOP853
from sympy import Expr, Float, Integer, Matrix, Rational, symbols

from core.codegen.printing import fma
from core.codegen.step import StepCode
from core.symbolic.laws import Side

__all__ = ["METHODS", "Method", "method_named"]

Builder = Callable[[Side, StepCode], Sequence[Expr]]


@dataclass(frozen=True)
class Method:
    """A one-step method."""

    name: str
    """Its key in METHODS."""
    order: int | None
    """Order of its global error; None where it is chosen from the tolerance."""
    conservative: bool
    """Whether it keeps the conserved quantities to round-off."""
    symmetric: bool
    """Whether a step back undoes a step forward."""
    doc: str
    """What it is, in a sentence."""
    build: Builder
    """Writes the step and returns its increments."""
    needs_conserved: bool = False
    """Whether it makes no sense without a conserved quantity."""

    def __repr__(self) -> str:
        order = "order by tolerance" if self.order is None else f"order {self.order}"
        kept = [word for word, so in (("conservative", self.conservative), ("symmetric", self.symmetric)) if so]
        return f"<Method {self.name}: {', '.join([order, *kept])}>"

    @property
    def adaptive(self) -> bool:
        """Whether it chooses its own step size, from a tolerance."""
        return self.order is None


def dmm2(side: Side, step: StepCode) -> Sequence[Expr]:
    """x₁ = x₀ + h fᵗ(t₀, x₀, t₁, x₁), paper (eq:twoSchemes)."""
    return step.hold(_dmm2(side, step))


def _dmm2(side: Side, step: StepCode) -> Sequence[Expr]:
    """Write dmm2 as such.

    Where ψ does not fix the orbit alone, the minimal-norm DMM is solved as a saddle-point system with multipliers λ,
    which has no inverse of ΛᵗΛᵗᵀ in it:  Δ − h f̄ + Λᵗᵀ λ = 0,  Λᵗ Δ + h s_t = 0.
    """
    discrete = side.discrete
    d, m = len(side.field), len(side.conserved)
    increment = Matrix(step.increment)
    if discrete.factor is not None or m == 0:
        return step.solve(list(increment - step.h * Matrix(step.at_ends(discrete.expression))))
    multipliers = symbols(f"l:{m}")
    rows = Matrix(m, d, step.at_ends(discrete.gradient))
    mean_field = Matrix(step.at_ends(discrete.mean_field))
    time_slope = Matrix(step.at_ends(discrete.time_slope))
    motion = increment - step.h * mean_field + rows.T * Matrix(multipliers)
    conservation = rows * increment + step.h * time_slope
    return step.solve([*motion, *conservation], multipliers)


#: Weights of symmetric compositions. Order 4: Suzuki, Phys. Lett. A 146 (1990). Orders 6 and 8: Kahan and Li, Math.
#: Comp. 66 (1997), s9odr6a and s17odr8a; see Hairer, Lubich, Wanner, Geometric Numerical Integration, V.3.2.
_SUZUKI4 = (1 / (4 - 4 ** (1 / 3)),) * 2
_KAHAN_LI6 = (0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.082213596293550800230)
_KAHAN_LI8 = (
    0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
    -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887,
)  # fmt: skip


def composition(half: Sequence[float]) -> Builder:
    """The method of dmm2 steps with these weights, the one in the middle that makes the sum 1, and these again back.

    Symmetric and conservative because dmm2 is; the weights raise its order.
    """
    weights = (*half, 1 - 2 * math.fsum(half), *reversed(half))

    def build(side: Side, step: StepCode) -> Sequence[Expr]:
        return step.hold(step.compose(weights, lambda: _dmm2(side, step)))

    return build


def rk2(side: Side, step: StepCode) -> Sequence[Expr]:
    """Explicit midpoint, the paper's baseline."""
    t, h = step.t, step.h
    k1 = step.field(t)
    k2 = step.field(t + h / 2, [h / 2 * a for a in k1])
    return [h * b for b in k2]


def rk4(side: Side, step: StepCode) -> Sequence[Expr]:
    """The classical Runge-Kutta method."""
    t, h = step.t, step.h
    k1 = step.field(t)
    k2 = step.field(t + h / 2, [h / 2 * a for a in k1])
    k3 = step.field(t + h / 2, [h / 2 * b for b in k2])
    k4 = step.field(t + h, [h * c for c in k3])
    return [h * Rational(1, 6) * (a + 2 * b + 2 * c + e) for a, b, c, e in zip(k1, k2, k3, k4, strict=True)]


def rk8(side: Side, step: StepCode) -> Sequence[Expr]:
    """The 8th-order weights of Dormand and Prince's DOP853 (Hairer, Nørsett, Wanner I, II.5), as SciPy holds them."""
    slopes: list[Sequence[Expr]] = []
    for nodes, row in zip(DOP853.C, DOP853.A, strict=True):
        at = step.t + Float(nodes) * step.h if nodes else step.t
        slopes.append(step.field(at, _weighted(step, row, slopes) if slopes else None))
    return _weighted(step, DOP853.B, slopes)


def _weighted(step: StepCode, weights: Iterable[float], slopes: Sequence[Sequence[Expr]]) -> list[Expr]:
    """h Σ bₖ kₖ, the slope that was worked out last being added last: the rest is there before it is."""
    sums = [Integer(0)] * len(step.x)
    for b, k in zip(weights, slopes, strict=False):
        if b:
            sums = [
                fma(Float(b), slope, total) if total else Float(b) * slope for slope, total in zip(k, sums, strict=True)
            ]
    return [step.h * total for total in sums]


def prk8(side: Side, step: StepCode) -> Sequence[Expr]:
    """rk8, its increment moved along the discrete gradient."""
    return step.move_onto_levels(rk8(side, step))


def taylor(side: Side, step: StepCode) -> Sequence[Expr]:
    """The Taylor series of the solution, its increment moved along the discrete gradient."""
    return step.move_onto_levels(step.polynomial(), prepared=True)


#: Every integrator by name.
METHODS: Mapping[str, Method] = MappingProxyType({
    m.name: m
    for m in (
        Method("dmm2", 2, True, True, "Discrete Multiplier Method: keeps every ψ to round-off, symmetric.", dmm2, True),
        Method("dmm4", 4, True, True, "Five steps of dmm2 (Suzuki): ψ kept, symmetric.", composition(_SUZUKI4), True),
        Method("dmm6", 6, True, True, "Nine of dmm2 (Kahan, Li): ψ kept, symmetric.", composition(_KAHAN_LI6), True),
        Method("dmm8", 8, True, True, "17 of dmm2 (Kahan, Li): ψ kept, symmetric.", composition(_KAHAN_LI8), True),
        Method("rk2", 2, False, False, "Explicit midpoint: the paper's baseline, whose ψ drifts.", rk2),
        Method("rk4", 4, False, False, "Classical Runge-Kutta: accurate for a while, ψ drifts slowly.", rk4),
        Method("rk8", 8, False, False, "Dormand and Prince's explicit method of order 8: ψ drifts, slower.", rk8),
        Method("prk8", 8, True, False, "rk8 moved onto ψ: a conservative method that is explicit.", prk8, True),
        Method("taylor", None, True, False, "Taylor series moved onto ψ; order and step from a tolerance.", taylor),
    )
})  # fmt: skip


def method_named(method: str | Method) -> Method:
    """The method of that name, or the method itself where it is one of METHODS.

    Raises
    ------
    ValueError
        If there is none.
    """
    name = method.name if isinstance(method, Method) else method
    found = METHODS.get(name) if isinstance(name, str) else None
    if found is None or (isinstance(method, Method) and method != found):
        raise ValueError(f"unknown method {method!r}; known are {', '.join(METHODS)}")
    return found
