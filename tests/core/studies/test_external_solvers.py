"""SciPy and heyoka on declared systems: against closed forms."""

import math
import sys

import numpy as np
import pytest

import core
from core.studies.external_solvers import EXTERNAL_SOLVERS, Arcs, ScalarFunctions, Stopped, external_arcs

HARMONIC, BALL = core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["bouncing_ball"]


@pytest.fixture(params=list(EXTERNAL_SOLVERS))
def solver(request):
    if request.param == "heyoka":
        pytest.importorskip("heyoka", reason="heyoka is an optional external solver, and is not installed")
    return EXTERNAL_SOLVERS[request.param]


def solve(solver, system, end, x0=None, t0=0.0, tolerance=1e-12, most=1000, check=lambda: None, record=False):
    start, functions = np.array(system.x0 if x0 is None else x0, dtype=float), ScalarFunctions(system)
    return external_arcs(functions, solver.prepare(functions, tolerance, 1.0), t0, end, start, most, check, record)


def test_each_side_turns_at_its_own_rate(solver):
    # x'' = -w**2 x with w**2 = 1 above y = 0 and 3 below: a turn takes pi + pi/sqrt(3), and leads back to the start.
    turn = math.pi * (1 + 1 / math.sqrt(3))
    arcs = solve(solver, HARMONIC, 5 * turn, (1.0, 1.0), record=True)
    assert arcs.side == [1, -1] * 5 + [1]
    assert arcs.left[-1][0] == 5 * turn
    assert arcs.left[-1][1] == pytest.approx([1.0, 1.0], abs=1e-9)
    # From (1, 1) at angle pi/4, clockwise: y = 0 after pi/4, then after pi/sqrt(3), pi, ...
    first = math.pi / 4
    expected = [first, first + math.pi / math.sqrt(3), first + turn]
    assert [t for t, _ in arcs.left[:3]] == pytest.approx(expected, abs=1e-9)
    assert arcs.change_of_psi(HARMONIC) < 1e-9


def test_parameters_are_those_of_the_system(solver):
    slow = HARMONIC.with_parameters(omega2_minus=1.0)
    assert solve(solver, slow, 2 * math.pi, (1.0, 1.0)).left[-1][1] == pytest.approx([1.0, 1.0], abs=1e-9)


def test_a_ball_bounces_at_the_times_of_the_geometric_series(solver):
    gravity, restitution = BALL.values["gravity"], BALL.values["restitution"]
    fall = math.sqrt(2 / gravity)  # from height 1
    impacts = fall * (1 + 2 * np.cumsum([0.0, *(restitution**k for k in range(1, 6))]))
    arcs = solve(solver, BALL, (impacts[4] + impacts[5]) / 2)
    assert [t for t, _ in arcs.left[:-1]] == pytest.approx(impacts[:5], abs=1e-9)
    assert set(arcs.side) == {1}
    speed = math.sqrt(2 * gravity)
    assert arcs.entered[1][1] == pytest.approx([0.0, restitution * speed], abs=1e-9)


def test_a_jump_that_stays_on_the_surface_but_for_round_off_is_on_it(solver):
    f = ("v", "-10")  # from height 5: impacts after 1, 2, 2.5, 2.75, ... at half the speed each
    ball = core.PiecewiseSystem("ball", ("y", "v"), f, f, "y", x0=(5.0, 0.0), jump=("y", "-v/2"))
    arcs = solve(solver, ball, 2.6)
    assert arcs.side == [1, 1, 1, 1]
    assert [t for t, _ in arcs.left[:3]] == pytest.approx([1.0, 2.0, 2.5], abs=1e-9)


def test_a_surface_that_moves_is_met_where_it_is(solver):
    # x = t meets x = 1 + t/2 at t = 2, and goes on at a rate of 3/4.
    moving = core.PiecewiseSystem("chase", ("x",), ("1",), ("3/4",), "x - 1 - t/2", x0=(0.0,))
    arcs = solve(solver, moving, 4.0)
    assert arcs.side == [-1, 1]
    assert arcs.left[0][0] == pytest.approx(2.0, abs=1e-12)
    assert arcs.left[1][1] == pytest.approx([3.5], abs=1e-12)


def test_a_sliding_motion_is_given_up_and_not_followed(solver):
    facing = core.PiecewiseSystem("facing", ("x",), ("1",), ("-1",), "x - 1", x0=(0.0,))
    with pytest.raises(Stopped, match="more than 50 crossings, up to t = 1"):
        solve(solver, facing, 4.0, most=50)


def test_functions_and_constants_of_expressions_are_known(solver):
    f = ("y", "-sin(x)*pi/3 + 0*exp(-x**2)*sqrt(2 + x)/e")
    system = core.PiecewiseSystem("pendulum", ("x", "y"), f, f, "x", x0=(0.5, 0.0))
    arcs = solve(solver, system, 10.0)
    # energy y**2/2 - (pi/3) cos x, which it is not told
    energy = [x[1] ** 2 / 2 - math.pi / 3 * math.cos(x[0]) for _, x in (arcs.entered[0], arcs.left[-1])]
    assert energy[1] == pytest.approx(energy[0], abs=1e-9)
    assert arcs.crossings == 3  # a quarter period is about 1.56


def test_a_start_on_the_surface_goes_where_the_fields_lead(solver):
    arcs = solve(solver, HARMONIC, 1.0, (-1.0, 0.0))  # y' = -w**2 x > 0
    assert arcs.side == [1]
    assert arcs.left[-1][1] == pytest.approx([-math.cos(1.0), math.sin(1.0)], abs=1e-10)


def test_more_crossings_than_there_should_be_are_given_up(solver):
    with pytest.raises(Stopped, match="more than 3 crossings"):
        solve(solver, HARMONIC, 100.0, most=3)


def test_a_run_is_given_up_when_it_is_told_to(solver):
    def check():
        raise Stopped("enough")

    f = ("y", "-x")
    apart = core.PiecewiseSystem("far", ("x", "y"), f, f, "x - 100", x0=(1.0, 0.0))
    with pytest.raises(Stopped, match="enough"):
        solve(solver, apart, 1e6, check=check)


def test_a_pole_ends_a_run_with_a_reason(solver):
    f = ("x**2",)  # 1/(1 - t)
    with pytest.raises(Stopped, match=r"stops at t = (1|0\.99)"):
        solve(solver, core.PiecewiseSystem("pole", ("x",), f, f, "x", x0=(1.0,)), 2.0)


def test_a_field_that_is_undefined_beyond_the_surface_ends_a_run_with_a_reason():
    system = core.PiecewiseSystem("edge", ("x",), ("1",), ("log(1 - x)",), "x - 1", x0=(0.0,))
    with pytest.raises(Stopped, match=r"undefined at t = 1\b"):
        solve(EXTERNAL_SOLVERS["scipy"], system, 2.0)


def test_a_surface_that_is_left_and_met_again_in_one_step_is_met_where_it_is_met_again():
    f = ("v", "100", "0")  # z, which rests, is large: SciPy's first step is longer than the 0.002 below y = 0
    system = core.PiecewiseSystem("dip", ("y", "v", "z"), f, f, "y", x0=(0.0, -0.1, 1e3))
    arcs = solve(EXTERNAL_SOLVERS["scipy"], system, 1.0, tolerance=1e-3)
    assert [t for t, _ in arcs.left[:-1]] == pytest.approx([0.002], abs=1e-9)


@pytest.mark.parametrize("root", ["sqrt(x)", "x**1.5"])  # of a negative number: an error, and a complex number
def test_trial_steps_out_of_the_domain_are_taken_back(root):
    # Nothing happens until t = 5, so steps are long; then x is drawn to 1, and a long step would lead far below 0.
    f = (f"-50*(1 + tanh(20*(t - 5)))*(x - 1)*{root}",)
    system = core.PiecewiseSystem("late", ("x",), f, f, "x - 3", x0=(2.0,))
    assert solve(EXTERNAL_SOLVERS["scipy"], system, 6.0, tolerance=1e-6).left[-1][1] == pytest.approx([1.0], abs=1e-5)


def test_without_heyoka_the_reason_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)
    with pytest.raises(Stopped, match="heyoka is not installed"):
        EXTERNAL_SOLVERS["heyoka"].prepare(ScalarFunctions(HARMONIC), 1e-9, 1.0)


def test_the_change_of_psi_adds_up_over_visits_forgets_jumps_between_them_and_sees_every_state():
    # psi = (w**2 x**2 + y**2)/2: 0.5 -> 2 -> 1, then 2 -> 4.5 after another 0.5
    def at(y):
        return 0.0, np.array([0.0, y])

    arcs = Arcs([1, -1], [at(1.0), at(2.0)], [at(2**0.5), at(3.0)], seen=[[at(2.0), at(2**0.5)], [at(3.0)]])
    assert arcs.change_of_psi(HARMONIC) == pytest.approx(3.0, abs=1e-15)
    assert Arcs([1], arcs.entered[:1], arcs.left[:1], seen=arcs.seen[:1]).change_of_psi(HARMONIC) == 1.5
    assert math.isnan(arcs.change_of_psi(core.CATALOGUE["gene_switch"]))


def test_of_several_surfaces_one_on_which_it_begins_is_left_to_where_the_field_leads(solver):
    regions = {a + b: core.Region((f"{b}1", "1")) for a in "+-" for b in "+-"}
    wave = core.PiecewiseSystem("wave", ("x", "y"), surfaces=("y - 1/2", "-sin(t)"), regions=regions, x0=(0.0, 0.0))
    arcs = solve(solver, wave, 4.0)
    assert [t for t, _ in arcs.left] == pytest.approx([0.5, math.pi, 4.0])
    assert arcs.left[-1][1] == pytest.approx([4.0 - 2 * math.pi, 4.0])
