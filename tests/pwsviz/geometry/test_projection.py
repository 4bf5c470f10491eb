"""What is drawn is true in the plane shown; what is left out is named."""

from itertools import permutations

import numpy as np
import pytest

import core
from core.diagnostics import inhabited
from pwsviz.figures.portrait_text import law_markup, portrait_note, scale_note
from pwsviz.geometry.line_pieces import area
from pwsviz.geometry.phase_plane import backdrop, closed_surface
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.projection import (
    axis_labels,
    conserved_note,
    planes,
    planes_alike,
    shows_field,
    shows_levels,
    shows_regions,
    shows_surface,
    surface_name,
    surfaces_shown,
)
from pwsviz.geometry.shades import regions_of
from pwsviz.geometry.window import Window
from pwsviz.scene.names import readable
from pwsviz.text.math_names import variable_name
from tests.pwsviz.own_systems import GATE, OWN_SYSTEMS, RELAY, STRIPS, WEDGE

WINDOW = Window(-2.0, 2.0, -2.0, 2.0)
XY = (0, 1)
SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


@every_system
def test_the_surface_drawn_is_where_g_vanishes_whatever_is_not_shown(system):
    ground, shown = backdrop(system, WINDOW, {}), surfaces_shown(system, XY)
    points = ground.surface[np.isfinite(ground.surface).all(axis=1)]
    assert (len(points) > 1) == shows_surface(system, XY) == bool(shown)
    hidden = np.random.default_rng(1).uniform(-1, 1, (len(points), system.dimension - 2))
    states, laws = np.column_stack([points, hidden]), system.laws
    g = laws.evaluate("all surfaces", laws.surfaces, 0.0, states, system.parameter_array)[:, shown]
    assert np.abs(g).min(axis=1, initial=np.inf).max(initial=0.0) < 1e-2, "each point lies on one of them"
    assert (np.abs(g).min(axis=0, initial=np.inf) < 1e-2).all(), "each of them is drawn"


def test_variables_have_greek_letters_wherever_formulas_have_them():
    table = core.CATALOGUE["vibrating_table"]
    assert axis_labels(table, Plane((0, 1))) == ("φ (v not shown)", "y")
    assert "plane of φ, y" in portrait_note(table, (0, 1))
    assert readable("y - a*sin(phi)", table) == "y − a·sin(φ)"
    assert [variable_name(name) for name in ("theta", "omega", "x1", "u")] == ["θ", "ω", "x₁", "u"]


@every_system
def test_sides_are_tinted_where_the_plane_tells_them_and_a_state_can_be(system):
    tinted = inhabited(system) & {*regions_of(system, -1)}
    assert bool(backdrop(system, WINDOW, {}).minus_outer) == (shows_regions(system, XY) and bool(tinted))
    if system.two_sided:
        assert shows_regions(system, XY) == shows_surface(system, XY)


@every_system
def test_level_sets_and_arrows_are_drawn_in_the_plane_only(system):
    ground = backdrop(system, WINDOW, {})
    for shade in (-1, 1):
        laws = [system.laws.regions[k] for k in regions_of(system, shade) if k in inhabited(system)]
        known = any(law.conserved for law in laws)
        assert np.isfinite(ground.levels[shade]).any() == (shows_levels(system) and known)
        assert np.isfinite(ground.arrows[shade]).any() == (shows_field(system) and bool(laws))


@every_system
def test_the_field_of_a_plane_is_drawn_if_its_points_tell_the_region_at_every_time(system):
    told = system.two_sided or (bool(system.surfaces) and system is not GATE)
    assert shows_field(system) == (system.dimension == 2 and told)


def test_a_surface_that_is_no_curve_in_the_plane_is_left_out_and_named():
    gene = core.CATALOGUE["gene_switch"]
    assert not shows_surface(gene, XY)
    assert len(closed_surface(gene, WINDOW)) == 0
    assert "z − θ" in portrait_note(gene, XY)
    assert axis_labels(gene, Plane(XY)) == ("x (z not shown)", "y")


def test_of_several_surfaces_those_that_are_no_curves_in_the_plane_are_named():
    ring, chua, bridge = (core.CATALOGUE[name] for name in ("gene_ring", "chua", "diode_bridge"))
    assert surfaces_shown(ring, XY) == [0, 1]
    assert "the field and the surface z − θ = 0 are not drawn" in portrait_note(ring, XY)
    assert "surface" not in portrait_note(chua, XY)
    assert "the field and the surfaces x + 1 = 0, x − 1 = 0 are not drawn" in portrait_note(chua, (1, 2))
    assert "the surfaces v − u = 0, v + u = 0 are not drawn" in portrait_note(bridge, (0, 2))
    assert "surface" not in portrait_note(bridge, XY)
    assert [shows_regions(ring, XY), shows_regions(chua, XY), shows_regions(bridge, XY)] == [False, True, True]


def test_a_system_of_several_surfaces_opens_in_the_plane_of_as_many_of_them_as_its_declaration_can_order_first():
    for name, system in core.CATALOGUE.items():
        if system.surfaces and not system.two_sided:
            planes = [surfaces_shown(system, axes) for axes in permutations(range(system.dimension), 2)]
            assert len(surfaces_shown(system, XY)) == max(map(len, planes)), name


def test_what_is_not_drawn_of_regions_without_a_place_of_their_own_is_named():
    assert "The regions overlap" in portrait_note(RELAY, XY)
    assert "The regions overlap" in portrait_note(core.CATALOGUE["thermostat"], XY)
    assert "fields and level sets are not drawn" in portrait_note(GATE, XY)
    assert portrait_note(STRIPS, XY) == portrait_note(WEDGE, XY) == ""


def test_a_surface_of_the_shown_variables_is_drawn_in_any_dimension():
    assert len(closed_surface(core.CATALOGUE["kepler"], WINDOW)) > 10
    assert axis_labels(core.CATALOGUE["kepler"], Plane(XY)) == ("x (u, v not shown)", "y")


def test_any_two_variables_span_a_portrait():
    kepler = core.CATALOGUE["kepler"]
    assert planes(kepler) == [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)]
    assert not shows_surface(kepler, (2, 3))
    assert shows_surface(kepler, (1, 0))
    assert axis_labels(kepler, Plane((3, 1))) == ("v (x, u not shown)", "y")
    assert axis_labels(core.CATALOGUE["three_bodies"], Plane((0, 2))) == ("x₁ (10 other variables not shown)", "x₂")
    x = np.arange(8.0).reshape(2, 4)
    assert np.array_equal(Plane((1, 3)).points(x), x[:, [1, 3]])
    assert np.array_equal(Plane((3, 1)).points(x), x[:, [3, 1]])


def test_variables_that_differ_by_one_number_are_drawn_in_one_picture():
    bodies = core.CATALOGUE["three_bodies"]
    assert planes_alike(bodies, (0, 1)) == [(2, 3), (4, 5)]
    assert planes_alike(bodies, (3, 2)) == [(1, 0), (5, 4)]
    place, speed = bodies.variables.index("x1"), bodies.variables.index("u1")
    assert [bodies.variables[k] for plane in planes_alike(bodies, (place, speed)) for k in plane] == [
        "x2", "u2", "x3", "u3",
    ]  # fmt: skip
    assert planes_alike(bodies, (0, 2)) == [], "x1 and x2 span a plane of their own"
    assert axis_labels(bodies, Plane((0, 1))) == ("x₁, x₂, x₃ (6 other variables not shown)", "y₁, y₂, y₃")
    assert (
        "Successively thinner lines show (x₂, y₂) and (x₃, y₃); discs mark where they start; "
        "marks of jumps refer to x₁, y₁." in portrait_note(bodies, (0, 1))
    )
    walled = core.PiecewiseSystem(
        name="Two beads, a wall for one", variables=("x1", "v1", "x2", "v2"), g="x1",
        f_minus=("v1", "-x1", "v2", "-x2"), f_plus=("v1", "-4*x1", "v2", "-x2"), x0=(1.0, 0.0, 0.5, 0.0),
    )  # fmt: skip
    assert planes_alike(walled, (0, 1)) == [], "the second bead would be seen to cross the surface of the first"
    assert planes_alike(walled, (2, 3)) == [(0, 1)]
    others = [system for name, system in core.CATALOGUE.items() if name != "three_bodies"]
    assert not any(planes_alike(system, axes) for system in others for axes in planes(system))


def test_a_swapped_plane_is_the_mirror_image():
    system = core.CATALOGUE["elliptic_curve"]
    plain, swapped = backdrop(system, WINDOW, {}), backdrop(system, WINDOW, {}, Plane((1, 0)))
    for side in (-1, 1):
        there = plain.arrows[side][np.isfinite(plain.arrows[side]).all(axis=1)]
        mirrored = swapped.arrows[side][np.isfinite(swapped.arrows[side]).all(axis=1)][:, ::-1]
        assert len(there) == len(mirrored) > 0
    assert np.abs(np.linalg.norm(swapped.surface[:-1], axis=1) - 1).max() < 1e-2


def test_what_changes_with_time_is_named():
    moving, damped = core.CATALOGUE["moving_interface"], core.CATALOGUE["damped_oscillator"]
    assert "t = 0" in surface_name(moving)
    assert "moves with time" in portrait_note(moving, XY)
    assert shows_levels(moving)
    assert not shows_levels(damped)
    assert "level sets move" in portrait_note(damped, XY)


@pytest.mark.parametrize(("g", "side"), [("sin(t)", 1), ("-sin(t)", -1), ("t - 3", -1), ("3 - t", 1)])
def test_where_the_law_changes_at_instants_the_whole_plane_is_on_the_side_just_after_the_beginning(g, side):
    wave = core.PiecewiseSystem("wave", ("x", "y", "z"), ("y", "-x", "0"), ("y", "-2*x", "0"), g)
    for system, note in ((wave, "t = 0"), (core.PiecewiseSystem("w", ("x", "y"), ("y", "-x"), ("y", "-2*x"), g), "")):
        ground = backdrop(system, WINDOW, {})
        assert not shows_surface(system, XY)
        assert shows_regions(system, XY)
        assert not np.isfinite(ground.surface).any()
        assert sum(map(area, ground.minus_outer)) == pytest.approx(16.0 if side < 0 else 0.0)
        assert surface_name(system) == "S: g = 0"
        assert "the law changes in the whole plane at once" in portrait_note(system, XY)
        assert note in portrait_note(system, XY)
    assert np.isfinite(ground.arrows[side]).any()
    assert not np.isfinite(ground.arrows[-side]).any()


def test_a_planar_system_at_rest_needs_no_words():
    for name in ("elliptic_curve", "type_repelling", "bouncing_ball"):
        assert portrait_note(core.CATALOGUE[name], XY) == conserved_note(core.CATALOGUE[name]) == ""


def test_the_conserved_view_says_what_is_not_known():
    assert "no conserved quantity" in conserved_note(core.CATALOGUE["relay_feedback"])
    assert "two conserved quantities" in conserved_note(core.CATALOGUE["rigid_body"])
    half = core.PiecewiseSystem("half", ("x", "y"), ("y", "-x"), ("y", "-x - y"), "x", psi_minus=("x**2 + y**2",))
    assert "where g > 0" in conserved_note(half)


def test_the_conserved_view_names_the_regions_of_which_nothing_is_known():
    assert "no conserved quantity is known in any region" in conserved_note(core.CATALOGUE["chua"])
    assert "no conserved quantity is known in any region" in conserved_note(core.CATALOGUE["thermostat"])
    assert conserved_note(core.CATALOGUE["diode_bridge"]) == conserved_note(STRIPS) == ""
    law = core.Region(("y", "-x"), ("x**2 + y**2",))
    for keys, named in (((), "regions −+, ++:"), (("++",), "region −+:")):
        regions = {"-+": core.Region(("y", "-x - y")), "++": core.Region(("y", "-x - y")), "--": law}
        system = core.PiecewiseSystem(
            name="part", variables=("x", "y"), surfaces=("x - y", "x + y"), regions=regions | dict.fromkeys(keys, law)
        )
        assert named in conserved_note(system)
    assert "region off:" in conserved_note(RELAY)


def test_the_equations_stand_below_the_portrait_unless_they_are_long():
    told = law_markup(core.CATALOGUE["elliptic_curve"])
    assert told.count('<p class="law">') == 3, "a line for each law"
    assert "ψ₋\xa0=\xa0y²\xa0−\xa0x³\xa0−\xa0a₋x</p>" in told, "as a product is written"
    assert told.endswith(">g\xa0=\xa0x²\xa0+\xa0y²\xa0−\xa0r²</p>"), "no equation breaks across lines"
    assert "−k₋\u202fsin(q)" in law_markup(core.CATALOGUE["pendulum"])
    assert "−m₋y₁y₂" in law_markup(core.CATALOGUE["rigid_body"])
    rooted = core.PiecewiseSystem("root", ("x",), f_minus=("x**(3/2)",), f_plus=("1",), g="x - 2")
    assert "x<sup>3/2</sup>" in law_markup(rooted)
    assert "reset\xa0map\xa0at\xa0g\xa0=\xa00" in law_markup(core.CATALOGUE["bouncing_ball"])
    assert "The equations are in the tab Scheme." in law_markup(core.CATALOGUE["three_bodies"])


@pytest.mark.parametrize(
    ("plus", "jump", "words"),
    [("-x", None, "the law changes in"), ("-x", ("x", "v + 0.5*x"), "every state jumps in"),
     ("-2*x", ("x", "v + 0.5*x"), "the law changes and every state jumps in")],
)  # fmt: skip
def test_of_instants_it_is_said_what_happens_at_them(plus, jump, words):
    system = core.PiecewiseSystem("Kicked", ("x", "v"), ("v", "-x"), ("v", plus), "sin(t)", jump=jump, x0=(1.0, 0.0))
    assert f"At the instants at which sin(t) = 0 {words} the whole plane at once" in portrait_note(system, XY)


def test_a_variable_that_is_drawn_in_a_unit_of_its_own_is_explained_in_words():
    table = core.CATALOGUE["vibrating_table"]
    why = "far {} than y and both axes have one scale."
    assert (
        scale_note(table, Plane((1, 2), (1.0, 10.0))) == f"v is drawn divided by 10, as it varies {why.format('more')}"
    )
    less = scale_note(table, Plane((2, 1), (0.01, 1.0)))
    assert less == f"v is drawn multiplied by 100, as it varies {why.format('less')}"
    assert scale_note(table, Plane((1, 2))) == ""
