"""The declaration of a system as text: its expressions, and everything that is wrong with it, field by field."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import gcd
from core.symbolic.declared_texts import SIGNS, DeclaredTexts, Problem, Texts
from core.symbolic.entry_checks import (
    MAX_DIMENSION,
    MAX_REGIONS,
    MAX_SURFACES,
    wrong_counts,
    wrong_names,
    wrong_regions,
)
from core.symbolic.expressions import TIME, parse, switching_name
from core.symbolic.laws import Laws, RegionLaw, Way, derive
from core.symbolic.mode import rate_along
from core.symbolic.regular import regular
from core.symbolic.rounded_decimals import rounded_decimals
from core.symbolic.source_text import quoted, to_text
from core.symbolic.stream_function import stream_function
from core.symbolic.zero_testing import (
    Domain,
    counterexample,
    definite_sign,
    has_values,
    independent,
    is_larger,
    is_zero,
    tidied,
)

__all__ = ["Declaration", "Verdict", "accepted"]

#: Most characters that a message quotes of a field that is wrong as a whole.
_SHOWN = 400
#: Most nodes of an expression tree of dψ/dt that a message shows.
_SHOWN_NODES = 200
#: Most nodes of switching functions of which common factors are sought.
_FACTORED_NODES = 100

#: The sign of the other side of a surface.
_OTHER = {"-": "+", "+": "-"}


class Verdict(NamedTuple):
    """Whether the field of a region conserves a quantity ψ."""

    objection: str
    """Why ψ is not conserved, and how to correct it; empty if it is conserved."""
    left_over: Expr | None = None
    """dψ/dt where ψ is conserved nowhere; None also where dψ/dt is too long to show."""


class Declaration(DeclaredTexts):
    """The texts of a system, their expressions, and what is wrong with either."""

    @cached_property
    def problems(self) -> tuple[Problem, ...]:
        """Everything that is wrong: with the names, then with each expression, then with the conserved quantities."""
        return (*self._faults, *self._of_quantities())

    def expressions(self, field: str) -> dict[int, Expr]:
        """Index -> expression, for those of a field that can be parsed."""
        return {k: found for k, found in enumerate(self._read.get(field, ())) if not isinstance(found, Problem)}

    @cached_property
    def verdicts(self) -> Mapping[str, tuple[Verdict, ...]]:
        """Name of a region -> a verdict on each of its ψ; () where something else has to be corrected first."""
        wrong = {problem.field for problem in self._faults}
        judged: dict[str, tuple[Verdict, ...]] = {}
        for region in self.regions:
            f, psi = self.field_of(region.name, "f"), self.field_of(region.name, "psi")
            known = not wrong & {"variables", "parameters", f, psi}
            quantities = self.expressions(psi).items() if known else ()
            judged[region.name] = tuple(self._judge(region.name, k, u) for k, u in quantities)
        return judged

    @cached_property
    def laws(self) -> Laws:
        """The laws of a declaration without problems, shared by all declarations that differ in `bounds` only."""
        surfaces, ways = self._ways
        names = [region.name for region in self.regions]
        signs = [() if self.transitions else tuple(SIGNS[s] for s in name) for name in names]
        regions = tuple(
            RegionLaw(name, sides, tuple(map(regular, self._law(name, "f"))), self._law(name, "psi"), tuple(ways[name]))
            for name, sides in zip(names, signs, strict=True)
        )
        return derive(self._x, tuple(map(Symbol, self.parameters)), surfaces, regions)

    def completed(self) -> Declaration:
        """Add a stream function as ψ to each region that has none, where the system is planar and f divergence-free.

        The declaration must have no problems. See `stream_function` for what is found; a ψ that a declaration would
        refuse is left out.
        """
        found = {}
        for region in self.regions:
            psi = (
                None if region.psi else stream_function(self._law(region.name, "f"), self._x, self._domain(region.name))
            )
            if psi is not None:
                found[region.name] = (to_text(psi),)
        refused = {problem.field for problem in self._with(found).problems} if found else set()
        kept = {name: psi for name, psi in found.items() if self.field_of(name, "psi") not in refused}
        return self._with(kept) if kept else self

    def _with(self, psi: Mapping[str, Texts]) -> Declaration:
        regions = (region._replace(psi=psi.get(region.name, region.psi)) for region in self.regions)
        return replace(self, regions=tuple(regions))

    # Names of fields -------------------------------------------------------------------------------------------------

    # Names and expressions -------------------------------------------------------------------------------------------

    @cached_property
    def _faults(self) -> tuple[Problem, ...]:
        """What is wrong with names, counts and expressions; only without these is conservation tested."""
        if len(self.regions) > MAX_REGIONS:
            return tuple(wrong_regions(self))
        unreadable = [found for entries in self._read.values() for found in entries if isinstance(found, Problem)]
        first = (*wrong_names(self), *wrong_counts(self), *unreadable, *wrong_regions(self))
        return first or tuple(self._of_guards())

    @cached_property
    def _read(self) -> dict[str, list[Expr | Problem]]:
        """Field -> each expression, or what is wrong with it; only as many as the field may have."""
        d = len(self.variables)
        if not 1 <= d <= MAX_DIMENSION:
            return {field: [] for field in self.texts}
        most = {"f": d, "psi": d - 1, "jump": d, "surface": 1 if self.two_sided else MAX_SURFACES}
        kept = {field: min(len(texts), most[self.kind(field)]) for field, texts in self.texts.items()}
        return {field: [self._expression(field, k) for k in range(n)] for field, n in kept.items()}

    def _where_read(self, field: str, k: int) -> str:
        """Say where a function that switches is read, if an expression that cannot be read contains one."""
        name = switching_name(str(self.texts[field][k])) if self.kind(field) in ("f", "surface") else ""
        where = "in one field for all regions (PiecewiseSystem.from_field), where its surface is found"
        return f"; {name} is read {where}" if name else ""

    @property
    def _named(self) -> str:
        """The names of the variables, each once, as messages list them."""
        return ", ".join(dict.fromkeys(self.variables))

    def _expression(self, field: str, k: int) -> Expr | Problem:
        try:
            found = parse(self.texts[field][k], (*self.variables, *self.parameters), self.called(field, k))
        except ValueError as reason:
            return Problem(field, f"{reason}{self._where_read(field, k)}", k)
        if self.longest is not None and is_larger(sympy.Tuple(*self._gradient(found)), self.longest):
            words = ": its derivatives are too long to work with; write it shorter"
        elif self.kind(field) == "surface" and not found.free_symbols & {*self._x, TIME}:
            words = f" names no variable and not t, so it has no zero: it has to contain one of t, {self._named}"
        elif self.kind(field) == "surface" and (sign := definite_sign(found)):
            words = (
                f" is {sign}, so that nothing switches where it is 0: it has to change sign there"
                if sign.startswith("nowhere")
                else f" is {sign} everywhere, so that nothing switches there: it has to be 0 somewhere"
            )
        else:
            return found
        return Problem(field, self._entry(field, k) + words, k)

    def _entry(self, field: str, k: int) -> str:
        """The name and the text of an expression, for a message."""
        return f"{self.called(field, k)} = {quoted(self.texts[field][k])}"

    def _of_guards(self) -> Iterator[Problem]:
        """Problems of surfaces that are the same: they would be met at the same instant, always."""
        surfaces = self.expressions("surfaces")
        for (i, u), (k, v) in product(surfaces.items(), repeat=2):
            if i < k and _same_zeros(u, v):
                words = (
                    f"{self._entry('surfaces', k)} is zero where {self.called('surfaces', i)} is: write each surface "
                )
                yield Problem("surfaces", words + "once, and one without factor in common with another", k)
        names = [region.name for region in self.regions]
        for k, _ in self.jumps if surfaces else ():
            without = [beside for beside in (_beside(name, k) for name in names) if beside not in names]
            if without and not surfaces[k].free_symbols & set(self._x):
                words = f"{self._entry('surfaces', k)} names no variable, so no jump leads back from where it is 0: "
                yield Problem("surfaces", f"{words}declare a law of region {without[0]!r}", k)

    # Transitions -----------------------------------------------------------------------------------------------------

    @cached_property
    def _ways(self) -> tuple[tuple[Expr, ...], Mapping[str, list[Way]]]:
        """The switching functions, and what follows at each guard of each region."""
        numbers = {region.name: k for k, region in enumerate(self.regions)}
        ways: dict[str, list[Way]] = {name: [] for name in numbers}
        if not self.transitions:
            jumps = {k: self._jump("jump" if self.two_sided else f"jumps[{k}]") for k, _ in self.jumps}
            for name, i in product(numbers, range(len(self.surfaces))):
                ways[name].append(Way(i, SIGNS[name[i]], numbers.get(_beside(name, i)), jump=jumps.get(i)))
            return tuple(self.expressions("g" if self.two_sided else "surfaces").values()), ways
        surfaces: list[Expr] = []
        for k, transition in enumerate(self.transitions):
            guard = self.expressions(f"transitions[{k}].guard")[0]
            number, sign = _number_among(guard, surfaces)
            jump = self._jump(f"transitions[{k}].jump") if transition.jump else None
            ways[transition.mode].append(Way(number, sign, numbers[transition.to], jump=jump))
        return tuple(surfaces), ways

    def _jump(self, field: str) -> tuple[Expr, ...]:
        return tuple(self.expressions(field).values())

    # Conserved quantities --------------------------------------------------------------------------------------------

    def _of_quantities(self) -> Iterator[Problem]:
        for name, verdicts in self.verdicts.items():
            field = self.field_of(name, "psi")
            wrong = [Problem(field, v.objection, k) for k, v in enumerate(verdicts) if v.objection]
            yield from wrong
            rows = sympy.Matrix([self._gradient(psi) for psi in self.expressions(field).values()])
            if verdicts and not wrong and not independent(rows, self._domain(name)):
                words = "their gradients are linearly dependent (or zero), everywhere or in a part of their side; "
                yield Problem(field, words + "remove what follows from the others")

    def _judge(self, region: str, k: int, psi: Expr) -> Verdict:
        domain, its_field = self._domain(region), self.field_of(region, "psi")
        name, field = self._entry(its_field, k), self.called(self.field_of(region, "f"), None)
        short = self.called(its_field, k)
        if not any(self._gradient(psi)):
            return Verdict(f"{name} is constant: remove it")
        remedy = f"correct {short} or {field}, or remove {short}"
        rate = rate_along(self._law(region, "f"), self._x, psi)
        if not has_values((psi, rate), domain):
            words = "write it so that it has, as log(x**2) in place of log(x), or remove it"
            where = f"where g {'<' if region == '-' else '>'} 0" if self.two_sided else f"in region {region!r}"
            return Verdict(f"{name} has no real value {where}: {words}")
        found = counterexample(rate, domain)
        if found is None:
            return Verdict("")
        if found.partly:
            words = f"{name} is conserved by {field} {found.scope}: at {found.at()}, its time derivative is"
            return Verdict(f"{words} {found.value:.3g}, not 0; {remedy}")
        over = None if is_larger(rate, _SHOWN_NODES) else tidied(rate)
        shown = "too long to show" if over is None else to_text(over)
        words = f"{name} is not conserved by {field}: {remedy}; its time derivative is"
        return Verdict(f"{words} {shown}, not 0{self._but_for_rounding(region, psi)}", over)

    def _but_for_rounding(self, region: str, psi: Expr) -> str:
        """Words on a quantity that is conserved but for the rounding of its decimals; '' where it is not."""
        rounded = rounded_decimals(psi, lambda u: rate_along(self._law(region, "f"), self._x, u), self._domain(region))
        if not rounded:
            return ""
        size = max(one.change for one in rounded)
        mended = " and ".join(one.words() for one in rounded)
        return (
            f"; that is as much as rounding of decimals makes, by {size:.1g} of them: with {mended} it would be 0. "
            "Write such numbers exactly"
        )

    @cached_property
    def _x(self) -> tuple[Symbol, ...]:
        return tuple(map(Symbol, self.variables))

    def _law(self, region: str, part: str) -> tuple[Expr, ...]:
        return tuple(self.expressions(self.field_of(region, part)).values())

    def _gradient(self, u: Expr) -> list[Expr]:
        return [u.diff(v) for v in (*self._x, TIME)]

    def _domain(self, region: str) -> Domain:
        """Where the law of a region holds: between its surfaces, for every value its parameters may take.

        Surfaces that cannot be parsed do not bound it.
        """
        ranges = {Symbol(name): ends for name, ends in zip(self.parameters, self.bounds, strict=True) if ends}
        if self.transitions:
            guards = (f"transitions[{k}].guard" for k, way in enumerate(self.transitions) if way.mode == region)
            heights: Iterable[Expr] = (u for field in guards for u in self.expressions(field).values())
        else:
            surfaces = self.expressions("g" if self.two_sided else "surfaces")
            heights = (SIGNS[region[k]] * u for k, u in surfaces.items() if k < len(region) and region[k] in SIGNS)
        return Domain(ranges, tuple(heights), self._law(region, "f"))


def _beside(region: str, surface: int) -> str:
    """Name of the region on the other side of a surface."""
    return region[:surface] + _OTHER[region[surface]] + region[surface + 1 :]


def _same_zeros(u: Expr, v: Expr) -> bool:
    """Whether two switching functions have zeros in common as they have a factor in common."""
    long = is_larger(u, _FACTORED_NODES) or is_larger(v, _FACTORED_NODES)
    if long or not (u.is_polynomial() and v.is_polynomial()):
        return is_zero(u - v) or is_zero(u + v)
    factor = gcd(u, v)
    return bool(factor.free_symbols & (u.free_symbols | v.free_symbols)) and not factor.is_number


def _number_among(guard: Expr, surfaces: list[Expr]) -> tuple[int, int]:
    """Number of a guard among switching functions, and its sign; a new one is added to them."""
    for number, u in enumerate(surfaces):
        for sign in (1, -1):
            if is_zero(guard - sign * u):
                return number, sign
    surfaces.append(guard)
    return len(surfaces) - 1, 1


@lru_cache(maxsize=256)
def accepted(declaration: Declaration) -> Declaration:
    """Check a declaration, and add the ψ that are found for it; cached, so a new x0 does not repeat it.

    Raises
    ------
    ValueError
        For the first of its problems.
    """
    for problem in declaration.problems:
        given = repr(declaration.given(problem.field))
        shown = given if len(given) <= _SHOWN else f"{given[: _SHOWN - 1]}…"
        raise ValueError((f"{problem.field} = {shown}: " if problem.entry is None else "") + problem.message)
    full = declaration.completed()
    return full if full is declaration else accepted(full)
