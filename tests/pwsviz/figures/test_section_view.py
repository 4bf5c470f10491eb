"""The figure of a section: points and return map by start, axes, and its words."""

import math
from dataclasses import replace

import numpy as np
import pytest

import core
from core import Status
from pwsviz.figures.section import START_COLOURS, SectionView
from pwsviz.figures.section_text import section_how, section_rows, section_text
from pwsviz.results.requests import SectionInputs
from pwsviz.results.results import Results
from pwsviz.results.sections import SectionPoints, SectionPortion
from pwsviz.scene.checks import MAX_STARTS
from pwsviz.scene.scene import Scene

STARTS = ((0.0, 3.0, 0.0), (0.0, 1.0, 0.0))


def portion(start, phi):
    phi = np.array(phi)
    x = np.column_stack([phi, np.sin(phi), 10.0 + phi])
    return SectionPortion(start, phi.copy(), x, np.zeros(len(phi), dtype=np.int16), np.zeros(len(phi), dtype=np.int8))


def points(*portions, statuses=(Status.CROSSING_LIMIT,) * 2, **settings):
    scene = Scene(system="vibrating_table", methods=["taylor"], starts=STARTS, section_points=3, **settings)
    return SectionPoints(SectionInputs.of_scene(scene), portions, statuses, (7.5, 8.25))


@pytest.fixture
def view():
    return SectionView(lambda *_: None, lambda: None)


def marks(view):
    data = [one.data_source.data for one in view.cloud.marks]
    return np.concatenate([np.column_stack([one["x"], one["y"]]) for one in data])


def test_points_have_the_colour_of_their_start_and_angles_lose_full_turns(view):
    view.show(points(portion(0, [1.0, 8.0]), portion(1, [3.0])), (0, 2), False)
    assert marks(view) == pytest.approx(np.array([[1.0, 11.0], [8.0 - 2 * math.pi, 18.0], [3.0, 13.0]]))
    assert [len(one.data_source.data["x"]) for one in view.cloud.marks[:3]] == [2, 1, 0]
    assert [one.glyph.fill_color for one in view.cloud.marks] == list(START_COLOURS)
    assert view.figure.xaxis.axis_label == "φ mod 2π"
    assert view.firsts.data["y"][:2] == [11.0, 13.0]
    assert np.isnan(view.firsts.data["y"][2:]).all()
    assert set(view.keys.data["label"]) == {"start 1", "start 2"}


def test_a_return_map_goes_on_from_one_portion_of_a_start_to_the_next(view):
    found = points(portion(0, [0.1, 0.2]), portion(1, [1.0]), portion(0, [0.3]), portion(1, [2.0, 3.0]))
    view.show(found, (0, 2), True)
    assert marks(view).tolist() == [[0.1, 0.2], [0.2, 0.3], [1.0, 2.0], [2.0, 3.0]]
    assert view.diagonal.visible
    assert np.isnan(view.firsts.data["x"]).all()
    view.show(found, (2, 0), True)
    assert marks(view)[:2] == pytest.approx(np.array([[10.1, 10.2], [10.2, 10.3]]))


def test_a_return_map_is_the_one_of_core():
    scene = Scene(system="chua", methods=["rk4"], starts=((0.1, 0.1, 0.0), (0.2, 0.1, 0.0)), section_points=30)
    found = core.section(scene.build(), (0.0, 1e3), scene.starts, points=30, method="rk4", tau=0.01)
    crossings, view = found.ensemble.crossings, SectionView(lambda *_: None, lambda: None)
    parts = [
        SectionPortion(k, crossings.t[rows], crossings.x_after[rows], crossings.mode[rows], crossings.surface_met[rows])
        for k in (0, 1)
        for rows in np.split(np.flatnonzero(found.member == k), [10])
    ]
    view.show(SectionPoints(SectionInputs.of_scene(scene), tuple(parts), (None, None), (0.0, 0.0)), (1, 2), True)
    pairs = found.return_map("y")
    starts, surfaces = found.member[:-1], crossings.surface_met[:-1]  # of the first point of each pair
    order = np.lexsort((surfaces, starts))
    wanted = [k for k in order if starts[k] == found.member[k + 1]]
    rows = np.cumsum(found.member[:-1] == found.member[1:]) - 1
    assert np.array_equal(marks(view), pairs[rows[wanted]])


def of_chua(starts):
    scene = Scene(system="chua", methods=["rk4"], starts=starts, section_points=30)
    found = core.section(scene.build(), (0.0, 1e3), starts, points=30, method="rk4", tau=0.01)
    c, parts = found.ensemble.crossings, [np.flatnonzero(found.member == k) for k in range(len(starts))]
    of = [SectionPortion(k, c.t[p], c.x_after[p], c.mode[p], c.surface_met[p]) for k, p in enumerate(parts)]
    return SectionPoints(SectionInputs.of_scene(scene), tuple(of), (None,) * len(starts), (0.0,) * len(starts))


@pytest.mark.parametrize("count", [1, 2])
def test_points_on_several_surfaces_differ_in_colour_and_marker_and_the_legend_names_these(view, count):
    outcome = of_chua(((0.1, 0.1, 0.0), (0.2, 0.1, 0.0))[:count])
    view.show(outcome, (0, 2), False)
    for start in range(count):
        for surface, (x, marker) in enumerate([(-1.0, "circle"), (1.0, "square")]):
            mark = view.cloud.marks[2 * start + surface]
            assert set(np.round(mark.data_source.data["x"], 6)) == {x}
            assert mark.glyph.marker == marker
            name = f"g{'₁₂'[surface]} = x {'+-'[surface]} 1 = 0".replace("-", "−")
            assert mark.name == (name if count == 1 else f"start {start + 1}: {name}")
        first = outcome.portions[start].surface[0]
        assert view.firsts.data["colour"][start] == START_COLOURS[2 * start + first]
    assert len(set(view.keys.data["label"])) == 2 * count
    assert sum(len(mark.data_source.data["x"]) for mark in view.cloud.marks) == 30 * count


def test_with_more_starts_than_colours_for_all_surfaces_points_are_told_by_start_alone(view):
    starts = tuple((0.1 + 0.01 * k, 0.1, 0.0) for k in range(7))
    view.show(of_chua(starts), (0, 2), False)
    assert set(view.keys.data["label"]) == {f"start {k + 1}" for k in range(7)}
    assert {mark.glyph.marker for mark in view.cloud.marks} == {"circle"}


def test_points_that_are_there_are_not_made_anew(view):
    first, second = portion(0, [1.0]), portion(1, [2.0])
    view.show(points(first), (0, 2), False)
    made = view.cloud._portions[0]
    view.show(points(first, second), (0, 2), False)
    assert view.cloud._portions[0] is made
    assert view.cloud.count == 2
    view.show(points(second), (0, 2), False)
    assert marks(view).tolist() == [[2.0, 12.0]]


def test_every_start_has_a_colour_of_its_own():
    assert len(set(START_COLOURS)) == MAX_STARTS


def test_words_tell_which_starts_have_fewer_points_and_why():
    whole = points(portion(0, [1.0, 2.0, 3.0]), portion(1, [1.0, 2.0, 3.0]), section_direction=1)
    assert section_text(whole) == (
        "6 points of 2 starts on S: g = 0, met from one side only, just after the reset map; "
        "integrated by taylor with tolerance 1e-12 to times from t = 7.5 to t = 8.25."
    )
    early = points(portion(0, [1.0, 2.0, 3.0]), portion(1, [2.0]), statuses=(Status.CROSSING_LIMIT, Status.ZENO))
    assert (
        "One start has all 3. Start 2 has ended with 1 point by t = 8.25, the last at t = 2: jumps come ever "
        "closer and accumulate here (Zeno)."
    ) in section_text(early)
    both = points(portion(1, [2.0]), statuses=(Status.ESCAPED, Status.ESCAPED))
    assert (
        "Start 1 has ended with no point by t = 7.5: g does not change sign on the way; the numerical"
        in section_text(both)
    )
    assert (
        "Start 2 has ended with 1 point by t = 8.25, the last at t = 2: the numerical solution blows up."
        in section_text(both)
    )
    never = points(statuses=(Status.STEP_LIMIT, Status.CROSSING_LIMIT), section_of="v**2 + 1")
    assert "no point by t = 7.5: h does not change sign on the way; the limit of steps" in section_text(never)
    left_out = points(statuses=(Status.ZENO,) * 2, section_discard=9)
    assert "Starts 1 and 2 have ended with no point: jumps come" in section_text(left_out)
    still = replace(early, at_rest=frozenset({1}))
    assert "Start 2 has ended with 1 point by t = 8.25, the last at t = 2: the motion has come to rest" in section_text(
        still
    )
    typed = points(portion(0, [1.0]), section_of="y - a**2", section_discard=9)
    assert "on y − a² = 0, crossed in both directions; " in section_text(typed)
    assert "after the first 9 are discarded; integrated by taylor" in section_how(typed)


@pytest.mark.parametrize(("status", "counts"), [(Status.ZENO, True), (Status.SLIDING, False), (Status.GRAZING, False)])
def test_a_last_point_at_the_end_is_said_not_to_count_where_the_run_does_not_count_it(status, counts):
    ended = points(portion(0, [1.0, 7.5]), statuses=(status, Status.CROSSING_LIMIT))
    assert ("is neither a jump nor a crossing" in section_text(ended)) is not counts


def test_a_table_has_a_row_for_each_point_start_by_start():
    table = section_rows(points(portion(0, [1.0]), portion(1, [4.0]), portion(0, [2.0])))
    assert list(table) == ["start", "point", "t", "phi", "y", "v"]
    assert table["start"].tolist() == [1, 1, 2]
    assert table["point"].tolist() == [1, 2, 1]
    assert table["phi"].tolist() == [1.0, 2.0, 4.0]


@pytest.mark.parametrize(("radius", "whole"), [(1.0, True), (3.0, False)])
def test_a_closed_surface_is_seen_whole_unless_it_is_far_larger_than_what_the_points_take(view, radius, whole):
    x = np.array([[-0.8, 0.6], [0.1, 0.99], [0.5, -0.8]])
    found = SectionPortion(0, np.arange(3.0), x, np.zeros(3, dtype=np.int16), np.zeros(3, dtype=np.int8))
    scene = Scene(system="elliptic_curve", values={"r": radius}, section_points=3)
    inputs = SectionInputs.of_scene(scene)
    view.show(SectionPoints(inputs, (found,), (Status.CROSSING_LIMIT,), (7.5,)), (0, 1), False)
    across, up = (view.cloud.corners.data[name] for name in "xy")
    assert (min(across) <= -radius and max(across) >= radius and max(up) >= radius) is whole


def test_the_axes_show_no_differences_that_errors_alone_may_make(view):
    """Of Chua’s circuit, at a limit cycle that meets the surface once a loop upwards."""
    for method, tau in (("taylor", 1.0), ("rk8", 0.05)):
        scene = Scene(system="chua", methods=[method], section_of="x - 1.5", section_direction=1)
        for name, number in {"values.alpha": 8.1, "tau": tau, "section_points": 400, "section_discard": 400}.items():
            scene.accept(name, number)
        found = Results().section(SectionInputs.of_scene(scene))
        x = found.of_start(0).x
        assert 0 < np.ptp(x, axis=0).max() <= found.noise < 1e-11
        view.show(found, (1, 2), False)
        (left, right), (low, high) = (view.cloud.corners.data[name] for name in "xy")
        assert min(right - left, high - low) > 0.1, "not as narrow as round-off"
        assert "All points are the same up to errors (differences below" in section_text(found)
    other = Results().section(SectionInputs.of_scene(Scene(section_points=50)))
    assert "the same" not in section_text(other), "a closed orbit meets the surface in several points"


@pytest.mark.parametrize(("height", "alike", "equal"), [(2.0, True, True), (2.0, False, False), (0.02, True, False)])
def test_scales_are_equal_where_they_are_in_the_portrait_unless_that_makes_a_strip(view, height, alike, equal):
    angle = np.linspace(0.0, 6.0, 30)
    x = np.column_stack([np.cos(angle), height / 2 * np.sin(angle), angle])
    kinds = np.zeros((2, len(angle)))
    found = SectionPortion(0, angle, x, kinds[0].astype(np.int16), kinds[1].astype(np.int8))
    view.show(points(found), (0, 1), False, alike)
    assert view.figure.match_aspect is equal
