"""Predator and prey: against Lambert's W, SciPy with events, and a test problem of the literature."""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import lambertw

import core

PREDATORS = core.CATALOGUE["predator_prey"]
EPS = np.finfo(float).eps
THRESHOLD = 1.0


def scipy_crossings(count):
    """DOP853 restarted at the threshold; the side changes there."""
    a, b, d, c = 2.0, 2.0, 1.0, {-1: 1.0, 1: 0.6}
    t, x, side, found = 0.0, np.array(PREDATORS.x0), -1, []
    for _ in range(count):

        def field(_, u, c=c[side]):
            return u[0] * (a - b * u[1]), u[1] * (c * u[0] - d)

        def event(_, u):
            return u[0] - THRESHOLD

        event.terminal, event.direction = True, -side
        run = solve_ivp(field, (t, t + 10), x, "DOP853", events=event, rtol=1e-13, atol=1e-14)
        t, x, side = run.t_events[0][0], run.y_events[0][0], -side
        found.append((t, *x))
    return np.array(found)


def test_predators_and_prey_cross_when_scipy_says():
    run = core.integrate(PREDATORS, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    assert len(run.crossings) == 18
    peer = scipy_crossings(18)
    # tau**4 times a factor of 10, and SciPy's own 1e-13 a step.
    assert np.abs(run.crossings.t - peer[:, 0]).max() < 1e-11
    assert np.abs(run.crossings.x - peer[:, 1:]).max() < 1e-11


def test_predators_at_the_threshold_are_two_branches_of_lamberts_w():
    # b y - a log y has the same value at every crossing: b y = -a W(-(b/a) exp(-value/a)), with a = b = 2.
    c, d, (x, y) = 1.0, 1.0, PREDATORS.x0
    value = 2 * y - 2 * math.log(y) + c * (x - THRESHOLD) - d * math.log(x / THRESHOLD)
    low, high = (-lambertw(-math.exp(-value / 2), branch).real for branch in (0, -1))
    states = core.integrate(PREDATORS, (0.0, 50.0), tau=1e-2, record="crossings").crossings.x
    # The bound: 16 eps of levels with terms up to 4; dy/dlevel is about 1.
    assert np.abs(states[0::2, 1] - low).max() <= 16 * EPS * 4
    assert np.abs(states[1::2, 1] - high).max() <= 16 * EPS * 4


def test_predators_that_are_never_sated_reach_the_state_of_detest_b1():
    one = PREDATORS.with_parameters(c_plus=1.0)
    run = core.integrate(one, (0.0, 20.0), x0=(1.0, 3.0), tau=1e-3, method="rk4", record="end")
    # Problem B1 of Hull, Enright, Fellen, Sedgwick, SIAM J. Numer. Anal. 9 (1972); the value to 16 digits.
    assert np.abs(run.x[-1] - (0.6761876008576667, 0.1860816099640036)).max() < 1e-9
