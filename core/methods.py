"""METHODS: each a name, an order, what it keeps, and how its step is written. A new integrator is one function here."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from sympy import Expr, Matrix, Rational, symbols

from core.codegen import StepCode
from core.laws import Side

__all__ = ["METHODS", "Method", "method_named"]

Builder = Callable[[Side, StepCode], Sequence[Expr]]


@dataclass(frozen=True)
class Method:
    """A one-step method."""

    name: str
    """Its key in METHODS."""
    order: int
    """Order of its global error."""
    conservative: bool
    """Whether it keeps the conserved quantities to round-off."""
    symmetric: bool
    """Whether a step back undoes a step forward."""
    doc: str
    """What it is, in a sentence."""
    build: Builder
    """Writes the step and returns its increments."""


def dmm2(side: Side, step: StepCode) -> Sequence[Expr]:
    """x₁ = x₀ + h fᵗ(t₀, x₀, t₁, x₁), paper (eq:twoSchemes).

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
        return step.compose(weights, lambda: dmm2(side, step))

    return build


def rk2(side: Side, step: StepCode) -> Sequence[Expr]:
    """Explicit midpoint, the paper's baseline."""
    t, h, x = step.t, step.h, step.x
    k1 = step.field(t, x)
    k2 = step.field(t + h / 2, _along(x, h / 2, k1))
    return [h * b for b in k2]


def rk4(side: Side, step: StepCode) -> Sequence[Expr]:
    """The classical Runge-Kutta method."""
    t, h, x = step.t, step.h, step.x
    k1 = step.field(t, x)
    k2 = step.field(t + h / 2, _along(x, h / 2, k1))
    k3 = step.field(t + h / 2, _along(x, h / 2, k2))
    k4 = step.field(t + h, _along(x, h, k3))
    return [h * Rational(1, 6) * (a + 2 * b + 2 * c + e) for a, b, c, e in zip(k1, k2, k3, k4, strict=True)]


def _along(x: Sequence[Expr], h: Expr, slope: Sequence[Expr]) -> list[Expr]:
    return [a + h * k for a, k in zip(x, slope, strict=True)]


#: Every integrator by name.
METHODS: Mapping[str, Method] = MappingProxyType({
    m.name: m
    for m in (
        Method("dmm2", 2, True, True, "Discrete Multiplier Method: keeps every ψ to round-off, symmetric.", dmm2),
        Method("dmm4", 4, True, True, "Five steps of dmm2 (Suzuki): ψ kept, symmetric.", composition(_SUZUKI4)),
        Method("dmm6", 6, True, True, "Nine steps of dmm2 (Kahan, Li): ψ kept, symmetric.", composition(_KAHAN_LI6)),
        Method("dmm8", 8, True, True, "17 steps of dmm2 (Kahan, Li): ψ kept, symmetric.", composition(_KAHAN_LI8)),
        Method("rk2", 2, False, False, "Explicit midpoint: the paper's baseline, whose ψ drifts.", rk2),
        Method("rk4", 4, False, False, "Classical Runge-Kutta: accurate for a while, ψ drifts slowly.", rk4),
    )
})  # fmt: skip


def method_named(name: str) -> Method:
    """The method of that name.

    Raises
    ------
    ValueError
        If there is none.
    """
    if name not in METHODS:
        raise ValueError(f"unknown method {name!r}; known are {', '.join(METHODS)}")
    return METHODS[name]
