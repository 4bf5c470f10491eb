"""The four vector fields of the paper's fig:vftypes, against their closed forms."""

import itertools
import math

import numpy as np
import pytest

import core
from core import Status

UPWARD, DOWNWARD, REPELLING, SLIDING = (
    core.CATALOGUE[f"type_{name}"] for name in ("upward", "downward", "repelling", "sliding")
)
EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    ("system", "below", "above"), [(UPWARD, 1, 1), (DOWNWARD, -1, -1), (REPELLING, -1, 1), (SLIDING, 1, -1)]
)
def test_all_of_the_surface_is_of_its_type_at_every_setting(system, below, above):
    line = np.column_stack([np.linspace(-5, 5, 21), np.zeros(21)])
    for values in itertools.product(*(q.bounds for q in system.parameters)):
        at = system.with_parameters(**dict(zip(system.values, values, strict=True)))
        assert (below * at.switching_rate(-1, 0.0, line) > 0).all()
        assert (above * at.switching_rate(1, 0.0, line) > 0).all()


@pytest.mark.parametrize("system", [UPWARD, DOWNWARD])
def test_transversal_types_cross_once_and_bend_there(system):
    run = core.integrate(system, (0.0, 50.0))
    place = math.sin(4) / 2  # y = ∓2 ± t/10 vanishes at t = 20; x ∓ sin(2y)/2 is kept
    assert run.status is Status.COMPLETED
    assert run.crossings.t == pytest.approx([20.0], abs=1e-13)
    assert run.crossings.x[0] == pytest.approx((place, 0.0), abs=4 * EPS)
    way = 30.0 * 0.05  # beyond: along a parabola
    assert abs(run.x[-1, 1]) == pytest.approx(way, abs=1e-13)
    assert run.x[-1, 0] == pytest.approx(place + way**2 / 2 - way, abs=1e-13)


def test_beside_a_repelling_surface_a_trajectory_leaves():
    run = core.integrate(REPELLING, (0.0, 50.0))
    y = 0.1 + 50.0 * 0.05
    assert run.status is Status.COMPLETED
    assert run.x[-1] == pytest.approx(((math.sin(2 * y) - math.sin(0.2)) / 2, y), abs=1e-13)
    assert len(run.crossings) == 0


def test_on_a_repelling_surface_a_run_stops_at_once():
    run = core.integrate(REPELLING, (0.0, 50.0), x0=(0.3, 0.0))
    assert (run.status, run.t.tolist(), run.steps) == (Status.REPELLING, [0.0], 0)


@pytest.mark.parametrize("y", [2.0, -2.0])
def test_a_sliding_surface_is_reached_from_either_side_and_ends_the_run(y):
    run = core.integrate(SLIDING, (0.0, 50.0), x0=(0.0, y))
    assert run.status is Status.SLIDING
    assert run.t[-1] == pytest.approx(20.0, abs=1e-13)
    assert run.x[-1] == pytest.approx((math.sin(4) / 2, 0.0), abs=4 * EPS)
    assert run.crossings.kind.tolist() == ["sliding"]


def test_back_in_time_repelling_and_sliding_change_places():
    back = core.integrate(REPELLING, (0.0, -50.0))
    assert back.status is Status.SLIDING
    assert back.t[-1] == pytest.approx(-2.0, abs=1e-14)  # from y = 0.1 at speed 0.05
    assert core.integrate(SLIDING, (0.0, -50.0), x0=(0.3, 0.0)).status is Status.REPELLING
