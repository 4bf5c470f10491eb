"""diagnose() on systems with several surfaces, walls and hysteresis: against formulas by hand, and one surface."""

import math

import numpy as np
import pytest

import core
from core import PiecewiseSystem, Region, Transition
from core.diagnostics import diagnose
from tests.core.diagnostics.test_diagnostics import ARRAYS
from tests.levels import deep_but

ELLIPTIC = core.CATALOGUE["elliptic_curve"]
NAN = math.nan


def along(run):
    return diagnose(run), run.crossings


@pytest.mark.parametrize("number", [0, 1])
def test_a_second_surface_that_is_never_met_changes_no_number(number):
    # The same law on both sides of x = -50, which the orbit does not reach; the circle is surface 0 or 1.
    keys = ("--", "-+", "+-", "++")
    own = {"-": Region(ELLIPTIC.f_minus, ELLIPTIC.psi_minus), "+": Region(ELLIPTIC.f_plus, ELLIPTIC.psi_plus)}
    surfaces = ["x + 50", "x + 50"]
    surfaces[number] = ELLIPTIC.g
    wide = PiecewiseSystem("wide", ELLIPTIC.variables, surfaces=tuple(surfaces), x0=ELLIPTIC.x0,
                           regions={key: own[key[number]] for key in keys}, parameters=ELLIPTIC.parameters)  # fmt: skip
    one, other = (core.integrate(s, (0.0, 20.0), tau=0.2, record="crossings") for s in (ELLIPTIC, wide))
    assert set(other.crossings.surface_met.tolist()) == {number}
    assert diagnose(one).warnings
    for name in ARRAYS:
        assert getattr(diagnose(other), name).tolist() == pytest.approx(getattr(diagnose(one), name).tolist()), name
    assert (diagnose(other).warnings, diagnose(other).summary) == (diagnose(one).warnings, diagnose(one).summary)
    assert other.message == one.message


def test_each_surface_has_the_constants_of_the_regions_that_meet_there():
    # x' = 1, 2, 4 in the three strips of x = 0, 1 and y' = 1: of g = x + k (y - 5)**2, g' = x' + 2 k (y - 5).
    strips = PiecewiseSystem(
        "strips", ("x", "y"), surfaces=("x + (y - 5)**2", "x - 1"),
        regions={"--": Region(("1", "1")), "+-": Region(("2", "1")), "++": Region(("4", "1"))}, x0=(-5.0, 5.0),
    )  # fmt: skip
    run = core.integrate(strips, (0.0, 20.0), tau=0.01, method="rk4")
    found, met = along(run)
    assert met.surface_met.tolist() == [0, 1]
    above = (met.x[0, 1] - 5) * 2
    assert found.rate_minus == pytest.approx([1 + above, 2])
    assert found.rate_plus == pytest.approx([2 + above, 4])
    assert found.alpha2 == pytest.approx([1 + above, 2])
    assert pytest.approx([1, 0]) == found.M  # g'' = 2 y'**2
    assert found.M_hat == pytest.approx([1, 0])
    assert found.alpha_hat2 == pytest.approx([1 + above, 2])  # the fields are constant, and so are the steps
    assert found.window == pytest.approx([1 + above, np.inf])


def test_a_ball_between_two_walls_has_the_constants_of_free_fall_at_both():
    # It arrives at the ceiling h = 2 with v = 1 and leaves it with -1/2; at the floor v**2 is 1/4 + 8, and it leaves
    # with half of that speed.
    walls = PiecewiseSystem(
        "walls", ("h", "v"), surfaces=("h", "h - 2"), regions={"+-": Region(("v", "-2"), ("v**2/2 + 2*h",))},
        jumps={0: ("h", "-v/2"), 1: ("h", "-v/2")}, x0=(0.5, math.sqrt(7)),
    )  # fmt: skip
    found, met = along(core.integrate(walls, (0.0, 2.3), tau=0.001))
    fall = math.sqrt(8.25)
    assert met.surface_met.tolist() == [1, 0]
    assert found.rate_minus == pytest.approx([1, NAN], nan_ok=True)  # beyond the walls no law is declared
    assert found.rate_plus == pytest.approx([NAN, -fall], nan_ok=True)
    assert found.alpha2 == pytest.approx([0.5, fall / 2])
    assert found.alpha_hat2 == pytest.approx([0.5, fall / 2 - 0.001])
    assert pytest.approx([1, 1]) == found.M
    assert found.window == pytest.approx([0.5, fall / 2])


def test_a_relay_with_hysteresis_is_judged_by_how_it_arrives():
    # On: T' = 3 - T arrives at T = 1 with 2. Off: T' = -2 - T arrives at T = -1 with -1.
    relay = PiecewiseSystem(
        "relay", ("T",), regions={"on": Region(("3 - T",)), "off": Region(("-2 - T",))}, x0=(0.0,),
        transitions=(Transition("on", "1 - T", "off"), Transition("off", "T + 1", "on")),
    )  # fmt: skip
    tau = 0.01
    found, met = along(core.integrate(relay, (0.0, 3.0), tau=tau, method="rk4"))
    assert len(met) >= 2
    odd = np.arange(len(met)) % 2 == 1
    assert found.alpha2 == pytest.approx(np.where(odd, 1.0, 2.0))
    assert found.alpha_hat2 == pytest.approx(found.alpha2)  # farther back it is faster
    # T'' = -T': within tau before the surface the largest is T' e**tau.
    assert pytest.approx(np.where(odd, 0.5, 1.0) * math.exp(tau), rel=1e-9) == found.M
    assert (found.M_hat == 0.0).all()


def test_where_a_run_slides_or_stops_there_is_no_bound_for_that_branch():
    # Stick-slip: it arrives at the belt, sticks, and slips again.
    system = core.CATALOGUE["stick_slip"]
    run = core.integrate(system, (0.0, 40.0), tau=0.01, method="rk4", sliding="continue")
    found, met = along(run)
    begins, ends = met.kind == "sliding", met.kind == "leaving"
    assert begins.any()
    assert ends.any()
    assert np.isnan(found.alpha2[begins | ends]).all()
    assert np.isnan(found.tau_plus[begins]).all()
    assert np.isnan(found.tau_minus[ends]).all()
    assert (found.tau_minus[begins] == np.inf).all()
    assert (found.tau_plus[ends] == np.inf).all()
    assert np.isfinite(found.rate_minus).all()
    assert np.isfinite(found.rate_plus).all()


def test_a_corner_and_an_undeclared_region_are_not_transversal():
    quarter = PiecewiseSystem(
        "quarter", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
        regions={key: Region(("1", "1")) for key in ("--", "-+", "+-", "++")},
    )  # fmt: skip
    found, met = along(core.integrate(quarter, (0.0, 3.0), tau=0.1, method="rk4"))
    assert met.kind.tolist() == ["corner"]
    assert np.isnan(found.alpha2).all()
    edge = PiecewiseSystem("edge", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -2.0),
                           regions={"--": Region(("1", "1"))})  # fmt: skip
    run = core.integrate(edge, (0.0, 3.0), tau=0.1, method="rk4")
    found, _ = along(run)
    assert run.status is core.Status.UNDECLARED
    assert np.isnan(found.alpha2).all()
    assert found.rate_minus == pytest.approx([1.0])
    assert np.isnan(found.rate_plus).all()


@pytest.mark.parametrize(
    ("beside", "sliding", "warns"),
    [(("-1", "1"), "stop", True), (("-1", "1"), "continue", False), (("1", "1"), "stop", False)],
)
def test_a_run_through_a_corner_says_if_one_beside_it_would_end_by_sliding(beside, sliding, warns):
    # Below y = 0 the field to the right of x = 0 points back to it, or not; the run meets both lines at the origin.
    ahead = Region(("1", "1"))
    corner = PiecewiseSystem("corner", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
                             regions={"--": ahead, "+-": Region(beside), "-+": ahead, "++": ahead})  # fmt: skip
    run = core.integrate(corner, (0.0, 2.0), tau=0.3, sliding=sliding)
    assert (run.status.name, run.crossings.kind.tolist()) == ("COMPLETED", ["corner"])
    assert run.x[-1] == pytest.approx([1.0, 1.0])
    assert ("x = 0 and y = 0 are met at once" in run.warning) is warns
    near = core.integrate(corner, (0.0, 2.0), (-1.0, -1.001), tau=0.3, sliding=sliding)
    assert (near.status.name == "SLIDING") is warns


@pytest.mark.parametrize("name", deep_but(("chua", "two_walls", "thermostat"), sorted(core.CATALOGUE)))
def test_every_system_of_the_catalogue_is_diagnosed(name):
    run = core.integrate(core.CATALOGUE[name], (0.0, 10.0), tau=0.02, method="rk4", record="crossings",
                         max_crossings=40)  # fmt: skip
    found = diagnose(run)
    assert len(found.alpha2) == len(run.crossings)
    through = ~np.isnan(found.alpha2)
    assert (found.alpha2[through] > 0.0).all()
    assert np.isfinite(found.M[through]).all()


def test_a_mode_entered_beyond_its_guard_ends_at_once_which_is_no_slow_crossing():
    regions = {"on": core.Region(f=("v", "1")), "off": core.Region(f=("v", "-1"))}
    ways = (core.Transition("on", "1 - x", "off", ("x - 3", "v")), core.Transition("off", "x + 1", "on"))
    system = core.PiecewiseSystem("Chain", ("x", "v"), regions=regions, transitions=ways, x0=(0.0, 0.3))
    run = core.integrate(system, (0.0, 3.0), tau=0.01, method="rk4")
    assert np.diff(run.crossings.t).tolist()[::2] == [0.0, 0.0]
    assert run.warning == ""


def test_walls_that_are_far_apart_are_not_said_to_be_met_at_once():
    # A billiard with a disc: a flight is one long step of taylor, within which its line meets both walls.
    walls = ("x - 1", "x + 1", "y - 1", "y + 1", "x**2 + y**2 - 4/25")
    flip, turn = ("x", "y", "-p", "q"), ("x", "y", "p", "-q")
    off = tuple(f"{v} - 2*{c}*(x*p + y*q)/(x**2 + y**2)" for v, c in (("p", "x"), ("q", "y")))
    billiard = core.PiecewiseSystem(
        "Billiard", ("x", "y", "p", "q"), surfaces=walls, regions={"-+-++": core.Region(("p", "q", "0", "0"))},
        jumps={0: flip, 1: flip, 2: turn, 3: turn, 4: ("x", "y", *off)}, x0=(0.7, -0.474, 0.859, 0.512),
    )  # fmt: skip
    assert not core.integrate(billiard, (0.0, 15.0), method="taylor").warning


def test_taylor_far_from_a_surface_is_not_said_to_pass_it_by_its_error():
    # z < 50; the longest step of the run is too long where the state moves fast, and led far away from there.
    law = ("10*(y - x)", "x*(28 - z) - y", "x*y - 8/3*z")
    lorenz = core.PiecewiseSystem("Lorenz", ("x", "y", "z"), law, law, "z - 1000", x0=(1.0, 1.0, 20.0))
    assert not core.integrate(lorenz, (0.0, 20.0), method="taylor").warning


def test_a_reset_off_its_surface_gives_no_bound_there():
    # The next crossing is 7.6 later: the field at x = -1, which is nearly 0, does not lead back within a step.
    reset = PiecewiseSystem("Reset", ("x", "y"), ("x + 1.001", "0"), ("x + 1.001", "0"), "1 - x", jump=("-1", "y"),
                            x0=(0.0, 0.0))  # fmt: skip
    assert core.integrate(reset, (0.0, 30.0), tau=0.05, method="rk4").warning == ""


def test_a_field_that_takes_ever_shorter_steps_beyond_the_end_does_not_hold_up_the_warning():
    """y comes to a pole at t = 0.816, before which sin y takes steps without number."""
    regions = {key: core.Region(("y**2 + sin(y)", "-z")) for key in ("++", "+-", "-+", "--")}
    system = core.PiecewiseSystem("Pole", ("y", "z"), surfaces=("z - 0.5", "y + 5"), regions=regions, x0=(1.0, 1.0))
    run = core.integrate(system, (0.0, 0.75), method="taylor")
    assert run.message == "t = 0.75: reached the end time."
    assert run.crossings.t == pytest.approx([np.log(2.0)], abs=1e-12)


@pytest.mark.parametrize(("first", "second", "coupling"), [(2.89, 1.751, 0.316), (1.66, 1.487, 0.081)])
def test_surfaces_met_long_after_each_other_are_not_said_to_be_met_at_once(first, second, coupling):
    """Two leaky integrators that fire at 1 and push each other; their times of firing are 0.003 apart or more."""
    system = PiecewiseSystem(
        "Neurons", ("a", "b"), surfaces=("1 - a", "1 - b"), regions={"++": Region(("I - a", "J - b"))},
        jumps={0: ("0", "b*(1 - k)"), 1: ("a*(1 - k)", "0")}, parameters={"I": first, "J": second, "k": coupling},
    )  # fmt: skip
    run = core.integrate(system, (0.0, 50.1), (0.1, 0.2), method="taylor")
    assert run.warning == ""
    ends = np.diff(np.concatenate([[0.0], run.crossings.t]))
    assert run.tau >= 0.99 * ends.max(), "its longest step ends at a crossing"


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
def test_a_point_in_a_box_is_judged_though_rounding_puts_it_beside_the_walls(method):
    system = PiecewiseSystem(
        "Box", ("x", "y", "u", "w"), surfaces=("x", "1-x", "y", "1-y"), regions={"++++": Region(("u", "w", "0", "0"))},
        jumps={0: ("x", "y", "-u", "w"), 1: ("x", "y", "-u", "w"), 2: ("x", "y", "u", "-w"), 3: ("x", "y", "u", "-w")},
    )  # fmt: skip
    rng, tau = np.random.default_rng(77), None if method == "taylor" else 0.02
    for _ in range(24):
        x0 = (*rng.uniform(0.1, 0.9, 2).round(3), *rng.uniform(-3.0, 3.0, 2).round(3))
        run = core.integrate(system, (0.0, 300.0), x0, tau=tau, method=method)
        assert run.warning == ""
        place = (x0[0] + x0[2] * 300.0) % 2.0
        assert abs(run.x[-1, 0] - min(place, 2.0 - place)) < 1e-9


def test_a_threshold_beyond_which_a_jump_leads_is_not_met_first():
    """Two cells that fire: x = 1 is met at y = 0.959, and that jump alone leads past y = 1."""
    cells = core.PiecewiseSystem(
        "cells", ("x", "y"), surfaces=("x - 1", "y - 1"), regions={"--": core.Region(f=("1.5 - x", "1.7 - y"))},
        jumps={0: ("0", "y + 0.1"), 1: ("x + 0.1", "0")}, x0=(0.455, 0.152),
    )  # fmt: skip
    run = core.integrate(cells, (0.0, 1.0), method="taylor")
    met = float(np.log(1.045 / 0.5))
    assert run.crossings.t == pytest.approx([met, met], rel=1e-12)
    assert not run.warning
