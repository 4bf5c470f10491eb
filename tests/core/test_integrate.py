"""integrate(): contract, oracles and honest stops."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status

OSCILLATOR, ELLIPTIC = core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["elliptic_curve"]
EPS = np.finfo(float).eps

# reference_values: closed forms, not of this project's making
OSCILLATOR_T = np.cumsum([math.pi / 4, *([math.pi / math.sqrt(3), math.pi] * 20)])
T_IN, T_OUT, T_1 = 0.64180734567849246, 1.25168416780647347, 0.97519090872044963
ELLIPTIC_T = np.cumsum([T_1, *([T_IN, T_OUT] * 30)])
X_STAR = (-0.44504186791262880857780512899, 0.89550976309855955275748939745)


def one_law(name="one law", f=("y", "-x"), g="x-2", psi=("x**2+y**2",), **more):
    """A system with the same law on both sides."""
    return core.PiecewiseSystem(name, ("x", "y"), f, f, g, psi, psi, **more)


# The paper's two systems ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("system", "levels", "bound"),
    [(OSCILLATOR, {1: 1.0, -1: 3.0}, 16), (ELLIPTIC, {1: 0.0, -1: X_STAR[0]}, 16)],
    ids=["oscillator", "elliptic"],
)
def test_dmm2_keeps_the_exact_level_of_each_side_to_round_off(system, levels, bound):
    # Evaluating psi rounds by about 2 eps of its largest term (3 for both systems), landing on S by as much again.
    run = core.integrate(system, (0.0, 100.0), tau=1e-3)
    for side, level in levels.items():
        psi = system.conserved(side, run.t[run.side == side], run.x[run.side == side])
        assert np.abs(psi - level).max() <= bound * EPS * 3


@pytest.mark.parametrize("system", [OSCILLATOR, ELLIPTIC], ids=["oscillator", "elliptic"])
@pytest.mark.parametrize("method", [m.name for m in core.METHODS.values() if m.conservative])
def test_every_conservative_method_keeps_psi_across_crossings(system, method):
    # Within each visit of a side: a few eps for the evaluation of psi (terms up to 3), one for each of the additions.
    error = core.integrate(system, (0.0, 60.0), tau=0.05, method=method).conserved_error()
    assert np.nanmax(np.abs(error)) <= 16 * EPS * 3


@pytest.mark.parametrize(("system", "least"), [(OSCILLATOR, 1e-9), (ELLIPTIC, 1e-8)], ids=["oscillator", "elliptic"])
def test_rk2_drifts_off_its_level_as_the_paper_shows(system, least):
    error = np.abs(core.integrate(system, (0.0, 100.0), tau=1e-3, method="rk2").conserved_error())
    assert least < np.nanmax(error) < 1e-5


def test_oscillator_crossing_times_converge_to_the_exact_ones():
    run = core.integrate(OSCILLATOR, (0.0, 80.0), tau=1e-2, method="rk4", record="crossings")
    exact = OSCILLATOR_T[OSCILLATOR_T < 80.0]
    assert len(run.crossings) == len(exact)
    assert np.abs(run.crossings.t - exact).max() < 1e-6  # tau**4 times a factor of 80


def test_elliptic_crossing_points_are_exact_whatever_the_step_size():
    # With d - 1 conserved quantities the orbit is exact: the error is in time only (paper, lem:geometricLemma).
    for tau in (1e-2, 1e-1, 0.3):
        x = core.integrate(ELLIPTIC, (0.0, 50.0), tau=tau).crossings.x
        expected = np.array([(X_STAR[0], X_STAR[1] * (1 if k % 2 == 0 else -1)) for k in range(len(x))])
        # Each landing rounds psi's level by an ulp or so: 40 of them, each worth at most 2 eps.
        assert len(x) > 20
        assert np.abs(x - expected).max() <= 80 * EPS


def test_rk4_agrees_with_scipy_restarted_at_the_crossing():
    inside = solve_ivp(lambda t, x: OSCILLATOR.field(1, t, x), (0, math.pi / 4), (1, 1), rtol=1e-12, atol=1e-12)
    after = solve_ivp(
        lambda t, x: OSCILLATOR.field(-1, t, x), (math.pi / 4, 2.0), inside.y[:, -1], rtol=1e-12, atol=1e-12
    )
    run = core.integrate(OSCILLATOR, (0.0, 2.0), tau=1e-3, method="rk4", record="end")
    assert np.abs(run.x[-1] - after.y[:, -1]).max() < 1e-10


def test_spiral_without_invariants_reaches_the_exact_end():
    system = core.PiecewiseSystem(
        "Spiral", ("x", "y"), ("x + w*y", "y - w*x"), ("x - w*y", "y + w*x"), "x**2 + y**2 - 1",
        parameters={"w": -2 * math.pi}, x0=(1 / math.e, 0.0),
    )  # fmt: skip
    run = core.integrate(system, (0.0, 1.7), tau=1e-3, method="rk4")
    radius, angle = math.exp(0.7), 2 * math.pi * 0.7
    assert run.crossings.t == pytest.approx([1.0], abs=1e-9)
    assert run.x[-1] == pytest.approx([radius * math.cos(angle), -radius * math.sin(angle)], abs=1e-8)


def test_moving_surface_is_met_where_it_is():
    system = one_law("moving", ("1", "0"), "x - sin(t)/2 - 1", ("y",), x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 3.0), tau=0.1, method="dmm2")
    assert len(run.crossings) == 1
    t = run.crossings.t[0]
    assert t - math.sin(t) / 2 - 1 == pytest.approx(0.0, abs=4 * EPS)


def square_wave(g, **more):
    """x' = −1 where g < 0 and +1 where g > 0, and y' = 0."""
    return core.PiecewiseSystem("square wave", ("x", "y"), ("-1", "0"), ("1", "0"), g, x0=(0.0, 0.0), **more)


@pytest.mark.parametrize("method", ["rk2", "rk8", "gauss4", "taylor", "dmm2"])
@pytest.mark.parametrize(("t0", "t1", "x"), [(0.0, 4.0, 2 * math.pi - 4), (0.0, -4.0, 2 * math.pi - 4), (1.0, 0.0, -1)])
def test_a_law_that_switches_at_instants_begins_on_the_side_ahead(method, t0, t1, x):
    run = core.integrate(square_wave("sin(t)"), (t0, t1), tau=0.3, method=method)
    assert run.status is Status.COMPLETED
    assert np.abs(run.crossings.t) == pytest.approx([math.pi] if abs(t1) == 4.0 else [0.0][: len(run.crossings)])
    assert run.x[-1] == pytest.approx([x, 0.0], abs=1e-14)


def test_a_kick_at_an_instant_changes_the_state_once_at_each():
    run = core.integrate(square_wave("sin(t)", jump=("x", "y + t")), (0.0, 7.0), tau=0.3, method="rk4")
    assert run.crossings.t == pytest.approx([math.pi, 2 * math.pi])
    assert run.x[-1, 1] == pytest.approx(3 * math.pi)


def test_an_instant_at_which_g_has_a_multiple_zero_is_told():
    run = core.integrate(square_wave("(t - 3)**3"), (0.0, 4.0), tau=0.3, method="rk4")
    assert (run.status, run.t[-1]) == (Status.GRAZING, pytest.approx(3.0))
    assert "Write g such that it has a simple zero on the surface" in run.message
    with pytest.raises(ValueError, match=r"t0 = 3\.0: g and its rate vanish then"):
        core.integrate(square_wave("(t - 3)**3"), (3.0, 4.0), method="rk4")


# Crossings -----------------------------------------------------------------------------------------------------------


def test_crossings_alternate_sides_and_lie_on_the_surface():
    run = core.integrate(ELLIPTIC, (0.0, 60.0), tau=1e-2)
    assert run.crossings.side.tolist() == [-1, 1] * (len(run.crossings) // 2) + [-1] * (len(run.crossings) % 2)
    assert np.abs(run.crossings.g).max() <= 4 * EPS  # the rounding of x**2 + y**2 - 1 itself
    assert set(run.crossings.kind) == {"transversal"}
    assert (run.crossings.rate_before * run.crossings.rate_after > 0).all()


@pytest.mark.parametrize("scale", [1.0, -1.0, 10.0])
def test_perturbed_crossing_time_is_moved_even_beyond_the_step(scale):
    tau = 1e-2
    plain = core.integrate(ELLIPTIC, (0.0, 3.0), tau=tau, max_crossings=1)
    moved = core.integrate(
        ELLIPTIC, (0.0, 3.0), tau=tau, max_crossings=1, perturbation_order=1, perturbation_scale=scale
    )
    assert moved.crossings.t[0] - plain.crossings.t[0] == pytest.approx(scale * tau, rel=1e-12)
    done = core.integrate(ELLIPTIC, (0.0, 3.0), tau=tau, perturbation_order=1, perturbation_scale=scale)
    assert (done.status, len(done.crossings)) == (Status.COMPLETED, 3)


@pytest.mark.parametrize("how", [{"perturbation_order": 1}, {"transition": "none"}, {}])
def test_the_place_where_the_scheme_met_the_surface_is_kept_beside_where_it_landed(how):
    run = core.integrate(ELLIPTIC, (0.0, 20.0), tau=1e-2, **how)
    g = np.abs(ELLIPTIC.switching(0.0, run.crossings.surface))
    # Stepped over: the chord of a step of length tau misses the curve by about tau**2.
    assert g.max() <= (1e-3 if "transition" in how else 4 * EPS)
    apart = np.abs(run.crossings.surface - run.crossings.x).max()
    assert apart > 1e-3 if how else apart == 0.0


@pytest.mark.parametrize("method", [m.name for m in core.METHODS.values() if m.symmetric])
def test_a_symmetric_method_undoes_its_steps_to_round_off(method):
    system = one_law(x0=(1.0, 0.5), g="x - 5")
    forward = core.integrate(system, (0.0, 64.0), tau=0.125, method=method)
    back = core.integrate(system, (64.0, 0.0), x0=forward.x[-1], tau=0.125, method=method)
    assert np.abs(back.x[-1] - (1.0, 0.5)).max() <= 32 * EPS  # two times 512 steps, their round-off compensated


# Stops ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("minus", "plus", "x0", "status"),
    [
        ("1", "-1", (-0.5, 0.0), Status.SLIDING),
        ("1", "-1", (0.0, 0.0), Status.SLIDING),
        ("-1", "1", (0.0, 0.0), Status.REPELLING),
        ("0", "0", (0.0, 0.0), Status.GRAZING),
        ("y", "y", (0.0, 0.0), Status.GRAZING),
    ],
)
def test_surfaces_that_cannot_be_crossed_are_reported_never_integrated_through(minus, plus, x0, status):
    system = core.PiecewiseSystem("wall", ("x", "y"), (minus, "0"), (plus, "0"), "x", x0=x0)
    for transition, beyond in (("mannshardt", 1e-12), ("none", 0.01)):  # without a transition, a step beyond
        run = core.integrate(system, (0.0, 5.0), tau=0.01, method="rk4", transition=transition)
        assert run.status is status
        assert run.x[-1] == pytest.approx([0.0, 0.0], abs=beyond)
        told = run.status.reason, run.status.advice
        rests = "where all fields vanish, and rests there", "start elsewhere"
        assert all(words in run.message for words in (rests if status is Status.GRAZING else told))


@pytest.mark.parametrize("scale", [None, 30.0, -30.0])
def test_coarse_steps_and_large_perturbations_do_not_look_like_sliding(scale):
    order = None if scale is None else 1
    transition = "none" if scale is None else "mannshardt"
    for tau in (0.1, 0.4, 0.7):
        run = core.integrate(OSCILLATOR, (0.0, 40.0), tau=tau, transition=transition,
                             perturbation_order=order, perturbation_scale=scale or 1.0)  # fmt: skip
        assert run.status is Status.COMPLETED


@pytest.mark.parametrize("method", list(core.METHODS))
def test_a_pole_is_an_escape_with_everything_before_it_kept(method):
    run = core.integrate(ELLIPTIC, (0.0, 10.0), x0=(2.0, 3.0), tau=1e-2, method=method)
    assert run.status is Status.ESCAPED
    assert np.isfinite(run.x).all()
    assert 0.6 < run.t[-1] < 0.9  # the pole is at 0.69


@pytest.mark.parametrize(("f", "t_end"), [(("y", "1"), 1e80), (("x + 1", "1"), 1e3)])
@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_a_solution_that_grows_without_a_pole_is_not_said_to_have_one(f, t_end, method):
    system = one_law("growing", f, "x - 1", (), x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, t_end), tau=None if method == "taylor" else t_end / 1e4, method=method)
    assert run.status is Status.ESCAPED
    assert "grows beyond 1e150" in run.message
    assert "pole there" not in run.message


def test_a_step_that_has_no_solution_is_no_convergence():
    system = one_law("stiff", ("y", "-sin(1000*x)*1000"), "x - 9", ("y**2/2 - cos(1000*x)",), x0=(1.0, 0.0))
    run = core.integrate(system, (0.0, 10.0), tau=5.0)
    assert run.status in (Status.NO_CONVERGENCE, Status.COMPLETED)
    assert np.isfinite(run.x).all()


def test_leaving_the_domain_of_the_field_is_reported():
    system = one_law("root", ("-1", "sqrt(x)"), "y - 9", (), x0=(1.0, 0.0))
    run = core.integrate(system, (0.0, 3.0), tau=0.1, method="rk4")
    assert run.status is Status.ESCAPED or run.status is Status.NO_CONVERGENCE
    assert run.t[-1] <= 1.0 + 1e-12
    assert np.isfinite(run.x).all()


def test_limits_stop_a_run_where_they_say():
    assert core.integrate(ELLIPTIC, (0, 10), tau=0.01, max_steps=50).steps == 50
    limited = core.integrate(ELLIPTIC, (0, 100), tau=0.01, max_crossings=5)
    assert (limited.status, len(limited.crossings)) == (Status.CROSSING_LIMIT, 5)
    assert limited.t[-1] == limited.crossings.t[-1]


def test_cancelling_keeps_what_was_computed():
    asked = []
    run = core.integrate(ELLIPTIC, (0, 1e4), tau=1e-3, cancel=lambda: asked.append(1) or len(asked) > 2)
    assert run.status is Status.CANCELLED
    assert 0 < run.steps < 10**6
    assert len(run.t) == run.steps + 1


# What is recorded ----------------------------------------------------------------------------------------------------


def test_records_agree_on_the_end_and_keep_what_they_promise():
    runs = {r: core.integrate(ELLIPTIC, (0, 20.005), tau=0.01, record=r) for r in ("steps", "crossings", "end")}
    assert [len(r.t) for r in runs.values()] == [2002, 2, 2]
    assert [len(r.crossings) for r in runs.values()] == [21, 21, 0]
    assert {r.crossing_count for r in runs.values()} == {21}
    for run in runs.values():
        assert run.t[0] == 0.0
        assert run.t[-1] == 20.005
        assert (run.x[-1] == runs["steps"].x[-1]).all()
        assert np.nanmax(np.abs(run.conserved_error())) < 16 * EPS


def test_steps_lie_on_the_grid_across_crossings():
    run = core.integrate(ELLIPTIC, (0.0, 5.0), tau=0.1)
    assert np.abs(run.t - np.arange(51) * 0.1).max() <= EPS * 5


def test_an_empty_time_span_is_the_initial_state():
    run = core.integrate(ELLIPTIC, (1.0, 1.0))
    assert (run.status, run.t.tolist(), run.steps) == (Status.COMPLETED, [1.0], 0)


# Arguments -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tau": 0.0}, "tau = 0.0"),
        ({"tau": -1e-3}, "positive"),
        ({"tau": math.nan}, "tau = nan"),
        ({"tau": "fast"}, "'fast'"),
        ({"method": "euler"}, "known are dmm2"),
        ({"transition": "jump"}, "mannshardt"),
        ({"record": "all"}, "'all'"),
        ({"x0": (1.0,)}, "2 needed"),
        ({"x0": (1.0, math.inf)}, "finite"),
        ({"t_span": (0.0, math.nan)}, "end time"),
        ({"t_span": 3.0}, "start and an end"),
        ({"perturbation_order": 0}, "perturbation_order"),
        ({"perturbation_scale": math.inf, "perturbation_order": 1}, "perturbation_scale"),
        ({"max_steps": 0}, "max_steps"),
        ({"max_crossings": 1.5}, "whole number"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_with_the_value(change, words):
    arguments = {"t_span": (0.0, 1.0), **change}
    with pytest.raises(ValueError, match=words.replace("(", r"\(")):
        core.integrate(ELLIPTIC, **arguments)


def test_conservative_methods_say_so_where_nothing_is_conserved():
    system = one_law("none", ("y", "-x - y/10"), psi=(), x0=(1.0, 0.0))
    with pytest.raises(ValueError, match="use one of rk2, rk4, rk8, gauss4, taylor"):
        core.integrate(system, (0.0, 1.0), method="dmm2")


@pytest.mark.parametrize(("name", "t_end"), [("elliptic_curve", 1200.0), ("coulomb_friction", 40.0)])
def test_the_end_alone_knows_where_its_segment_was_entered(name, t_end):
    # The one makes more crossings than a call of the loop holds; the other stops at its last.
    end, whole = (
        core.integrate(core.CATALOGUE[name], (0.0, t_end), method="prk8", tau=0.1, record=record)
        for record in ("end", "crossings")
    )
    assert end.status is whole.status
    assert end.crossing_count == len(whole.crossings) > 0
    assert end.entered_t[-1] == whole.entered_t[whole.segment[-1]]
    assert (end.entered_x[-1] == whole.entered_x[whole.segment[-1]]).all()


def test_progress_is_told_as_the_part_of_the_time_that_is_done():
    told = []
    core.integrate(ELLIPTIC, (0.0, 400.0), tau=1e-3, record="end", progress=told.append)
    assert told == sorted(told)
    assert len(told) == 4
    assert told[-1] == 1.0
    told.clear()
    core.integrate(ELLIPTIC, (10.0, 0.0), progress=told.append)
    assert told == [1.0]


@pytest.mark.parametrize("callback", ["progress", "cancel"])
def test_what_a_callback_raises_comes_out(callback):
    def fails(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        core.integrate(ELLIPTIC, (0.0, 10.0), **{callback: fails})


@pytest.mark.parametrize("method", ["dmm2", "prk8", "taylor"])
def test_a_method_that_keeps_psi_says_so_where_psi_is_not_defined(method):
    run = core.integrate("predator_prey", (0.0, 20.0), (0.0, 1.0), 0.05, method)
    assert run.status is Status.NO_CONVERGENCE
    assert "ψ is not defined here" in run.message
    assert core.integrate("predator_prey", (0.0, 20.0), (0.0, 1.0), 0.05, "rk2").status is Status.COMPLETED


def test_where_crossings_accumulate_a_speed_that_is_round_off_is_called_so_but_no_small_number_elsewhere():
    ball = core.integrate("bouncing_ball", (0.0, 20.0))
    assert ball.status is Status.ZENO
    assert "v = 0 up to rounding" in ball.message
    prey = core.integrate("predator_prey", (0.0, 5.0), (-1.0, 1.0), method="dmm2")
    assert 0.0 < prey.x[-1, 1] < 1e-16
    assert "to rounding" not in prey.message


def test_the_reason_of_a_run_is_a_clause_of_its_outcome():
    for system, start in (("bouncing_ball", None), ("type_sliding", None), ("predator_prey", (-1.0, 1.0))):
        run = core.integrate(system, (0.0, 40.0), start)
        assert f": {run.reason}. " in run.outcome


def thermostat(first="on", second="off"):
    """Two regions that overlap between x = −0.6 and 0.6, in either order; the field tells them apart."""
    laws = {"on": core.Region(f=("v", "-(x - 0.5)")), "off": core.Region(f=("v", "-(x + 0.5)"))}
    ways = (core.Transition("on", "x + 0.6", "off"), core.Transition("off", "0.6 - x", "on"))
    return core.PiecewiseSystem(
        "relay", ("x", "v"), regions={name: laws[name] for name in (first, second)}, transitions=ways, x0=(-0.5, 0.0)
    )


@pytest.mark.parametrize("method", ["rk8", "taylor"])
@pytest.mark.parametrize("names", [("on", "off"), ("off", "on")])
def test_a_run_begins_in_the_region_that_is_named(method, names):
    system = thermostat(*names)
    rests = core.integrate(system, (0.0, 5.0), method=method, region="off")
    assert rests.x == pytest.approx(np.array([-0.5, 0.0]) + 0 * rests.x)
    swings = core.integrate(system, (0.0, 1.0), method=method, region="on")
    assert swings.x[-1] == pytest.approx((0.5 - math.cos(1.0), math.sin(1.0)), abs=1e-12)
    assert not swings.warning
    both = core.ensemble(system, (0.0, 1.0), [(-0.5, 0.0)] * 2, method=method, region="on")
    assert np.array_equal(both.x, [swings.x[-1]] * 2)
    default = core.integrate(system, (0.0, 1.0), method=method)
    assert np.array_equal(default.x, core.integrate(system, (0.0, 1.0), method=method, region=names[0]).x)


def test_a_region_that_the_state_is_outside_of_is_refused():
    told = r"x0 = \(-0.7, 0.0\) is outside the region 'on', which ends where x \+ .* = 0: it is -0.1 there"
    with pytest.raises(ValueError, match=told):
        core.integrate(thermostat(), (0.0, 1.0), (-0.7, 0.0), method="rk8", region="on")
    with pytest.raises(ValueError, match=f"member 1: {told}"):
        core.ensemble(thermostat(), (0.0, 1.0), [(0.0, 0.0), (-0.7, 0.0)], method="rk8", region="on")


@pytest.mark.parametrize(
    ("system", "name", "told"),
    [(thermostat(), "hot", "one of on, off is needed"), (OSCILLATOR, "on", "its regions have no names")],
)
def test_an_unknown_region_is_refused(system, name, told):
    with pytest.raises(ValueError, match=told):
        core.integrate(system, (0.0, 1.0), region=name)
