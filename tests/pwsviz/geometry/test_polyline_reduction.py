"""Curves shrink to what a screen shows, and by no more than promised."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import core
from pwsviz.geometry.envelope import envelope
from pwsviz.geometry.polyline_reduction import (
    MOST_CELLS,
    MOST_VERTICES,
    RESOLUTION,
    distinct_pixels,
    first_in_cells,
    painted_first,
    screen_path,
    simplify,
    spliced,
)
from tests.bounds import bounded_time

coordinates = st.floats(-100, 100, width=32)
polylines = hnp.arrays(float, st.tuples(st.integers(2, 60), st.just(2)), elements=coordinates)


def distance_to_path(points, path):
    """Largest distance of any of the points to a polyline; rows of NaN part its pieces."""
    a, b = path[:-1], path[1:]
    whole = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
    a, chord = a[whole], (b - a)[whole]
    length2 = np.maximum((chord**2).sum(axis=1), 1e-300)
    worst = 0.0
    for block in np.array_split(points, 1 + len(points) // 500):
        offset = block[:, None] - a
        share = np.clip((offset * chord).sum(axis=2) / length2, 0, 1)
        gap = np.linalg.norm(offset - share[..., None] * chord, axis=2)
        worst = max(worst, gap.min(axis=1).max(initial=0.0))
    return worst


def circle(n, turns=1.0, drift=0.0):
    t = np.linspace(0, 2 * np.pi * turns, n)
    return np.column_stack([np.cos(t), np.sin(t)]) * (1 + drift * t)[:, None]


@example(np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0]]), 0.0)
@given(polylines, st.floats(0, 50))
def test_simplified_curve_stays_within_tolerance(points, tolerance):
    kept = simplify(points, tolerance)
    assert distance_to_path(points, points[kept]) <= tolerance + 1e-9 * 200


@given(polylines, st.data())
def test_ends_and_pinned_vertices_are_kept(points, data):
    pinned = data.draw(hnp.arrays(bool, len(points)))
    kept = simplify(points, 1e9, pinned)
    assert {0, len(points) - 1} | set(np.flatnonzero(pinned)) <= set(kept)
    assert (np.diff(kept) > 0).all()


def test_a_straight_line_needs_two_vertices():
    t = np.linspace(0, 1, 1000)
    assert len(simplify(np.column_stack([t, 2 * t]), 1e-9)) == 2


def test_vertices_gather_where_the_curve_bends():
    x = np.linspace(-1, 1, 5000)
    kept = simplify(np.column_stack([x, np.tanh(40 * x)]), 1e-3)
    assert np.mean(np.abs(x[kept]) < 0.15) > 0.7


@pytest.mark.parametrize("turns", [1, 30, 3000])
def test_a_closed_orbit_is_drawn_to_a_pixel_however_often_it_goes_round(turns):
    points = circle(200_000, turns)
    path = screen_path(points)
    assert len(path) <= MOST_VERTICES
    assert distance_to_path(points[::997], path) <= 2 * 2 / RESOLUTION


@given(polylines, st.integers(8, 50))
def test_no_path_exceeds_its_limit(points, limit):
    assert len(screen_path(points, limit=limit)) <= limit


def test_a_curve_that_fills_an_area_is_bounded_too():
    rng = np.random.default_rng(1)
    assert len(screen_path(rng.normal(size=(100_000, 2)))) <= MOST_VERTICES


@pytest.mark.parametrize("key", ["chua", "henon_heiles"])
def test_a_curve_that_fills_an_area_but_sparsely_has_no_gaps(key):
    run = core.integrate(key, (0.0, 300.0), method="rk4", tau=0.01)
    points = run.x[:, [0, -1]]
    pixel = np.ptp(points, axis=0).max() / RESOLUTION
    assert distance_to_path(points[::97], screen_path(points)) <= 4 * pixel  # those left out are beside others


def test_no_edge_jumps_across_a_gap():
    path = screen_path(circle(100_000, 1000.3, drift=1e-6))
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert np.nanmax(steps) < 0.3
    assert np.isfinite(path[[0, -1]]).all()


def test_kinks_are_kept():
    points = circle(10_001)
    kinks = np.zeros(len(points), dtype=bool)
    kinks[[1234, 7777]] = True
    path = screen_path(points, kinks)
    for kink in points[kinks]:
        assert (path == kink).all(axis=1).any()


def test_states_that_are_not_finite_are_left_out():
    points = np.array([[0.0, 0.0], [1.0, 1.0], [np.inf, 0.0], [np.nan, 1.0]])
    assert np.array_equal(screen_path(points), [[0.0, 0.0], [1.0, 1.0]])


def test_a_point_at_rest_is_one_vertex():
    assert len(screen_path(np.ones((50, 2)))) == 1


def test_first_visits_leaves_no_cell_empty_and_none_twice():
    points = np.random.default_rng(0).uniform(size=(5000, 2))
    cells = ((points - points.min(axis=0)) / 0.05).astype(int)
    first = cells[first_in_cells(points, 0.05)]
    assert len(np.unique(first, axis=0)) == len(first) == len(np.unique(cells, axis=0))


@given(polylines, st.data())
def test_rows_are_spliced_in_before_their_places(points, data):
    places = np.sort(data.draw(hnp.arrays(int, st.integers(0, 9), elements=st.integers(0, len(points)))))
    rows = np.arange(2.0 * len(places)).reshape(-1, 2)
    out, marks = spliced(points, rows, places)
    assert np.array_equal(out, np.insert(points, places, rows, axis=0))
    assert np.array_equal(out[marks], rows)


def test_coinciding_marks_are_drawn_once():
    marks = np.tile([[0.0, 1.0], [2.0, 3.0]], (500, 1))
    assert list(distinct_pixels(marks)) == [0, 1]


@given(hnp.arrays(float, st.integers(1, 400), elements=st.floats(-1e3, 1e3)), st.integers(2, 40))
def test_envelope_holds_the_extremes_of_every_column(y, columns):
    t = np.cumsum(np.linspace(0.5, 1.5, len(y)))
    te, ye = envelope(t, y, columns)
    assert len(te) == len(ye) <= max(2 * columns, 1)
    assert ye.min() == y.min()
    assert ye.max() == y.max()
    assert (np.diff(te) >= 0).all()
    if len(y) > 2 * columns:
        for k, start in enumerate(te[::2]):
            end = te[2 * k + 2] if 2 * k + 2 < len(te) else np.inf
            here = y[(t >= start) & (t < end)]
            assert (ye[2 * k], ye[2 * k + 1]) == (here.min(), here.max())


def test_envelope_passes_over_missing_values():
    y = np.full(1000, np.nan)
    y[500] = 3.0
    assert np.nanmax(envelope(np.arange(1000.0), y, 10)[1]) == 3.0


@given(st.integers(1, 40))
def test_short_series_are_not_touched(n):
    t, _ = envelope(np.arange(float(n)), np.ones(n), 20)
    assert len(t) == n


def test_the_time_taken_grows_no_faster_than_the_number_of_points():
    points = circle(1_000_000, 10)
    with bounded_time():
        screen_path(points)


def turns(count, drift=0.0, points=240):
    angle = np.linspace(0.0, 2 * np.pi * count, int(count * points) + 1)
    radius = 1.0 + drift * angle / (2 * np.pi)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def length(path):
    return np.nansum(np.linalg.norm(np.diff(path, axis=0), axis=1))


def test_an_orbit_that_repeats_itself_is_painted_once():
    once, often = (screen_path(turns(count)) for count in (1.0, 10.3))
    assert length(often) == pytest.approx(length(once), rel=0.02)
    assert not np.isnan(often).any(), "in one piece, of which dashes are dashes"


def test_turns_that_can_be_told_apart_are_all_painted():
    spiral = turns(10, drift=5 * 2.0 / RESOLUTION)
    assert length(screen_path(spiral)) == pytest.approx(length(spiral), rel=0.02)


@pytest.mark.parametrize("drift", [0.0, 0.3, 1.0, 3.0])
def test_what_is_left_out_lies_beside_what_is_painted(drift):
    given = turns(12, drift=drift * 2.0 / RESOLUTION)
    path, pixel = screen_path(given), np.ptp(given, axis=0).max() / RESOLUTION
    a, b = path[:-1], path[1:]
    for point in given[::37]:
        share = ((point - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-300)
        away = np.linalg.norm(a + share.clip(0.0, 1.0)[:, None] * (b - a) - point, axis=1)
        assert np.nanmin(away) < 3 * pixel


@pytest.mark.parametrize("points", [24, 240, 40_000])
def test_what_is_painted_first_does_not_depend_on_how_finely_a_path_is_divided(points):
    path = turns(3.5, points=points)
    new = painted_first(path, 2.0 / RESOLUTION)
    assert new[: points - points // 100].all(), "a path does not repeat the piece that leads to it"
    assert not new[points + 1 :].any()


def test_a_curve_across_a_large_picture_takes_room_for_itself_alone():
    t = np.linspace(0.0, 40.0, 4000)
    path, pixel = np.column_stack([np.cos(t), np.sin(t)]) * np.exp(t / 10.0)[:, None], 0.03
    pixels = np.prod(np.ptp(path, axis=0) / pixel)
    assert pixels < MOST_CELLS
    painted_first(path[:10], pixel)  # compiled
    tracemalloc.start()
    new = painted_first(path, pixel)
    room = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert new.all()
    assert room < pixels, f"{room:,} bytes for {pixels:,.0f} pixels of 4 bytes"


def test_curves_that_cross_stay_whole():
    cross = np.array([[-1.0, -1.0], [1.0, 1.0], [np.nan, np.nan], [-1.0, 1.0], [1.0, -1.0]])
    assert length(screen_path(cross)) == pytest.approx(length(cross))
