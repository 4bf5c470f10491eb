"""Mathematics in MathML: it says what sympy says, and no name is ever markup."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Add, Float, Integer, Mul, Pow, Rational, Symbol, exp, log, sin, sqrt

import core
from core.symbolic.multiplier import DIFFERENCES
from pwsviz.text.math_names import name_markup
from pwsviz.text.mathml import _explicit, equation, formula, latex, markup, names_of

x, y, z = sympy.symbols("x y z")
KNOWN = {"mi", "mn", "mo", "mrow", "mfrac", "msub", "msup", "msubsup", "msqrt", "mroot", "mover", "mtext", "mspace"}
TABLES = {"mtable", "mtr", "mtd"}


def parsed(inside: str) -> ElementTree.Element:
    """The inside of a <math> as a tree: it is well-formed, of elements of presentation MathML alone."""
    root = ElementTree.fromstring(f"<math>{inside}</math>")  # noqa: S314 - our own
    assert {e.tag for e in root.iter()} <= {"math", *KNOWN, *TABLES}
    return root


def seen(expression: object, names: dict[Symbol, str] | None = None) -> str:
    """What is seen, as a line: fractions, powers and roots by signs."""
    return _line(parsed(markup(expression, names)))  # type: ignore[arg-type]


def _line(element: ElementTree.Element) -> str:
    parts = [_line(child) for child in element]
    match element.tag:
        case "mfrac":
            return f"[{parts[0]}]/[{parts[1]}]"
        case "msup":
            return f"{parts[0]}^[{parts[1]}]"
        case "msub":
            return f"{parts[0]}_[{parts[1]}]"
        case "msubsup":
            return f"{parts[0]}_[{parts[1]}]^[{parts[2]}]"
        case "msqrt":
            return f"√[{''.join(parts)}]"
    return (element.text or "").strip("\u2061\u2062") + "".join(parts)


@pytest.mark.parametrize(
    ("expression", "line"),
    [
        (y**2 - x**3 - z * x, "y^[2]−x^[3]−xz"),
        (Add(x, Mul(-1, Add(y, z), evaluate=False), evaluate=False), "x−(y+z)"),
        (x - (x - y) * z, "x−z(x−y)"),
        (Mul(-1, x + y, x - y), "−(x−y)(x+y)"),
        (x / 2 + y / 2, "[x+y]/[2]"),
        (z - x / 2 - y / 2, "z−[x+y]/[2]"),
        (-z * (x + y) / 2, "−[z(x+y)]/[2]"),
        (-x / (y * z), "−[x]/[yz]"),
        (Rational(-3, 4) * x, "−[3x]/[4]"),
        (x**-2, "[1]/[x^[2]]"),
        (x ** Rational(-3, 2), "[1]/[x^[3/2]]"),
        ((x**2) ** y, "(x^[2])^[y]"),
        ((-x) ** y, "(−x)^[y]"),
        (Mul(2, Pow(3, x), evaluate=False), "2⋅3^[x]"),
        (2 * sqrt(3) * x, "2⋅√[3]x"),
        (sqrt(x + 1), "√[x+1]"),
        (exp(-x * y), "e^[−xy]"),
        (x * sin(y), "xsin(y)"),
        (log(x) ** 2, "(log(x))^[2]"),
        (Float("1.5e-12") * x, "1.5⋅10^[−12]x"),
        (Float(0.1), "0.1"),
        (Integer(-7), "−7"),
        (Integer(10) ** 50 * x, "1⋅10^[50]x"),
        (sympy.pi * x, "πx"),
        (Symbol("threshold") * x, "threshold⋅x"),
    ],
)
def test_an_expression_is_typeset_with_the_brackets_it_needs(expression: object, line: str) -> None:
    assert seen(expression) == line


def test_names_have_their_subscripts_signs_and_greek_letters() -> None:
    system = core.CATALOGUE["harmonic_oscillator"]
    names = names_of(system)
    omega, start = Symbol("omega2_minus"), system.laws.modes[1].discrete.ends.start[0]
    assert seen(omega, dict(names)) == "ω_[−]^[2]"
    assert seen(omega**2, dict(names)) == "(ω_[−]^[2])^[2]"
    assert seen(start, dict(names)) == "x_[0]"
    assert seen(Symbol("a_minus")) == "a_[−]"
    assert seen(Symbol("omega")) == "ω"
    assert seen(Symbol("x1")) == "x_[1]"


@pytest.mark.parametrize(
    ("name", "line"), [("xdot", "x˙"), ("that", "t^"), ("lambda_", "λ"), ("a_b_c", "a_[bc]"), ("x_1", "x_[1]")]
)
def test_other_names_are_what_sympy_takes_them_for(name: str, line: str) -> None:
    assert seen(Symbol(name)) == line


def test_a_name_made_to_be_slow_is_not() -> None:
    """Without possessive quantifiers this takes longer than anybody lives."""
    assert name_markup("\\aaaaaaaaaa" * 40 + "_").startswith("<mtext>")


def test_ends_of_a_step_have_an_index_more_where_the_variable_has_one() -> None:
    system = core.CATALOGUE["rigid_body"]
    ends = system.laws.modes[1].discrete.ends
    assert seen(ends.end[0], dict(names_of(system))) == "y_[1,1]"


def test_a_vector_is_a_column_and_a_matrix_keeps_its_shape() -> None:
    rows = parsed(markup([x, y])).findall(".//mtr")
    assert [len(row) for row in rows] == [1, 1]
    assert [len(row) for row in parsed(markup(sympy.Matrix(2, 3, [x] * 6))).findall(".//mtr")] == [3, 3]


@pytest.mark.parametrize("difference", DIFFERENCES.values(), ids=lambda cls: cls.__name__)
def test_a_divided_difference_is_shown_as_what_it_is(difference: type) -> None:
    """(φ(b) − φ(a))/(b − a), read back from the LaTeX's twin in sympy."""
    shown = _explicit(difference(x, y)).replace(
        lambda u: u.func.__name__ == "sinhc", lambda u: sympy.sinh(u.args[0]) / u.args[0]
    )
    phi = difference.phi  # type: ignore[attr-defined]
    wanted = (phi(y) - phi(x)) / (y - x)
    at = {x: Rational(3, 10), y: Rational(7, 5)}
    assert abs((shown - wanted).subs(at).evalf(30)) < 1e-25
    parsed(markup(difference(x, y)))
    assert "slope" not in latex(difference(x, y))


def test_a_variable_named_b_does_not_confuse_its_divided_difference() -> None:
    ends = sympy.symbols("B_0 B_1")
    shown = latex(DIFFERENCES[sympy.sin](*ends))
    assert shown.count("B_{0}") == shown.count("B_{1}") == 2


def test_an_equation_says_itself_in_plain_characters() -> None:
    text = equation("f_{-}", x**2 + 2 * y)
    root = ElementTree.fromstring(text)  # noqa: S314
    assert root.get("alttext") == root.get("aria-label") == "f_- = x^2 + 2 y"
    assert _line(root) == "f_[−]=x^[2]+2y"


def test_a_formula_is_typeset_piece_by_piece() -> None:
    root = ElementTree.fromstring(formula(r"\hat{x} = x_{k} + \tau f^{\tau}_{s} ( t )"))  # noqa: S314
    assert _line(root) == "x^=x_[k]+τf_[s]^[τ](t)"


@pytest.mark.parametrize(
    "expression",
    [
        sum(Symbol(f"a{k}") for k in range(500)),
        Integer(10) ** 5000 + x,
        Rational(1, 10**5000) * x,
        x ** (10**50),
    ],
    ids=["long", "digits", "small", "exponent"],
)
def test_what_is_too_large_is_cut_and_says_so(expression: sympy.Expr) -> None:
    assert len(markup(expression)) < 500
    assert len(latex(expression)) < 500
    assert len(equation("f", expression)) < 2000


def test_what_is_nested_too_deep_says_so() -> None:
    nested: sympy.Expr = x
    for _ in range(80):
        nested = sin(nested)
    assert "too long to typeset" in markup(nested)
    assert "too long" in latex(nested)


class _Elements(HTMLParser):
    """Notes every element that a browser would make of a text."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}


HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "&lt;b&gt;",
    "\x00",
    "\u202e",
    r"\hat{<b>}",
    "'",
)


@given(st.text(min_size=1, max_size=40) | st.sampled_from(HOSTILE), st.booleans())
def test_no_name_is_ever_markup(name: str, named: bool) -> None:
    symbol = Symbol(name) if not named else x
    names = {x: name} if named else None
    for text in (f"<math>{markup(symbol**2 + y, names)}</math>", equation(name, symbol + 1, names), name_markup(name)):
        found = _Elements()
        found.feed(text)
        assert found.tags <= {"math", *KNOWN}
        assert found.attributes <= {"display", "alttext", "aria-label", "accent", "stretchy", "width"}
        ElementTree.fromstring(f"<p>{re.sub('&(?!#|amp|lt|gt|quot)', '', text)}</p>")  # noqa: S314
        assert all(c.isprintable() for c in text)


@pytest.mark.parametrize("key", core.CATALOGUE)
def test_every_system_of_the_catalogue_is_typeset(key: str) -> None:
    system = core.CATALOGUE[key]
    names = dict(names_of(system))
    for mode in system.laws.regions:
        for expression in (*mode.field, *mode.conserved, *system.laws.surfaces, *mode.discrete.gradient):
            parsed(markup(expression, names))
            assert "too long" not in markup(expression, names)
            assert "text" not in latex(expression, names)


def test_a_name_that_ends_in_a_number_and_a_sign_has_one_subscript():
    assert markup(Symbol("omega2_minus")) == "<msub><mi>ω</mi><mrow><mn>2</mn><mo>−</mo></mrow></msub>"
    assert latex(Symbol("omega2_minus")) == r"\omega_{2-}"


def test_a_formula_is_said_in_the_order_in_which_it_is_typeset():
    k, d, x, y = sympy.symbols("k d x y")
    assert 'alttext="g = k (d - x)"' in equation("g", k * (d - x))
    assert 'alttext="g = y^2 - x^3 - k x"' in equation("g", y**2 - x**3 - k * x)
