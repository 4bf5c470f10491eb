"""Crossings, jumps and slides are counted apart, and told in the same words everywhere."""

import numpy as np
import pytest

import core
from core.integration.tally import Tally, kinds_of
from core.studies.sequence import CrossingSequence


@pytest.mark.parametrize(
    ("tally", "words"),
    [
        (Tally(), "0 crossings"),
        (Tally(1), "1 crossing"),
        (Tally(2000, ends=1), "2,000 crossings"),
        (Tally(3, slides=2, ends=1), "3 crossings, 2 slides"),
        (Tally(jumps=1), "1 jump"),
        (Tally(0, 3, 1, 1), "3 jumps, 1 slide"),
    ],
)
def test_a_tally_names_what_there_is(tally, words):
    assert str(tally) == words


def test_a_difference_names_the_kinds_that_differ():
    assert Tally(7).difference(Tally(8)) == "7 crossings instead of 8"
    assert Tally(3, 0, 1, 1).difference(Tally(2, 0, 1, 0)) == "3 crossings instead of 2, 1 end of sliding instead of 0"
    assert Tally(1, 2, 3, 4).difference(Tally(1, 2, 3, 4)) == ""


def test_the_kind_of_a_meeting_follows_from_the_modes_before_and_after():
    modes = np.array([0, 1, 1, 2, 0, 2, 3, 1])  # of two regions; from 2 on it slides
    assert kinds_of(modes, 2).tolist() == [0, 1, 2, 3, 2, 2, 3]


@pytest.mark.parametrize("key", ["stick_slip", "bouncing_ball", "two_walls", "chua", "coulomb_friction"])
def test_a_run_is_counted_as_its_crossings_are_named(key):
    run = core.integrate(key, (0.0, 20.0), method="rk4", tau=1e-2, sliding="continue")
    kinds = run.crossings.passed.kind.tolist()
    named = {"transversal": 0, "jump": 1, "sliding": 2, "leaving": 3}
    assert run.tally == Tally(*(sum(named[kind] == k for kind in kinds) for k in range(4)))
    assert CrossingSequence.of(run).tally == run.tally


def test_the_map_of_stability_tells_slides_from_crossings_of_run_and_solution():
    options = {"methods": ("rk4",), "taus": (0.01, 0.02), "values": (1.0, 2.0), "parts": "map", "sliding": "continue"}
    found = core.stability_study("stick_slip", (0.0, 20.0), **options).map
    for column, value in enumerate(found.values):
        start = (float(value), *core.CATALOGUE["stick_slip"].x0[1:])
        run = core.integrate("stick_slip", (0.0, 20.0), start, method="taylor", sliding="continue")
        wanted = [(run.crossings.kind == kind).sum() for kind in ("transversal", "jump", "sliding", "leaving")]
        assert np.abs(found.expected_met[column] - wanted).max() <= 1  # judged a little before or after the end
    assert found.expected_met[:, 2].min() > 0
    right = found.works[0]
    assert (found.met[0][right] == np.broadcast_to(found.expected_met, found.met[0].shape)[right]).all()


def test_another_mode_and_another_time_are_told_by_kind_and_number():
    system = core.CATALOGUE["stick_slip"]
    one = CrossingSequence.labelled(system, [1.0, 2.0, 3.0], [1, -1, 0, -1])
    assert one.tally == (1, 0, 1, 1)
    other = CrossingSequence.labelled(system, [1.0, 2.0, 3.0], [1, -1, 1, -1])
    assert one.difference(other) == "at t = 2 it begins to slide, where the solution enters the side g > 0"
    late = CrossingSequence.labelled(system, [1.0, 2.6, 3.0], [1, -1, 0, -1])
    assert late.difference(one) == "slide 1 comes at t = 2.6, not 2, nearer to a different crossing of the reference"
    fewer = CrossingSequence.labelled(system, [1.0, 2.0], [1, -1, 0])
    assert fewer.difference(one) == "0 ends of sliding instead of 1"
