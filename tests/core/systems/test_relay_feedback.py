"""Relay feedback, against its closed form between switches: constant push and drag linear in the speed."""

import math

import numpy as np

import core
from core import Status
from tests.core.systems.arcs import crossings

RELAY = core.CATALOGUE["relay_feedback"]
FORCE, DRAG, LEAD = 1.0, 0.05, 0.15


def flow(side, s, state):
    x, v = state
    steady = -side * FORCE / DRAG
    fading = (v - steady) * -math.expm1(-DRAG * s)
    return np.array([x + steady * s + fading / DRAG, v - fading])


def height(_, state):
    return state[0] + LEAD * state[1]


def test_the_relay_switches_when_the_closed_form_says_and_then_slides():
    run = core.integrate(RELAY, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    t, x = crossings(flow, height, RELAY.x0, 1, 8)
    assert run.status is Status.SLIDING
    assert len(run.crossings) == 8
    # tau**4; the closed form itself cancels by DRAG**-2 = 400 eps.
    assert np.abs(run.crossings.t - t).max() < 1e-12
    assert np.abs(run.crossings.x - x).max() < 1e-12


def test_the_relay_slides_where_both_pushes_point_to_the_line():
    run = core.integrate(RELAY, (0.0, 50.0), tau=1e-2, method="rk4")
    v = run.crossings.x[:, 1]
    # g' = v + LEAD (∓F - cv) has both signs where |v| (1 - c LEAD) < F LEAD.
    sliding = np.abs(v) * (1 - DRAG * LEAD) < FORCE * LEAD
    assert sliding.tolist() == [False] * 7 + [True]
    assert run.crossings.kind.tolist() == ["transversal"] * 7 + ["sliding"]
    assert run.t[-1] == run.crossings.t[-1]
