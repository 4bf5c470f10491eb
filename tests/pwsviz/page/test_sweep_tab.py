"""The tab of the bifurcation diagram: a click sets the parameter, and what stands behind “more” is made when needed."""

import numpy as np
import pytest

import core
from pwsviz.export.caption import caption
from pwsviz.export.files import csv_bytes
from pwsviz.export.tables import sweep_tables
from pwsviz.figures.point_cloud import FEW, FINE
from pwsviz.figures.section_prospects import prospects
from pwsviz.geometry.window import Window
from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


def opened(**settings):
    """Return a page with the tab open on a small diagram of the stick-slip block."""
    given = {"system": "stick_slip", "methods": ["taylor"], "tau": 0.5, "sweep_values": 40, "sweep_points": 6}
    page = Explorer(Scene(**{**given, "sweep_discard": 4, "view": "sweep", **settings}), Results())
    page.refresh()
    assert page.settle(60)
    return page


@pytest.fixture(scope="module")
def page():
    page = opened()
    yield page
    page.close()


def test_a_click_sets_the_parameter_and_computes_no_diagram(page):
    tab = page.view
    assert tab.outcome.whole.any()
    before = page.results.computed["sweep"]
    tab._go(1.23456789)
    page.settle(60)
    assert page.scene.values["belt"] == 1.235, "rounded to what the picture resolves"
    assert tab.view.present.data["x"] == [1.235]
    assert "At w = 1.235 all points are" in tab.words.object, "the points of this value, which is none of the diagram's"
    assert set(tab.view.chosen.data["x"]) == {1.235}
    assert page.results.computed["sweep"] == before
    tab._go(-5.0)
    assert page.scene.values["belt"] == 0.05, "the nearest that the parameter may have"


def test_a_value_of_the_diagram_or_of_a_continuation_is_not_computed_again(page):
    before = page.results.computed["swept value"]
    page.scene.accept("values.belt", float(page.view.outcome.values[7]))
    assert page.settle(60)
    page.scene.accept("sweep_continuation", "up")
    page.scene.accept("values.belt", 1.21)
    assert page.settle(60)
    assert "the swept value nearest to" in page.view.words.object
    assert (page.results.computed["swept value"], len(page.view.view.chosen.data["x"])) == (before, 0)
    page.scene.accept("sweep_continuation", "none")
    assert page.settle(60)


def test_a_caption_gives_no_one_value_to_the_parameter_that_is_swept(page):
    page.scene.values = {**page.scene.values, "belt": 0.25}
    page.settle(60)
    _, piece = page._pieces()
    told = caption(page.scene, piece.title, **piece.origin)
    assert "; w = " not in told


def test_a_picture_is_painted_in_finer_pixels_than_the_screen():
    page = opened(sweep_values=400, sweep_points=20)
    cloud = page.view.view.cloud
    assert cloud.count > FEW
    shape = np.shape(cloud._picture.data["image"][0])
    page._pieces()
    assert np.shape(cloud._picture.data["image"][0]) == (FINE * shape[0], FINE * shape[1])
    page.close()


def test_values_in_sight_are_swept_again(page):
    tab = page.view
    assert not tab._narrow.visible
    tab.view.cloud.window = window = Window(0.4, 1.0, -2.0, 2.0)
    tab._look(window)
    assert tab._narrow.visible
    tab._sweep_in_sight()
    page.settle(60)
    assert page.scene.sweep_range == (0.4, 1.0)
    assert tab.outcome.values[[0, -1]].tolist() == [0.4, 1.0]
    assert not tab._narrow.visible


def test_the_controls_follow_the_scene(page):
    controls, scene = page.view.controls, page.scene
    assert not controls.numbers, "made when they are asked for"
    controls._open()
    assert controls.box.visible
    assert next(iter(controls.surface.options.values())) == ""
    scene.accept("sweep_parameter", "decay")
    assert controls.parameter.value == "decay"
    assert [field.entry.text for field in controls.ends] == ["0.05", "5"]
    controls.ends[1].type("2")
    assert scene.sweep_range == (0.05, 2.0)
    controls._coordinate.value = "v"
    assert scene.sweep_coordinate == "v"
    controls.surface.value = "other"
    assert controls.function.visible
    controls.function.value = "y +"
    assert controls.function.error_state
    assert scene.sweep_of == ""
    controls.function.value = "2y - 1"
    assert not controls.function.error_state
    assert scene.sweep_of == "2*y - 1"
    scene.accept("sweep_of", "")
    assert not controls.function.visible


def test_a_system_without_parameters_is_told_plainly():
    page, laws = opened(), {"f_minus": ("y", "-x"), "f_plus": ("y", "-2*x"), "g": "y", "x0": (1.0, 1.0)}
    page.scene.use(core.PiecewiseSystem("Plain", ("x", "y"), **laws))
    page.scene.view = "sweep"
    assert page.settle(60)
    assert "Plain has no parameter, so there is nothing to sweep." in page.view.words.object
    assert not page.view.controls._first.visible
    assert not page.view._place.visible, "the words stand where they are seen"
    assert page.view.program() == ""
    page.scene.accept("system", "stick_slip")
    assert page.settle(60)
    assert page.view._place.visible
    page.close()


def test_tables_have_a_row_for_each_point_and_each_value():
    page = opened()
    found, tables = page.view.outcome, page.view.tables()
    points, values = (tables[name]() for name in ("points", "values"))
    assert len(points["value"]) == found.counts.sum()
    assert (np.diff(points["value"]) >= 0).all()
    for value in found.values[found.whole]:
        assert np.array_equal(points["y"][points["value"] == value], found.points_at(value))
    assert np.array_equal(values["points"], found.counts)
    assert set(values["ended"]) <= {"all points found", *(status.reason for status in core.Status)}, "in words"
    assert sweep_tables(found).keys() == {"points", "values"}
    page.close()


def test_the_chosen_value_and_its_points_are_in_the_tables_and_explained():
    page = opened()
    tab = page.view
    tab._go(1.23456789)
    assert page.settle(60)
    points, chosen = (tab.tables()[name]() for name in ("points", "chosen"))
    marked = points["chosen"] == 1
    assert points["y"][marked].tolist() == list(tab.view.chosen.data["y"])
    assert set(points["value"][marked]) == {1.235}
    assert (np.diff(points["value"]) >= 0).all(), "among the others"
    assert (chosen["value"].tolist(), chosen["points"].tolist()) == ([1.235], [marked.sum()])
    assert "chosen: 1 at the chosen value of the parameter" in csv_bytes(points).decode()
    present = float(tab.outcome.values[7])
    of_the_diagram = sweep_tables(tab.outcome, present)["points"]()
    assert of_the_diagram["chosen"].sum() == tab.outcome.counts[7], "no point is there twice"
    assert "chosen" not in sweep_tables(tab.outcome, 100.0), "it lies outside"
    page.close()


def test_what_comes_of_a_system_that_has_just_been_left_is_drawn_all_the_same():
    page = opened()
    found = page.view.outcome
    page.scene.accept("system", "chua")
    page.views["sweep"].draw(found)
    assert "of w from" in page.views["sweep"].details(found)
    page.settle(60)
    page.close()


def test_a_diagram_without_points_leaves_its_room_to_the_words():
    page = opened(system="bouncing_ball", sweep_parameter="gravity", sweep_discard=400)
    assert not page.view._place.visible
    assert "No run has more than the 400 crossings discarded first" in page.view.words.object
    page.close()


def test_the_number_of_discarded_points_is_shown_and_repeated_where_it_is_automatic():
    page = opened(system="coulomb_friction", methods=["dmm2"], tau=0.01, sweep_discard=None)
    tab = page.view
    tab.controls._open()
    entry = tab.controls.numbers["sweep_discard"].entry
    assert (entry.text, entry.note) == ("auto", "= 0")
    assert tab._place.visible
    assert "discard" not in tab.program(), "0 is the default of the function"
    tab.controls.numbers["sweep_discard"].type("2")
    page.settle(60)
    assert (entry.text, entry.note, page.scene.sweep_discard) == ("2", "", 2)
    assert "sweep_discard=2" in query(page.scene)
    tab.controls.numbers["sweep_discard"].type("auto")
    assert page.settle(60)
    assert (entry.text, entry.note, page.scene.sweep_discard) == ("auto", "= 0", None)
    assert "sweep_discard" not in query(page.scene)
    page.close()


def test_a_diagram_that_stays_in_sight_while_another_is_prepared_is_called_the_former_one():
    page = opened()
    page.view.begin()
    assert "previous result" in page.view.progress._words.object
    page.close()


@pytest.mark.parametrize("view", ["sweep", "section"])
def test_a_view_without_a_reference_warns_of_steps_that_are_too_long(view):
    page = opened(system="elliptic_curve", methods=["dmm2"], view=view, tau=0.2, sweep_range=(0.5, 1.3))
    assert '<p class="stopped">' in page.view.words.object
    assert "too long for this field" in page.view.words.object
    page.close()


def test_an_example_does_not_recommend_itself():
    page = opened()
    titles = [one.title for one in PRESETS.values() if one.settings["view"] == "sweep"]
    assert all(title in page.view.words.object for title in titles)
    page.close()
    for title in titles:
        hope = prospects(core.CATALOGUE["stick_slip"], "sweep", title)
        assert title not in hope
        assert all(other in hope for other in titles if other != title)
