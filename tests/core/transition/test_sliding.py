"""Sliding along the surface: Filippov's field, entered and left in time, with no loss of order."""

from functools import cache

import numpy as np
import pytest

import core
from core import Status
from tests.core.sliding_solutions import friction, relay
from tests.levels import QUICK_METHODS, deep_but

EPS = 2.0**-52

LOADED = "((y {} mu - load/(1 - w**2)*cos(w*t))**2 + (v + load*w/(1 - w**2)*sin(w*t))**2)/2"
BLOCK = core.PiecewiseSystem(
    name="Block under a load", variables=("y", "v"), g="v", x0=(3.0, -0.1),
    f_minus=("v", "-y + mu + load*cos(w*t)"), f_plus=("v", "-y - mu + load*cos(w*t)"),
    psi_minus=(LOADED.format("-"),), psi_plus=(LOADED.format("+"),), parameters={"mu": 0.4, "load": 0.6, "w": 0.5},
)  # fmt: skip
RELAY = core.PiecewiseSystem(
    name="Relay", variables=("x", "y", "z"), g="x - 0.2*y + z", x0=(0.5, 0.0, 0.3),
    f_minus=("y", "z", "-x - 2*y - 1.5*z + 1"), f_plus=("y", "z", "-x - 2*y - 1.5*z - 1"),
)  # fmt: skip
#: Before, along and after sliding.
INSTANTS = {"block": (3.3, 8.5, 17.0), "relay": (0.5, 2.5, 8.0)}
#: Step sizes by the order expected: above round-off, and so short that the leading term of the error rules.
STEPS = {1: 0.1 / 2.0 ** np.arange(6, 10), 2: 0.1 / 2.0 ** np.arange(5, 9), 3: 0.1 / 2.0 ** np.arange(2, 6),
         4: 0.02 / 2.0 ** (np.arange(4) / 2), 6: 0.25 / 2.0 ** (np.arange(4) / 3),
         8: 0.35 / 2.0 ** (np.arange(4) / 4)}  # fmt: skip
#: Deviation of slopes allowed: of order 8 the window between the leading term and round-off is half an octave.
SLACK = {1: 0.1, 2: 0.1, 3: 0.1, 4: 0.1, 6: 0.25, 8: 0.6}


@cache
def exact(name):
    end = INSTANTS[name][-1]
    return friction("3", "-0.1", end, "0.4", "0.6", "0.5") if name == "block" else relay(("0.5", "0", "0.3"), end)


def errors(name, method, **settings):
    """Errors of the states before, along and after sliding, and of the instants of all crossings."""
    system, solution, instants = {"block": BLOCK, "relay": RELAY}[name], exact(name), INSTANTS[name]
    run = core.integrate(
        system, (0.0, instants[-1]), method=method, sliding="continue", t_eval=instants[:-1], **settings
    )  # fmt: skip
    assert run.status is Status.COMPLETED, run.message
    assert run.crossings.kind.tolist() == solution.kinds
    states = [np.abs(run.at(t) - solution.state(t, system.dimension)).max() for t in instants]
    return np.array([*states, np.abs(run.crossings.t - solution.times).max()])


CASES = [("block", m, p) for m in core.METHODS for p in (None, 1, 2, 3) if p is None or not core.METHODS[m].adaptive]
CASES += [("relay", m, p) for _, m, p in CASES if not core.METHODS[m].needs_conserved]
QUICK = [("block", m, None) for m in QUICK_METHODS] + [
    ("block", "dmm2", 1),
    ("block", "dmm4", 3),
    ("relay", "rk4", None),
]


@pytest.mark.parametrize(("name", "method", "p"), deep_but(QUICK, CASES))
def test_order_is_kept_into_along_and_out_of_sliding(name, method, p):
    if core.METHODS[method].adaptive:
        found = np.array([errors(name, method, tolerance=tolerance) for tolerance in (1e-6, 1e-9, 1e-12)])
        assert (found < 100 * np.array([[1e-6], [1e-9], [1e-12]])).all()
        return
    order = core.METHODS[method].order if p is None else min(core.METHODS[method].order, p)
    found = np.array([errors(name, method, tau=tau, perturbation_order=p) for tau in STEPS[order]])
    for k in range(1 if p is not None and p < core.METHODS[method].order else 0, found.shape[1]):
        slope = np.polyfit(np.log(STEPS[order]), np.log(found[:, k]), 1)[0]
        assert abs(slope - order) < SLACK[order], (k, slope, found)


def test_the_exact_solutions_of_this_file_are_those_of_scipy():
    from scipy.integrate import solve_ivp

    solution = exact("block")
    (_, _, _, _), (t0, z0, side, kind), (t1, z1, *_) = solution.arcs[:3]
    assert (kind, side) == ("transversal", 1)
    x0, x1 = (np.array([float(v) for v in z[:2]]) for z in (z0, z1))
    found = solve_ivp(lambda t, x: BLOCK.field(side, t, x), (float(t0), float(t1)), x0, rtol=1e-12, atol=1e-13)
    assert np.abs(found.y[:, -1] - x1).max() < 1e-10
    assert abs(x1[1]) < 1e-20


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, core.METHODS))
def test_the_state_stays_on_the_surface_while_it_slides(method):
    # Both circle about the axis; below is a push upward, above one downward, so that the sphere attracts everywhere.
    system = core.PiecewiseSystem(
        name="Sphere", variables=("x", "y", "z"), g="x**2 + y**2 + z**2 - 1", x0=(0.5, 0.2, 0.3),
        f_minus=("-y + x", "x + y", "z - 0.3*sin(t)"), f_plus=("-y - x", "x - y", "-z - 0.3*sin(t)"),
        psi_minus=(), psi_plus=(),
    )  # fmt: skip
    if core.METHODS[method].needs_conserved:
        system = _with_a_kept_quantity()
    steps = 2000 if core.METHODS[method].adaptive else 20000
    run = core.integrate(system, (0.0, 0.05 * steps), tau=0.05, method=method, sliding="continue")
    assert run.status is Status.COMPLETED, run.message
    slid = run.mode == 2
    assert slid.sum() > 0.9 * len(slid)
    drift = np.abs(system.switching(run.t, run.x))[slid].max()
    # A conservative method corrects g at each step to what rounding leaves: of 3 coordinates of size 1, and of the time
    # by which the plane moves at 0.2.
    assert drift < (8 * EPS + 0.2 * EPS * run.t[-1] if core.METHODS[method].conservative else 0.1)


def _with_a_kept_quantity():
    """Turned about an axis on both sides of a moving plane: the distance from the axis is kept by sliding, too."""
    return core.PiecewiseSystem(
        name="Turntable", variables=("x", "y", "z"), g="z - 0.2*sin(t)", x0=(0.6, 0.3, -0.5),
        f_minus=("-y", "x", "1 + x/4"), f_plus=("-y", "x", "-1 + y/4"), psi_minus=("x**2 + y**2",),
        psi_plus=("x**2 + y**2",),
    )  # fmt: skip


@pytest.mark.parametrize("method", ["dmm2", "prk8", "taylor"])
def test_what_both_sides_keep_sliding_keeps(method):
    system = _with_a_kept_quantity()
    assert [str(u) for u in system.modes[2].conserved] == ["x**2 + y**2", "z - sin(t)/5"]
    run = core.integrate(system, (0.0, 60.0), tau=0.1, method=method, sliding="continue")
    assert run.crossings.kind.tolist() == ["sliding"]
    error = run.conserved_error()
    assert error.shape[1] == 2
    slid = run.mode == 2
    assert np.abs(error[slid]).max() < 4 * EPS + 0.2 * EPS * run.t[-1]  # the plane moves at 0.2
    assert np.isnan(error[~slid, 1]).all(), "off the surface there is one quantity"
    assert np.abs(run.x[:, 0] ** 2 + run.x[:, 1] ** 2 - 0.45).max() < 4 * EPS


def test_the_field_of_sliding_keeps_g_and_is_a_convex_combination():
    rng = np.random.default_rng(7)
    for system in (BLOCK, RELAY, _with_a_kept_quantity()):
        x, t = rng.normal(size=(40, system.dimension)), rng.uniform(0, 9, 40)
        sliding = system.modes[2]
        below, above = (system.switching_rate(side, t, x) for side in (-1, 1))
        part = (below / (below - above))[:, None]
        wanted = (1 - part) * system.field(-1, t, x) + part * system.field(1, t, x)
        found = system.laws.evaluate("f_s", sliding.field, t, x, system.parameter_array)
        assert np.allclose(found, wanted, rtol=1e-12, atol=1e-12)
        rate = system.laws.evaluate("rate of g", (sliding.rate_of(system.laws.g),), t, x, system.parameter_array)
        assert np.abs(rate).max() < 1e-12


def test_a_run_stops_where_it_would_slide_unless_it_is_asked_to_continue():
    stopped = core.integrate("coulomb_friction", (0.0, 40.0))
    assert stopped.status is Status.SLIDING
    assert 'sliding="continue"' in stopped.message
    slid = core.integrate("coulomb_friction", (0.0, 40.0), sliding="continue")
    assert slid.status is Status.COMPLETED
    assert slid.crossings.kind[-1] == "sliding"
    assert slid.crossings.side[-1] == 0
    assert slid.crossings.mode[-1] == 2
    assert len(slid.crossings.passed) == len(slid.crossings) == len(stopped.crossings)
    assert np.array_equal(slid.crossings.t, stopped.crossings.t)
    assert np.array_equal(slid.x[slid.mode == 2], np.repeat(slid.x[-1:], (slid.mode == 2).sum(), axis=0)), "it sticks"
    with pytest.raises(ValueError, match="'slide': choose from stop, continue"):
        core.integrate("coulomb_friction", (0.0, 1.0), sliding="slide")


def test_a_run_is_the_same_whether_its_mode_of_sliding_is_compiled_before_or_during_it(monkeypatch):
    settings = {"tau": 0.05, "method": "dmm2", "sliding": "continue", "envelope": 40}
    first = core.integrate(BLOCK, (0.0, 17.0), **settings)
    again = core.integrate(BLOCK, (0.0, 17.0), **settings)
    for name in ("t", "x", "mode", "segment", "envelope"):
        assert np.array_equal(getattr(first, name), getattr(again, name), equal_nan=True), name
    assert first.steps == again.steps
    assert first.evaluations == again.evaluations


def test_states_between_steps_are_found_along_sliding(draws):
    run = core.integrate(BLOCK, (0.0, 17.0), tau=0.05, method="prk8", sliding="continue")
    t = np.linspace(0.0, 17.0, 400)
    wanted = np.array([exact("block").state(s, 2) for s in t])
    assert np.abs(run.at(t) - wanted).max() < 1e-11
    sampled = core.integrate(BLOCK, (0.0, 17.0), tau=0.05, method="prk8", sliding="continue", t_eval=t, record="end")
    assert np.array_equal(sampled.at(t), run.at(t))


def test_backward_in_time_what_repels_attracts():
    repelling = core.PiecewiseSystem(
        name="Watershed", variables=("x", "y"), f_minus=("1", "-1"), f_plus=("2", "1"), g="y", x0=(0.0, 0.5)
    )
    run = core.integrate(repelling, (0.0, -3.0), method="rk4", tau=0.1, sliding="continue")
    assert run.crossings.kind.tolist() == ["sliding"]
    assert run.x[-1] == pytest.approx([-1.0 - 2.5 * 1.5, 0.0], abs=1e-12)


def test_a_start_on_the_surface_slides_at_once():
    run = core.integrate(RELAY, (0.0, 3.0), x0=(0.1, 0.0, -0.1), method="rk4", tau=0.01, sliding="continue")
    assert (run.mode == 2).all()
    assert run.crossing_count == 0
    stopped = core.integrate(RELAY, (0.0, 3.0), x0=(0.1, 0.0, -0.1), method="rk4", tau=0.01)
    assert stopped.status is Status.SLIDING
    assert stopped.mode.tolist() == [-1]


def test_where_both_fields_turn_at_once_the_run_stops_and_says_so():
    # On y = 0 the rates are ±(1 − x), so both vanish at x = 1, where the sliding state arrives at t = 1.
    two_fold = core.PiecewiseSystem(
        name="Two folds", variables=("x", "y"), f_minus=("1", "1 - x"), f_plus=("1", "x - 1"), g="y", x0=(0.0, 0.0)
    )
    run = core.integrate(two_fold, (0.0, 3.0), method="rk4", tau=0.03, sliding="continue")
    assert run.status is Status.GRAZING
    assert run.t[-1] == pytest.approx(1.0, abs=1e-7)
    assert "sliding ends where" in run.message


def test_a_jump_leaves_no_sliding():
    reset = core.PiecewiseSystem(
        name="Reset", variables=("x", "y"), f_minus=("1", "1"), f_plus=("1", "-1"), g="y", jump=("x/2", "y"), x0=(0, 1)
    )
    run = core.integrate(reset, (0.0, 3.0), sliding="continue", method="rk4")
    assert run.status is Status.SLIDING
    assert "jump does not slide" in run.message


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4", "taylor"])
def test_a_surface_that_ceases_to_attract_all_at_once_ends_the_run(method):
    # x' = −cos t sign x: at t = π/2 both rates change their signs, and the surface repels.
    system = core.PiecewiseSystem(
        name="Tide", variables=("x",), f_minus=("cos(t)",), f_plus=("-cos(t)",), g="x", x0=(-0.5,)
    )
    run = core.integrate(system, (0.0, 3.0), tau=0.01, method=method, sliding="continue")
    assert run.status is Status.GRAZING
    assert run.t[-1] == pytest.approx(np.pi / 2, abs=1e-6)
    assert run.crossings.kind.tolist() == ["sliding", "grazing"]


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
@pytest.mark.parametrize("apart", [sign * 10.0**-k for k in (1, 3, 6, 10, 12) for sign in (1, -1)])
def test_of_two_fields_that_turn_shortly_after_each_other_the_first_is_followed(method, apart):
    # Along y = 0 the rates are 1 − x and −(1 + apart − x), and x = t.
    system = core.PiecewiseSystem(
        name="Nearly two folds", variables=("x", "y"), f_minus=("1", "1 - x"), f_plus=("1", "-(1 + apart - x)"), g="y",
        parameters={"apart": apart}, x0=(0.0, 0.0),
    )  # fmt: skip
    run = core.integrate(system, (0.0, 2.0), tau=0.03, method=method, sliding="continue")
    assert run.status is Status.COMPLETED, run.message
    assert run.crossings.kind.tolist() == ["leaving"]
    left = min(1.0, 1.0 + apart)
    assert run.crossings.t[0] == pytest.approx(left, abs=1e-14)
    assert run.x[-1, 1] == pytest.approx(-np.sign(apart) * (2.0 - left) ** 2 / 2, abs=1e-10)


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
@pytest.mark.parametrize("tau", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("d", [1e-1, 1e-2, 1e-3])
def test_a_state_that_leaves_and_soon_returns_does_both(method, tau, d):
    # The rate above is −(y − 1 − d)(y − 1 − 2d), and y = t: up at 1 + d, and back where its integral vanishes.
    system = core.PiecewiseSystem(
        name="Hop", variables=("x", "y"), f_minus=("1", "1"), f_plus=("-(y - 1 - d)*(y - 1 - 2*d)", "1"), g="x",
        parameters={"d": d}, x0=(-1.0, 0.0),
    )  # fmt: skip
    run = core.integrate(system, (0.0, 2.0), tau=tau, method=method, sliding="continue")
    assert run.status is Status.COMPLETED, run.message
    assert run.crossings.kind.tolist() == ["sliding", "leaving", "sliding"]
    assert run.crossings.t == pytest.approx([1.0, 1.0 + d, 1.0 + 2.5 * d], abs=1e-9)


def test_what_only_the_rates_show_is_warned_of():
    # The rate above turns for 1/6 of time; the field of sliding, (0, 1), gives the series no reason for short steps.
    system = core.PiecewiseSystem(
        name="Gust", variables=("x", "y"), f_minus=("1", "1"), f_plus=("-1 + 2*exp(-100*(y - 5)**2)", "1"), g="x",
        x0=(-0.5, 0.0),
    )  # fmt: skip
    run = core.integrate(system, (0.0, 20.0), method="taylor", sliding="continue")
    assert len(run.crossings) == 3 or "may have been missed" in run.message


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4"])
@pytest.mark.parametrize("power", [3, 5])
def test_a_field_that_turns_infinitely_slowly_ends_the_run(method, power):
    system = core.PiecewiseSystem(
        name="Slow turn", variables=("x", "y"), f_minus=(f"y**{power}", "-1"), f_plus=("-1", "-1"), g="x", x0=(0.0, 2.0)
    )
    run = core.integrate(system, (0.0, 3.0), tau=0.01, method=method, sliding="continue")
    assert run.status is Status.GRAZING
    assert run.t[-1] == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_slide_that_ends_at_the_end_of_a_step_is_left_from_there(method):
    # The rate of the left field is k − t, and x = −(t − k)²/2 from t = k on, which many steps of 0.01 meet.
    system = core.PiecewiseSystem(
        "falls off", ("x", "y"), ("k - t", "1"), ("-1", "1"), "x", parameters={"k": 1.1}, x0=(-0.5, 0.0)
    )
    for k in np.arange(110, 200, 3) / 100:
        run = core.integrate(system.with_parameters(k=k), (0.0, 4.0), tau=0.01, method=method, sliding="continue")
        assert run.status is Status.COMPLETED, run.message
        assert run.crossings.kind.tolist() == ["sliding", "leaving"]
        assert run.x[-1, 0] == pytest.approx(-((4.0 - k) ** 2) / 2, abs=1e-12)


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
def test_fields_that_are_0_over_0_on_the_surface_slide_by_their_limits(method):
    u = "(x + 0.77*y - 0.68)"

    def slide(quotient: str) -> core.Trajectory:
        system = core.PiecewiseSystem("0/0", ("x", "y"), (f"y + {quotient}", "-x"), ("y", f"-x - {quotient}"), u)
        settings = {} if method == "taylor" else {"tau": 0.01}
        return core.integrate(system, (0.0, 3.0), (0.418, 0.915), method=method, sliding="continue", **settings)

    run, limit = slide(f"sin({u})/{u}"), slide("1")
    assert run.crossings.kind.tolist() == limit.crossings.kind.tolist() == ["sliding", "leaving"], run.message
    assert run.crossings.x[1] == pytest.approx(limit.crossings.x[1], abs=1e-12)  # where a rate vanishes on the line
