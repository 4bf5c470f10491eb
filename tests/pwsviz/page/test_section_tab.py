"""The Section view: what a click there starts, what its choices do, and what it says."""

import math

import numpy as np
import pytest

from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from tests.pwsviz.figures.test_point_cloud import looked_at


def opened(key=None, **settings):
    """Return a page with the Section view open, and the view."""
    scene = Scene()
    scene.load({**PRESETS[key].settings, **settings} if key else settings)
    page = Explorer(scene, Results())
    page._refresh_view()
    assert page.settle(60)
    return page, page.view


@pytest.fixture
def islands():
    page, tab = opened("henon_heiles_section", section_points=200)
    yield page, tab
    page.close()


def clicked(page, tab, x, y):
    tab._place(x, y)
    assert page.settle(60)


def test_a_click_starts_an_orbit_of_the_same_energy_that_has_points_there(islands):
    page, tab = islands
    looked_at(tab.view.cloud, -0.5, 0.7, -0.5, 0.5)
    before = tab.view.cloud.count
    clicked(page, tab, 0.31204, 0.0501)
    x, y, u, v = page.scene.starts[-1]
    assert (x, y, v) == pytest.approx((0.0, 0.312, 0.050), abs=1e-3)
    assert (u**2 + v**2 + y**2) / 2 - y**3 / 3 == pytest.approx(1 / 8, abs=1e-12)
    assert "x and u from g = 0 and ψ = 0.125" in tab.note.object
    assert tab.view.cloud.count == before * 8 // 7
    assert tab.outcome.counts == (200,) * 8


def test_a_click_where_the_energy_does_not_reach_says_so_and_changes_nothing(islands):
    page, tab = islands
    clicked(page, tab, 0.9, 0.9)
    assert len(page.scene.starts) == 7
    assert "No state here has g = 0 and ψ = 0.125" in tab.note.object


def test_a_double_click_takes_back_what_its_first_click_has_placed(islands):
    page, tab = islands
    clicked(page, tab, 0.3, 0.0)
    assert len(page.scene.starts) == 8
    tab._fit()
    assert len(page.scene.starts) == 7


def test_other_coordinates_and_the_return_map_compute_nothing(islands):
    page, tab = islands
    tab._across.value = 2
    assert page.scene.section_axes == (2, 3)
    tab._up.value = 2  # exchanges them
    assert page.scene.section_axes == (3, 2)
    page.scene.accept("section_map", True)
    assert page.settle(60)
    assert page.results.computed["section"] == 1
    assert tab.view.figure.yaxis.axis_label == "v at the next point"
    assert not tab._up_place.visible
    clicked(page, tab, 0.1, 0.1)
    assert len(page.scene.starts) == 7
    page.history.undo()
    assert page.scene.section_map is False


def test_a_typed_function_is_read_as_people_type_and_a_wrong_one_named(islands):
    page, tab = islands
    tab._of.value = "…"
    assert tab._other.visible
    tab._other.value = "y - 2x² - 1/10"
    assert page.scene.section_of == "y - 2*x**2 - 1/10"
    assert page.settle(100)
    x, y = tab.outcome.of_start(0).x[:, :2].T
    assert np.abs(y - 2 * x**2 - 0.1).max() < 1e-12
    assert "y − 2x² − 1/10 = 0" in tab.words.object
    tab._other.value = "y - q"
    assert "unknown name 'q'" in tab._other.helper_text
    assert page.scene.section_of == "y - 2*x**2 - 1/10"


def test_another_system_starts_with_its_own_surface(islands):
    page, tab = islands
    page.scene.accept("section_of", "y")
    page.scene.accept("section_axes", (0, 3))
    page.scene.accept("system", "chua")
    assert (page.scene.section_of, page.scene.section_axes) == ("", None)
    assert list(tab._of.options) == ["all surfaces", "x + 1 = 0", "x − 1 = 0", "another …"]
    assert page.settle(100)
    assert tab.plane == (1, 2)
    page.scene.accept("section_of", "x - 1")
    assert page.settle(100)
    assert np.abs(tab.outcome.of_start(0).x[:, 0] - 1).max() < 1e-12


def test_a_click_on_a_section_over_time_starts_at_0_where_the_laws_do_not_change_with_time():
    page, tab = opened(system="stick_slip", methods=["rk4"], view="section", section_axes=(2, 0), section_points=20)
    assert list(tab.view.cloud.marks[0].data_source.data["x"]) == tab.outcome.of_start(0).t.tolist()
    assert "A click starts a trajectory there, at t = 0." in tab.note.object
    clicked(page, tab, 9.0, 0.5)
    assert page.scene.starts[-1] == pytest.approx((0.5, page.scene.build().values["belt"]), abs=1e-2)
    assert "from g = 0" in tab.note.object
    page.close()


def test_a_section_over_time_says_why_it_takes_no_click_where_laws_or_surface_change_with_time():
    for settings in ({"system": "moving_interface"}, {"system": "harmonic_oscillator", "section_of": "sin(t)"}):
        page, tab = opened(**settings, methods=["rk4"], view="section", section_axes=(0, 2), section_points=20)
        assert "All runs start at t = 0" in tab.note.object
        clicked(page, tab, 1.0, 1.0)
        assert (len(page.scene.starts), "All runs start at t = 0" in tab.note.object) == (1, True)
        page.close()


def test_a_click_on_a_strobe_says_whether_its_start_is_a_point_of_it():
    for of, elsewhere in (("sin(t)", False), ("cos(t)", True)):
        page, tab = opened(system="moving_interface", methods=["rk4"], view="section", section_of=of, section_points=20)
        clicked(page, tab, 1.0, 0.5)
        assert len(page.scene.starts) == 2
        assert ("h ≠ 0 at t = 0: its points lie elsewhere" in tab.note.object) == elsewhere
        page.close()


def test_a_click_in_the_plane_starts_on_the_surface_nearby_and_it_is_said_that_it_does():
    page, tab = opened(view="section", section_points=20)
    assert "A click starts a trajectory nearby, on the surface." in tab.note.object
    clicked(page, tab, -1.2, 0.1)
    assert page.scene.starts[-1] == pytest.approx((-0.9965, 0.083), abs=1e-3)
    assert math.hypot(*page.scene.starts[-1]) == pytest.approx(1.0, abs=1e-9)
    page.close()


def test_files_and_captions_tell_the_surface(islands):
    _, tab = islands
    assert list(tab.table())[:3] == ["start", "point", "t"]
    how = tab.how(tab.outcome)
    assert "(200 of each) on S: g = 0, met from one side only, just after the reset map; " in how
    assert tab.pictures() == [tab.view.figure]
    assert "A number marks the first point of each start." in tab.note.object


def test_directions_are_offered_where_the_surface_may_be_met_in_both():
    page, tab = opened(system="bouncing_ball", methods=["rk4"], view="section", section_points=20)
    ways = tab._more.objects[0]
    assert not ways.visible
    page.scene.accept("section_of", "v")
    assert ways.visible
    page.close()


def test_of_several_surfaces_a_click_says_which_it_takes():
    page, tab = opened(system="chua", methods=["rk4"], view="section", section_points=20)
    assert "A click starts a trajectory there, on the surface of the nearest point." in tab.note.object
    page.scene.accept("section_of", "x - 1")
    assert page.settle(60)
    assert "nearest point" not in tab.note.object
    page.close()
