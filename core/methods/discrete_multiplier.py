"""The Discrete Multiplier Method, and compositions of its steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Float, Integer, Matrix, cbrt, symbols

from core.codegen.step import StepCode
from core.methods.base import Method, Scheme, written_sum
from core.symbolic.mode import Mode

__all__ = ["DMM2", "DMM4", "DMM6", "DMM8", "Composition", "DiscreteMultiplier"]


@dataclass(frozen=True)
class DiscreteMultiplier(Scheme):
    """x₁ = x₀ + h fᵗ(t₀, x₀, t₁, x₁), with the discrete field fᵗ that keeps ψ: paper (eq:twoSchemes)."""

    order: int = 2
    family = "Discrete multiplier"
    conservative = symmetric = needs_conserved = True

    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write one step, which also corrects the round-off of ψ in earlier steps."""
        return step.restore_levels(self.write_bare(mode, step))

    def write_bare(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write the scheme without the correction of round-off.

        Unless the invariants determine the orbit, the minimal-norm DMM is solved as a saddle-point system with
        multipliers λ, which avoids the inverse of ΛᵗΛᵗᵀ:  Δ − h f̄ + Λᵗᵀ λ = 0,  Λᵗ Δ + h s_t = 0.
        """
        discrete = mode.discrete
        d, m = len(mode.field), len(mode.conserved)
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


@dataclass(frozen=True)
class Composition(Scheme):
    """Symmetric composition: steps of another scheme with lengths weight·h.

    Symmetric and conservative because that scheme is; the weights raise its order.

    Attributes
    ----------
    half
        First half of the weights; the middle one makes the sum 1, and the others mirror these.
    of
        The scheme.
    order
        As in `Scheme`.
    """

    half: tuple[Expr, ...]
    of: DiscreteMultiplier
    order: int
    family = DiscreteMultiplier.family
    conservative = symmetric = needs_conserved = True

    @property
    def weights(self) -> tuple[Expr, ...]:
        """All weights, exact or to thirty digits."""
        middle = 1 - 2 * sum(self.half, Integer(0))
        return (*self.half, middle, *reversed(self.half))

    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write one step, which also corrects the round-off of ψ in earlier steps."""
        half = [float(weight) for weight in self.half]
        weights = (*half, 1 - 2 * math.fsum(half), *reversed(half))  # these add up to 1 in doubles, too
        return step.restore_levels(step.compose(weights, lambda: self.of.write_bare(mode, step)))


def _decimals(*texts: str) -> tuple[Expr, ...]:
    return tuple(Float(text, 40) for text in texts)


_DMM = DiscreteMultiplier()

DMM2 = Method("dmm2", _DMM, "Discrete Multiplier Method, order 2: implicit, symmetric, conserves every ψ to round-off.")

#: Suzuki, Phys. Lett. A 146 (1990).
DMM4 = Method(
    "dmm4",
    Composition((1 / written_sum(Integer(4), -cbrt(4)),) * 2, _DMM, 4),
    "Composition of five steps of dmm2 (Suzuki), order 4: symmetric, conserves every ψ.",
)

#: Kahan, Li, Math. Comp. 66 (1997), s9odr6a; see Hairer, Lubich, Wanner, Geometric Numerical Integration, V.3.2.
DMM6 = Method(
    "dmm6",
    Composition(
        _decimals(
            "0.39216144400731413927925056", "0.33259913678935943859974864", "-0.70624617255763935980996482",
            "0.08221359629355080023149045",
        ),
        _DMM,
        6,
    ),
    "Composition of nine steps of dmm2 (Kahan and Li), order 6: symmetric, conserves every ψ.",
)  # fmt: skip

#: As before, s17odr8a.
DMM8 = Method(
    "dmm8",
    Composition(
        _decimals(
            "0.13020248308889008087881763", "0.56116298177510838456196441", "-0.38947496264484728640807860",
            "0.15884190655515560089621075", "-0.39590389413323757733623154", "0.18453964097831570709183254",
            "0.25837438768632204729397911", "0.29501172360931029887096624",
        ),
        _DMM,
        8,
    ),
    "Composition of 17 steps of dmm2 (Kahan and Li), order 8: symmetric, conserves every ψ.",
)  # fmt: skip
