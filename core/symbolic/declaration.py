"""The declaration of a system as text: its expressions, and everything that is wrong with it, field by field."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple

import sympy
from sympy import Expr, Symbol

from core.symbolic.expressions import TIME, check_name, parse, quoted, to_text
from core.symbolic.laws import Laws, derive
from core.symbolic.mode import rate_along
from core.symbolic.stream_function import stream_function
from core.symbolic.zero_testing import Domain, counterexample, has_values, independent, is_larger, tidied

__all__ = ["MAX_DIMENSION", "SIDES", "Declaration", "Problem", "Verdict", "accepted", "miscounted"]

#: Largest number of variables.
MAX_DIMENSION = 24
#: Most characters that a message quotes of a field that is wrong as a whole.
_SHOWN = 400
#: Most nodes of an expression tree of dψ/dt that a message shows.
_SHOWN_NODES = 200

#: Sign of g -> the word for that side in the names of fields.
SIDES: Mapping[int, str] = MappingProxyType({-1: "minus", 1: "plus"})


class Problem(NamedTuple):
    """Something that is wrong with a declaration."""

    field: str
    """Field of the declaration in which it is."""
    message: str
    """What is wrong and how to correct it, without a full stop."""
    entry: int | None = None
    """Index of the expression that the message names first; None where the message is about the whole field."""


class Verdict(NamedTuple):
    """Whether the field of a side conserves a quantity ψ."""

    objection: str
    """Why ψ is not conserved, and how to correct it; empty if it is conserved."""
    left_over: Expr | None = None
    """dψ/dt where ψ is conserved nowhere; None also where dψ/dt is too long to show."""


def _as_declared(field: str, entry: int | None) -> str:
    """Name of a field or of one of its entries, as in Python: ``f_plus[1]``."""
    return field if entry is None or field == "g" else f"{field}[{entry}]"


@dataclass(frozen=True)
class Declaration:
    """The texts of a system, valid or not: fields as in `PiecewiseSystem`, each a tuple, () for none.

    Parameters
    ----------
    bounds
        Least and greatest value of each parameter; None where it has none.
    called
        (field, index or None) -> the name that messages give to the field or to that entry of it.
    longest
        Most nodes in the trees of all first derivatives of one expression; None for no limit.
    """

    variables: tuple[str, ...]
    parameters: tuple[str, ...]
    bounds: tuple[tuple[float, float] | None, ...]
    f_minus: tuple[str, ...]
    f_plus: tuple[str, ...]
    g: tuple[str, ...]
    psi_minus: tuple[str, ...] = ()
    psi_plus: tuple[str, ...] = ()
    jump: tuple[str, ...] = ()
    called: Callable[[str, int | None], str] = _as_declared
    longest: int | None = None

    @cached_property
    def problems(self) -> tuple[Problem, ...]:
        """Everything that is wrong: with the names, then with each expression, then with the conserved quantities."""
        return (*self._faults, *self._of_quantities())

    def expressions(self, field: str) -> dict[int, Expr]:
        """Index -> expression, for those of a field that can be parsed."""
        return {k: found for k, found in enumerate(self._read[field]) if not isinstance(found, Problem)}

    @cached_property
    def verdicts(self) -> Mapping[int, tuple[Verdict, ...]]:
        """Side (−1 or +1) -> a verdict on each of its ψ; () where something else has to be corrected first."""
        wrong = {problem.field for problem in self._faults}
        judged: dict[int, tuple[Verdict, ...]] = dict.fromkeys(SIDES, ())
        for sign, word in SIDES.items():
            if not wrong & {"variables", "parameters", f"f_{word}", f"psi_{word}"}:
                quantities = self.expressions(f"psi_{word}").items()
                judged[sign] = tuple(self._judge(sign, k, psi) for k, psi in quantities)
        return judged

    @cached_property
    def laws(self) -> Laws:
        """The laws of a declaration without problems, shared by all declarations that differ in `bounds` only."""
        law = {field: tuple(self.expressions(field).values()) for field in self._read}
        x, p, (g,) = self._x, tuple(map(Symbol, self.parameters)), law["g"]
        fields, quantities = (law["f_minus"], law["f_plus"]), (law["psi_minus"], law["psi_plus"])
        return derive(x, p, g, fields, quantities, law["jump"] or None)

    def completed(self) -> Declaration:
        """Add a stream function as ψ to each side that has none, where the system is planar and f divergence-free.

        The declaration must have no problems. See `stream_function` for what is found; a ψ that a declaration would
        refuse is left out.
        """
        found: dict[str, Any] = {}
        for sign, word in SIDES.items():
            known = self.expressions(f"psi_{word}")
            psi = None if known else stream_function(self._field(sign), self._x, self._domain(sign))
            if psi is not None:
                found[f"psi_{word}"] = (to_text(psi),)
        refused = {problem.field for problem in replace(self, **found).problems} if found else set()
        return replace(self, **{f: found[f] for f in found.keys() - refused}) if found.keys() - refused else self

    # Names and expressions -------------------------------------------------------------------------------------------

    @cached_property
    def _faults(self) -> tuple[Problem, ...]:
        """What is wrong with names, counts and expressions; only without these is conservation tested."""
        unreadable = [found for entries in self._read.values() for found in entries if isinstance(found, Problem)]
        return (*self._of_names(), *self._of_counts(), *unreadable)

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
        for field, texts in {"f_minus": self.f_minus, "f_plus": self.f_plus, "jump": self.jump}.items():
            words = miscounted(texts, "expression", self.variables)
            if words and (texts or field != "jump"):
                yield Problem(field, words)
        if len(self.g) != 1:
            yield Problem("g", "type one expression, as in: x**2 + y**2 - 1; the law changes where it is zero")
        for field, texts in {"psi_minus": self.psi_minus, "psi_plus": self.psi_plus}.items():
            if len(texts) >= d:
                yield Problem(field, f"there are {len(texts)} here; with {_count(d, 'variable')}, {d - 1} at most")

    @cached_property
    def _read(self) -> dict[str, list[Expr | Problem]]:
        """Field -> each expression, or what is wrong with it; only as many as the field may have."""
        d = len(self.variables)
        most = {"f_minus": d, "f_plus": d, "g": 1, "psi_minus": d - 1, "psi_plus": d - 1, "jump": d}
        most = most if 1 <= d <= MAX_DIMENSION else dict.fromkeys(most, 0)
        return {f: [self._expression(f, k) for k in range(min(len(getattr(self, f)), n))] for f, n in most.items()}

    def _expression(self, field: str, k: int) -> Expr | Problem:
        try:
            found = parse(getattr(self, field)[k], (*self.variables, *self.parameters), self.called(field, k))
        except ValueError as reason:
            return Problem(field, str(reason), k)
        if self.longest is not None and is_larger(sympy.Tuple(*self._gradient(found)), self.longest):
            words = ": its derivatives are too long to work with; write it shorter"
        elif field == "g" and not found.free_symbols & set(self._x):
            words = f" names no variable, so g = 0 is not a surface: write one of {', '.join(self.variables)} into it"
        else:
            return found
        return Problem(field, self._entry(field, k) + words, k)

    def _entry(self, field: str, k: int) -> str:
        """The name and the text of an expression, for a message."""
        return f"{self.called(field, k)} = {quoted(getattr(self, field)[k])}"

    # Conserved quantities --------------------------------------------------------------------------------------------

    def _of_quantities(self) -> Iterator[Problem]:
        for sign, verdicts in self.verdicts.items():
            field = f"psi_{SIDES[sign]}"
            wrong = [Problem(field, v.objection, k) for k, v in enumerate(verdicts) if v.objection]
            yield from wrong
            rows = sympy.Matrix([self._gradient(psi) for psi in self.expressions(field).values()])
            if verdicts and not wrong and not independent(rows, self._domain(sign)):
                words = "their gradients are linearly dependent (or zero), everywhere or in a part of their side; "
                yield Problem(field, words + "remove what follows from the others")

    def _judge(self, sign: int, k: int, psi: Expr) -> Verdict:
        word, domain = SIDES[sign], self._domain(sign)
        name, field = self._entry(f"psi_{word}", k), self.called(f"f_{word}", None)
        short = self.called(f"psi_{word}", k)
        remedy = f"correct {short} or {field}, or remove {short}"
        rate = rate_along(self._field(sign), self._x, psi)
        if not has_values((psi, rate), domain):
            words = "write it so that it has, as log(x**2) in place of log(x), or remove it"
            return Verdict(f"{name} has no real value where g {'<' if sign < 0 else '>'} 0: {words}")
        found = counterexample(rate, domain)
        if found is None:
            return Verdict("")
        if found.partly:
            words = f"{name} is conserved by {field} {found.scope}: at {found.at()}, its time derivative is"
            return Verdict(f"{words} {found.value:.3g}, not 0; {remedy}")
        over = None if is_larger(rate, _SHOWN_NODES) else tidied(rate)
        shown = "too long to show" if over is None else to_text(over)
        words = f"{name} is not conserved by {field}: {remedy}; its time derivative is"
        return Verdict(f"{words} {shown}, not 0", over)

    @cached_property
    def _x(self) -> tuple[Symbol, ...]:
        return tuple(map(Symbol, self.variables))

    def _field(self, sign: int) -> tuple[Expr, ...]:
        return tuple(self.expressions(f"f_{SIDES[sign]}").values())

    def _gradient(self, u: Expr) -> list[Expr]:
        return [u.diff(v) for v in (*self._x, TIME)]

    def _domain(self, sign: int) -> Domain:
        """Where the law of a side holds: on its side of the surface, for every value its parameters may take.

        Everywhere if g cannot be parsed.
        """
        ranges = {Symbol(name): ends for name, ends in zip(self.parameters, self.bounds, strict=True) if ends}
        g = self.expressions("g").get(0)
        return Domain(ranges, None if g is None else sign * g, self._field(sign))


@lru_cache(maxsize=256)
def accepted(declaration: Declaration) -> Declaration:
    """Check a declaration, and add the ψ that are found for it; cached, so a new x0 does not repeat it.

    Raises
    ------
    ValueError
        For the first of its problems.
    """
    for problem in declaration.problems:
        given = repr(getattr(declaration, problem.field))
        shown = given if len(given) <= _SHOWN else f"{given[: _SHOWN - 1]}…"
        raise ValueError((f"{problem.field} = {shown}: " if problem.entry is None else "") + problem.message)
    full = declaration.completed()
    return full if full is declaration else accepted(full)


def miscounted(given: Sequence[object], noun: str, variables: Sequence[str]) -> str:
    """Message that the number of entries is not the number of variables; empty if it is."""
    if len(given) == len(variables):
        return ""
    return f"{_count(len(given), noun)} here, {len(variables)} are needed: one for each of {', '.join(variables)}"


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"
