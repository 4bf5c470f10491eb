"""A system as a person types it: texts, what is wrong with each of them, and the system they make."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from types import MappingProxyType
from typing import NamedTuple, TypeVar

import sympy
from sympy import Expr, Symbol

import core
from core.integrate import checked_start
from core.symbolic.expressions import TIME, check_name, parse, to_text
from core.symbolic.zero_testing import Domain, counterexample, has_values, independent, is_larger, tidied
from pwsviz.scene.scene import MAX_COORDINATE
from pwsviz.text.mathml import TOO_LONG, markup, too_long

__all__ = ["FIELDS", "Checked", "Draft", "Finding", "check", "examples", "split"]

MAX_CHARACTERS = 1000  #: of one field
MAX_NAME = 60  #: characters of the system's name
MAX_VARIABLES = 8
MAX_PARAMETERS = 20
MAX_DERIVATIVES = 3000  #: nodes of the trees of all first derivatives of one expression
_COMPLAINTS = 3  #: about one field; more would bury the first
_SHOWN = 60  #: characters of a text that is complained about
_LEFT_OVER = 200  #: nodes of what is shown to be left over

#: The fields, and what they are called on the page.
FIELDS: Mapping[str, str] = MappingProxyType(
    {
        "name": "Name",
        "variables": "Variables",
        "parameters": "Parameters",
        "f_minus": "Field f₋, where g < 0",
        "f_plus": "Field f₊, where g > 0",
        "g": "Switching function g",
        "psi_minus": "Conserved quantities ψ₋",
        "psi_plus": "Conserved quantities ψ₊",
        "x0": "Start x₀",
        "jump": "State after the jump",
    }
)

_SIDES = {-1: ("minus", "₋", "−"), 1: ("plus", "₊", "+")}


@dataclass(frozen=True)
class Draft:
    """What stands in the fields. Lists are separated by commas, semicolons or new lines."""

    name: str = ""
    """Of the system, for people."""
    variables: str = ""
    """Names."""
    f_minus: str = ""
    """An expression for each variable."""
    f_plus: str = ""
    """An expression for each variable."""
    g: str = ""
    """The switching function."""
    psi_minus: str = ""
    """Expressions, fewer than there are variables; or none."""
    psi_plus: str = ""
    """Expressions, fewer than there are variables; or none."""
    parameters: str = ""
    """Such as ``k = 3 in [0.1, 10]``, the range being optional."""
    x0: str = ""
    """A number for each variable."""
    jump: str = ""
    """An expression for each variable, or nothing."""

    @classmethod
    def of(cls, system: core.PiecewiseSystem) -> Draft:
        """Write a system as a person would type it, at its current parameter values."""
        lists = {n: "\n".join(getattr(system, n) or ()) for n in ("f_minus", "f_plus", "psi_minus", "psi_plus", "jump")}
        return cls(
            name=system.name,
            variables=", ".join(system.variables),
            parameters="\n".join(_declared(p, system.values[p.name]) for p in system.parameters),
            g=system.g,
            x0=", ".join(map(_typed, system.x0)),
            **lists,
        )


@dataclass(frozen=True)
class Finding:
    """What is found out about one conserved quantity, or about there being none."""

    words: str
    """For people, without markup."""
    conserved: bool
    """Whether a quantity is kept."""
    maths: str = ""
    """What is left over, or what was found, as ``<math>`` elements."""


@dataclass(frozen=True)
class Checked:
    """What comes of a draft."""

    system: core.PiecewiseSystem | None = None
    """The system, if every field is right."""
    complaints: Mapping[str, str] = field(default_factory=dict)
    """Field -> what is wrong with it and what would do; “system” for what concerns no field alone."""
    maths: Mapping[str, str] = field(default_factory=dict)
    """Field -> ``<math>`` elements, escaped, of what can be read of it."""
    conserved: Mapping[int, tuple[Finding, ...]] = field(default_factory=dict)
    """Side (−1 or +1) -> what is found out about its conserved quantities."""


def check(draft: Draft) -> Checked:
    """Read all fields of a draft, each by itself, and say what is wrong with each.

    Nothing is evaluated as code, and the sizes that are read are bounded, so that any text takes bounded time.
    """
    return _Check(draft).run()


def split(text: str) -> list[str]:
    """Split a list at commas, semicolons and new lines that stand in no brackets; empty entries count for nothing."""
    items, depth = [""], 0
    for character in re.sub(r"\r\n?|\n", "\n", text):
        depth = max(0, depth + (character in "([") - (character in ")]"))
        if depth == 0 and character in ",;\n":
            items.append("")
        else:
            items[-1] += character
    return [item.strip().replace("\n", " ") for item in items if item.strip()]


class _Left(NamedTuple):
    """What stands on the left of an equation."""

    said: str
    shown: str


_T = TypeVar("_T")


class _Check:
    """One pass over a draft: each method reads a field, and writes down what it finds."""

    def __init__(self, draft: Draft) -> None:
        self.texts = {name: getattr(draft, name).replace("−", "-") for name in FIELDS}  # as pages write a minus
        self.complaints: dict[str, list[str]] = {}
        self.maths: dict[str, str] = {}
        self.conserved: dict[int, tuple[Finding, ...]] = {}
        self.variables: tuple[str, ...] = ()
        self.parameters: tuple[core.Parameter, ...] = ()
        self.g: Expr | None = None

    def run(self) -> Checked:
        self.refuse_long_texts()
        self.read_name()
        self.read_variables()
        self.read_parameters()
        fields = {side: self.read_vector(f"f_{word}", _derivative) for side, (word, *_) in _SIDES.items()}
        self.read_g()
        for side, f in fields.items():
            self.read_conserved(side, f)
        x0 = self.read_start()
        if split(self.texts["jump"]):
            self.read_vector("jump", _after)
        system = None if self.complaints else self.build(x0)
        complaints = {name: " ".join(words[:_COMPLAINTS]) for name, words in self.complaints.items()}
        return Checked(system if not complaints else None, complaints, self.maths, self.conserved)

    def complain(self, name: str, words: str) -> None:
        self.complaints.setdefault(name, []).append(words)

    def refuse_long_texts(self) -> None:
        for name, text in self.texts.items():
            limit = MAX_NAME if name == "name" else MAX_CHARACTERS
            if len(text) > limit:
                self.complain(name, f"This is {len(text):,} characters long: {limit:,} at most.")
                self.texts[name] = ""

    # Names -----------------------------------------------------------------------------------------------------------

    def read_name(self) -> None:
        text = self.texts["name"].strip()
        if not text.isprintable():
            self.complain("name", f"{text!a} holds characters that cannot be seen: leave them out.")
        elif not text:
            self.complain("name", "Give your system a name.")

    def read_variables(self) -> None:
        found = self.each("variables", _variable, MAX_VARIABLES)
        self.require_distinct("variables", found)
        self.variables = tuple(dict.fromkeys(found))
        if not found:
            self.complain("variables", "Name the variables, as in: x, y")

    def read_parameters(self) -> None:
        found = self.each("parameters", _parameter, MAX_PARAMETERS)
        self.require_distinct("parameters", [*self.variables, *(p.name for p in found)])
        self.parameters = tuple({p.name: p for p in found if p.name not in self.variables}.values())
        self.maths["parameters"] = "".join(map(_parameter_maths, self.parameters))

    def require_distinct(self, name: str, names: Sequence[str]) -> None:
        for twice in sorted({n for n in names if names.count(n) > 1}):
            self.complain(name, f"{twice!r} stands for two things: names must differ.")

    # Entries of a list -----------------------------------------------------------------------------------------------

    def each(self, name: str, read: Callable[[str], _T], most: int) -> list[_T]:
        """Read the entries of a list, and complain of those that cannot be read."""
        texts = split(self.texts[name])
        if len(texts) > most:
            self.complain(name, f"There are {len(texts)} here: {most} at most.")
        found = []
        for text in texts[:most]:
            try:
                found.append(read(text))
            except ValueError as reason:
                self.complain(name, _sentence(str(reason)))
        return found

    def expressions(self, name: str, lefts: Sequence[_Left]) -> tuple[Expr, ...]:
        """Read as many expressions as there are left sides, typeset those that can be read, complain of the others."""
        names = (*self.variables, *(p.name for p in self.parameters))
        found, shown = [], []
        for text, left in zip(split(self.texts[name]), lefts, strict=False):
            try:
                found.append(self.expression(text, names, left.said))
            except ValueError as reason:
                self.complain(name, _sentence(str(reason)))
            else:
                shown.append(_equation(left, found[-1]))
        self.maths[name] = "".join(shown)
        return tuple(found)

    def expression(self, text: str, names: Sequence[str], what: str) -> Expr:
        """Read one expression, if its derivatives, which every scheme needs, are of a size to work with."""
        expression = parse(text, names, what)
        gradient = sympy.Tuple(*self.gradient(expression))
        if is_larger(gradient, MAX_DERIVATIVES):
            raise ValueError(f"{what} = {_short(text)!r}: its derivatives are too long to work with; write it shorter")
        return expression

    # Laws ------------------------------------------------------------------------------------------------------------

    def read_vector(self, name: str, left: Callable[[str], _Left]) -> tuple[Expr, ...]:
        """Read an expression for each variable."""
        found = self.expressions(name, [left(v) for v in self.variables])
        count, needed = len(split(self.texts[name])), len(self.variables)
        if count != needed and name not in self.complaints:
            listed = ", ".join(self.variables)
            self.complain(name, f"{_count(count, 'expression')} here, {needed} are needed: one for each of {listed}.")
        return found

    def read_g(self) -> None:
        found = self.expressions("g", [_Left("g", "<mi>g</mi>")])
        if "g" in self.complaints:
            return
        if len(split(self.texts["g"])) != 1:
            self.complain("g", "Type one expression, as in: x**2 + y**2 - 1. The law changes where it is zero.")
        elif not found[0].free_symbols & set(map(Symbol, self.variables)):
            self.complain("g", f"{self.texts['g'].strip()[:_SHOWN]!r} names no variable, so it is zero on no surface.")
        else:
            self.g = found[0]

    def read_start(self) -> tuple[float, ...]:
        found = self.each("x0", _coordinate, MAX_VARIABLES)
        if len(found) != len(self.variables) and "x0" not in self.complaints:
            listed = ", ".join(self.variables)
            count, needed = _count(len(found), "number"), len(self.variables)
            self.complain("x0", f"{count} here, {needed} are needed: one for each of {listed}.")
        return tuple(found)

    # Conserved quantities --------------------------------------------------------------------------------------------

    def read_conserved(self, side: int, f: tuple[Expr, ...]) -> None:
        word, sign, _ = _SIDES[side]
        name, most = f"psi_{word}", max(len(self.variables) - 1, 0)
        count = len(split(self.texts[name]))
        lefts = [_quantity(side, k, count) for k in range(min(count, most))]
        found = self.expressions(name, lefts)
        if count > most:
            self.complain(
                name, f"There are {count} here; with {_count(len(self.variables), 'variable')}, {most} at most."
            )
        self.conserved[side] = ()
        if not count:
            self.conserved[side] = (Finding("None given; conservative methods will not be offered.", False),)
        elif not self.complaints.keys() & {name, f"f_{word}", "variables", "parameters"}:
            domain = self.domain(side, f)
            self.conserved[side] = tuple(
                self.judge(sign, left, psi, self.rate(psi, f), domain) for left, psi in zip(lefts, found, strict=True)
            )
            for finding in self.conserved[side]:
                if not finding.conserved:
                    self.complain(name, f"{finding.words} Mend it, mend f{sign}, or leave it out.")
            if name not in self.complaints and not independent(sympy.Matrix([*map(self.gradient, found)]), domain):
                self.complain(name, "Their gradients are linearly dependent, or zero: leave out what says nothing new.")

    def rate(self, psi: Expr, f: tuple[Expr, ...]) -> Expr:
        """Return the time derivative of ψ along a field."""
        terms = [psi.diff(Symbol(v)) * u for v, u in zip(self.variables, f, strict=True)]
        return sympy.Add(psi.diff(TIME), *terms)

    def gradient(self, u: Expr) -> list[Expr]:
        return [u.diff(v) for v in (*map(Symbol, self.variables), TIME)]

    def domain(self, side: int, f: tuple[Expr, ...]) -> Domain:
        """Where the law of a side is used; everywhere as long as g cannot be read."""
        ranges = {Symbol(p.name): p.bounds for p in self.parameters if p.bounds is not None}
        return Domain(ranges, None if self.g is None else side * self.g, f)

    def judge(self, sign: str, left: _Left, psi: Expr, rate: Expr, domain: Domain) -> Finding:
        """Say whether a quantity is conserved, and else what is left over."""
        if not has_values((psi, rate), domain):
            return Finding(f"{left.said} has no real value on its side of the surface.", False)
        witness = counterexample(rate, domain)
        if witness is None:
            return Finding(f"{left.said} is conserved: its time derivative along f{sign} is 0.", True)
        if witness.partly:
            words = (
                f"{left.said} is conserved {witness.scope}: at {witness.at()}, d/dt {left.said} = {witness.value:.3g}."
            )
            return Finding(words, False)
        if is_larger(rate, _LEFT_OVER):
            return Finding(f"{left.said} is not conserved: what is left over of d/dt {left.said} is long.", False)
        over = tidied(rate)
        words = f"{left.said} is not conserved: d/dt {left.said} = {_short(to_text(over))} is left over."
        derived = f"<mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac><mo>&#8290;</mo>{left.shown}"
        return Finding(words, False, _equation(_Left(f"d/dt {left.said}", derived), over))

    # All of it -------------------------------------------------------------------------------------------------------

    def build(self, x0: tuple[float, ...]) -> core.PiecewiseSystem | None:
        """Make the system, and say what was found for it."""
        texts = {name: tuple(split(text)) for name, text in self.texts.items()}
        try:
            system = core.PiecewiseSystem(
                name=self.texts["name"].strip(),
                variables=self.variables,
                f_minus=texts["f_minus"],
                f_plus=texts["f_plus"],
                g=texts["g"][0],
                psi_minus=texts["psi_minus"],
                psi_plus=texts["psi_plus"],
                parameters=self.parameters,
                x0=x0,
                jump=texts["jump"] or None,
            )
        except ValueError as reason:
            self.complain("system", _sentence(str(reason)))
            return None
        try:
            checked_start(system, 0.0, x0)
        except ValueError as reason:
            self.complain("x0", _sentence(str(reason)))
        for side, (word, sign, _) in _SIDES.items():
            if system.laws.sides[side].conserved and not texts[f"psi_{word}"]:
                found = system.laws.sides[side].conserved[0]
                shown = _equation(_quantity(side, 0, 1), found)
                self.conserved[side] = (Finding(f"Found for you, since f{sign} has no divergence:", True, shown),)
        return system


def _variable(text: str) -> str:
    return check_name(text, "Variable")


def _parameter(text: str) -> core.Parameter:
    """Read ``k = 3 in [0.1, 10]``."""
    name, equals, rest = (part.strip() for part in text.partition("="))
    value, within, bounds = (part.strip() for part in re.sub(r"\bin\b", "\0", rest, count=1).partition("\0"))
    ends = split(bounds[1:-1]) if bounds.startswith("[") and bounds.endswith("]") else []
    if not equals or (within and len(ends) != 2):
        raise ValueError(f"{_short(text)!r} is no parameter: write k = 3, or k = 3 in [0.1, 10]")
    check_name(name, "Parameter")
    numbers = [_number(part, name) for part in (value, *ends)]
    return core.Parameter(name, numbers[0], (numbers[1], numbers[2]) if within else None)


def _coordinate(text: str) -> float:
    number = _number(text, "x₀")
    if abs(number) > MAX_COORDINATE:
        raise ValueError(f"{_short(text)!r} is too far away: take numbers between ±{MAX_COORDINATE:,.0f}")
    return number


def _number(text: str, what: str) -> float:
    """Read a number, such as 0.1, 1/3 or sqrt(2)."""
    constant = parse(text, (), what)
    if constant.free_symbols:
        raise ValueError(f"{what} = {_short(text)!r} is no number")
    return float(constant)


def _derivative(variable: str) -> _Left:
    return _Left(f"{variable}′", f'<mrow>{markup(Symbol(variable))}<mo lspace="0" rspace="0">′</mo></mrow>')


def _after(variable: str) -> _Left:
    shown = f"<msub><mrow>{markup(Symbol(variable))}</mrow><mtext>after</mtext></msub>"
    return _Left(f"{variable} after the jump", shown)


def _quantity(side: int, k: int, count: int) -> _Left:
    """Name a conserved quantity, with its number where there are several."""
    _, sign, shown = _SIDES[side]
    if count == 1:
        return _Left(f"ψ{sign}", f"<msub><mi>ψ</mi><mo>{shown}</mo></msub>")
    number = f"<mrow><mn>{k + 1}</mn><mo>{shown}</mo></mrow>"
    return _Left(f"ψ{sign} no. {k + 1}", f"<msub><mi>ψ</mi>{number}</msub>")


def _equation(left: _Left, right: Expr, more: str = "") -> str:
    """Typeset an equation, and say it in plain characters."""
    said = escape(f"{left.said} = {TOO_LONG if too_long(right) else to_text(right)}")
    inside = f"{left.shown}<mo>=</mo>{markup(right)}{more}"
    return f'<math display="block" alttext="{said}" aria-label="{said}"><mrow>{inside}</mrow></math>'


def _parameter_maths(parameter: core.Parameter) -> str:
    name, value = Symbol(parameter.name), sympy.Float(parameter.default)
    ends = parameter.bounds
    within = ""
    if ends is not None:
        low, high = (markup(sympy.Float(end)) for end in ends)
        within = f"<mo>∈</mo><mrow><mo>[</mo>{low}<mo>,</mo>{high}<mo>]</mo></mrow>"
    return _equation(_Left(parameter.name, markup(name)), value, within)


def _declared(parameter: core.Parameter, value: float) -> str:
    within = "" if parameter.bounds is None else f" in [{', '.join(map(_typed, parameter.bounds))}]"
    return f"{parameter.name} = {_typed(value)}{within}"


def _typed(number: float) -> str:
    """Shortest text of a number."""
    return repr(float(number)).removesuffix(".0")


def _short(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _sentence(words: str) -> str:
    return words if words.endswith((".", "…")) else f"{words}."


examples: Mapping[str, Draft] = MappingProxyType(
    {
        "Two springs": Draft(
            name="My oscillator",
            variables="x, y",
            f_minus="y\n-k*x",
            f_plus="y\n-x",
            g="y",
            parameters="k = 3 in [0.1, 10]",
            x0="1, 1",
        ),
        "Duffing oscillator, stiffness switched": Draft(
            name="Duffing oscillator",
            variables="x, v",
            f_minus="v\n-a*x - b_minus*x**3",
            f_plus="v\n-a*x - b_plus*x**3",
            g="x",
            psi_minus="v**2/2 + a*x**2/2 + b_minus*x**4/4",
            psi_plus="v**2/2 + a*x**2/2 + b_plus*x**4/4",
            parameters="a = 1 in [0.1, 5]\nb_minus = 0.5 in [0, 5]\nb_plus = 4 in [0, 5]",
            x0="1.2, 0",
        ),
        "Lotka–Volterra with harvest": Draft(
            name="Harvested prey",
            variables="x, y",
            f_minus="x*(a - b*y)\ny*(c*x - d)",
            f_plus="x*(a - h - b*y)\ny*(c*x - d)",
            g="y - y_max",
            psi_minus="c*x - d*log(x) + b*y - a*log(y)",
            psi_plus="c*x - d*log(x) + b*y - (a - h)*log(y)",
            parameters=(
                "a = 2 in [0.5, 5]\nb = 1 in [0.1, 5]\nc = 1 in [0.1, 5]\nd = 1 in [0.1, 5]\n"
                "h = 0.8 in [0, 2]\ny_max = 2.5 in [0.5, 5]"
            ),
            x0="0.5, 1",
        ),
        "Spinning top in three dimensions": Draft(
            name="Spinning top",
            variables="p, q, r",
            f_minus="(B - C)/A*q*r\n(C - A)/B*r*p\n(A - B)/C*p*q",
            f_plus="(B - C_plus)/A*q*r\n(C_plus - A)/B*r*p\n(A - B)/C_plus*p*q",
            g="p",
            psi_minus="(A*p**2 + B*q**2 + C*r**2)/2\n(A**2*p**2 + B**2*q**2 + C**2*r**2)/2",
            psi_plus="(A*p**2 + B*q**2 + C_plus*r**2)/2\n(A**2*p**2 + B**2*q**2 + C_plus**2*r**2)/2",
            parameters="A = 1 in [0.5, 4]\nB = 2 in [0.5, 4]\nC = 3 in [0.5, 4]\nC_plus = 3.5 in [0.5, 4]",
            x0="1, 0.5, 1",
        ),
        "Impact oscillator": Draft(
            name="Impact oscillator",
            variables="x, v",
            f_minus="v\n-x",
            f_plus="v\n-x",
            g="x + wall",
            psi_minus="(x**2 + v**2)/2",
            psi_plus="(x**2 + v**2)/2",
            parameters="wall = 0.5 in [0.1, 0.9]\nr = 0.95 in [0.1, 1]",
            x0="1, 0",
            jump="-wall\n-r*v",
        ),
        "Van der Pol, nothing conserved": Draft(
            name="Van der Pol oscillator",
            variables="x, v",
            f_minus="v\nmu_minus*(1 - x**2)*v - x",
            f_plus="v\nmu_plus*(1 - x**2)*v - x",
            g="x",
            parameters="mu_minus = 0.5 in [0, 3]\nmu_plus = 2 in [0, 3]",
            x0="0.5, 1",
        ),
    }
)
"""Systems to start from, by title."""
