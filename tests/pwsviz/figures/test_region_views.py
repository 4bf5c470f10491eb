"""Figures and the Scheme of systems with more regions than two sides: named, shaded and typeset as in the run."""

import re
from html import unescape

import numpy as np
import pytest
from bokeh.core.properties import value

import core
from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.marks import end_columns
from pwsviz.figures.moving import ELSEWHEN
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.scheme import scheme_markup
from pwsviz.figures.state import StateView
from pwsviz.geometry.phase_plane import backdrop
from pwsviz.geometry.plane import XY
from pwsviz.geometry.shades import shade_names, shades_of
from pwsviz.geometry.window import Window
from pwsviz.results.animation import landmarks
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.results.states import state_curves
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import OWN_SYSTEMS, RELAY, STRIPS, WEDGE

SYSTEMS = {**{name: one for name, one in core.CATALOGUE.items() if not one.two_sided}, **OWN_SYSTEMS}
WINDOW = Window(-2.0, 2.0, -2.0, 2.0)

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


def scene_of(system, **settings):
    scene = Scene(**settings)
    scene.use(system)
    scene.accept("methods", ["rk4"])
    scene.accept("t_end", 6.0)
    return scene


def middles(source):
    return 0.5 * (np.array(source.data["start"]) + np.array(source.data["end"]))


def assert_shaded_as_occupied(segments, run):
    """Each band has the shade of the mode that the run occupies in its middle, and all of them cover the run."""
    shades = shades_of(run.system, run.mode)
    for shade, source in segments.items():
        assert all(shades[np.searchsorted(run.t, t) - 1] == shade for t in middles(source))
    lengths = [np.subtract(source.data["end"], source.data["start"]).sum() for source in segments.values()]
    assert sum(lengths) == pytest.approx(run.t[-1] - run.t[0])


@every_system
def test_the_plot_of_the_state_shades_and_names_the_regions_of_the_run(system):
    run = core.integrate(system, (0.0, 6.0), tau=1e-2, method="rk4", sliding="stop")
    view, names = StateView(), shade_names(system)
    view.show([state_curves(run)], system.variables, run, XY.points(run.crossings.x))
    assert_shaded_as_occupied(view.shared.segments, run)
    labels = [entry.label for entry in view.panels[-1].entries]
    for shade, source in view.shared.segments.items():
        assert not len(source.data["start"]) or value(names[shade]) in labels


@every_system
def test_the_plot_of_the_conserved_quantity_shades_and_names_the_regions_of_the_run(system):
    results, view = Results(), ConservedView()
    inputs = run_inputs(scene_of(system))
    curves, run = results.error_curves(inputs), results.run(inputs[0])
    view.show(curves, landmarks(run, XY))
    assert_shaded_as_occupied(view.segments, run)
    for shade, name in shade_names(system).items():
        assert view.entries[shade].label == value(name if shade else f"{name}: |Δg|")


@every_system
def test_the_legend_of_the_portrait_names_what_is_tinted_and_nothing_if_nothing_is(system):
    view = PortraitView(*[lambda *_: None] * 5)
    pictures = Results().pictures(PortraitInputs.of(scene_of(system)))
    view.show_orbits(system, pictures, [pictures.orbits[0].start], 0)
    ground = backdrop(system, WINDOW, {})
    view.show_backdrop(ground)
    tint = view.ground._tint_entry
    assert tint.visible == bool(ground.minus_outer)
    named = shade_names(system).get(-1, "")
    assert tint.label == value(named if ground.minus_outer else f"{named}{ELSEWHEN}")
    for entry, part in zip(view.ground._line_entries[2:], (ground.arrows, ground.levels), strict=False):
        assert entry.visible == any(np.isfinite(lines).any() for lines in part.values())


@every_system
def test_the_legend_of_the_portrait_tells_where_no_state_can_be(system):
    view = PortraitView(*[lambda *_: None] * 5)
    ground = backdrop(system, WINDOW, {})
    view.show_backdrop(ground)
    assert view.ground._bare_entry.label == value(ground.formulas["bare"])
    assert view.ground._bare_entry.visible == bool(ground.bare_outer)
    assert len(view.ground.bare.data["xs"]) == len(ground.bare_outer)


def test_a_key_stands_for_what_is_seen_alone():
    """The backdrop of a view is larger than the view."""
    view, entry = PortraitView(*[lambda *_: None] * 5), lambda: view.ground._bare_entry.visible
    walls = core.CATALOGUE["two_walls"]
    seen = {(-3.0, 3.0): True, (-0.9, 0.9): False, (1.5, 2.5): True, (-0.5, 1.2): True}
    for ends, hatched in seen.items():
        view.look_at(Window(*ends, *ends))
        view.show_backdrop(backdrop(walls, Window(-4.0, 4.0, -4.0, 4.0), {}))
        assert entry() == hatched


def headings(text):
    return [unescape(found) for found in re.findall("<h3>(.*?)</h3>", text)]


@every_system
def test_the_scheme_has_the_law_of_every_region_under_its_name(system):
    text = scheme_markup(system, "dmm2" if system.laws.most_conserved else "rk2")
    for law in system.laws.regions:
        name = law.name.replace("-", "−") if system.surfaces else law.name
        assert f"Region {name}" in headings(text)
    said = re.findall(r'alttext="([^"]*)"', text)
    for k in range(len(system.laws.surfaces)):
        assert any(line.startswith(f"g_{k + 1} = ") for line in said)
    assert r"\text" not in text, "indices are typeset, not quoted"
    assert text.count("the state is reset") >= system.laws.jumps


def test_regions_that_have_names_have_them_as_indices_and_follow_one_another():
    text = unescape(scheme_markup(core.CATALOGUE["thermostat"], "rk2"))
    assert "<msub><mi>f</mi><mi>on</mi></msub>" in text
    assert "“on” is followed by “off” where g₁ falls to 0." in text
    assert "f_{on} = " in text
    assert headings(scheme_markup(RELAY, "rk2"))[:2] == ["Region pre-heat", "Region off"]


HOSTILE = ["<img src=x onerror=alert(1)>", "}{\\x_^", "", " ", "\0", "\u202e", '"', "</math>", r"\text{", "'", "&lt;"]


@pytest.mark.parametrize("name", HOSTILE)
def test_the_name_of_a_region_is_never_markup(name):
    regions = {name: core.Region(("1", "0"), ("y",)), "off": core.Region(("-1", "0"), ("y",))}
    ways = (core.Transition(name, "1 - x", "off"), core.Transition("off", "x + 1", name))
    system = core.PiecewiseSystem(name="n", variables=("x", "y"), regions=regions, transitions=ways)
    run = core.integrate(system, (0.0, 6.0), tau=0.1, method="rk2")
    for text in (scheme_markup(system, "rk2"), scheme_markup(system, "dmm2", None, run)):
        assert "<img" not in text
        assert text.count("<math") == text.count("</math>")
        assert "f_{1} = " in text or name in (" ", "")


def test_a_sliding_mode_that_was_entered_is_shown_under_its_surface():
    regions = {k: core.Region(("1", "-1" if k[1] == "+" else "1")) for k in ("--", "-+", "+-", "++")}
    system = core.PiecewiseSystem(
        name="slide", variables=("x", "y"), surfaces=("x", "y"), regions=regions, x0=(-1.0, 0.5)
    )
    run = core.integrate(system, (0.0, 3.0), tau=0.1, method="rk2", sliding="continue")
    assert "-0" in {system.laws.name(k) for k in run.mode}
    text = scheme_markup(system, "rk2", None, run)
    assert headings(text).count("Sliding along g2 = 0 (−0)") == 1
    assert any(line.startswith("f_-0 = ") for line in re.findall(r'alttext="([^"]*)"', text))
    assert not any("Sliding" in words for words in headings(scheme_markup(system, "rk2")))


def test_the_constants_of_the_theory_are_shown_of_several_surfaces():
    inputs = run_inputs(scene_of(STRIPS))[0]
    results = Results()
    run, diagnosis = results.run(inputs), results.diagnosis(inputs)
    assert len(run.crossings)
    assert diagnosis.alpha_S2 == core.diagnose(run).alpha_S2
    assert f"The worst values over {len(run.crossings)} crossing" in scheme_markup(STRIPS, "rk4", diagnosis, run)


def test_where_a_run_enters_a_region_without_law_its_end_is_marked():
    scene = scene_of(WEDGE)
    scene.accept("x0", (-1.0, -0.5))
    end = end_columns(Results().pictures(PortraitInputs.of(scene)).numbered)
    assert end["label"] == ["end: no law"]
    assert (end["x"][0], end["y"][0]) == (pytest.approx(-2 / 3), pytest.approx(-2 / 3))


def test_the_key_of_a_tint_that_is_not_there_now_says_that_it_is_at_other_times():
    """Of laws that change at an instant the whole plane is on one side."""
    for g, told in (("t - 3", "g < 0"), ("3 - t", f"g < 0{ELSEWHEN}")):
        system = core.PiecewiseSystem("Switched", ("x", "v"), ("v", "-x"), ("v", "1 - x"), g, x0=(1.0, 0.0))
        view = PortraitView(*[lambda *_: None] * 5)
        pictures = Results().pictures(PortraitInputs.of(scene_of(system)))
        view.show_orbits(system, pictures, [pictures.orbits[0].start], 0)
        view.show_backdrop(backdrop(system, WINDOW, {}))
        assert view.ground._tint_entry.visible
        assert view.ground._tint_entry.label == value(told)
