"""diagnose(): the paper's constants against closed forms, and warnings where a step size is too large."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import core
from core.diagnostics import diagnose, diagnosis, encounters, step_warning
from core.diagnostics.scheme import Scheme
from tests.core import sample_systems as systems

OSCILLATOR, ELLIPTIC = core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["elliptic_curve"]
EPS = np.finfo(float).eps
X_STAR = np.array([-0.44504186791262880857780512899, 0.89550976309855955275748939745])  # reference_values
ROOT2 = math.sqrt(2)
ARRAYS = (
    "rate_minus", "rate_plus", "alpha2", "alpha_hat2", "M", "M_hat", "tau_minus", "tau_plus", "window", "window_hat",
)  # fmt: skip
#: Straight through the unit circle: in at x = -0.8, out at x = 0.8.
LINE = core.PiecewiseSystem("line", ("x", "y"), ("1", "0"), ("1", "0"), "x**2 + y**2 - 1", ("y",), ("y",),
                            x0=(-2.0, 0.6))  # fmt: skip


def run_of(system, t_end, tau, **options):
    return core.integrate(system, (0.0, t_end), tau=tau, **{"record": "crossings", **options})


def slope(taus, errors):
    return np.polyfit(np.log(taus), np.log(errors), 1)[0]


# The constants, in closed form ---------------------------------------------------------------------------------------


def test_oscillator_has_the_transversality_worked_out_by_hand():
    # g = y: grad g . f = -omega2 x, and |x*| = sqrt(2) at every crossing.
    found = diagnose(run_of(OSCILLATOR, 20.0, 0.1))
    down = np.where(np.arange(len(found.alpha2)) % 2 == 0, -1, 1)
    assert found.rate_minus == pytest.approx(down * 3 * ROOT2, rel=64 * EPS)
    assert found.rate_plus == pytest.approx(down * ROOT2, rel=64 * EPS)  # a few roundings of x a crossing
    assert found.alpha2 == pytest.approx(ROOT2, rel=64 * EPS)
    assert found.alpha_S2 == found.alpha2.min()


def test_oscillator_has_the_second_rate_worked_out_by_hand():
    # y'' = -omega2 y with y = sqrt(2) omega sin(omega s) from the crossing on: largest at s = tau where omega2 = 3.
    # The arc is followed by four classical Runge-Kutta steps of tau/4: (omega tau/4)**4 = 4e-6 and less.
    tau, omega = 0.1, math.sqrt(3)
    found = diagnose(run_of(OSCILLATOR, 20.0, tau))
    second_rate = ROOT2 * omega**3 * math.sin(omega * tau) / 2
    assert found.M.tolist() == pytest.approx([second_rate] * len(found.M), rel=1e-6)
    assert found.window == pytest.approx(ROOT2 / second_rate, rel=1e-6)


def test_oscillator_has_the_discrete_transversality_of_the_implicit_midpoint():
    # The implicit midpoint turns by the Cayley transform: mean of y' over a step from (x*, 0) = omega2 x*/(1 + q),
    # q = omega2 tau**2/4; the least of both sides at omega2 = 1. g is linear, so M_hat = 0.
    found = diagnose(run_of(OSCILLATOR, 20.0, 0.3))
    assert found.alpha_hat2 == pytest.approx(ROOT2 / (1 + 0.3**2 / 4), rel=1e-12)  # solved to 1e-13
    assert (found.M_hat == 0.0).all()
    assert (found.window_hat == np.inf).all()


def test_oscillator_has_the_wellposedness_bounds_of_a_linear_field():
    # f_tau = A (x0 + x1)/2, ||A|| = max(1, omega2): delta/M -> 1/L2 = 2/||A|| as delta grows; at 256 the natural
    # length it is less by a factor of 1 + 1/256.
    found = diagnose(run_of(OSCILLATOR, 20.0, 0.1))
    coming, going = found.tau_minus * (1 + 1 / 256), found.tau_plus * (1 + 1 / 256)
    above = np.arange(len(coming)) % 2 == 0  # comes from y > 0
    assert coming == pytest.approx(np.where(above, 2.0, 2 / 3), rel=1e-8)
    assert going == pytest.approx(np.where(above, 2 / 3, 2.0), rel=1e-8)


def elliptic_rate(state, a):
    x, y = state
    return 2 * y * (2 * x + 3 * x**2 + a)


def elliptic_second_rate(state, a):
    """x'.H x' + grad g.x'' by hand, with x' = (2y, 3x^2 + a) and H = 2I."""
    x, y = state
    dx, dy = 2 * y, 3 * x**2 + a
    return 2 * (dx**2 + dy**2) + 2 * x * 2 * dy + 2 * y * 6 * x * dx


def test_elliptic_curve_has_the_rates_of_the_exact_crossing_point():
    found = diagnose(run_of(ELLIPTIC, 20.0, 0.01))
    inside, outside = (abs(elliptic_rate(X_STAR, a)) for a in (-3.0, -2.0))
    assert np.abs(found.rate_minus) == pytest.approx(inside, rel=256 * EPS)  # 13 landings, a few eps each
    assert np.abs(found.rate_plus) == pytest.approx(outside, rel=256 * EPS)
    assert found.alpha_S2 == pytest.approx(min(inside, outside), rel=256 * EPS)


@pytest.mark.parametrize("tau", [0.02, 0.2])
def test_elliptic_curve_has_the_second_rate_that_scipy_finds_along_the_arcs(tau):
    found = diagnose(run_of(ELLIPTIC, 2.0, tau))
    largest = 0.0
    for a, end in ((-2.0, -tau), (-3.0, tau)):  # into the circle

        def field(t, x, a=a):
            return 2 * x[1], 3 * x[0] ** 2 + a

        arc = solve_ivp(field, (0.0, end), X_STAR, "DOP853", np.linspace(0, end, 401), rtol=1e-12, atol=1e-12)
        largest = max(largest, np.abs(elliptic_second_rate(arc.y, a)).max() / 2)
    mine = found.M[0] if elliptic_rate(X_STAR, -2.0) < 0 else found.M[1]
    # The supremum over five points, of an arc followed with an error of (tau/4)**4.
    assert largest * (1 - tau**2) <= mine <= largest * (1 + tau**4)


def test_straight_flow_through_a_circle_has_a_window_that_is_exact():
    # g'' = 2 everywhere: M = 1, alpha**2 = 1.6, and it meets the circle again after just 1.6 = alpha**2/M.
    run = run_of(LINE, 4.0, 0.1)
    found = diagnose(run)
    assert np.diff(run.crossings.t) == pytest.approx([1.6], rel=8 * EPS)
    for name, value in {"alpha2": 1.6, "alpha_hat2": 1.6, "M": 1, "M_hat": 1, "window": 1.6, "window_hat": 1.6}.items():
        assert getattr(found, name) == pytest.approx([value, value], rel=16 * EPS), name
    assert (found.tau_plus == np.inf).all()  # a constant field: the step's equation has a solution at any tau


def test_moving_surface_counts_its_own_motion():
    # g = x - sin(t)/2 - 1 and x = t: g' = 1 - cos(t)/2, g'' = sin(t)/2.
    tau = 0.1
    system = core.PiecewiseSystem("moving", ("x", "y"), ("1", "0"), ("1", "0"), "x - sin(t)/2 - 1", ("y",), ("y",))
    found = diagnose(run_of(system, 3.0, tau))
    t_star = brentq(lambda t: t - math.sin(t) / 2 - 1, 1.0, 2.0, xtol=1e-15)
    assert found.alpha2 == pytest.approx([1 - math.cos(t_star) / 2], rel=16 * EPS)
    assert found.alpha_hat2 == pytest.approx(found.alpha2, rel=16 * EPS)
    # t* = 1.499: the largest sin(t)/4 is at pi/2, and one of the times looked at is within tau/4 of that.
    assert found.M.tolist() == pytest.approx([0.25], rel=(tau / 4) ** 2 / 2)
    assert found.M_hat == pytest.approx([0.25], rel=(tau / 4) ** 2 / 2)


def test_surface_that_mixes_time_and_state_has_all_its_second_derivatives():
    # x = e**t, y = e**-t: g = x y t + x - 3 is t + e**t - 3 along the flow, and g'' = e**t.
    tau = 0.05
    system = core.PiecewiseSystem("mixed", ("x", "y"), ("x", "-y"), ("x", "-y"), "x*y*t + x - 3", ("x*y",), ("x*y",),
                                  x0=(1.0, 1.0))  # fmt: skip
    found = diagnose(run_of(system, 2.0, tau, method="dmm8"))
    t_star = brentq(lambda t: t + math.exp(t) - 3, 0.0, 2.0, xtol=1e-15)
    assert found.alpha2 == pytest.approx([1 + math.exp(t_star)], rel=1e-10)  # dmm8 at this tau
    assert found.M.tolist() == pytest.approx([math.exp(t_star + tau) / 2], rel=1e-8)  # (tau/4)**4


def test_uniform_motion_has_discrete_constants_that_are_the_continuous_ones():
    # x = y = 1 + t: g = x y t + x - 3 has g' = 3 t**2 + 4 t + 2 and g'' = 6 t + 4, with every mixed derivative.
    tau = 0.05
    system = core.PiecewiseSystem("uniform", ("x", "y"), ("1", "1"), ("1", "1"), "x*y*t + x - 3", ("x - y",),
                                  ("x - y",), x0=(1.0, 1.0))  # fmt: skip
    found = diagnose(run_of(system, 2.0, tau))
    t_star = brentq(lambda t: (1 + t) ** 2 * t + t - 2, 0.0, 2.0, xtol=1e-15)
    rate, second_rate = 3 * t_star**2 + 4 * t_star + 2, 6 * (t_star + tau) + 4
    values = {"alpha2": rate, "alpha_hat2": rate, "M": second_rate / 2, "M_hat": second_rate / 2}
    for name, value in values.items():
        assert getattr(found, name) == pytest.approx([value], rel=32 * EPS), name


# The discrete field --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("system", systems.ALL, ids=lambda s: s.name)
def test_mean_velocity_is_the_increment_that_a_run_records(system):
    h = 0.02
    run = core.integrate(system, (0.0, h), tau=h)
    assert len(run.crossings) == 0
    start = run.x[:1]
    v = Scheme(system, "dmm2").velocity(int(run.mode[0]), np.zeros(1), start, np.array([h]))
    expected = (run.x[-1] - run.x[0]) / h
    # Solved to 1e-13; a difference of states loses eps/h of them.
    assert np.abs(v[0] - expected).max() <= 1e-13 * np.abs(expected).max() + 4 * EPS / h * np.abs(start).max()


@pytest.mark.parametrize("method", ["rk2", "rk4"])
def test_explicit_methods_have_their_own_velocity_and_no_equation_to_solve(method):
    h = 0.1
    run = core.integrate(ELLIPTIC, (0.0, h), tau=h, method=method)
    v = Scheme(ELLIPTIC, method).velocity(1, np.zeros(1), run.x[:1], np.array([h]))
    assert v[0] == pytest.approx((run.x[-1] - run.x[0]) / h, rel=64 * EPS)
    found = diagnose(run_of(ELLIPTIC, 5.0, h, method=method))
    assert (found.tau_minus == np.inf).all()
    assert (found.tau_plus == np.inf).all()


def test_recorded_steps_at_the_surface_keep_to_the_constants():
    run = core.integrate(ELLIPTIC, (0.0, 40.0), tau=0.05)
    found = diagnose(run)
    for k, (t, x) in enumerate(zip(run.crossings.t, run.crossings.x, strict=True)):
        row = np.searchsorted(run.t, t)
        for other in (row - 1, row):
            v = (run.x[other] - x) / (run.t[other] - t)
            assert abs(2 * x @ v) >= found.alpha_hat2[k] * (1 - 1e-9)
            assert v @ v <= found.M_hat[k] * (1 + 1e-9)  # H = 2I, and a half


def test_discrete_transversality_tends_to_the_continuous_one_with_the_length_of_the_step():
    # A step from the surface has the field's mean over its length: it differs by half of tau times grad g . x''.
    taus = np.array([0.01, 0.005, 0.0025])
    found = [diagnose(run_of(ELLIPTIC, 1.5, tau)) for tau in taus]
    assert slope(taus, [d.alpha_S2 - d.alpha_hat_S2 for d in found]) == pytest.approx(1.0, abs=0.1)
    x, y = X_STAR
    curvature = max(4 * y**2 + (3 * x**2 + a) ** 2 for a in (-3.0, -2.0))
    assert slope(taus, [d.M_hat[0] - curvature for d in found]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("method", ["dmm2", "rk2", "rk4"])
def test_discrete_transversality_tends_to_the_mean_over_an_exact_step_with_the_order_of_the_method(method):
    # From (sqrt(2), 0) where omega2 = 1, y falls by sqrt(2) sin(tau) in an exact step.
    taus = np.array([0.2, 0.1, 0.05])
    found = [diagnose(run_of(OSCILLATOR, 10.0, tau, method=method, perturbation_order=None)) for tau in taus]
    radius = [abs(d.rate_plus[0]) for d in found]  # rk2 and rk4 drift from sqrt(2)
    errors = [abs(d.alpha_hat2[0] - r * math.sin(h) / h) for d, r, h in zip(found, radius, taus, strict=True)]
    assert slope(taus, errors) == pytest.approx(core.METHODS[method].order, abs=0.1)


# Kinds of run --------------------------------------------------------------------------------------------------------


def test_what_is_recorded_does_not_matter():
    one, other = (diagnose(run_of(ELLIPTIC, 20.0, 0.1, record=record)) for record in ("steps", "crossings"))
    for name in ARRAYS:
        assert (getattr(one, name) == getattr(other, name)).all(), name
    assert (one.summary, one.warnings) == (other.summary, other.warnings)


def test_a_run_without_crossings_has_nothing_to_warn_of():
    found = diagnose(run_of(OSCILLATOR, 0.1, 0.01))
    assert all(getattr(found, name).shape == (0,) for name in ARRAYS)
    assert math.isnan(found.alpha_S2)
    assert math.isnan(found.alpha_hat_S2)
    assert (found.warnings, found.summary) == ((), "No crossings.")


def test_crossings_that_were_not_kept_are_counted():
    run = run_of(OSCILLATOR, 10.0, 0.01, record="end")
    found = diagnose(run)
    assert run.crossing_count > 0
    assert found.summary.startswith(f"{run.crossing_count} crossings, none kept")
    assert (len(found.alpha2), found.warnings) == (0, ())


def test_time_running_back_meets_the_same_constants():
    forth = core.integrate(ELLIPTIC, (0.0, 20.0), tau=0.01)
    back = core.integrate(ELLIPTIC, (20.0, 0.0), forth.x[-1], tau=0.01, record="crossings")
    one, other = diagnose(forth), diagnose(back)
    assert len(one.alpha2) == len(other.alpha2)
    for name in ("rate_minus", "rate_plus", "alpha2", "alpha_hat2", "M", "M_hat", "window", "window_hat"):
        # The orbit is exact; the steps of this symmetric scheme are the same ones, met from the other end.
        assert getattr(one, name) == pytest.approx(getattr(other, name)[::-1], rel=1e-10), name


def test_a_crossing_the_run_stopped_at_is_counted_apart():
    # Coulomb friction from y = 3: it turns at -2.2, 1.4 and -0.6, where |y''| is at least |y| - 0.4, and sticks.
    friction = core.PiecewiseSystem("friction", ("y", "v"), ("v", "-y + 0.4"), ("v", "-y - 0.4"), "v", x0=(3.0, 0.0))
    run = run_of(friction, 20.0, 0.01, method="rk4")
    found = diagnose(run)
    assert run.status is core.Status.SLIDING
    assert found.alpha2 == pytest.approx([1.8, 1.0, 0.2, math.nan], rel=1e-8, nan_ok=True)  # rk4 at this tau
    assert np.isnan(found.alpha_hat2[-1])
    assert np.isnan(found.window[-1])
    assert found.alpha_S2 == pytest.approx(0.2, rel=1e-6)
    assert "4 crossings (1 not transversal)" in found.summary
    assert np.isfinite(found.rate_minus).all()


def test_a_jump_arrives_at_one_speed_and_leaves_at_another():
    ball = core.PiecewiseSystem("ball", ("h", "v"), ("v", "-40"), ("v", "-10"), "h",
                                jump=("h", "-v/2"), x0=(5.0, 0.0))  # fmt: skip
    run = run_of(ball, 1.2, 0.01, method="rk4")
    found = diagnose(run)
    assert len(run.crossings) == 1
    assert found.alpha2 == pytest.approx([5.0], rel=1e-12)  # falls to v = -10, leaves at 5
    assert found.alpha_hat2 == pytest.approx([5.0 - 10 * 0.01 / 2], rel=1e-12)  # mean over a step of 0.01
    assert found.M.tolist() == pytest.approx([5.0], rel=1e-12)  # half of free fall's h'' = -10
    assert found.window == pytest.approx([1.0], rel=1e-12)  # up and down again at 5 takes 2 * 5 / 10


def test_a_jump_that_ends_the_run_is_no_crossing():
    clay = core.PiecewiseSystem("clay", ("h", "v"), ("v", "-10"), ("v", "-10"), "h", jump=("h", "0*v"), x0=(5.0, 0.0))
    run = run_of(clay, 3.0, 0.01, method="rk4")
    assert run.crossings.side.tolist() == [0]
    assert np.isnan(diagnose(run).alpha2).all()


def test_many_dimensions_and_crossings_are_worked_on_in_pieces(monkeypatch):
    run = run_of(systems.KEPLER, 60.0, 0.02)
    whole = diagnose(run)
    monkeypatch.setattr(diagnosis, "_CHUNK", 3 * 16)
    pieces = diagnose(run)
    assert len(run.crossings) > 6
    for name in ARRAYS:
        assert getattr(pieces, name) == pytest.approx(getattr(whole, name), rel=1e-12), name


# Warnings ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("system", [OSCILLATOR, ELLIPTIC], ids=["oscillator", "elliptic"])
def test_a_small_step_size_keeps_every_bound(system):
    run = run_of(system, 20.0, 0.01)
    assert diagnose(run).warnings == ()
    assert diagnose(run).summary.endswith("tau = 0.01 satisfies all bounds.")
    assert step_warning(run) == ""


def test_a_step_longer_than_the_window_is_warned_of():
    run = run_of(LINE, 6.0, 2.0)
    found = diagnose(run)
    assert found.warnings[0] == (
        "tau = 2 exceeds alpha^2/M = 1.6 at crossing 1 (t = 1.2, the worst of 2 crossings), below which the theory "
        "excludes a second crossing within a step; take tau below 1.6"
    )
    assert step_warning(run) == found.warnings[0] + "."
    assert "exceeds a bound" in found.summary


def test_a_step_beyond_the_wellposedness_bounds_is_warned_of():
    found = diagnose(run_of(OSCILLATOR, 20.0, 1.0))
    named = " ".join(found.warnings)
    assert "tau_-^*" in named
    assert "tau_+^*" in named
    assert "sufficient, not necessary" in named
    assert np.isnan(found.alpha_hat2).all()  # 3 tau/2 > 1: the map of the lemma does not contract where omega2 = 3


def test_a_step_that_breaks_the_discrete_transversality_is_warned_of():
    # Spiralling out of the unit circle, it turns by 2 in a step: so the whole step points back through the surface.
    field = ("x/2 - 2*y", "2*x + y/2")
    system = core.PiecewiseSystem("spiral", ("x", "y"), field, field, "x**2 + y**2 - 1", x0=(0.8, 0.0))
    found = diagnose(run_of(system, 3.0, 1.0, method="rk4"))
    assert found.alpha2 == pytest.approx([1.0], rel=16 * EPS)
    assert found.alpha_hat2[0] < 0
    assert found.window_hat.tolist() == [0.0]
    assert any(w.startswith("tau = 1 breaks the discrete transversality condition at") for w in found.warnings)


@pytest.mark.parametrize("angle", np.geomspace(0.1, 1.5, 12))  # that an oscillator turns by in a step
@pytest.mark.parametrize("method", ["rk2", "rk4"])
def test_a_step_that_changes_the_energy_by_some_percent_in_half_a_period_is_warned_of(method, angle):
    oscillator = core.CATALOGUE["harmonic_oscillator"].with_parameters(omega2_minus=1.0, omega2_plus=1.0)
    run = run_of(oscillator, 4.0, float(angle), x0=(1e-3, 1.0), method=method)
    change = abs(run.crossings.x[0] @ run.crossings.x[0] / (run.x[0] @ run.x[0]) - 1)
    assert change < 0.04 or "is too long for this field" in step_warning(run)


def test_every_constant_names_its_place_in_the_paper():
    tree = ast.parse(Path(diagnosis.__file__).read_text(encoding="utf-8"))
    labels = {}
    for cls in (node for node in tree.body if isinstance(node, ast.ClassDef)):
        for field, doc in zip(cls.body, cls.body[1:], strict=False):
            if isinstance(field, ast.AnnAssign) and isinstance(doc, ast.Expr):
                labels[field.target.id] = ast.literal_eval(doc.value)
    for name in (*ARRAYS, "alpha_S2", "alpha_hat_S2"):
        assert "eq:" in labels[name] or "lem:" in labels[name], name


def test_a_run_whose_crossings_accumulate_is_not_blamed_on_its_step():
    run = core.integrate(core.CATALOGUE["bouncing_ball"], (0.0, 3.0))
    assert run.status is core.Status.ZENO
    assert run.message == run.outcome


def test_a_region_without_crossings_costs_nothing():
    asked = []

    def ask(number, t):
        asked.append(number)
        return number * t

    t = np.array([1.0, 2.0])
    for regions in ([1, 1], [0, 0], [0, 1], [-1, 1], []):
        asked.clear()
        number = np.array(regions, dtype=int)
        found = encounters.by_number(number, ask, t[: len(regions)])
        assert found.tolist() == pytest.approx([math.nan if n < 0 else n * u for n, u in zip(regions, t, strict=False)],
                                               nan_ok=True)  # fmt: skip
        assert len(asked) == max(1, len(set(regions) - {-1}))


@pytest.mark.parametrize("method", ["rk4", "prk8", "dmm2"])
def test_a_bound_that_is_exceeded_is_no_warning_where_the_scheme_does_not_meet_the_surface_again(method):
    # The circle shrinks onto an orbit that turns by 0.1 in a step: the chord points back, but g is monotone.
    field, psi = ("y", "-x"), ("x**2 + y**2",)
    system = core.PiecewiseSystem("slow", ("x", "y"), field, field, "x**2 + y**2 - 1 - t/100", psi, psi, x0=(0.6, 0.9))
    run = core.integrate(system, (0.0, 30.0), tau=0.1, method=method)
    assert any("discrete transversality" in words for words in diagnose(run).warnings)
    assert step_warning(run) == ""


@pytest.mark.parametrize("rate", [1e-14, 1e-16, 1e-300])
def test_a_surface_that_is_left_so_slowly_that_no_digit_changes_is_not_said_to_be_met_again(rate):
    law = ("y", f"-{rate!r}*x")
    slow = core.PiecewiseSystem("slow", ("x", "y"), law, ("y", "-x"), "y + 0.2", x0=(1.0, 1.0))
    for method in ("rk4", "rk8", "gauss4"):
        run = core.integrate(slow, (0.0, 4.0), tau=0.02, method=method)
        assert (run.crossing_count, run.warning) == (1, "")
