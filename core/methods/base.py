"""The declaration of a method: a name, a description, and a scheme, from which everything else follows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Add, Expr

from core.codegen.step import StepCode
from core.symbolic.mode import Mode

__all__ = ["Method", "Scheme", "written_sum"]


def written_sum(*terms: Expr) -> Expr:
    """An unevaluated sum: sympy's first evaluated sum takes a tenth as long as importing it."""
    return Add(*terms, evaluate=False)


class Scheme(ABC):
    """A one-step map, as data.

    Attributes
    ----------
    family
        What schemes that are made alike are called.
    order
        Order of its global error; None where it is chosen from a tolerance.
    conservative
        Whether it keeps the conserved quantities to round-off.
    symmetric
        Whether a step back undoes a step forward.
    needs_conserved
        Whether it makes no sense without a conserved quantity.
    """

    family: str
    order: int | None
    conservative: bool = False
    symmetric: bool = False
    needs_conserved: bool = False

    def keeps(self, mode: Mode) -> bool:
        """Whether it keeps all conserved quantities of a mode to round-off."""
        return self.conservative

    @abstractmethod
    def write(self, mode: Mode, step: StepCode) -> Sequence[Expr]:
        """Write the text of one step to `step`; returns the d increments of the state."""


@dataclass(frozen=True)
class Method:
    """A one-step method."""

    name: str
    """Its key in METHODS."""
    scheme: Scheme
    """The one-step map."""
    doc: str
    """Description in a sentence."""

    @property
    def family(self) -> str:
        """What methods that are made alike are called."""
        return self.scheme.family

    @property
    def order(self) -> int | None:
        """Order of its global error; None where it is chosen from the tolerance."""
        return self.scheme.order

    @property
    def conservative(self) -> bool:
        """Whether it keeps the conserved quantities to round-off."""
        return self.scheme.conservative

    def keeps(self, mode: Mode) -> bool:
        """Whether it keeps all conserved quantities of a mode to round-off, be it for their form."""
        return self.scheme.keeps(mode)

    @property
    def symmetric(self) -> bool:
        """Whether a step back undoes a step forward."""
        return self.scheme.symmetric

    @property
    def needs_conserved(self) -> bool:
        """Whether it makes no sense without a conserved quantity."""
        return self.scheme.needs_conserved

    @cached_property
    def adaptive(self) -> bool:
        """Whether it chooses its own step size, from a tolerance."""
        return self.order is None

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        order = "order by tolerance" if self.order is None else f"order {self.order}"
        kept = [word for word, so in (("conservative", self.conservative), ("symmetric", self.symmetric)) if so]
        return f"<Method {self.name}: {', '.join([order, *kept])}>"
