"""Generate the lines that end a step without solution where it passes a singularity of the field."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Symbol

from core.codegen.functions import Names
from core.codegen.printing import assignments
from core.codegen.rounding import rounding_bound
from core.kernels import abi
from core.symbolic.expressions import TIME
from core.symbolic.mode import Mode
from core.symbolic.singularities import BESIDE

__all__ = ["PassingCode"]

#: Time up to which the end of a step is examined …
_BEYOND = Symbol("beyond")
#: … relative to it, so far beyond it: the next step starts at a rounded time, and its state is rounded, too.
_ROUNDING = 2 * 2.0**-52


def _counted(angle: str, but_zero: bool) -> str:
    """Text of a number that changes where an angle passes an integer."""
    if but_zero:
        return f"math.floor(max({angle}, 0.0)) - math.floor(max(-{angle}, 0.0))"
    return f"math.floor({angle})"


class PassingCode:
    """Lines that compare a place in a step with its start: a singularity lies between if its expression changes sign.

    So does a sine or cosine whose angle has passed a multiple of π.

    Attributes
    ----------
    start
        Lines that evaluate the expressions at the start of the step.
    """

    def __init__(self, names: Names, mode: Mode) -> None:
        self._names, self._mode = names, mode
        self._found = mode.singularities
        # The others are bounded at one of their zeros, which a surface may be.
        self._everywhere = [k for k, found in enumerate(self._found) if not found.but_zero]
        self.start = self._assign("start", self._names.symbols)

    def _assign(self, place: str, symbols: dict[Symbol, Expr]) -> list[str]:
        values = [found.zero if found.angle is None else found.angle for found in self._found]
        targets = [f"{place}_{k}" for k in range(len(values))]
        return assignments(targets, [u.xreplace(symbols) for u in values], self._names.temporaries)

    def lines_at_end(self, x: Sequence[Symbol]) -> list[str]:
        """Lines that end the step where a singularity lies between its start and its end x, or next to that."""
        beyond = f"{_BEYOND} = t + h + (abs(t + h) if h > 0.0 else -abs(t + h)) * {_ROUNDING}"
        return [beyond, *self.lines(_BEYOND, x)] if self._found else []

    def lines(self, t: Expr, x: Sequence[Symbol]) -> list[str]:
        """Lines that end the step where a singularity lies between its start and the state x at time t."""
        symbols = {**self._names.symbols, **dict(zip(self._mode.variables, x, strict=True)), TIME: t}
        lines = self._assign("there", symbols)
        for k, singularity in enumerate(self._found):
            a, b = f"start_{k}", f"there_{k}"
            passed = f"{a} <= 0.0 <= {b} or {b} <= 0.0 <= {a}"
            if singularity.angle is not None:
                counts = [_counted(u, singularity.but_zero) for u in (a, b)]
                passed = f"abs({b}) < math.inf and {counts[0]} != {counts[1]}"
            lines += [f"if {passed}:", *self._no_solution(k)]
        return lines

    def lines_at_start(self) -> list[str]:
        """Lines that end the function where rounding alone may put the state beyond a singularity."""
        lines = self._zeros("start", self._names.x)
        for k in self._everywhere:
            lines += [f"if abs(start_{k}) <= {_ROUNDING} * start_doubt_{k}:", *self._no_solution(k)]
        return lines

    def lines_at_surface(self, texts: Sequence[str], x: Sequence[Symbol]) -> list[str]:
        """Lines that end the function where a singularity lies at x, of these texts, to which rounding is corrected."""
        lines = [f"{v} = {text}" for v, text in zip(x, texts, strict=True)] if self._everywhere else []
        lines += self._zeros("there", x)
        for k in self._everywhere:
            least = f"max({BESIDE} * abs(start_{k}), {_ROUNDING} * there_doubt_{k})"
            lines += [f"if abs(there_{k}) <= {least}:", *self._no_solution(k)]
        return lines

    def _zeros(self, place: str, x: Sequence[Symbol]) -> list[str]:
        at = dict(zip(self._names.x, x, strict=True))
        zeros = [self._found[k].zero.xreplace(self._names.symbols) for k in self._everywhere]
        values = [value.xreplace(at) for zero in zeros for value in (zero, rounding_bound(zero))]
        targets = [f"{place}_{what}{k}" for k in self._everywhere for what in ("", "doubt_")]
        return assignments(targets, values, self._names.temporaries)

    @staticmethod
    def _no_solution(k: int) -> list[str]:
        return [
            f"    w[{abi.SINGULARITY}], w[{abi.SINGULAR_FROM}] = {float(k + 1)}, t",
            f"    w[{abi.SINGULAR_LENGTH}] = h",
            f"    return {abi.NO_SOLUTION}",
        ]
