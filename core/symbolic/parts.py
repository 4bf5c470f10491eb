"""What a system is declared of: parameters, regions, transitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from core.interface.arguments import listed, number
from core.symbolic.expressions import check_name
from core.symbolic.source_text import to_text

__all__ = ["Parameter", "Region", "Transition", "latex_of_name", "text_of", "texts_of"]


@dataclass(frozen=True)
class Parameter:
    """A number in a system that can be changed without compiling it anew."""

    name: str
    """Identifier, as used in the expressions."""
    default: float
    """Initial value."""
    bounds: tuple[float, float] | None = None
    """Least and greatest allowed value."""
    doc: str = ""
    """Its meaning, in a few words."""
    latex: str | None = None
    """LaTeX for it; derived from the name where not given."""

    def __post_init__(self) -> None:
        check_name(self.name, "parameter")
        if self.bounds is not None:
            if not isinstance(self.bounds, Sequence) or len(self.bounds) != 2:
                raise ValueError(f"bounds of parameter {self.name} are {self.bounds!r}: two numbers are needed")
            low, high = (number(b, f"bound of parameter {self.name}") for b in self.bounds)
            if not low < high:
                raise ValueError(
                    f"parameter {self.name}: the lower bound {low:g} is not below the upper bound {high:g}"
                )
            object.__setattr__(self, "bounds", (low, high))
        object.__setattr__(self, "default", self.check(self.default))

    @property
    def symbol(self) -> str:
        """LaTeX for it."""
        return self.latex or latex_of_name(self.name)

    def check(self, value: float) -> float:
        """Return `value` as a float if the parameter may take it, else raise ValueError."""
        found = number(value, f"parameter {self.name}")
        if self.bounds is not None and not self.bounds[0] <= found <= self.bounds[1]:
            raise ValueError(f"parameter {self.name} = {found!r} is outside {self.bounds[0]:g} … {self.bounds[1]:g}")
        return found


@dataclass(frozen=True)
class Region:
    """The law of one region."""

    f: tuple[str, ...]
    """d expressions."""
    psi: tuple[str, ...] = ()
    """0 to d − 1 conserved quantities."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "f", texts_of(self.f, "f"))
        object.__setattr__(self, "psi", texts_of(self.psi, "psi"))


@dataclass(frozen=True)
class Transition:
    """A way out of a region: where its guard, positive inside, falls to zero.

    A region that is entered where a guard of it is negative is left by that guard at once, with its jump.
    """

    mode: str
    """Key of the region that it ends."""
    guard: str
    """An expression, positive inside the region."""
    to: str
    """Key of the region that follows."""
    jump: tuple[str, ...] | None = None
    """d expressions: the state after reaching the guard's zero; None where it is continuous."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "guard", text_of(self.guard))
        object.__setattr__(self, "jump", None if self.jump is None else texts_of(self.jump, "jump") or None)


def texts_of(given: Any, what: str) -> tuple[str, ...]:
    """Expressions as text; ValueError, which says what they are, if they are no sequence."""
    return tuple(map(text_of, listed(given, what, "a tuple is needed, as in ('y', '-x')")))


def text_of(expression: Any) -> str:
    """An expression, a number or text as text."""
    return to_text(expression) if isinstance(expression, sympy.Basic) else str(expression)


def latex_of_name(name: str) -> str:
    """LaTeX of a name; the endings _minus and _plus become the subscripts − and +."""
    for word, sign in (("_minus", "-"), ("_plus", "+")):
        if name.endswith(word):
            return rf"{sympy.latex(sympy.Symbol(name.removesuffix(word)))}_{{{sign}}}"
    return str(sympy.latex(sympy.Symbol(name)))
