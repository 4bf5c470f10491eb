"""A declaration of a system as text: what of it can be read, and everything that is wrong with it, field by field."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import sympy
from sympy import Expr, Symbol

from core.symbolic.expressions import TIME, check_name, parse, quoted, to_text
from core.symbolic.laws import Laws, derive, rate_along
from core.symbolic.stream_function import stream_function
from core.symbolic.zero_testing import (
    Counterexample,
    Domain,
    counterexample,
    has_values,
    independent,
    is_larger,
    tidied,
)

__all__ = ["MAX_DIMENSION", "SIDES", "Called", "Declaration", "Problem", "Verdict", "accepted", "miscounted"]

MAX_DIMENSION = 24
_SHOWN_NODES = 200  #: of the time derivative of what is not conserved

#: How a message calls a field, or the entry of it that has a number.
Called: TypeAlias = "Callable[[str, int | None], str]"

#: The sides of the surface, and what their fields are called by.
SIDES: Mapping[int, str] = MappingProxyType({-1: "minus", 1: "plus"})


class Problem(NamedTuple):
    """Something that is wrong with a declaration."""

    field: str
    """The field that it stands in."""
    message: str
    """What is wrong and what would do, without a full stop."""
    entry: int | None = None
    """Number of the expression by whose name the message begins; None where it is about the field as a whole."""


@dataclass(frozen=True)
class Verdict:
    """What is found out about a quantity along the field of its side."""

    psi: Expr
    """The quantity."""
    rate: Expr
    """Its time derivative."""
    is_real: bool
    """Whether it has a real value anywhere on its side."""
    against: Counterexample | None
    """A point at which the time derivative does not vanish."""

    @property
    def conserved(self) -> bool:
        """Whether it is a conserved quantity."""
        return self.is_real and self.against is None

    @cached_property
    def left_over(self) -> Expr | None:
        """The time derivative where that vanishes nowhere; None where it does somewhere, or is too long to be shown."""
        if self.conserved or not self.is_real or self.against is None or self.against.partly:
            return None
        return None if is_larger(self.rate, _SHOWN_NODES) else tidied(self.rate)

    def objection(self, field: str, sign: int) -> str:
        """What is wrong with a quantity that is not conserved, and what would do; `field` is what its field is called.

        It continues the name of the quantity.
        """
        if not self.is_real or self.against is None:
            where = f"where g {'<' if sign < 0 else '>'} 0"
            return f"has no real value {where}: write it so that it has, as log(x**2) for log(x), or leave it out"
        mend = f"mend it, mend {field}, or leave it out"
        if self.against.partly:
            value = f"its time derivative is {self.against.value:.3g}, not 0"
            return f"is conserved by {field} {self.against.scope}: at {self.against.at()}, {value}; {mend}"
        shown = "too long to show" if self.left_over is None else to_text(self.left_over)
        return f"is not conserved by {field}: its time derivative is {shown}, not 0; {mend}"


def _as_declared(field: str, entry: int | None) -> str:
    """Call the parts of a declaration what a program calls them."""
    return field if entry is None or field == "g" else f"{field}[{entry}]"


@dataclass(frozen=True)
class Declaration:
    """The texts of a system, which need not make one.

    Each field of expressions is a tuple of them; see `PiecewiseSystem` for what they mean.
    """

    variables: tuple[str, ...]
    """d names."""
    parameters: tuple[str, ...]
    """Names."""
    bounds: tuple[tuple[float, float] | None, ...]
    """Least and greatest value of each parameter, None where it has none."""
    f_minus: tuple[str, ...]
    """d expressions."""
    f_plus: tuple[str, ...]
    """d expressions."""
    g: tuple[str, ...]
    """One expression."""
    psi_minus: tuple[str, ...] = ()
    """At most d − 1 expressions."""
    psi_plus: tuple[str, ...] = ()
    """At most d − 1 expressions."""
    jump: tuple[str, ...] | None = None
    """d expressions, or None."""
    called: Called = _as_declared
    """How messages call the parts of the declaration."""
    longest: int | None = None
    """Most nodes of the trees of all first derivatives of one expression; None for any number."""

    @cached_property
    def problems(self) -> tuple[Problem, ...]:
        """Everything that is wrong: with the names, then with each expression, then with what is to be conserved."""
        return (*self._faults, *self._of_quantities())

    def _of_quantities(self) -> Iterator[Problem]:
        for sign, word in SIDES.items():
            verdicts, names = self.verdicts[sign], (f"psi_{word}", f"f_{word}")
            for k, verdict in enumerate(verdicts):
                if not verdict.conserved:
                    objection = verdict.objection(self.called(names[1], None), sign)
                    yield Problem(names[0], f"{self._entry(names[0], k)} {objection}", k)
            if verdicts and all(v.conserved for v in verdicts) and not self._independent(sign):
                words = "their gradients are linearly dependent (or zero), everywhere or in a part of their side; "
                yield Problem(names[0], words + "leave out what follows from the others")

    # What is read of it ----------------------------------------------------------------------------------------------

    def expressions(self, field: str) -> dict[int, Expr]:
        """The expressions of a field that can be read, by their numbers."""
        return {k: found for k, found in enumerate(self._read[field]) if not isinstance(found, Problem)}

    @cached_property
    def verdicts(self) -> Mapping[int, tuple[Verdict, ...]]:
        """Side (−1 or +1) -> what is found out about its quantities; () where something else has to be mended first."""
        wrong = {problem.field for problem in self._faults}
        judged = {}
        for sign, word in SIDES.items():
            ready = not wrong & {"variables", "parameters", f"f_{word}", f"psi_{word}"}
            quantities = self.expressions(f"psi_{word}").values() if ready else ()
            judged[sign] = tuple(self._judge(psi, sign) for psi in quantities)
        return judged

    @cached_property
    def laws(self) -> Laws:
        """The mathematics of a declaration that has no problems, shared by all that differ in `bounds` only."""
        law = {field: tuple(self.expressions(field).values()) for field in self._read}
        parameters = tuple(map(Symbol, self.parameters))
        jump = None if self.jump is None else law["jump"]
        fields, quantities = (law["f_minus"], law["f_plus"]), (law["psi_minus"], law["psi_plus"])
        return derive(self._x, parameters, law["g"][0], fields, quantities, jump)

    def completed(self) -> Declaration:
        """Give each side of a plane that has no ψ the one that its field has for being divergence-free.

        There must be no problems. See `stream_function` for what is found; what could not be declared is left out.
        """
        found = {}
        for sign, word in SIDES.items():
            known = self._texts(f"psi_{word}")
            psi = None if known else stream_function(self._field(sign), self._x, self._domain(sign))
            if psi is not None:
                found[f"psi_{word}"] = (to_text(psi),)
        refused = {problem.field for problem in replace(self, **found).problems} if found else ()
        kept = {field: texts for field, texts in found.items() if field not in refused}
        return replace(self, **kept) if kept else self

    # Names and expressions -------------------------------------------------------------------------------------------

    @cached_property
    def _faults(self) -> tuple[Problem, ...]:
        """What is wrong before it can be asked what is conserved."""
        unreadable = [found for entries in self._read.values() for found in entries if isinstance(found, Problem)]
        return (*self._of_names(), *self._of_counts(), *unreadable, *self._of_surface())

    def _of_names(self) -> Iterator[Problem]:
        for role, names in (("variable", self.variables), ("parameter", self.parameters)):
            for name in names:
                try:
                    check_name(name, role)
                except ValueError as reason:
                    yield Problem(f"{role}s", str(reason))
        for twice in sorted(name for name, times in Counter((*self.variables, *self.parameters)).items() if times > 1):
            field = "parameters" if twice in self.parameters else "variables"
            yield Problem(field, f"{twice!r} stands for two things: names must differ")

    def _of_counts(self) -> Iterator[Problem]:
        d = len(self.variables)
        if not 1 <= d <= MAX_DIMENSION:
            yield Problem("variables", f"{d} variables: from 1 to {MAX_DIMENSION} are possible")
            return
        for field in ("f_minus", "f_plus", *(() if self.jump is None else ("jump",))):
            if words := miscounted(self._texts(field), "expression", self.variables):
                yield Problem(field, words)
        if len(self.g) != 1:
            where = "the law changes where it is zero"
            yield Problem("g", f"{len(self.g) or 'none'} here: type one expression, as x**2 + y**2 - 1; {where}")
        for word in SIDES.values():
            if (m := len(self._texts(f"psi_{word}"))) >= d:
                yield Problem(f"psi_{word}", f"there are {m} here; with {_count(d, 'variable')}, {d - 1} at most")

    def _of_surface(self) -> Iterator[Problem]:
        for k, g in self.expressions("g").items():
            if not g.free_symbols & set(self._x):
                wanted = f"write one of {', '.join(self.variables)} into it"
                yield Problem("g", f"{self._entry('g', k)} names no variable, so it is zero on no surface: {wanted}", k)

    @cached_property
    def _read(self) -> dict[str, list[Expr | Problem]]:
        """Each expression, or what is wrong with it; no more of a field than there may be."""
        d = min(len(self.variables), MAX_DIMENSION)
        most = {"f_minus": d, "f_plus": d, "g": 1, "psi_minus": d - 1, "psi_plus": d - 1, "jump": d}
        return {
            field: [self._expression(field, k) for k in range(min(count, len(self._texts(field))))]
            for field, count in most.items()
        }

    def _expression(self, field: str, k: int) -> Expr | Problem:
        names = (*self.variables, *self.parameters)
        try:
            expression = parse(self._texts(field)[k], names, self.called(field, k))
        except ValueError as reason:
            return Problem(field, str(reason), k)
        if self.longest is not None and is_larger(sympy.Tuple(*self._gradient(expression)), self.longest):
            return Problem(field, f"{self._entry(field, k)}: its derivatives are too long; write it shorter", k)
        return expression

    def _texts(self, field: str) -> tuple[str, ...]:
        return getattr(self, field) or ()

    def _entry(self, field: str, k: int) -> str:
        """What an expression is called, and its text."""
        return f"{self.called(field, k)} = {quoted(self._texts(field)[k])}"

    # Mathematics -----------------------------------------------------------------------------------------------------

    @cached_property
    def _x(self) -> tuple[Symbol, ...]:
        return tuple(map(Symbol, self.variables))

    def _field(self, sign: int) -> tuple[Expr, ...]:
        return tuple(self.expressions(f"f_{SIDES[sign]}").values())

    def _gradient(self, u: Expr) -> list[Expr]:
        return [u.diff(v) for v in (*self._x, TIME)]

    def _domain(self, sign: int) -> Domain:
        """Where the law of a side is used: on its side of the surface, for every value its parameters may take.

        As long as g cannot be read that is everywhere.
        """
        ranges = {Symbol(name): ends for name, ends in zip(self.parameters, self.bounds, strict=True) if ends}
        g = self.expressions("g").get(0)
        return Domain(ranges, None if g is None else sign * g, self._field(sign))

    def _judge(self, psi: Expr, sign: int) -> Verdict:
        domain = self._domain(sign)
        rate = rate_along(self._field(sign), self._x, psi)
        is_real = has_values((psi, rate), domain)
        return Verdict(psi, rate, is_real, counterexample(rate, domain) if is_real else None)

    def _independent(self, sign: int) -> bool:
        """Whether the gradients of a side's quantities are linearly independent."""
        rows = sympy.Matrix([self._gradient(verdict.psi) for verdict in self.verdicts[sign]])
        return independent(rows, self._domain(sign))


@lru_cache(maxsize=256)
def accepted(declaration: Declaration) -> Declaration:
    """The declaration with the conserved quantities that are found for it; checked once, not again for every x0.

    Raises
    ------
    ValueError
        For the first of its problems.
    """
    for problem in declaration.problems:
        whole = f"{problem.field} = {getattr(declaration, problem.field)!r}: "
        raise ValueError((whole if problem.entry is None else "") + problem.message)
    full = declaration.completed()
    return full if full is declaration else accepted(full)


def miscounted(given: Sequence[object], noun: str, variables: Sequence[str]) -> str:
    """Say how many there are where one is needed for each variable; nothing if that is so."""
    if len(given) == len(variables):
        return ""
    return f"{_count(len(given), noun)} here, {len(variables)} are needed: one for each of {', '.join(variables)}"


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"
