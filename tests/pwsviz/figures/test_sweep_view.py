"""The bifurcation diagram shows what was computed, marks where runs end early, and says so in words."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bokeh.events import Tap

from core import Status
from pwsviz.figures.stability_outcomes import OUTCOMES
from pwsviz.figures.sweep import SweepView
from pwsviz.figures.sweep_text import (
    approached,
    period_of,
    stretches,
    surface_words,
    sweep_details,
    sweep_how,
    sweep_numbers,
    sweep_text,
)
from pwsviz.geometry.point_counts import Portion
from pwsviz.results.requests import SweepInputs
from pwsviz.results.sweeps import NO_START, Diagram
from pwsviz.scene.scene import Scene

VALUES = np.linspace(-3.0, 3.0, 7)
LIMIT, BLOWS_UP, DONE, TO_COME = (
    int(one) for one in (Status.CROSSING_LIMIT, Status.ESCAPED, Status.COMPLETED, Status.RUNNING)
)


def diagram(outcomes, points=4, **settings):
    """A diagram of a₋ whose whole values have the points 1, 2, 1, 2; COMPLETED ones have two, others none."""
    scene = Scene(sweep_parameter="a_minus", sweep_range=(-3.0, 3.0), sweep_values=7, sweep_points=points, **settings)
    counts = np.array([{LIMIT: points, DONE: 2}.get(code, 0) for code in outcomes])
    portions = tuple(
        Portion(np.full(count, value), np.resize([1.0, 2.0], count), 0)
        for value, count in zip(VALUES, counts, strict=True)
    )
    return Diagram(SweepInputs.of_scene(scene), VALUES, np.array(outcomes), counts, portions)


MIXED = diagram([LIMIT, LIMIT, TO_COME, BLOWS_UP, BLOWS_UP, DONE, NO_START])


def test_the_figure_shows_points_and_the_whole_range_of_values():
    view = SweepView(print, print)
    view.show(MIXED)
    view.mark(-3.5, "a₋")
    assert not view._present.visible, "the legend names no line that is not there"
    view.mark(-2.5, "a₋")
    assert view._present.visible
    assert view.cloud.count == 10
    assert view.figure.xaxis[0].axis_label == "a₋"
    assert view.figure.yaxis[0].axis_label == "x"
    low, high = view.ends.data["x"]
    assert low < -3.0 < 3.0 < high
    assert view.present.data["x"] == [-2.5]
    assert view._present.label.value == "chosen value, a₋ = −2.5"


EXAMINED = np.array([-1.0, 2.0])


def test_the_values_that_a_warning_is_about_are_marked():
    view = SweepView(print, print)
    view.show(replace(MIXED, warnings=("a₋ = −1: the step is too long.",), examined=EXAMINED, warned=EXAMINED[:1]))
    assert view.warned.data["x"] == [-1.0]
    assert (view._doubt.visible, view._doubt.label.value) == (True, "in doubt: 1 of 2 runs examined")
    assert len(view._doubt.renderers) == 1, "a single value has a line and no shade"
    view.show(replace(MIXED, warnings=("too long",), examined=np.array([-1.0, 0.0, 2.0]), warned=np.array([-1.0, 0.0])))
    shade, line = view._doubt.renderers
    assert (shade.data_source, line.data_source) == (view.doubtful, view.warned), "the key has what lies in between"
    view.show(MIXED)
    assert not view._doubt.visible, "the legend names no line that is not there"


def test_values_at_which_small_errors_grow_have_a_shade_of_their_own():
    view = SweepView(print, print)
    view.show(replace(MIXED, examined=EXAMINED, sensitive=EXAMINED[:1]))
    assert (view.growing.data["start"], view.growing.data["end"]) == ([-1.5], [-0.5]), "as wide as the value"
    assert view._growth.visible
    assert not view._doubt.visible
    assert view._growth.label.value == "small errors grow: 1 of 2 runs examined"
    view.show(MIXED)
    assert not view._growth.visible, "the legend names no shade that is not there"


def test_the_chosen_value_has_points_of_its_own_on_its_line():
    view = SweepView(print, print)
    view.show(MIXED)
    alone = replace(MIXED, portions=(Portion(np.full(2, -2.5), np.array([1.0, 3.0]), 0),))
    view.mark(-2.5, "a₋", alone)
    assert (list(view.chosen.data["x"]), list(view.chosen.data["y"])) == ([-2.5, -2.5], [1.0, 3.0])
    view.mark(-2.4, "a₋", None)
    assert not len(view.chosen.data["x"])


def test_no_period_is_told_of_a_chosen_value_before_others_have_points_beside_which_they_are_judged():
    alone = diagram([LIMIT] * 7)
    assert "the points have period 2" in sweep_text(alone, -3.0, alone)
    assert sweep_text(diagram([TO_COME] * 7), -3.0, alone) == ""


def test_strips_mark_the_values_whose_runs_end_early_and_are_never_empty():
    view = SweepView(print, print)
    view.show(MIXED)
    strips = view.early.data
    assert list(strips["start"]) == [-0.5, 1.5, 2.5]
    assert list(strips["end"]) == [1.5, 2.5, 3.5]
    assert strips["words"] == [
        OUTCOMES[Status.ESCAPED].words, "fewer points than requested", "no run begins here"
    ]  # fmt: skip
    assert view._early.visible
    view.show(diagram([LIMIT] * 7))
    assert len(view.early.data["words"]) == 1, "the browser cannot draw the key of a glyph without marks"
    assert not view._early.visible


def test_no_stretch_covers_what_is_still_to_come():
    found = diagram([BLOWS_UP, TO_COME, BLOWS_UP, TO_COME, LIMIT, TO_COME, TO_COME])
    assert list(stretches(found)) == [(BLOWS_UP, 0, 0), (BLOWS_UP, 2, 2)]


def test_a_click_chooses_a_value():
    chosen = []
    view = SweepView(chosen.append, print)
    view.figure._trigger_event(Tap(view.figure, sx=1, sy=1, x=1.25, y=0.5))
    assert chosen == [1.25]


def test_words_and_table_say_how_many_values_end_how_and_where():
    words = sweep_text(MIXED, -2.9)
    repeat = "the points have period 2, of crossings in both directions."
    assert words.startswith(f"At the swept value nearest to a₋ = -2.9 {repeat}")
    plotted = "10 points: x on S for 6 values of a₋ from -3 to 3. The 4 points requested were found for 2"
    assert sweep_details(MIXED).startswith(plotted)
    rows = {row[0]: row[1:] for row in sweep_numbers(MIXED).rows}
    assert rows == {
        OUTCOMES[Status.ESCAPED].words: ("2", "0 to 1"),
        "fewer points than requested by t = 2000": ("1", "2"),
        "no run begins here": ("1", "3"),
    }
    assert sweep_numbers(diagram([LIMIT] * 7)).rows == ()
    assert "The 4 points requested were found for every value." in sweep_details(diagram([LIMIT] * 7))
    assert "the swept value nearest to" not in sweep_text(diagram([LIMIT] * 7), 9.0)
    assert "were found for none of the 7 values." in sweep_details(diagram([DONE] * 7))


def test_runs_that_have_their_points_before_jumps_accumulate_are_told_of_beside_those_that_stop():
    told = "Where jumps accumulate only after the 4 points wanted, the run ends with these and is not in the table."
    stops = int(Status.ZENO)
    assert told in sweep_text(diagram([stops, stops, LIMIT, LIMIT, LIMIT, LIMIT, LIMIT]), -3.0)
    for others in ([stops] * 7, [LIMIT] * 7, [BLOWS_UP, *[LIMIT] * 6], [stops, *[TO_COME] * 6]):
        assert told not in sweep_text(diagram(others), -3.0)


@pytest.mark.parametrize(
    ("points", "period"),
    [
        ([1.0] * 8, 1),
        ([1.0, 2.0] * 4, 2),
        ([1.0, 2.0, 1.0, 3.0] * 3, 4),
        ([1.0, 2.0, 3.0, 1.0], 0),  # not seen twice
        (np.sin(np.arange(200.0)), 0),
        ([1.0, 1.0 + 1e-8] * 5, 1),
        ([1.0], 0),
    ],
)
def test_a_period_counts_if_it_is_seen_twice(points, period):
    assert period_of(np.array(points), 1.0) == period


def test_points_a_full_turn_apart_are_the_same():
    about_zero = np.array([1e-9, 2 * np.pi - 1e-9] * 4)
    assert period_of(about_zero, 2 * np.pi, 2 * np.pi) == 1
    assert period_of(about_zero, 2 * np.pi) == 2


def test_points_that_differ_by_round_off_are_the_same():
    assert period_of(1e-17 * np.random.default_rng(0).random(20), 1e-17, least=1e-15) == 1
    found = diagram([LIMIT] * 7)
    assert 0.0 < found.round_off < 1e-14


@pytest.mark.parametrize(
    ("points", "length"),
    [
        (0.9 ** np.arange(60), 1),
        ((-0.8) ** np.arange(60), 1),
        (np.tile([0.0, 1.0], 30) + 0.9 ** np.arange(60), 2),
        (np.sin(np.arange(60.0)), 0),
        (np.random.default_rng(0).random(60), 0),
        (1.1 ** np.arange(60), 0),
    ],
)
def test_points_that_come_closer_to_a_cycle_each_time_are_told_from_others(points, length):
    assert approached(points) == length


def test_how_names_all_that_repeats_the_diagram():
    chosen = {"sweep_of": "x - 1", "sweep_direction": -1, "sweep_continuation": "up", "study_method": "taylor"}
    inputs = SweepInputs.of_scene(Scene(methods=["taylor"], sweep_discard=100, **chosen))
    assert surface_words(inputs) == "the surface x − 1 = 0 where the function decreases"
    how = sweep_how(inputs)
    for words in (
        "y where the runs meet the surface", "400 values of r from 0.1 to 4",
        "the first 100 points of each run are discarded, and at most the next 100 (t ≤ 2,000) are plotted",
        "next smaller value", "taylor with tolerance 10⁻¹²", "Filippov",
    ):  # fmt: skip
        assert words in how, words
    told = sweep_how(SweepInputs.of_scene(Scene(system="stick_slip", methods=["rk4"], sweep_discard=100)))
    assert "where the runs meet S, and where sliding begins on it, for" in told
    assert "at most the next 100 (t ≤ 2,000)" in told
    chua = {"system": "chua", "methods": ["taylor"]}
    assert surface_words(SweepInputs.of_scene(Scene(**chua))) == "any of the surfaces gᵢ = 0 where gᵢ increases"
    assert surface_words(SweepInputs.of_scene(Scene(**chua, sweep_direction=0))) == "any of the surfaces gᵢ = 0"


def test_nothing_is_said_of_the_present_value_if_no_computed_value_is_next_to_it():
    one = diagram([LIMIT, *[TO_COME] * 6])
    assert "the swept value nearest to" in sweep_text(one, -2.1)
    assert "the swept value nearest to" not in sweep_text(one, -1.9)


def test_a_diagram_without_points_says_that_all_crossings_were_left_out():
    nothing = "No run has more than the 100 crossings discarded first"
    assert nothing in sweep_text(diagram([BLOWS_UP] * 7, sweep_discard=100), 0.0)
    assert nothing not in sweep_text(MIXED, 0.0)
    most = diagram([LIMIT, *[DONE] * 6], sweep_discard=100)
    most.counts[1:] = 0
    words = "For 6 of the values no run has more than the 100 crossings discarded first: discard fewer, or let"
    assert words in sweep_text(most, 0.0)
    assert nothing not in sweep_text(diagram([BLOWS_UP] * 7, sweep_discard=0), 0.0)


def test_points_are_said_to_be_states_after_the_reset_map_where_one_acts():
    ball = {"system": "vibrating_table", "methods": ["taylor"]}
    assert "values of φ mod 2π where the runs meet S, just after the reset map, for" in sweep_how(
        SweepInputs.of_scene(Scene(**ball))
    )
    other = SweepInputs.of_scene(Scene(**ball, sweep_of="v"))
    assert "reset" not in sweep_how(other)


def test_axes_name_the_coordinate_as_formulas_do():
    scene = Scene(system="vibrating_table", methods=["taylor"], sweep_values=2)
    view, nothing = SweepView(print, print), np.zeros(2, dtype=np.int64)
    view.show(Diagram(SweepInputs.of_scene(scene), np.array([0.0, 2.0]), nothing + TO_COME, nothing))
    assert view.figure.yaxis[0].axis_label == "φ mod 2π"


def test_values_between_those_of_the_sweep_are_told_as_chosen_and_those_of_the_sweep_in_few_digits():
    found = diagram([LIMIT] * 7)
    low, spacing = found.values[0], found.spacing
    present = float(low + 0.4 * spacing)
    assert sweep_text(found, present).startswith(f"At the swept value nearest to a₋ = {present:.6g}")
    grid = SimpleNamespace(values=np.linspace(8.0, 9.2, 400), spacing=1.2 / 399)
    assert Diagram.told(grid, grid.values[233]) == "8.701"
