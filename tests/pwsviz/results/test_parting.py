"""Runs part where their crossings cease to correspond, and the page says so."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

import core
from pwsviz.figures.portrait_text import parted_words
from pwsviz.results.parting import parting
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene


def runs(system, t_end, tau, *methods):
    return {method: core.integrate(core.CATALOGUE[system], (0.0, t_end), tau=tau, method=method) for method in methods}


def test_a_run_out_of_step_parts_where_its_crossing_is_nearer_to_another():
    found = runs("harmonic_oscillator", 100.0, 0.2, "dmm2", "rk2")
    one, other = (run.crossings.t for run in found.values())
    (method, t), *more = parting(found).parted
    assert (parting(found).agreeing, method, more) == ("dmm2", "rk2", [])
    k = int(np.flatnonzero(np.minimum(one[: len(other)], other[: len(one)]) == t)[0])
    late = abs(one - other[: len(one)])
    gaps = np.minimum(np.diff(one), np.diff(other[: len(one)]))
    assert late[k] > min(gaps[k - 1 : k + 1]) / 2
    assert all(late[j] <= min(gaps[j - 1 : j + 1]) / 2 for j in range(1, k))


def test_of_several_runs_all_are_held_against_that_which_agrees_longest():
    found = runs("three_bodies", 100.0, 0.01, "dmm2", "rk2", "rk8", "taylor")
    told = parting(found)
    assert told.agreeing in ("rk8", "taylor")
    assert {method for method, _ in told.parted} | {told.agreeing} == set(found)
    assert [t for _, t in told.parted] == sorted(t for _, t in told.parted)


def test_one_crossing_of_a_corner_is_two_in_quick_succession():
    corner = np.array([3.0, 7.0]), np.array([3, 0])
    surfaces = np.array([3.0 - 1e-13, 3.0, 7.0, 7.0 + 1e-13]), np.array([1, 3, 2, 0])
    touch = np.array([3.0, 5.0, 5.0 + 1e-6, 7.0]), np.array([3, 2, 3, 0])
    late = np.array([3.0, 9.5]), np.array([3, 0])
    runs = {name: as_run(*met) for name, met in zip("cstl", (corner, surfaces, touch, late), strict=True)}
    assert parting({name: runs[name] for name in "cst"}) is None
    assert parting({name: runs[name] for name in "cl"}).parted == (("l", 7.0),)


def as_run(t, mode):
    """A run from t = 0 to 10 with these crossings."""
    fields = {one.name: np.empty(len(t)) for one in dataclasses.fields(core.Crossings)}
    met = core.Crossings(**fields | {"t": t, "mode": mode, "kind": np.repeat("transversal", len(t))})
    return SimpleNamespace(t=np.array([0.0, 10.0]), mode=np.array([0, 0]), crossings=met)


@pytest.mark.parametrize("long", ["dmm2", "rk2"])
def test_runs_are_compared_up_to_the_end_of_the_shorter(long):
    ends = {method: 40.0 if method == long else 20.0 for method in ("dmm2", "rk2")}
    found = {method: runs("elliptic_curve", end, 0.01, method)[method] for method, end in ends.items()}
    assert parting(found) is None
    assert parting(found | {"rk4": runs("elliptic_curve", 0.1, 0.01, "rk4")["rk4"]}) is None, "none is met"


def test_runs_of_another_course_agree_up_to_where_they_part():
    ((_, t),) = parting(runs("chua", 100.0, 0.01, "rk4", "taylor")).parted
    assert parting(runs("chua", t - 1e-6, 0.01, "rk4", "taylor")) is None


@pytest.mark.parametrize(
    ("system", "t_end", "tau"),
    [("elliptic_curve", 20.0, 0.01), ("elliptic_curve", 20.0, 0.1), ("bouncing_ball", 20.0, 0.05)],
)
def test_a_crossing_beyond_the_end_of_one_run_and_bounces_that_accumulate_part_no_runs(system, t_end, tau):
    assert parting(runs(system, t_end, tau, "dmm2", "taylor")) is None


def test_the_page_says_from_when_on_two_runs_cannot_both_be_right():
    scene = Scene()
    scene.system = "chua"
    scene.methods, scene.t_end = ["rk4", "taylor"], 100.0
    told = parted_words(Results().pictures(PortraitInputs.of(scene)))
    assert "the crossings of taylor and rk4 do not correspond: the two no longer follow the same" in told
    scene.t_end = 10.0
    assert parted_words(Results().pictures(PortraitInputs.of(scene))) == ""
