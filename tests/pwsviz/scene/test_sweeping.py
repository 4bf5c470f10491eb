"""The settings of a bifurcation diagram: what a system suggests, and what is refused."""

import pytest

import core
from pwsviz.scene.permalink import query, read
from pwsviz.scene.scene import Scene
from pwsviz.scene.sweeping import MOST_POINTS, swept_coordinate, swept_direction, swept_parameter, swept_range
from tests.pwsviz.own_systems import OWN_SYSTEMS


@pytest.mark.parametrize("key", core.CATALOGUE)
def test_a_system_suggests_a_parameter_with_its_bounds(key):
    scene = Scene(system=key)
    parameter = swept_parameter(scene)
    assert parameter.bounds is not None
    assert swept_range(scene) == parameter.bounds


@pytest.mark.parametrize(
    ("key", "name", "why"),
    [("elliptic_curve", "radius", "of the surface"), ("two_walls", "restitution", "of the reset map"),
     ("chua", "alpha", "of the field"), ("harmonic_oscillator", "omega2_plus", "of the field where it starts"),
     ("diode_circuit", "c_plus", "of the field where it starts")],
)  # fmt: skip
def test_the_parameter_is_one_that_moves_the_points(key, name, why):
    assert swept_parameter(Scene(system=key)).name == name, why


@pytest.mark.parametrize(
    ("key", "coordinate"),
    [("harmonic_oscillator", "x"), ("elliptic_curve", "x"), ("two_walls", "v"), ("chua", "y"), ("thermostat", "r"),
     ("moving_interface", "x"), ("stick_slip", "y"), ("gene_ring", "x")],
)  # fmt: skip
def test_the_coordinate_is_the_first_that_varies_on_the_surface(key, coordinate):
    assert swept_coordinate(Scene(system=key)) == coordinate


def test_the_coordinate_follows_a_surface_that_is_typed():
    scene = Scene(system="chua")
    scene.accept("sweep_of", "y")
    assert swept_coordinate(scene) == "x"
    scene.accept("sweep_of", "x - sin(t)")
    assert swept_coordinate(scene) == "x", "the surface moves"


def test_parameters_without_bounds_get_values_around_their_own_and_none_are_none():
    laws = {"variables": ("x", "y"), "f_minus": ("y", "-k*x"), "f_plus": ("y", "-x - m"), "g": "y", "x0": (1.0, 1.0)}
    scene = Scene()
    scene.use(core.PiecewiseSystem("free", parameters={"k": 3.0, "m": 0.0}, **laws))
    assert swept_range(scene) == (-1.0, 1.0)
    scene.accept("sweep_parameter", "k")
    assert swept_range(scene) == (1.5, 4.5)
    scene.use(core.PiecewiseSystem("none", **{**laws, "f_minus": ("y", "-x"), "f_plus": ("y", "-2*x")}))
    assert swept_parameter(scene) is None
    with pytest.raises(ValueError, match="no parameter"):
        scene.accept("sweep_range", (0.0, 1.0))


def test_another_parameter_or_system_brings_its_own_range():
    scene = Scene()
    scene.accept("sweep_range", (0.5, 1.0))
    scene.accept("sweep_parameter", "a_minus")
    assert swept_range(scene) == (-8.0, 4.0)
    scene.accept("sweep_of", "x - 1")
    scene.accept("system", "chua")
    assert (scene.sweep_parameter, scene.sweep_range, scene.sweep_coordinate, scene.sweep_of) == ("", None, "", "")
    assert swept_range(scene) == (8.0, 9.2)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("sweep_parameter", "k", "not one of a_minus, a_plus, radius"),
        ("sweep_coordinate", "z", "not one of x, y"),
        ("sweep_range", (1.0, 1.0), "greater than the first"),
        ("sweep_range", (0.0,), "two numbers"),
        ("sweep_range", 3.0, "two numbers"),
        ("sweep_range.1", "-9", "between 0.1 and 4"),
        ("sweep_range.0", "abc", "not a number"),
        ("sweep_values", "1", "between 2 and 4,000"),
        ("sweep_values", "10.5", "whole number"),
        ("sweep_points", "5001", "between 1 and 5,000"),
        ("sweep_discard", "-1", "between 0"),
        ("sweep_end", "1e6", "between"),
        ("sweep_of", "x +", "x +"),
        ("sweep_of", "3", "constant|depends neither"),
        ("sweep_direction", 2, "not one of"),
        ("sweep_continuation", "sideways", "not one of"),
    ],
)
def test_what_makes_no_sense_is_refused_and_changes_nothing(field, value, words):
    scene = Scene()
    before = scene.settings()
    with pytest.raises(ValueError, match=words):
        scene.accept(field, value)
    assert scene.settings() == before


def test_a_diagram_has_a_bounded_number_of_points():
    scene = Scene()
    scene.accept("sweep_points", 5000)
    with pytest.raises(ValueError, match=f"{MOST_POINTS:,}"):
        scene.accept("sweep_values", 401)
    scene.accept("sweep_values", 400)


CHOSEN = {
    "sweep_parameter": "a_plus", "sweep_range": (-3.0, 1 / 3), "sweep_coordinate": "y", "sweep_of": "x - y**2",
    "sweep_direction": -1, "sweep_continuation": "down", "sweep_values": 77, "sweep_points": 7, "sweep_discard": 0,
    "sweep_end": 12.5,
}  # fmt: skip


def test_a_link_brings_the_diagram_back():
    scene = Scene(view="sweep")
    for name, value in CHOSEN.items():
        scene.accept(name, value)
    settings, complaints = read(query(scene))
    assert complaints == []
    assert {name: settings[name] for name in CHOSEN} == CHOSEN


@pytest.mark.parametrize("text", ["auto", "100", "0"])
def test_a_link_says_how_many_points_are_discarded_or_that_it_is_automatic(text):
    settings, complaints = read(f"v=2&view=sweep&sweep_discard={text}")
    assert (settings.get("sweep_discard"), complaints) == (None if text == "auto" else int(text), [])


def test_each_value_of_a_link_is_judged_by_itself():
    settings, complaints = read(
        "v=2&sweep_parameter=nowhere&sweep_range=1,0&sweep_values=1e9&sweep_points=33&sweep_of=__x__"
    )
    assert len(complaints) == 4
    assert complaints[0].endswith("Used instead: the system’s own.")
    assert settings["sweep_points"] == 33
    assert (settings["sweep_range"], settings["sweep_values"], settings["sweep_of"]) == (None, 400, "")


@pytest.mark.parametrize("system", OWN_SYSTEMS.values(), ids=list(OWN_SYSTEMS))
def test_every_system_suggests_something(system):
    scene = Scene()
    scene.use(system)
    assert swept_coordinate(scene) in system.variables
    low, high = swept_range(scene)
    assert low < high


def test_the_direction_is_automatic_unless_it_is_chosen_and_links_tell_both():
    scene = Scene(system="chua", view="sweep")
    assert (scene.sweep_direction, swept_direction(scene)) == ("auto", 1)
    assert "sweep_direction" not in query(scene)
    for chosen in (0, -1):
        scene.accept("sweep_direction", chosen)
        assert swept_direction(scene) == read(query(scene))[0]["sweep_direction"] == chosen
    assert read("v=2&sweep_direction=auto")[0]["sweep_direction"] == "auto"
    assert swept_direction(Scene(system="bouncing_ball")) == 0
