"""Every method at hard crossings: grazing, several in a step, at its ends, sticking, accumulating."""

import math
from functools import cache

import numpy as np
import pytest

import core
from core import Status
from tests.levels import QUICK_METHODS, deep_but

EPS = np.finfo(float).eps
METHODS = list(core.METHODS)
CONSERVATIVE = [m.name for m in core.METHODS.values() if m.conservative]
both = pytest.mark.parametrize("direction", [1, -1], ids=["on", "back"])
every = pytest.mark.parametrize("method", deep_but(QUICK_METHODS, METHODS))


@cache
def one_law(f, g, psi, **parameters):
    """A system with the same law on both sides."""
    return core.PiecewiseSystem("one law", ("x", "y"), f, f, g, psi, psi, parameters)


def run_of(system, t_span, x0, method, tau, **more):
    """A run with steps of size tau, or of the method's own choice."""
    return core.integrate(system, t_span, x0, None if core.METHODS[method].adaptive else tau, method, **more)


# Grazing -------------------------------------------------------------------------------------------------------------

#: |R(0.3 i)| of the stability functions of rk4 and rk8 is 1 − 5e-6 and 1 − 2e-13: over 210 steps that is the change of
#: amplitude below which their own solutions no longer reach the surface. That of rk2 grows.
LEAST_DELTA = {"rk4": 1e-3, "rk8": 1e-10}


@every
@both
@pytest.mark.parametrize("delta", [10.0**-k for k in range(2, 15)])
def test_grazing_ladder_has_twenty_crossings_for_every_depth(method, direction, delta):
    if delta < 0.99 * LEAST_DELTA.get(method, 0.0):
        pytest.skip("the method's own solution shrinks by more")
    system = one_law(("y", "-x"), "x - c", ("x**2 + y**2",), c=0.5).with_parameters(c=1 - delta)
    run = run_of(system, (0.0, direction * 20 * math.pi), (0.0, 1.0), method, 0.3)
    assert (run.status, len(run.crossings)) == (Status.COMPLETED, 20)
    assert run.crossings.side.tolist() == [1, -1] * 10


# Several in a step ---------------------------------------------------------------------------------------------------

#: y = (t + 6)(t + 2)(t − 2) along the motion. rk2 is no method for it: its own solution has other roots.
CUBIC = (("1", "3*x**2 + 12*x - 4"), "y", ("y - (x + 6)*(x + 2)*(x - 2)",))


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, [m for m in METHODS if m != "rk2"]))
@pytest.mark.parametrize("span", [(-7.0, 3.0), (-6.5, 2.5), (-9.0, 2.125), (-6.75, 7.0)])
@both
def test_cubic_with_three_roots_in_one_step_has_all_three_in_order(method, span, direction):
    start, end = span[::direction]
    x0 = (start, (start + 6) * (start + 2) * (start - 2))
    run = run_of(one_law(*CUBIC), (start, end), x0, method, 100.0)
    assert run.status is Status.COMPLETED
    # y has values up to 700 in the step and a slope of 16 at the middle root.
    assert run.crossings.t == pytest.approx([-6.0, -2.0, 2.0][::direction], abs=64 * EPS * 700 / 16)
    assert run.crossings.side.tolist() == [direction, -direction, direction]
    assert core.METHODS[method].adaptive or run.steps == 1


@every
def test_many_crossings_in_few_steps_are_all_made(method):
    # Between two looks the height is taken for a cubic: taylor alone is told of five roots in one step.
    system = one_law(("1", "0"), "(x - 1)*(x - 1.5)*(x - 1.50001)*(x - 4)*(x - 7)", ("y",))
    run = run_of(system, (0.0, 8.0), (0.0, 0.5), method, 1.25)
    assert run.status is Status.COMPLETED
    # Near 1.5 the slope of g is 1e-5 of its terms: so many times larger is what their rounding does to the root.
    assert run.crossings.t == pytest.approx([1.0, 1.5, 1.50001, 4.0, 7.0], abs=16 * EPS)


@every
def test_crossings_in_long_steps_alternate_and_lie_on_the_surface(method):
    # A quarter turn a step: the scheme's own solution crosses, whatever it is worth.
    system = one_law(("y", "-x"), "y", ("x**2 + y**2",))
    run = run_of(system, (0.0, 60.0), (1.0, 1.0), method, 1.5)
    assert run.status is Status.COMPLETED
    assert (np.diff(run.crossings.t) > 0.5).all()
    assert (np.diff(run.crossings.side) != 0).all()
    # y is what is left of an increment of 1.5 |x|: its rounding, and that of the stages before it.
    assert (np.abs(run.crossings.g) <= 16 * EPS * 1.5 * np.abs(run.crossings.x[:, 0])).all()


@every
def test_a_crossing_near_the_origin_is_located_to_its_own_digits_however_far_the_start(method):
    # x = 1e6 exp(−t) meets 1e-6: what rounding does to g there has nothing to do with the start.
    system = one_law(("-x", "y"), "x - 0.000001", ("x*y",))
    run = run_of(system, (0.0, 30.0), (1e6, 1e-6), method, 0.3)
    assert len(run.crossings) == 1
    # Half an ulp of a time of 28 moves x by 1.8e-15 of itself, 8 eps; the same again for the state.
    assert abs(run.crossings.g[0]) <= 16 * EPS * 1e-6


@every
@pytest.mark.parametrize("rate", [1e-180, 1e-20, 1e20, 1e180])
def test_crossings_are_found_whatever_the_unit_of_time(method, rate):
    system = one_law(("k*y", "-k*x"), "y", ("x**2 + y**2",), k=1.0).with_parameters(k=rate)
    run = run_of(system, (0.0, 10 / rate), (1.0, 1.0), method, 0.01 / rate)
    assert run.status is Status.COMPLETED
    assert run.crossings.t * rate == pytest.approx([math.pi * (k + 0.25) for k in range(3)], abs=1e-3)


# At the ends of steps and runs ---------------------------------------------------------------------------------------


@every
@both
@pytest.mark.parametrize("tau", [0.25, 1.0])
def test_a_surface_met_exactly_at_a_steps_end_is_crossed_once(method, direction, tau):
    run = run_of(one_law(("1", "0"), "x - c", ("y",), c=1.0).with_parameters(c=direction), (0.0, 3.0 * direction),
                 (0.0, 0.0), method, tau)  # fmt: skip
    assert run.status is Status.COMPLETED
    assert run.crossings.t == pytest.approx([direction], abs=4 * EPS)
    assert run.side[-1] == direction


@every
@both
@pytest.mark.parametrize("tau", [0.25, 1.0, 2.0])
def test_a_run_that_ends_on_the_surface_completes_with_that_crossing(method, direction, tau):
    system = one_law(("1", "0"), "x - c", ("y",), c=1.0).with_parameters(c=direction)
    run = run_of(system, (0.0, direction), (0.0, 0.0), method, tau)
    assert (run.status, run.t[-1]) == (Status.COMPLETED, direction)
    if run.x[-1, 0] == direction:  # five steps of weights that sum to 1 but for round-off may end beside it
        assert run.crossings.t == pytest.approx([direction], abs=4 * EPS)
    again = run_of(system, (direction, 2.0 * direction), run.x[-1], method, tau)
    assert len(run.crossings) + len(again.crossings) == 1


@every
@both
def test_a_start_on_the_surface_takes_the_side_the_motion_leads_to(method, direction):
    system = one_law(("1", "0"), "x", ("y",))
    run = run_of(system, (0.0, direction), (0.0, 0.0), method, 0.25)
    assert (run.status, len(run.crossings)) == (Status.COMPLETED, 0)
    assert (run.side == direction).all()


@every
def test_a_start_and_an_end_on_the_surface_leave_what_is_between(method):
    if method == "rk2":
        pytest.skip("its own solution of the cubic has other roots")
    run = run_of(one_law(*CUBIC), (-6.0, 2.0), (-6.0, 0.0), method, 100.0)
    assert run.status is Status.COMPLETED
    assert run.side[0] == 1
    ends = [-2.0, 2.0] if len(run.crossings) == 2 else [-2.0]  # round-off decides whether the end is on S
    assert run.crossings.t == pytest.approx(ends, abs=64 * EPS * 45 / 16)


@pytest.mark.parametrize("name", ["harmonic_oscillator", "elliptic_curve", "pendulum"])
@every
@both
def test_a_restart_at_a_crossing_never_fires_it_again(name, method, direction):
    system = core.CATALOGUE[name]
    crossings = run_of(system, (0.0, 15.0), None, method, 0.03).crossings
    assert len(crossings) > 4
    for t, x, side in zip(crossings.t, crossings.x, crossings.side, strict=True):
        again = run_of(system, (t, t + 0.2 * direction), x, method, 0.03)
        assert (again.status, len(again.crossings)) == (Status.COMPLETED, 0)
        assert (again.side == direction * side).all()


@every
def test_time_running_back_meets_the_same_places(method):
    system = core.CATALOGUE["elliptic_curve"]
    on = run_of(system, (0.0, 10.0), None, method, 0.01)
    back = run_of(system, (10.0, 0.0), on.x[-1], method, 0.01)
    assert len(back.crossings) == len(on.crossings) == 10
    assert (back.crossings.side == -on.crossings.side[::-1]).all()
    # rk2's error constant; its places drift, and its times with them: (0.01)² times 10 crossings.
    bound = 1e-3 if core.METHODS[method].order == 2 else 1e-6
    assert np.abs(back.crossings.t[::-1] - on.crossings.t).max() < bound
    assert np.abs(back.x[-1] - on.x[0]).max() < 8 * bound  # |f| ≤ 5


# Stops ---------------------------------------------------------------------------------------------------------------


@every
def test_the_friction_block_sticks_at_four_pi(method):
    run = run_of(core.CATALOGUE["coulomb_friction"], (0.0, 20.0), (3.0, 0.0), method, 1e-2)
    assert (run.status, run.crossings.kind[-1]) == (Status.SLIDING, "sliding")
    order = core.METHODS[method].order or 8
    assert run.t[-1] == pytest.approx(4 * math.pi, abs=4e-4 if order == 2 else 2e-9 if order == 4 else 1e-11)
    places = pytest.approx([-2.2, 1.4, -0.6, -0.2], abs=16 * EPS * 3 if method in CONSERVATIVE else 1e-4)
    assert run.crossings.x[:, 0] == places


@every
@pytest.mark.parametrize(("restitution", "bounces"), [(0.5, 53), (0.9, 343), (0.99, 3587)])
def test_the_ball_stops_where_its_bounces_accumulate(method, restitution, bounces):
    height, gravity = 1.0, 9.8
    system = core.CATALOGUE["bouncing_ball"].with_parameters(restitution=restitution)
    fall = math.sqrt(2 * height / gravity)
    accumulation = fall + 2 * fall * restitution / (1 - restitution)
    run = run_of(system, (0.0, 2 * accumulation), (height, 0.0), method, 1e-2)
    assert run.status is Status.ZENO
    # Each bounce rounds the speed once, and all later gaps with it.
    assert run.t[-1] == pytest.approx(accumulation, rel=EPS * (8 + 0.1 / (1 - restitution) ** 1.0 * 6))
    # The gaps left sum to an eps of the time: e**n ≈ eps (1 − e) / 2 or so.
    assert run.crossing_count == pytest.approx(bounces, rel=0.05)


@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_crossings_at_the_ends_of_steps_but_for_rounding_end_no_run(method):
    """What is left of such a step is so short that rounding hides whether it leaves the surface."""
    system = core.PiecewiseSystem("clock", ("x", "z"), ("1", "0"), ("2", "0"), "sin(pi*t) + z", x0=(0.0, 0.0))
    for start in np.arange(0.5, 18.0, 1.85):
        for tau in (0.1, 0.05, 0.2, 0.125, 0.3):
            run = core.integrate(system, (start, start + 60.0), method=method, tau=tau)
            case = (start, tau, run.message)
            assert run.status is core.Status.COMPLETED, case
            assert run.crossings.t == pytest.approx(np.arange(math.ceil(start), start + 60.0), abs=1e-12), case
            if method == "taylor":
                break


#: Constant fields around a corner of three planes, towards which solutions spiral through all but two of its regions.
SPIRAL = {
    "+++": ("-8/5", "2/5", "3/10"), "++-": ("-7/10", "3/5", "1"), "+-+": ("17/10", "6/5", "1/5"),
    "+--": ("2/5", "4/5", "3/5"), "-++": ("-13/10", "-11/10", "-2/5"), "-+-": ("-1/2", "-7/5", "-9/10"),
    "--+": ("3/10", "-2/5", "-3/5"), "---": ("9/10", "-9/5", "-7/10"),
}  # fmt: skip


@pytest.mark.parametrize("record", ["steps", "end"])
@pytest.mark.parametrize("method", [*(m for m in METHODS if m not in CONSERVATIVE), "taylor"])
def test_a_spiral_into_a_corner_ends_where_its_crossings_accumulate(method, record):
    regions = {name: core.Region(f) for name, f in SPIRAL.items()}
    system = core.PiecewiseSystem("Spiral", ("x", "y", "z"), surfaces=("x", "y", "z"), regions=regions)
    run = core.integrate(system, (0.0, 20.0), (-15 / 97, -13 / 97, 29 / 97), method=method, tau=0.02, record=record)
    assert run.status is Status.ZENO, run.message
    assert run.t[-1] == pytest.approx(2.88662003, abs=1e-8)
    assert run.crossing_count < 1000
