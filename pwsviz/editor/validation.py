"""A system as a user types it: reads the texts, and returns the system or what is wrong with each text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple, TypeVar

import sympy
from sympy import Symbol

import core
from core.integrate import checked_start
from core.symbolic import SIDES, Declaration, Problem, Verdict, miscounted
from pwsviz.editor.draft import FIELDS, Draft
from pwsviz.editor.entries import as_known, is_decimal, read_coordinate, read_parameter, read_variable
from pwsviz.editor.naming import MAX_NAME
from pwsviz.editor.one_field import OneField, called_by_variables, where
from pwsviz.editor.regions import REGION_FIELDS, Regions, read_parts
from pwsviz.editor.typeset import constant, equation, rate, state_after
from pwsviz.scene.scene import can_use
from pwsviz.text.advice import on_page
from pwsviz.text.math_names import name_markup, quantity_name, unicode_name
from pwsviz.text.mathml import markup
from pwsviz.text.typed import Typed, rates, split
from pwsviz.text.words import listed

__all__ = ["Checked", "Finding", "check", "split"]

MAX_CHARACTERS = 1000  #: characters of one field, which bound the time of parsing it
MAX_REGION_CHARACTERS = 4000  #: characters of a field that holds the expressions of all regions
MAX_VARIABLES = 12  #: variables, which bound the time of analysing and compiling the system
MAX_PARAMETERS = 20  #: parameters, each of which has a field on the page
MAX_DERIVATIVES = 3000  #: nodes of the expression trees of all first derivatives of one expression
_COMPLAINTS = 3  #: complaints about one field that are shown; more would bury the first
_LONGEST = 400  #: characters of one complaint

#: The fields that hold the expressions of two sides.
_SIDES = ("f_minus", "f_plus", "g", "psi_minus", "psi_plus", "jump")
#: The fields that hold expressions.
_EXPRESSIONS = ("f", "psi", *_SIDES)

#: The fields that are read by themselves.
_WHOLE = ("name", *REGION_FIELDS)
#: Most characters of fields that may hold fewer or more than the others.
_LIMITS = {"name": MAX_NAME, "regions": MAX_REGION_CHARACTERS, "quantities": MAX_REGION_CHARACTERS}

#: The sign of a side, in words and in mathematics.
_SIGNS = {"minus": ("₋", "−"), "plus": ("₊", "+")}


@dataclass(frozen=True)
class Finding:
    """The result of checking one conserved quantity, or of looking for one where none is given."""

    words: str
    """A sentence without markup."""
    conserved: bool
    """Whether the quantity is conserved."""
    maths: str = ""
    """The time derivative if it is not 0, or the quantity found, as ``<math>`` elements."""


@dataclass(frozen=True)
class Checked:
    """The result of checking a draft."""

    system: core.PiecewiseSystem | None = None
    """The system, if every field is valid."""
    complaints: Mapping[str, str] = field(default_factory=dict)
    """Field -> what is wrong with it and what would do; “system” for what concerns several fields."""
    maths: Mapping[str, str] = field(default_factory=dict)
    """Field -> ``<math>`` elements, escaped, of the expressions that could be read."""
    conserved: Mapping[str, tuple[Finding, ...]] = field(default_factory=dict)
    """Field -> the findings on its conserved quantities."""


def check(draft: Draft) -> Checked:
    """Read and check all fields of a draft.

    Nothing is evaluated as code, and all sizes are bounded, so that any text takes bounded time.
    """
    return _Check(draft).run()


class _LeftSide(NamedTuple):
    """The left-hand side of an equation, in plain characters and as markup."""

    said: str
    shown: str


#: A text as Python quotes it in a message of `core`: between double quotes if it has single ones.
_QUOTED = re.compile(r"""'((?:[^'\\]|\\.)*)'|"([^"]*'[^"]*)\"""")

_T = TypeVar("_T")


class _Check:
    """One pass over a draft: reads the fields one by one, then checks the declaration as a whole."""

    def __init__(self, draft: Draft) -> None:
        self.texts = {name: getattr(draft, name).replace("−", "-") for name in FIELDS}  # U+2212, as copied from a page
        self.complaints: dict[str, list[str]] = {}
        self.typed = Typed()
        self.refuse_long_texts()
        self.items = {name: tuple(split(text)) for name, text in self.texts.items() if name not in _WHOLE}
        for name in ("f_minus", "f_plus", "f"):
            self.items[name] = tuple(rates(self.texts[name], self.items["variables"]))
        self.items |= {name: tuple(map(self.typed.read, self.items[name])) for name in _EXPRESSIONS}
        self.require_names()
        self.variables = self.each("variables", read_variable, MAX_VARIABLES)
        known = {p.name: p for p in draft.known}
        self.parameters = self.each("parameters", partial(read_parameter, formula=self.typed.read), MAX_PARAMETERS)
        self.parameters = tuple(as_known(p, known.get(p.name)) for p in self.parameters)
        self.symbols = {Symbol(p.name): p.symbol for p in self.parameters}
        self.x0 = self.each("x0", partial(read_coordinate, formula=self.typed.read), MAX_VARIABLES)
        self.read: OneField | Regions | None = None
        self.in_one_field = bool(draft.f.strip())
        self.in_regions = not self.in_one_field and any(getattr(draft, name).strip() for name in REGION_FIELDS)
        self.declaration = self.declare()

    def run(self) -> Checked:
        self.check_declaration()
        maths = {name: "" if self.in_regions else self.typeset(name) for name in _SIDES}
        maths |= {"f": self.read.markup(self.variables, self.symbols)} if isinstance(self.read, OneField) else {}
        maths |= self.read.maths(self.symbols) if isinstance(self.read, Regions) else {}
        maths["parameters"] = "".join(map(_parameter_maths, self.parameters))
        maths["x0"] = self.typeset_start()
        system = None if self.complaints else self.build()
        if self.in_one_field or self.in_regions:
            conserved = {"psi" if self.in_one_field else "quantities": self.findings_in_regions(system)}
        else:
            conserved = {f"psi_{word}": self.findings(side, system) for side, word in SIDES.items()}
        complaints = {name: " ".join(words[:_COMPLAINTS]) for name, words in self.complaints.items()}
        return Checked(system, complaints, maths, conserved)

    def complain(self, name: str, words: str) -> None:
        """Add a complaint about a field, as a sentence."""
        words = _QUOTED.sub(_in_quotes, self.typed.message(on_page(words)))
        words = words if len(words) <= _LONGEST else f"{words[: _LONGEST - 1]}…"
        self.complaints.setdefault(name, []).append(words if words.endswith((".", "…")) else f"{words}.")

    # Each field by itself --------------------------------------------------------------------------------------------

    def refuse_long_texts(self) -> None:
        for name, text in self.texts.items():
            limit = _LIMITS.get(name, MAX_CHARACTERS)
            if len(text) > limit:
                self.complain(name, f"This has {len(text):,} characters; at most {limit:,} are allowed")
                self.texts[name] = ""

    def require_names(self) -> None:
        text = self.texts["name"].strip()
        if not text.isprintable():
            self.complain("name", f"{text!a} contains invisible characters: remove them")
        elif not text:
            self.complain("name", "Give your system a name")
        if not self.items["variables"]:
            self.complain("variables", "Name the variables, as in: x, y")

    def each(self, name: str, read: Callable[[str], _T], most: int) -> tuple[_T, ...]:
        """Read the entries of a list, and complain about those that cannot be read."""
        texts = self.items[name]
        if len(texts) > most:
            self.complain(
                name, f"{'1 entry' if len(texts) == 1 else f'{len(texts)} entries'}; at most {most} are allowed"
            )
        found = []
        for text in texts[:most]:
            try:
                found.append(read(text))
            except ValueError as reason:
                self.complain(name, _capital(str(reason)))
        return tuple(found)

    # What they declare -----------------------------------------------------------------------------------------------

    def declare(self) -> Declaration:
        # A parameter whose value cannot be read has a name nevertheless, which the other fields may use.
        names = tuple(text.partition("=")[0].strip() for text in self.items["parameters"][:MAX_PARAMETERS])
        given = {p.name: p.bounds for p in self.parameters}
        bounds = tuple(given.get(name) for name in names)
        if self.in_one_field or self.in_regions:
            self.read = self.read_one_field(names, bounds) if self.in_one_field else self.read_regions(names, bounds)
            nothing = Declaration.of_sides(self.variables, names, bounds, (), (), ())
            return self.read.declaration if self.read else nothing
        if self.items["psi"]:
            self.complain("psi", "These are quantities of the field f, which is empty: write them beside their side")
        texts = {name: self.items[name] for name in _SIDES}
        return Declaration.of_sides(self.variables, names, bounds, **texts, called=self.called, longest=MAX_DERIVATIVES)

    def refuse_other_fields(self, own: str, others: Iterable[str], laws: str) -> None:
        """Complain beside a field that gives all laws if others have some, too: it is not known which are meant."""
        filled = [f"“{FIELDS[name].partition(',')[0]}”" for name in others if self.texts[name].strip()]
        if filled:
            self.complain(own, f"{laws} the laws of all regions: clear {listed(filled)}, or this field")

    def read_regions(
        self, names: tuple[str, ...], bounds: tuple[tuple[float, float] | None, ...]
    ) -> Regions | None:  # fmt: skip
        """Read regions by their signs or names; where that fails, complain."""
        first = next((name for name in REGION_FIELDS if self.texts[name].strip()), "regions")  # long texts are gone
        self.refuse_other_fields(first, (*_SIDES, "psi"), "Regions have")
        parts = dict(read_parts(self.texts, self.variables, self.typed.read))
        for name, part in parts.items():
            if isinstance(part, ValueError):
                self.complain(name, _capital(str(part)))
        if any(isinstance(part, ValueError) for part in parts.values()):
            return None
        try:
            return Regions.of(self.variables, names, bounds, parts, MAX_DERIVATIVES)
        except ValueError as reason:
            self.complain("quantities", _capital(str(reason)))
            return None

    def read_one_field(
        self, names: tuple[str, ...], bounds: tuple[tuple[float, float] | None, ...]
    ) -> OneField | None:  # fmt: skip
        """Find the regions of one field; where that fails, complain."""
        self.refuse_other_fields("f", (*_SIDES, *REGION_FIELDS), "The field f gives")
        try:
            if words := miscounted(self.items["f"], "expression", self.variables):
                raise ValueError(words)
            return OneField.read(self.variables, names, bounds, self.items["f"], self.items["psi"], MAX_DERIVATIVES)
        except ValueError as reason:
            said = str(reason)
            words = called_by_variables(said, self.variables)
            if not self.complaints.get("f"):
                self.complain("psi" if said.startswith("psi[") else "f", words if "[" in said[:4] else _capital(words))
            return None

    def check_declaration(self) -> None:
        """Complain about the declaration, in the fields that could be read."""
        found = list(self.declaration.problems)
        if self.read is None and (self.in_one_field or self.in_regions):  # nothing is known but the names
            found = [problem for problem in found if problem.field in ("variables", "parameters")]
        if self.read is not None:
            found = self.read.problems(self.variables) if isinstance(self.read, OneField) else self.read.problems()
        if self.variables and (words := miscounted(self.x0, "number", self.variables)):
            found.append(Problem("x0", f"{words}{'; separate them by commas' * (len(self.x0) < len(self.variables))}"))
        readable = FIELDS.keys() - self.complaints.keys()
        for problem in found:
            if problem.field in readable:
                self.complain(problem.field, _capital(problem.message) if problem.entry is None else problem.message)

    def left(self, name: str, k: int) -> _LeftSide:
        """Return the left-hand side for expression `k` of a field."""
        kind, _, word = name.partition("_")
        if kind == "psi":
            return _quantity(word, k, len(self.items[name]))
        if kind == "g":
            return _LeftSide("g", "<mi>g</mi>")
        return _LeftSide(*(rate if kind == "f" else state_after)(self.variables[k]))

    def called(self, name: str, entry: int | None) -> str:
        """Return the name that messages use for the vector field of a side, or for one expression."""
        return f"f{_SIGNS[name.removeprefix('f_')][0]}" if entry is None else self.left(name, entry).said

    def equation(self, left: _LeftSide, right: sympy.Expr) -> str:
        return equation(*left, right, self.symbols)

    def typeset(self, name: str) -> str:
        """Typeset the expressions of a field that could be read."""
        return "".join(self.equation(self.left(name, k), u) for k, u in self.declaration.expressions(name).items())

    def typeset_start(self) -> str:
        """Typeset the coordinates of the start if one of them was typed as a formula."""
        if all(map(is_decimal, self.items["x0"])):
            return ""
        named = zip(self.variables, self.x0, strict=False)
        return "".join(equation(*_LeftSide(name, markup(Symbol(name))), constant(x)) for name, x in named)

    def findings(self, side: int, system: core.PiecewiseSystem | None) -> tuple[Finding, ...]:
        """Return a finding on each given quantity of a side; if none is given, on those found symbolically."""
        word = SIDES[side]
        if self.items[f"psi_{word}"]:
            return tuple(
                self.finding(word, k, verdict)
                for k, verdict in enumerate(self.declaration.verdicts["-" if side < 0 else "+"])
            )
        found = () if system is None else system.laws.modes[side].conserved
        words = f"Found automatically, since the divergence of f{_SIGNS[word][0]} is 0:"
        none = Finding(_without_quantity(word, system), False)
        return tuple(Finding(words, True, self.equation(_quantity(word, 0, 1), psi)) for psi in found) or (none,)

    def findings_in_regions(self, system: core.PiecewiseSystem | None) -> tuple[Finding, ...]:
        """Return what is conserved in the regions of one field, or of several."""
        if system is None:
            return ()
        typed = set(self.declaration.verdicts) if self.items["psi"] else set()
        if isinstance(self.read, Regions):
            typed = {one.name for one in self.declaration.regions if one.psi}
        if not system.laws.most_conserved:
            return (Finding(_without_quantity("", system), False),)
        return tuple(
            Finding(
                f"{'Conserved' if mode.name in typed else 'Found automatically'} {where(mode.name)}:",
                True,
                self.equation(_quantity("", k, len(mode.conserved)), psi),
            )
            for mode in system.laws.regions
            for k, psi in enumerate(mode.conserved)
        )

    def finding(self, word: str, k: int, verdict: Verdict) -> Finding:
        """Say that a quantity is conserved, or typeset its time derivative; the reason is in a complaint."""
        left = self.left(f"psi_{word}", k)
        if not verdict.objection:
            return Finding(f"{left.said} is conserved: its time derivative along f{_SIGNS[word][0]} is 0.", True)
        if verdict.left_over is None:
            return Finding("", False)
        derived = f"<mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac><mo>&#8290;</mo>{left.shown}"
        return Finding("", False, self.equation(_LeftSide(f"d/dt {left.said}", derived), verdict.left_over))

    def build(self) -> core.PiecewiseSystem | None:
        """Return the system, or None after a complaint if it is refused or cannot start."""
        texts: dict[str, Any] = {name: self.items[name] for name in _EXPRESSIONS}
        texts["g"] = next(iter(self.items["g"]), "")
        texts |= self.read.arguments() if isinstance(self.read, Regions) else {}
        names = {"name": self.texts["name"].strip(), "variables": self.variables, "parameters": self.parameters}
        field = "system"
        try:
            system = core.PiecewiseSystem(**names, **texts, x0=self.x0)
            field = "x0"
            checked_start(system, 0.0, self.x0)
        except ValueError as reason:
            self.complain(field, str(reason))
            return None
        return system


def _without_quantity(word: str, system: core.PiecewiseSystem | None) -> str:
    """Say what it means that a side has no conserved quantity; of a system with other faults, that alone."""
    if system is None:
        return "None given."
    refused = [name for name in core.METHODS if not can_use(system, name)]
    if refused:
        where = "on either side" if word else "in any region"
        return f"None given or found {where}, so {listed(refused)} will not be offered."
    return (
        f"None given or found: where g {'<' if word == 'minus' else '>'} 0, conservative methods have no ψ to conserve."
    )


def _quantity(word: str, k: int, count: int) -> _LeftSide:
    """Return the name of a conserved quantity of a side, with its number if there are several."""
    name = quantity_name({"minus": "-", "plus": "+"}.get(word, ""), k, count)
    return _LeftSide(unicode_name(name, name), name_markup(name))


def _parameter_maths(parameter: core.Parameter) -> str:
    value = constant(parameter.default)
    ends = parameter.bounds
    within = ""
    if ends is not None:
        low, high = (markup(constant(end)) for end in ends)
        within = f"<mo>∈</mo><mrow><mo>[</mo>{low}<mo>,</mo>{high}<mo>]</mo></mrow>"
    return equation(*_LeftSide(parameter.name, name_markup(parameter.symbol)), value, more=within)


def _in_quotes(found: re.Match[str]) -> str:
    """Return a quoted text in the quotes of the page, with its own as they were typed."""
    text = found[2] or found[1].replace("\\'", "'")
    return f"“{text}”"


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
