"""The equations in LaTeX: every law, balanced, on lines of a page."""

import re

import pytest

import core
from pwsviz.export.latex import equations_latex, latex_file
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import OWN_SYSTEMS

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}
every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


def written(system):
    return equations_latex(system, {p.name: p.default for p in system.parameters})


@every_system
def test_braces_environments_and_brackets_are_balanced(system):
    text = written(system)
    depth = 0
    for sign in re.findall(r"(?<!\\)[{}]", text):
        depth += 1 if sign == "{" else -1
        assert depth >= 0
    assert depth == 0
    for line in re.split(r"\\\\(?:\[1ex\])?\n", text):  # \left and \right have to be in one cell
        assert line.count(r"\left") - line.count(r"\leftarrow") == line.count(r"\right")
        assert line.count("&") == 1
    assert "^2^" not in text.replace("{", "").replace("}^", "}"), "no double superscript"
    assert text.isascii(), "for any LaTeX"


@every_system
def test_every_rate_every_psi_and_every_parameter_is_written(system):
    text, laws = written(system), system.laws.regions
    told = laws[:1] if system.two_sided and len(set(system.regions.values())) == 1 else laws
    assert text.count("' &= ") == len(system.variables) * len(told)
    assert len(re.findall(r"\\psi(?:_\{[^}]*\})? &=", text)) == sum(len(mode.conserved) for mode in told)
    assert text.partition("parameters:")[2].count("&=") == len(system.parameters)


def test_no_sum_begins_with_a_minus_sign_if_one_of_its_terms_is_positive():
    text = written(core.CATALOGUE["elliptic_curve"])
    for line in (r"g &= x^{2} + y^{2} - r^{2}", r"\psi_{-} &= y^{2} - x^{3} - a_{-} x"):
        assert line in text


def test_long_sums_are_broken_between_terms():
    lines = written(core.CATALOGUE["three_bodies"]).splitlines()
    assert sum(line.startswith(r"&\quad {}+") for line in lines) >= 6


def test_a_file_has_its_origin_as_comments_and_no_line_of_it_can_become_mathematics():
    text = latex_file(Scene(), {"link": "http://x/?a=1%20\nb", "system": "n"}).decode()
    assert text.startswith("% Needs \\usepackage{amsmath}.\n% link: http://x/?a=1%20 b\n% system: n\n\\begin{align*}\n")


def test_names_that_a_user_chose_are_escaped():
    regions = {"on_1": core.Region(("1",)), "50%": core.Region(("-1",))}
    ways = (core.Transition("on_1", "1 - x", "50%"), core.Transition("50%", "x + 1", "on_1"))
    system = core.PiecewiseSystem(name="n", variables=("x",), regions=regions, transitions=ways, x0=(0.0,))
    assert r"\text{region on\_1:}" in equations_latex(system, {})
    assert r"\text{on\_1 to 50\%:}" in equations_latex(system, {})
