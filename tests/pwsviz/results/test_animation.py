"""Frames are the integrator's own steps; landmarks say where and what each crossing is."""

import copy

import numpy as np
import pytest

import core
from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.polyline_reduction import RESOLUTION
from pwsviz.results.animation import FEW, frames, landmarks
from tests.pwsviz.own_systems import KICKED


@pytest.fixture(scope="module")
def run():
    return core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), tau=1e-2)


def test_few_steps_are_all_there_with_the_crossings(run):
    shown = frames(run, XY)
    steps = np.isin(shown.t, run.t)
    assert np.array_equal(shown.t[steps], run.t)
    assert np.array_equal(shown.places[steps], run.x)
    assert set(shown.t[~steps]) <= set(run.crossings.t)
    assert np.array_equal(shown.steps, run.t)
    assert np.array_equal(shown.met[0], run.crossings.t)
    assert shown.tally == (len(run.crossings), 0, 0, 0)
    assert shown.method == "dmm2"


@pytest.mark.parametrize("limit", [1, 2, 3, 7, 100, 1999, 2000])
def test_of_many_steps_every_kth_is_kept_and_both_ends(run, limit):
    shown = frames(run, XY, limit)
    if len(shown.steps) < min(FEW, limit):
        assert np.abs(run.at(shown.t) - shown.places).max() == 0.0, "states between few steps are the method's own"
        return
    at = np.searchsorted(run.t, shown.steps)
    assert len(shown.steps) <= limit + 1
    assert np.array_equal(run.t[at], shown.steps), "no time is made up"
    assert at[0] == 0
    assert at[-1] == len(run.t) - 1
    assert len(set(np.diff(at)[:-1])) <= 1
    given = dict(zip([*run.t, *run.crossings.t], [*run.x, *run.crossings.x], strict=True))
    assert set(shown.steps) <= set(shown.t)
    assert all(np.array_equal(given[t], place) for t, place in zip(shown.t, shown.places, strict=True))


def away_from_chords(run, shown):
    """Largest distance of states of a run from the line between the places before and after them, in pixels."""
    t = np.linspace(0.0, run.t[-1], 20_001)[1:-1]
    x, k = run.at(t), np.searchsorted(shown.t, t, side="right")
    a, b = shown.places[k - 1], shown.places[k]
    share = np.clip(((x - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-300), 0.0, 1.0)
    away = np.linalg.norm(a + share[:, None] * (b - a) - x, axis=1)
    return np.nanmax(away) * RESOLUTION / np.ptp(run.x, axis=0).max()


@pytest.mark.parametrize(("method", "t_end"), [("dmm2", 20.0), ("dmm2", 200.0), ("taylor", 100.0), ("dmm2", 1000.0)])
def test_the_lines_from_place_to_place_are_the_curve_or_are_said_not_to_be(method, t_end):
    tau = {"tau": 1e-2} if method == "dmm2" else {"tolerance": 1e-10}
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, t_end), method=method, **tau)
    shown = frames(run, XY)
    assert shown.traced == (t_end < 1000.0)
    assert (away_from_chords(run, shown) < 1.0) == shown.traced


def test_of_few_steps_states_between_them_are_shown_too():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), tau=1.0, method="taylor")
    shown = frames(run, XY)
    assert np.array_equal(shown.steps, run.t)
    assert set(run.t) <= set(shown.t)
    assert np.abs(np.diff(shown.places, axis=0)).max() < 0.1


def test_every_crossing_is_counted():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 3000.0), tau=1e-2, method="prk8")
    shown = frames(run, XY)
    assert len(shown.met[0]) == shown.tally.crossings == len(run.crossings) > 3000


def test_crossings_jumps_and_slides_are_counted_apart():
    slides = core.integrate(core.CATALOGUE["stick_slip"], (0.0, 40.0), tau=1e-2, method="rk4", sliding="continue")
    shown = frames(slides, XY)
    kinds = slides.crossings.kind
    for times, kind in zip(shown.met, ("transversal", "jump", "sliding"), strict=True):
        assert np.array_equal(times, slides.crossings.t[kinds == kind])
    assert shown.tally == tuple((kinds == kind).sum() for kind in ("transversal", "jump", "sliding", "leaving"))
    assert shown.tally.slides > 1
    jumps = core.integrate(core.CATALOGUE["bouncing_ball"], (0.0, 1.0), tau=1e-2, method="rk4")
    assert str(jumps.tally) == f"{len(jumps.crossings)} jumps"


def test_kicks_are_counted_as_the_jumps_that_their_marks_are():
    kicked = core.integrate(KICKED, (0.0, 4.5), tau=0.05, method="rk4")
    shown = frames(kicked, XY)
    assert shown.tally == (0, 4, 0, 0)
    assert [len(times) for times in shown.met] == [0, 4, 0]
    assert set(landmarks(kicked, XY).kinds) == {"jump"}


def test_the_plane_is_that_of_the_axes(run):
    assert np.array_equal(frames(run, Plane((1, 0))).places, frames(run, XY).places[:, ::-1])
    assert np.array_equal(landmarks(run, Plane((1, 0))).places, run.crossings.x[:, ::-1])


def test_states_that_are_not_finite_are_left_out(run):
    broken = copy.copy(run)
    vars(broken)["x"] = np.where(np.arange(len(run.t))[:, None] >= 50, np.nan, run.x)
    shown = frames(broken, XY)
    assert shown.t[-1] == run.t[49]
    assert np.isfinite(shown.places).all()


def test_a_bound_of_no_steps_is_refused(run):
    with pytest.raises(ValueError, match="limit = 0"):
        frames(run, XY, limit=0)


def test_landmarks_tell_every_crossing_also_where_one_hides_another(run):
    marks = landmarks(run, XY)
    assert len(marks.places) == len(marks.kinds) == 21
    assert np.allclose((marks.places**2).sum(axis=1), 1.0, atol=1e-12), "the surface is the unit circle"


def test_landmarks_name_jumps():
    ball = core.integrate(core.CATALOGUE["bouncing_ball"], (0.0, 1.0), tau=1e-2)
    assert landmarks(ball, XY).kinds[0] == "jump"


@pytest.mark.parametrize("tau", [0.3, 1e-2, 1e-4])
def test_a_jump_is_a_gap_between_its_two_ends(tau):
    ball = core.integrate(core.CATALOGUE["bouncing_ball"], (0.0, 1.2), tau=tau, method="rk4")
    shown = frames(ball, XY)
    gaps = np.flatnonzero(np.isnan(shown.places[:, 0]))
    assert len(gaps) == len(ball.crossings) == 3
    for met, ends in ((ball.crossings.x, gaps - 1), (ball.crossings.x_after, gaps + 1)):
        assert np.array_equal(shown.places[ends], met)
        assert np.array_equal(shown.t[ends], ball.crossings.t)
    at_impact = np.searchsorted(shown.t, ball.crossings.t, side="right") - 1
    assert np.isfinite(shown.places[at_impact]).all(), "the marker has a place at every time"
    speeds = np.abs(np.diff(shown.places[:, 1]))
    assert speeds[np.isfinite(speeds)].max() < 0.3, "no line leads across a jump"
