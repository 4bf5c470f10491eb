"""The scheme in mathematics: the paper's two as printed, and for every system and method something sound."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy
from scipy.integrate import DOP853

import core
from pwsviz.figures.scheme import scheme_markup
from tests.levels import deep_but

VOID = {"br", "hr"}
PAIRS = [
    (name, key)
    for key, system in core.CATALOGUE.items()
    for name, method in core.METHODS.items()
    if not method.needs_conserved or system.laws.most_conserved
]


class _Outline(HTMLParser):
    """Elements in order, and whether each is closed where it should be."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: set[str] = set()
        self.headings: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Sequence[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attrs}
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def said(text: str) -> list[str]:
    """The equations, as they are said."""
    return re.findall(r'alttext="([^"]*)"', text)


def test_the_oscillator_has_the_implicit_midpoint_rule_as_printed() -> None:
    text = scheme_markup(core.CATALOGUE["harmonic_oscillator"], "dmm2")
    source = re.search("<pre><code>(.*)</code></pre>", text, re.DOTALL)
    assert source is not None
    assert r"\frac{\Delta x}{\tau} = \frac{y_{0} + y_{1}}{2}" in source[1]
    assert r"\frac{\Delta y}{\tau} = - \frac{\omega^2_{-} \left(x_{0} + x_{1}\right)}{2}" in source[1]
    assert r"\frac{\Delta y}{\tau} = - \frac{\omega^2_{+} \left(x_{0} + x_{1}\right)}{2}" in source[1]


def test_the_elliptic_curve_has_the_scheme_as_printed() -> None:
    text = scheme_markup(core.CATALOGUE["elliptic_curve"], "dmm2")
    rates = [line.split(" = ")[1] for line in said(text) if line.startswith("change of")]
    x0, x1, y0, y1, *a = sympy.symbols("x_0 x_1 y_0 y_1 a_minus a_plus")
    shown = [sympy.sympify(rate.replace(" ", "*").replace("*+*", "+").replace("^", "**")) for rate in rates]
    assert shown == [y0 + y1, x1**2 + x1 * x0 + x0**2 + a[0], y0 + y1, x1**2 + x1 * x0 + x0**2 + a[1]]
    line = "<mo>=</mo><mrow><msub><mi>y</mi><mn>0</mn></msub><mo>+</mo><msub><mi>y</mi><mn>1</mn></msub></mrow>"
    assert line in text


@pytest.mark.parametrize(("method", "key"), deep_but(["dmm2", "prk8"], PAIRS))
def test_every_system_and_method_is_shown_soundly(key: str, method: str) -> None:
    system = core.CATALOGUE[key]
    text = scheme_markup(system, method)
    outline = _Outline(text)
    assert len(outline.headings) == 4
    assert set(outline.tags) & {"script", "img", "a", "style"} == set()
    assert outline.attributes <= {
        "class", "scope", "role", "display", "alttext", "aria-label", "accent", "stretchy", "width", "displaystyle",
    }  # fmt: skip
    meanings = [escape(parameter.doc) for parameter in system.parameters if parameter.doc]
    assert "slope" not in re.sub("|".join(map(re.escape, meanings)) or "$", "", text)
    assert "too long" not in text
    for math in re.findall(r"<math.*?</math>", text):
        ElementTree.fromstring(math)  # noqa: S314 - our own
    multipliers = sum(line.startswith("Lambda^tau_") for line in said(text))
    known = sum(bool(region.psi) for region in system.regions.values())
    shown = min(1, known) if "The law</" in text else known
    assert multipliers == (shown if core.METHODS[method].conservative else 0)


@pytest.mark.parametrize("method", ["dmm2", "prk8"])
@pytest.mark.parametrize(("key", "timed"), [("damped_oscillator", True), ("kepler", False)])
def test_the_slope_in_time_is_there_where_a_conserved_quantity_names_time(key: str, method: str, timed: bool) -> None:
    assert ("s_t" in " ".join(said(scheme_markup(core.CATALOGUE[key], method)))) is timed


def test_a_value_of_a_parameter_is_shown_as_it_is() -> None:
    system = core.CATALOGUE["elliptic_curve"].with_parameters(a_plus=-2.53125)
    assert ">−2.53125<" in scheme_markup(system, "dmm2")
    assert ">−2.53125<" not in scheme_markup(core.CATALOGUE["elliptic_curve"], "dmm2")


@pytest.mark.parametrize("method", ["rk2", "rk4"])
def test_the_weights_shown_make_a_method_of_its_order(method: str) -> None:
    """Butcher's conditions up to order 2 and 4, read back from the table."""
    text = scheme_markup(core.CATALOGUE["relay_feedback"], method)
    table = next(t for t in re.findall("<table>.*?</table>", text) if ">stage<" in t)
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in re.findall("<tr>.*?</tr>", table)[1:]]

    def value(cell: str) -> float:
        figures = [float(f) for f in re.findall("<mn>(.*?)</mn>", cell)]
        return figures[0] / figures[1] if "mfrac" in cell else (figures or [0.0])[0]

    matrix = np.array([[value(cell) for cell in row[1:]] for row in rows])
    c, a, b = matrix[:-1, 0], matrix[:-1, 1:], matrix[-1, 1:]
    assert a.sum(axis=1) == pytest.approx(c)
    conditions = [(b.sum(), 1), (b @ c, 1 / 2)]
    if method == "rk4":
        conditions += [(b @ c**2, 1 / 3), (b @ a @ c, 1 / 6), (b @ c**3, 1 / 4), (b @ a @ a @ c, 1 / 24)]
    for got, wanted in conditions:
        assert got == pytest.approx(wanted)


@pytest.mark.parametrize(("method", "count"), [("dmm4", 5), ("dmm6", 9), ("dmm8", 17)])
def test_the_coefficients_of_a_composition_add_up_to_one(method: str, count: int) -> None:
    text = scheme_markup(core.CATALOGUE["pendulum"], method)
    rows = re.findall(r'<th scope="row">([\d, ]+)</th><td>([−.\d]+)</td>', text)
    weights = [(len(places.split(",")), float(weight.replace("−", "-"))) for places, weight in rows]
    assert sum(times for times, _ in weights) == count
    assert sum(times * weight for times, weight in weights) == pytest.approx(1, abs=1e-14)
    assert sum(times * weight**3 for times, weight in weights) == pytest.approx(0, abs=1e-13)


def test_stages_of_the_large_method_are_those_of_dop853() -> None:
    assert f"i = 1 , … , {DOP853.n_stages}" in scheme_markup(core.CATALOGUE["pendulum"], "rk8")


def test_the_transition_is_that_which_was_asked_for() -> None:
    system = core.CATALOGUE["elliptic_curve"]
    plain = scheme_markup(system, "dmm2")
    moved = scheme_markup(system, "dmm2", perturbation_order=2, perturbation_scale=0.5)
    assert "c tau^2" in " ".join(said(moved))
    assert "p = 2 and c = 0.5" in moved
    assert "moved on purpose" not in plain
    assert "t-hat - t_k" in " ".join(said(plain))
    assert "t-hat" not in " ".join(said(scheme_markup(system, "dmm2", locate=False)))


def test_a_jump_and_a_surface_that_moves_are_in_the_equations() -> None:
    ball = scheme_markup(core.CATALOGUE["bouncing_ball"], "dmm2")
    assert "the state is reset" in ball
    assert "other side" not in ball, "one law holds on both"
    assert "g ( t-hat , x-hat ) = 0" in said(scheme_markup(core.CATALOGUE["moving_interface"], "dmm2"))
    assert "g ( x-hat ) = 0" in said(scheme_markup(core.CATALOGUE["pendulum"], "dmm2"))


def test_what_a_person_typed_is_never_markup() -> None:
    hostile = '<img src=x onerror="alert(1)">'
    parameters = (core.Parameter("k", 1.0, doc=hostile, latex=hostile),)
    system = core.PiecewiseSystem(hostile, ("x", "y"), ("y", "-k*x"), ("y", "-x"), "y", parameters=parameters)
    outline = _Outline(scheme_markup(system, "dmm2"))
    assert "img" not in outline.tags
    assert hostile in "".join(outline.words)


def test_systems_that_differ_in_how_a_parameter_is_typeset_are_told_apart() -> None:
    system = core.CATALOGUE["elliptic_curve"]
    renamed = tuple(replace(p, latex="R") if p.name == "radius" else p for p in system.parameters)
    first, second = (scheme_markup(s, "dmm2") for s in (system, replace(system, parameters=renamed)))
    assert "<mi>R</mi>" not in first
    assert "<mi>R</mi>" in second


@pytest.mark.parametrize("key", ["elliptic_curve", "kepler"])
def test_words_and_formulas_have_one_symbol_for_the_multiplier(key: str) -> None:
    run = core.integrate(core.CATALOGUE[key], (0.0, 5.0), tau=0.01, method="dmm2")
    text = scheme_markup(core.CATALOGUE[key], "dmm2", core.diagnose(run), run)
    assert "The multiplier Λ<sup>τ</sup> is" in text
    assert "|f<sup>τ</sup>·H f<sup>τ</sup>|" in text
    assert not re.findall("ᵗ|[^ ]\\^τ", text)
