"""Methods whose increment is projected along the discrete gradient to the levels of ψ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr

from core.codegen.step import StepCode
from core.methods.base import Method, Scheme
from core.methods.runge_kutta import DOP853, ButcherTableau
from core.symbolic.mode import Mode

__all__ = ["PRK8", "TAYLOR", "Projected", "TaylorSeries"]


@dataclass(frozen=True)
class Projected(Scheme):
    """A one-step map whose increment is projected along the discrete gradient."""

    of: ButcherTableau
    family = "Projected Runge–Kutta"
    conservative = needs_conserved = True

    @property
    def order(self) -> int:  # type: ignore[override]
        """Order of the map."""
        return self.of.order

    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write the map and the projection."""
        return step.project_to_levels(self.of.write(mode, step))


@dataclass(frozen=True)
class TaylorSeries(Scheme):
    """The Taylor series of the solution, whose increment is projected along the discrete gradient."""

    order: None = None
    family = "Taylor series"
    conservative = True

    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write the projection of the series, whose coefficients are prepared once for trial steps of all lengths."""
        return step.project_to_levels(step.polynomial(), prepared=True)


PRK8 = Method(
    "prk8",
    Projected(DOP853),
    "rk8, each step projected onto the level set of ψ, order 8: explicit but for the projection, conserves every ψ.",
)

TAYLOR = Method(
    "taylor",
    TaylorSeries(),
    "Taylor series, order and step size chosen from a tolerance; projected onto the level set of ψ where one is known.",
)
