"""Texts of a person's own system: what is read, what is complained of, and that no text hangs or breaks anything."""

import re
from dataclasses import fields, replace
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import core
from pwsviz.editor.draft import FIELDS, Draft
from pwsviz.editor.examples import EXAMPLES
from pwsviz.editor.regions import REGION_FIELDS
from pwsviz.editor.validation import MAX_CHARACTERS, check
from pwsviz.scene.permalink import query, read
from pwsviz.scene.scene import Scene, can_use
from pwsviz.text.math_names import name_markup
from pwsviz.text.numbers import shortest
from tests.bounds import bounded_time
from tests.levels import deep_but
from tests.pwsviz.own_systems import OWN_SYSTEMS

OSCILLATOR = Draft(
    name="Mine",
    variables="x, y",
    f_minus="y\n-k*x",
    f_plus="y\n-x",
    g="y",
    parameters="k = 3 in [0.1, 10]",
    x0="1, 1",
)
#: What our markup is made of; "all" is the test's own.
TAGS = {
    *("all", "p", "math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "mfrac", "msup", "msub", "msubsup", "msqrt"),
    *("mroot", "mover", "mtable", "mtr", "mtd"),
}
#: Of processor time; on an idle machine no text below takes 0.9 s.


def test_fields_are_those_of_a_draft():
    assert set(FIELDS) == {field.name for field in fields(Draft)} - {"known"}


@pytest.mark.parametrize("title", EXAMPLES)
def test_every_example_makes_a_system_that_runs_across_its_surface(title):
    checked = check(EXAMPLES[title])
    assert checked.complaints == {}
    known = checked.system.laws.most_conserved > 0
    run = core.integrate(checked.system, (0.0, 20.0), tau=0.01, method="dmm2" if known else "rk2")
    assert run.status is core.Status.COMPLETED
    assert len(run.crossings) >= 2
    if known:  # round-off of ψ, some units of it in size
        assert np.nanmax(np.abs(run.conserved_error())) < 1e-12
    else:
        assert all("will not be offered" in side[0].words for side in checked.conserved.values())


TWO_SIDED = [key for key, system in core.CATALOGUE.items() if system.two_sided]


@pytest.mark.parametrize("key", deep_but(set(TWO_SIDED) - {"three_bodies"}, TWO_SIDED))  # whose check takes seconds
def test_a_built_in_system_written_out_and_read_again_is_the_same(key):
    system = core.CATALOGUE[key]
    again = check(Draft.of(system)).system
    for name in ("name", "variables", "f_minus", "f_plus", "g", "psi_minus", "psi_plus", "x0", "jump", "values"):
        assert getattr(again, name) == getattr(system, name)
    assert again.parameters == system.parameters, "with their bounds, symbols and descriptions"


@pytest.mark.parametrize(("key", "name"), [("pendulum", "angle"), ("kepler", "radius")])
def test_parameters_of_a_system_started_from_keep_their_symbols_while_it_is_edited(key, name):
    system = core.CATALOGUE[key]
    draft = Draft.of(system)
    checked = check(replace(draft, parameters=f"{draft.parameters}\nnew = 1"))
    symbols = {p.name: p.symbol for p in checked.system.parameters}
    assert symbols == {p.name: p.symbol for p in system.parameters} | {"new": "new"}
    assert symbols[name] != name
    for field in ("parameters", "g"):
        assert name_markup(symbols[name]) in checked.maths[field]
        assert f"<mi>{name}</mi>" not in checked.maths[field]


DECLARED = (
    "name", "variables", "f_minus", "f_plus", "g", "psi_minus", "psi_plus", "x0", "jump", "values", "surfaces",
    "regions", "jumps", "transitions", "f", "psi",
)  # fmt: skip


@pytest.mark.parametrize(
    "system", [*(one for one in core.CATALOGUE.values() if not one.two_sided), *OWN_SYSTEMS.values()], ids=str
)
def test_regions_walls_and_hysteresis_written_out_and_read_again_are_the_same(system):
    checked = check(Draft.of(system))
    assert checked.complaints == {}
    for name in DECLARED:
        assert getattr(checked.system, name) == getattr(system, name), name


WALLS = Draft(
    name="Walls", variables="x, v", x0="0, 1", parameters="r = 0.9 in [0.1, 1]",
    surfaces="x + 1\nx - 1", regions="+ −: x' = v, v' = -x^3", quantities="+-: v^2/2 + x^4/4",
    resets="g1, g2 => x, -r*v",
)  # fmt: skip
HEATER = Draft(
    name="Heater", variables="T, q", x0="0, 0", regions="on: 1 - T/9, 0\nstand by:\n  -T/9,\n  1",
    transitions="on -> stand by: 1 - T\nstand by → on: T + 1 => T, q/2",
)  # fmt: skip


def test_walls_and_hysteresis_are_read_as_people_type_them_and_shown_as_read():
    walls = check(WALLS)
    assert walls.complaints == {}
    assert dict(walls.system.regions) == {"+-": core.Region(("v", "-x**3"), ("v**2/2 + x**4/4",))}
    assert dict(walls.system.jumps) == {0: ("x", "-r*v"), 1: ("x", "-r*v")}
    assert "Region +-:" in walls.maths["regions"]
    assert [walls.maths[name].count("<math") for name in REGION_FIELDS] == [2, 2, 1, 4, 0]
    assert walls.conserved["quantities"][0].conserved
    assert core.integrate(walls.system, (0.0, 9.0), method="prk8", tau=0.05).tally.jumps > 2
    heater = check(HEATER)
    assert heater.complaints == {}
    assert heater.system.transitions == (
        core.Transition("on", "1 - T", "stand by"), core.Transition("stand by", "T + 1", "on", ("T", "q/2")),
    )  # fmt: skip
    assert "stand by → on, where:" in heater.maths["transitions"]
    assert heater.maths["transitions"].count("<math") == 4


@pytest.mark.parametrize("draft", [WALLS, HEATER], ids=lambda draft: draft.name)
def test_walls_and_hysteresis_come_back_from_a_link_as_they_were_read(draft):
    scene = Scene()
    scene.use(check(draft).system)
    found, complaints = read(query(scene))
    assert complaints == []
    assert check(Draft.of(found["own"])).system == check(draft).system


@pytest.mark.parametrize(
    ("changes", "field", "says"),
    [
        ({"surfaces": "x + 1"}, "regions", "“+-” is not a region: write 1 sign, - or +, one for each surface"),
        ({"surfaces": "x + 1, x +"}, "surfaces", "g2 = “x +”: this is not an expression"),
        ({"surfaces": "x + 1, 2x + 2"}, "surfaces", "g2 = “2x + 2” is zero where g1 is"),
        ({"surfaces": "", "resets": "", "quantities": ""}, "surfaces", "0 surfaces: from 1 to 6 are possible"),
        ({"regions": "v, -x"}, "regions", "“v, -x” belongs to no region: begin each region with its signs"),
        ({"regions": "+-: v, -x\n+ -: v, 0"}, "regions", "“+-” is there twice"),
        ({"regions": "+-: v"}, "regions", "Region +-: 1 expression given, 2 needed"),
        ({"regions": "+-: v, -q*x", "quantities": ""}, "regions", "v′ in region +- = “-q*x”: unknown name “q”"),
        ({"regions": ""}, "quantities", "“+-” is not a region: write its field first"),
        ({"regions": ": v, -x"}, "regions", "Nothing stands before a colon"),
        ({"quantities": "+-: v^2"}, "quantities", "ψ in region +- = “v^2” is not conserved by the field of region +-"),
        ({"quantities": "++: v"}, "quantities", "“++” is not a region: the regions are +-"),
        ({"resets": "x, -v"}, "resets", "“x, -v” is at no surface: write the surface, an arrow"),
        ({"resets": "wall => x, -v"}, "resets", "“wall” is not a surface"),
        ({"resets": "g3 => x, -v"}, "resets", "There is no surface g3: 2 switching functions are given"),
        ({"resets": "g1 => x"}, "resets", "At g1: 1 expression given, 2 needed"),
        ({"resets": "g1 =>"}, "resets", "Nothing stands after an arrow"),
        ({"resets": "g1 => x, -q"}, "resets", "v⁺ at g1 = “-q”: unknown name “q”"),
        ({"resets": "g1 => x, -v\ng1 => x, v"}, "resets", "The surface g1 is there twice"),
        ({"transitions": "on: x"}, "transitions", "“on: x” is not a transition"),
        ({"f_minus": "v, -x"}, "surfaces", "Regions have the laws of all regions: clear “Field f₋”, or this field"),
        ({"f": "v, -abs(x)"}, "f", "The field f gives the laws of all regions: clear “Switching functions g1”, “Reg"),
        ({"x0": "30, 1"}, "x0", "(30, 1) lies in a region for which no law is declared"),
        ({"psi": "v"}, "surfaces", "clear “Conserved quantities ψ”, or"),
    ],
)
def test_a_mistake_in_regions_and_walls_is_told_beside_it(changes, field, says):
    checked = check(replace(WALLS, **changes))
    assert checked.system is None
    assert says in checked.complaints[field]


@pytest.mark.parametrize(
    ("transitions", "says"),
    [
        (
            "on -> off: 1 - T\nstand by -> on: T + 1",
            "From on to off: “off” is not a region; there are “on”, “stand by”",
        ),
        ("on -> stand by: 1 - T", "Region “stand by” has no guard, so a run would never leave it"),
        (
            "on -> stand by: 1 - T, q\nstand by -> on: T",
            "is not a transition: write both regions, a colon and the guard",
        ),
        ("on -> stand by: 1 - s\nstand by -> on: T", "the guard of on → stand by = “1 - s”: unknown name “s”"),
        ("on -> stand by: 1 - T => T\nstand by -> on: T", "From on to stand by: 1 expression given, 2 needed"),
        ("on -> stand by: 1\nstand by -> on: T", "the guard of on → stand by = “1” names no variable"),
    ],
)
def test_a_mistake_in_transitions_is_told_beside_them(transitions, says):
    checked = check(replace(HEATER, transitions=transitions))
    assert checked.system is None
    assert says in checked.complaints["transitions"]


@pytest.mark.parametrize("name", ["a: b", "a -> b", " a", "a\nb", ""])
def test_a_name_that_the_fields_would_take_for_something_else_is_refused(name):
    regions = {name: core.Region(("1", "0")), "off": core.Region(("-1", "0"))}
    ways = (core.Transition(name, "1 - x", "off"), core.Transition("off", "x + 1", name))
    system = core.PiecewiseSystem("odd", ("x", "y"), regions=regions, transitions=ways)
    with pytest.raises(ValueError, match="names that cannot be written here"):
        Draft.of(system)


FRICTION = Draft(
    name="Belt", variables="x, v", f="v\n-x - mu*sign(v - 1)", parameters="mu = 0.5 in [0.1, 1]", x0="2, 0"
)


def test_one_field_gives_the_surfaces_and_regions_that_it_shows():
    checked = check(FRICTION)
    assert checked.complaints == {}
    assert (checked.system.g, checked.system.f_minus, checked.system.f_plus) == (
        "v - 1",
        ("v", "mu - x"),
        ("v", "-mu - x"),
    )
    assert "Found: 1 surface, 2 regions." in checked.maths["f"]
    assert checked.maths["f"].count("<math") == 1 + 2 * 2
    assert [finding.conserved for finding in checked.conserved["psi"]] == [True, True]
    assert [words.words for words in checked.conserved["psi"]] == [
        "Found automatically where g < 0:", "Found automatically where g > 0:",
    ]  # fmt: skip
    two = check(replace(FRICTION, f="v\n-x - 2max(x - 1, 0) - 2min(x + 1, 0)", parameters=""))
    assert two.system.surfaces == ("x - 1", "x + 1")
    assert sorted(two.system.regions) == ["++", "-+", "--"]
    assert "Found: 2 surfaces, 3 regions." in two.maths["f"]


def test_one_field_comes_back_from_a_link_as_it_was_typed():
    typed = replace(FRICTION, f="v\n-x - k*max(x-1, 0) -  mu*sign(v - 1)", parameters="mu = 0.5\nk = 2")
    scene = Scene()
    scene.use(check(typed).system)
    found, complaints = read(query(scene))
    assert complaints == []
    assert Draft.of(found["own"]) == typed
    assert found["own"].surfaces == ("x - 1", "v - 1")


@pytest.mark.parametrize(
    ("changes", "field", "says"),
    [
        ({"f": "v\n-x"}, "f", "Nothing switches"),
        ({"f": "v\n-q*abs(x)"}, "f", "v′ = “-q*abs(x)”: unknown name “q”"),
        ({"f": "-abs(x)"}, "f", "1 expression given, 2 needed"),
        ({"g": "x"}, "f", "clear “Switching function g”, or this field"),
        ({"psi": "x**2"}, "psi", "ψ where g < 0 = “x**2” is not conserved by the field where g < 0"),
        ({"f": "", "psi": "x", "g": "v", "f_minus": "v, -x", "f_plus": "v, -x"}, "psi", "which is empty"),
        ({"f": "v\nabs(abs(" * 30 + "x" + "))" * 30}, "f", "nested"),
        ({"f": "v\n" + "+".join(f"abs(x - {k})" for k in range(7))}, "f", "at most 6 surfaces"),
    ],
)
def test_a_mistake_in_one_field_is_told_beside_it(changes, field, says):
    checked = check(replace(FRICTION, **changes))
    assert checked.system is None
    assert says in checked.complaints[field]


def test_a_system_is_written_out_at_its_current_values():
    system = core.CATALOGUE["elliptic_curve"].with_parameters(a_plus=-2.5)
    assert "a_plus = -2.5 in [-8, 4]" in Draft.of(system).parameters


def test_numbers_may_be_written_as_constants():
    system = check(replace(OSCILLATOR, parameters="k = 1/3; w = sqrt(2) in [0, pi]", x0="-1, 2/4")).system
    assert dict(system.values) == {"k": 1 / 3, "w": 2**0.5}
    assert system.parameters[1].bounds == (0.0, np.pi)
    assert system.x0 == (-1.0, 0.5)


@pytest.mark.parametrize(
    ("field", "text", "says"),
    [
        ("name", " ", "Give your system a name"),
        ("name", "a\u202eb", "invisible"),
        ("name", "n" * 61, "61 characters"),
        ("variables", "", "Name the variables"),
        ("variables", "x, 2y", "“2y” is not usable"),
        ("variables", "x, x", "“x” is used twice"),
        ("variables", ", ".join(f"x{k}" for k in range(13)), "at most 12"),
        ("parameters", "k", "“k” is not a parameter: write k = 3"),
        ("parameters", "k = 3 in 0.1..10", "write k = 3, or k = 3 in [0.1, 10]"),
        ("parameters", "k = 3 in [1]", "write k = 3, or k = 3 in [0.1, 10]"),
        ("parameters", "k = 30 in [0.1, 10]", "outside 0.1 … 10"),
        ("parameters", "k = 3 in [10, 0.1]", "is not below the upper bound"),
        ("parameters", "k = t", "is not a number"),
        ("parameters", "k = 3; k = 4", "“k” is used twice"),
        ("parameters", "k = 3; x = 4", "“x” is used twice"),
        ("parameters", "k = 3; sin = 1", "reserved"),
        ("f_minus", "y", "1 expression given, 2 needed: one for each of x, y"),
        ("f_minus", "y, -x, 0", "3 expressions given"),
        ("f_minus", "y, x x", "this is not an expression; a multiplication sign is missing between x and x"),
        (
            "f_minus",
            "y, -2x^2 - k cos(x)",
            "y′ = “-2x^2 - k cos(x)”: this is not an expression; a multiplication sign is",
        ),
        ("f_minus", "y, k*x^^2", "a number or a name is missing before ^."),
        ("psi_minus", "2x^2", "ψ₋ = “2x^2” is not conserved by f₋"),
        ("psi_minus", "x³", "its time derivative is 3*x^2*y, not 0"),
        ("parameters", "k = 2x", "Parameter k = “2x”: unknown name “x”"),
        ("f_plus", "y, -q*x", "unknown name “q”"),
        ("f_plus", "", "No expressions given, 2 needed"),
        ("g", "", "Type one expression"),
        ("g", "x, y", "Type one expression"),
        ("g", "k - 3", "“k - 3” names no variable and not t"),
        ("psi_minus", "x**2", "ψ₋ = “x**2” is not conserved by f₋: correct ψ₋ or f₋, or remove ψ₋"),
        ("psi_minus", "x**2", "its time derivative is 2*x*y, not 0"),
        ("psi_minus", "log(-1 - x**2)", "ψ₋ = “log(-1 - x**2)” has no real value where g < 0"),
        ("psi_plus", "x**2 + y**2, x", "There are 2 here; with 2 variables, 1 at most"),
        ("psi_plus", "7", "is constant: remove it"),
        ("x0", "1", "1 number given, 2 needed"),
        ("x0", "1, one", "unknown name “one”"),
        ("x0", "1 1", "“1 1” is not one number: separate numbers by commas, as in 1, 1"),
        ("x0", "1 -1", "separate numbers by commas, as in 1, -1"),
        ("x0", "1/2 1/3", "separate numbers by commas, as in 1/2, 1/3"),
        ("x0", "0.5", "1 number given, 2 needed: one for each of x, y; separate them by commas"),
        ("f_minus", "y, -x - abs(y)", f"abs is read in the box “{FIELDS['f']}”, where its surface is found"),
        ("g", "Max(x, y)", f"max is read in the box “{FIELDS['f']}”"),
        ("f_minus", "y, -kx", "unknown name “kx” (did you mean k*x?)"),
        ("f_minus", "y, -2xy", "unknown name “xy” (did you mean x*y?)"),
        ("parameters", "k = 3 m = 2", "is more than one parameter: separate parameters by commas or new lines"),
        ("x0", "1, 2e6", "too large"),
        ("jump", "x", "1 expression given"),
        ("jump", "x, -r*y", "y⁺ = “-r*y”: unknown name “r”"),
        ("g", "x % y", "t, pi, e, + - * / ^, and sin"),
        ("g", "x" * (MAX_CHARACTERS + 1), "1,001 characters; at most 1,000"),
    ],
)
def test_a_mistake_is_told_beside_its_field_with_what_would_do(field, text, says):
    checked = check(replace(OSCILLATOR, **{field: text}))
    assert says in checked.complaints[field]
    assert checked.system is None


def test_a_law_may_switch_at_instants():
    checked = check(replace(OSCILLATOR, g="sin(t)"))
    assert checked.complaints == {}
    assert checked.system is not None
    assert checked.system.laws.instants == {0}


@pytest.mark.parametrize(
    "laws", [{}, {"g": "k"}, {"f_minus": "", "f_plus": "", "g": "", "f": "y, -x"}], ids=["sides", "no variable", "one"]
)
def test_of_names_that_are_the_same_this_is_said(laws):
    checked = check(replace(OSCILLATOR, variables="x, x", **{"psi_minus": "", "psi_plus": ""} | laws))
    assert checked.complaints["variables"] == "The name “x” is used twice: names must differ."
    assert "x, x" not in " ".join(checked.complaints.values())


def test_of_a_constant_it_is_not_said_that_it_is_conserved():
    checked = check(replace(OSCILLATOR, psi_plus="7"))
    assert "constant" in checked.complaints["psi_plus"]
    assert [one.conserved for one in checked.conserved["psi_plus"]] == [False]


def test_all_fields_are_checked_not_only_the_first_that_is_wrong():
    wrong = Draft(name="", variables="x", f_minus="x x", f_plus="x, 1", g="3", parameters="k", x0="", jump="y")
    assert set(check(wrong).complaints) == {"name", "f_minus", "f_plus", "g", "parameters", "x0", "jump"}


def test_a_start_where_the_field_has_no_value_is_told_beside_it():
    complaints = check(replace(OSCILLATOR, f_minus="y\n-k/x", f_plus="y\n-k/x", x0="0, 1")).complaints
    assert set(complaints) == {"x0"}
    assert "no finite value" in complaints["x0"]


def test_a_number_is_typeset_with_the_digits_or_the_ratio_of_its_field_on_the_page():
    typed = Draft(
        "Own", "x, y", "y\n-k*x", "y\n-s*x", "y", parameters="k = 1/3 in [1/7, 1]\ns = sqrt(2)", x0="1/3, 0.5"
    )
    checked = check(typed)
    third, root = "<mfrac><mn>1</mn><mn>3</mn></mfrac>", f"<mn>{shortest(2**0.5)}</mn>"
    assert third in checked.maths["parameters"]
    assert root in checked.maths["parameters"]
    assert "<mfrac><mn>1</mn><mn>7</mn></mfrac>" in checked.maths["parameters"]
    assert third in checked.maths["x0"]
    assert checked.system.values["k"] == 1 / 3


def test_mathematics_appears_of_what_can_be_read_while_other_fields_are_wrong():
    checked = check(replace(OSCILLATOR, g="", f_minus="y, x x", psi_plus="x**2 + y**2"))
    assert {"g", "f_minus"} <= set(checked.complaints)
    assert checked.maths["f_minus"].count("<math") == 1
    assert checked.maths["f_plus"].count("<math") == 2
    assert "<msup><mi>x</mi><mn>2</mn></msup>" in checked.maths["psi_plus"]
    assert "<mi>k</mi>" in checked.maths["parameters"]
    assert [finding.conserved for finding in checked.conserved["psi_plus"]] == [True]


def test_what_is_left_over_of_a_quantity_is_its_time_derivative():
    checked = check(replace(OSCILLATOR, psi_minus="x**2 + y**2", psi_plus="x**2 + y**2"))
    left = checked.conserved["psi_minus"][0]
    assert not left.conserved
    x, y, k = sympy.symbols("x y k")
    said = checked.complaints["psi_minus"].split("time derivative is ")[1].removesuffix(", not 0.")
    assert sympy.expand(sympy.sympify(said) - (2 * x * y + 2 * y * (-k * x))) == 0
    assert "<mfrac>" in left.maths
    assert checked.conserved["psi_plus"][0].words == "ψ₊ is conserved: its time derivative along f₊ is 0."


def test_a_quantity_that_names_time_is_differentiated_by_it_too():
    damped = Draft("Damped", "x", "-k*x", "-k*x", "x - 1", parameters="k = 1", x0="2")
    assert "at most" in check(replace(damped, psi_minus="x*exp(k*t)")).complaints["psi_minus"]
    plane = replace(damped, variables="x, y", f_minus="-k*x, 0", f_plus="-k*x, 1", x0="2, 0", psi_minus="x*exp(k*t)")
    assert check(plane).conserved["psi_minus"][0].conserved


def test_what_is_found_without_being_given_is_said():
    checked = check(OSCILLATOR)
    assert checked.conserved["psi_minus"][0].words.startswith("Found automatically")
    assert "<mfrac>" in checked.conserved["psi_minus"][0].maths
    assert checked.system.psi_plus == ("x**2/2 + y**2/2",)


HOSTILE = {
    "deep nesting": "(" * 400 + "x" + ")" * 400,
    "deep calls": "sin(" * 38 + "x" + ")" * 38,
    "tower of numbers": "9**9**9",
    "huge power": "x**1000000",
    "tower of powers": "x**" * 18 + "x",
    "tower of exp": "exp(" * 38 + "x" + ")" * 38,
    "exp of exp": "exp(exp(exp(exp(x*1e50))))",
    "large argument": "sin(1e300*x)*x**64",
    "expands without end": "(x + y + k + t)**64",
    "expands, nested": "((x + y)**9*(x - k)**9 + 1)**9",
    "long sum": "+".join(f"x*y**{k}" for k in range(2, 60)),
    "many factors": "*".join(f"(x**{k}+t)**(y*{k}+k)" for k in range(2, 35)),
    "long Horner form": "(" * 38 + "x" + "*(x+y)+k)" * 38,
    "many functions": "*".join(f"sin(k*x*y+{k})*log(k*x+{k})*exp(y*x+{k})" for k in range(2, 15)),
    "long to integrate": "sin(k*y)**3*cos(k*y)**3",
    "longer to integrate": "sin(y)**20*cos(y)**20",
    "integral too long": "y**60*exp(y)",
    "constants": "tanh(" * 30 + "1" + ")" * 30,
    "attribute": "x.__class__.__bases__",
    "dunder": "__class__",
    "lambda": "lambda: 1",
    "import": "__import__('os').system('id')",
    "format": "{0.__class__}%s%n",
    "markup": "<script>alert(1)</script>",
    "attribute markup": '"><img src=x onerror=alert(1)>',
    "icon": ":material/home:",
    "null": "x\0y",
    "right to left": "\u202ex + y",
    "look-alikes": "х + у",
    "surrogate": "x\ud800",
    "pasted": "x+" * 50_000 + "x",
    "pasted brackets": "([" * 50_000,
    "pasted commas": "," * 100_000,
    "many entries": "x," * 500,
    "many lines": "\n" * 900 + "x",
}


def with_text(text: str) -> list[Draft]:
    """A text in fields of every kind: without divergence, so that ψ is sought; as laws; as a number; and everywhere."""
    return [
        replace(OSCILLATOR, f_minus=f"{text}\n0", f_plus=f"0\n{text}"),
        replace(OSCILLATOR, g=text, psi_minus=text, jump=f"{text}\n{text}"),
        replace(OSCILLATOR, parameters=f"k = {text}", x0=f"{text}, {text}"),
        replace(WALLS, surfaces=f"{text}\nx", regions=f"+-: {text}\n+-: v, {text}", resets=f"g1 => {text}"),
        replace(WALLS, regions=f"--: {text}, v\n+-: v, {text}", quantities=f"+-: {text}"),
        replace(HEATER, transitions=f"on -> stand by: {text}\nstand by -> on: x => {text}, {text}"),
        replace(HEATER, transitions=f"{text} -> on: T\nstand by -> {text}: T", regions=f"{text}: T, q"),
        Draft(*[text] * len(FIELDS)),
    ]


def assert_plain(draft: Draft) -> None:
    """Nothing but bounded words and well-formed mathematics comes of a draft, in bounded time."""
    with bounded_time():
        checked = check(draft)
    assert (checked.system is None) == bool(checked.complaints)
    assert all(0 < len(words) < 1500 for words in checked.complaints.values())
    findings = [finding.maths for side in checked.conserved.values() for finding in side]
    for maths in (*checked.maths.values(), *findings):
        tree = ElementTree.fromstring(f"<all>{maths}</all>")  # noqa: S314 - our own markup, and this is its test
        assert {e.tag for e in tree.iter()} <= TAGS


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_texts_are_refused_or_read_in_bounded_time(text):
    for draft in with_text(text):
        assert_plain(draft)


@settings(max_examples=40)
@given(st.sampled_from(list(FIELDS)), st.text(max_size=40) | st.text("xyk 0123.+-*/(),;=[]<&>\n", max_size=40))
def test_no_text_in_any_field_raises(name, text):
    for draft in (OSCILLATOR, WALLS, HEATER):
        assert_plain(replace(draft, **{name: text}))


def test_a_parameter_with_a_wrong_value_is_complained_of_where_it_stands_alone():
    assert list(check(replace(OSCILLATOR, parameters="k = 30 in [0.1, 10]")).complaints) == ["parameters"]


def test_a_side_without_quantity_leaves_out_no_method_that_the_other_side_admits():
    kept = replace(EXAMPLES["Duffing oscillator, stiffness switched"], psi_plus="", f_plus="v\n-a*x - v")
    checked = check(kept)
    assert can_use(checked.system, "dmm2")
    (words,) = [finding.words for finding in checked.conserved["psi_plus"]]
    assert words == "None given or found: where g > 0, conservative methods have no ψ to conserve."
    neither = check(replace(kept, psi_minus="", f_minus="v\n-a*x - v"))
    (words,) = [finding.words for finding in neither.conserved["psi_plus"]]
    for name in core.METHODS:
        assert (f" {name} " in f" {words} ".replace(",", " ")) != can_use(neither.system, name)


def test_powers_and_products_are_taken_as_people_type_them_and_shown_as_read():
    typed = replace(OSCILLATOR, f_minus="y\n-k x^2 - 2x(1 + y)", parameters="k = 2pi in [0.1, 10]", x0="1/4, 2^-1")
    checked = check(replace(typed, f_minus="y\n-k*x^2 - 2x*(1 + y)"))
    assert checked.complaints == {}
    assert checked.system.f_minus == ("y", "-k*x**2 - 2*x*(1 + y)")
    assert checked.system.x0 == (0.25, 0.5)
    assert checked.system.values["k"] == pytest.approx(2 * np.pi)
    assert "0.25" in checked.maths["x0"]
    assert check(OSCILLATOR).maths["x0"] == ""
    assert "f_minus" in check(typed).complaints, "x(1 + y) could be a function"


@pytest.mark.parametrize("text", ["unknown", "__import__('os')", '__import__("os")', "f('a') + \"b\"", "x'"])
def test_a_complaint_quotes_a_text_as_it_was_typed(text):
    words = check(replace(OSCILLATOR, g=text)).complaints["g"]
    assert words.startswith(f"g = “{text}”: ")
    assert not re.search('"“|”"|\\\\', words)
