"""Every run drawn has its crossings marked by kind, and its end if it stops early."""

from dataclasses import replace

import pytest

import core
from pwsviz.figures.marks import (
    ENDS,
    KIND_COLOURS,
    KIND_MARKERS,
    crossing_columns,
    end_columns,
    kind_columns,
    left_out,
    star_labels,
)
from pwsviz.figures.portrait_text import figures_of
from pwsviz.geometry.window import Window
from pwsviz.results import orbits
from pwsviz.results.orbits import MOST_PLACES
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


def pictures(preset, **changes):
    scene = Scene()
    scene.load({**PRESETS[preset].settings, **changes})
    return Results().pictures(PortraitInputs.of(scene))


def test_every_status_that_stops_a_run_has_a_mark():
    assert set(core.Status) - set(ENDS) == {
        core.Status.RUNNING, core.Status.COMPLETED, core.Status.CANCELLED, core.Status.EVENT,
        core.Status.EVENT_LIMIT,  # the page asks for no events
    }  # fmt: skip


@pytest.mark.parametrize("selected", [0, 2])
def test_every_start_has_its_marks_whichever_is_selected(selected):
    drawn = pictures("grazing", selected=selected)
    marks, ends = crossing_columns(drawn.numbered, 1 + selected), end_columns(drawn.numbered)
    assert 2 in marks["start"]
    assert 1 not in marks["start"], "it falls short"
    assert marks["chosen"] == [number == 1 + selected for number in marks["start"]]
    assert list(zip(ends["start"], ends["label"], strict=True)) == [(3, "end: tangency")]
    assert abs(ends["x"][0] - 0.5) < 1e-6


def test_where_places_of_crossings_are_left_out_it_is_said_how_many():
    run = pictures("grazing").orbits[0]
    marked = replace(run, kinds=("transversal",) * MOST_PLACES, places=MOST_PLACES)
    assert left_out([marked]) == ""
    words = "Crossings are marked at 1,000 of 1,300 places, the first of each run."
    assert left_out([replace(marked, places=1300)]) == words
    assert left_out([marked] * 4).startswith("Crossings are marked at 3,000 of 4,000 places"), "of all runs together"


def test_a_run_knows_how_many_places_a_screen_tells_apart_and_keeps_the_first(monkeypatch):
    orbit = pictures("grazing", selected=1).orbits[0]
    assert orbit.places == len(orbit.kinds) > 1
    monkeypatch.setattr(orbits, "MOST_PLACES", 1)
    drawn = pictures("grazing", selected=1)
    assert (drawn.orbits[0].places, drawn.orbits[0].kinds) == (orbit.places, orbit.kinds[:1])
    assert "Crossings are marked" in figures_of(drawn)


def test_each_of_six_sliding_runs_has_its_end_on_the_surface():
    ends = end_columns(pictures("vf_sliding").numbered)
    assert sorted(ends["start"]) == [1, 2, 3, 4, 5, 6]
    assert set(ends["label"]) == {"end: sliding"}
    assert max(map(abs, ends["y"])) < 1e-9


def test_stars_that_cover_one_another_have_their_numbers_above_them_in_the_order_of_the_stars():
    view = Window(0.0, 35.0, 0.0, 20.0)  # a star covers what is within 1
    row = [(1.0, 5.0), (9.0, 5.0), (1.8, 5.0), (2.6, 5.0), (9.0, 6.5)]
    inside, above = star_labels(row, view)  # the first and the fourth hang together by the third
    assert inside == ["", "2", "", "", "5"]
    assert above == ["", "", "1, 3, 4", "", ""]
    assert star_labels([(3.0, 5.0), (1.6, 5.0), (2.3, 5.0)], view)[1] == ["", "", "2, 3, 1"], "from left to right"
    assert star_labels([(3.0, 5.0), (3.0, 5.6)], view)[1] == ["", "2, 1"], "from the top down"
    assert star_labels(row, view.scaled(0.1)) == (["1", "2", "3", "4", "5"], [""] * 5)
    assert star_labels(row, None) == (["1", "2", "3", "4", "5"], [""] * 5)
    assert star_labels([(2.0, 3.0)] * 2, view) == (["", ""], ["1, 2", ""])
    assert star_labels([], view) == ([], [])


def test_no_end_differs_from_a_crossing_by_a_dot_alone():
    # A legend draws marks of 8 pixels, in which a dot is not seen.
    crossings = {(KIND_MARKERS[kind], KIND_COLOURS[kind]) for kind in KIND_MARKERS}
    assert not crossings & {(look.marker.removesuffix("_dot"), look.colour) for look in ENDS.values()}


def test_starts_beyond_a_wall_are_named():
    told = {}
    for starts in ((((1.0, 0.0)), (-1.0, 0.0)), ((-1.0, 0.0),), ((1.0, 0.0),)):
        scene = Scene(system="bouncing_ball", starts=starts, methods=["rk2"], t_end=1.0)
        told[len(starts), starts[0][0]] = figures_of(Results().pictures(PortraitInputs.of(scene)))
    assert "Start 2 lies beyond the wall" in told[2, 1.0]
    assert "The start lies beyond the wall" in told[1, -1.0]
    assert "beyond" not in told[1, 1.0]


def test_a_start_from_which_methods_stop_for_different_reasons_is_named_once():
    scene = Scene(system="predator_prey", starts=((0.5, 1.0), (-0.5, 1.0)), methods=["dmm2", "rk2"])
    told = figures_of(Results().pictures(PortraitInputs.of(scene)))
    assert "Start 1 of 2. Start 2 stops early (no solution or blow-up)." in told


def test_markers_that_are_painted_smaller_are_given_larger_sizes():
    columns = kind_columns(["transversal", "leaving", "sliding"], [5, 5, 7])
    circle, triangle, square = columns["size"]
    assert (circle, square) == (5, 7)
    assert 0.43 * triangle**2 > 0.78 * circle**2  # areas of a triangle and a circle of size 1
