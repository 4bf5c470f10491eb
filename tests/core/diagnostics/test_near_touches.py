"""A run is compared with one in half steps where that is at the same place, though earlier or later."""

import numpy as np
import pytest

import core

WORDS = "at a distance below its accumulated error"


@pytest.mark.parametrize("radius", [0.2203, 0.5812, 1.30301, 1.58872, 1.66391])
@pytest.mark.parametrize("method", ["dmm2", "dmm4"])
def test_a_shift_in_time_along_the_orbit_is_not_taken_for_a_distance_from_the_surface(radius, method):
    """The orbit from (−1, −1) is closed, and DMM stay on it: they cross, or pass, as the reference does."""
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=radius)
    exact = core.integrate(system, (0.0, 12.0), (-1.0, -1.0), method="taylor", tolerance=1e-14)
    g = (exact.at(np.linspace(0.0, 12.0, 2001)) ** 2).sum(axis=1) - radius**2
    rates = np.abs(exact.crossings.rate_before)
    assert rates.min(initial=np.inf) > 0.5, "it crosses steeply"
    assert len(rates) or g.min() > 0.1 or g.max() < -0.1, "or it stays away"
    run = core.integrate(system, (0.0, 300.0), (-1.0, -1.0), tau=0.08, method=method)
    assert WORDS not in run.warning, run.warning


#: Method, tau, damping, frequency, end, number of the turn whose greatest x is about the level, and how far it is off.
TURNS = [
    ("rk4", 0.4910068382972008, -0.020930660814525968, 1.4176610337689262, 66.10004265025286, 13, 0.014836744022685977),
    (
        "rk2",
        0.20455415675332006,
        -0.017543428832886242,
        1.0096201508772658,
        116.89123341675703,
        18,
        5.498827416650087e-4,
    ),
]


@pytest.mark.parametrize(("method", "tau", "damping", "frequency", "end", "turn", "off"), TURNS)
def test_on_a_spiral_a_turn_is_compared_with_the_same_turn(method, tau, damping, frequency, end, turn, off):
    """Another turn of the run in half steps may come nearer than the same one, and the level not be in doubt there."""
    w = float(np.sqrt(frequency**2 - damping**2))
    level = float(np.exp(-2 * np.pi * turn * damping / w)) * (1.0 + off)
    field = ("v", f"-{frequency**2!r}*x - {2 * damping!r}*v")
    swing = core.PiecewiseSystem("Swing", ("x", "v"), field, field, f"x - {level!r}", x0=(1.0, 0.0))
    t = np.linspace(0.0, end, 200_001)
    above = np.exp(-damping * t) * (np.cos(w * t) + damping / w * np.sin(w * t)) > level
    run = core.integrate(swing, (0.0, end), tau=tau, method=method)
    assert run.crossing_count != np.count_nonzero(np.diff(above)), "it meets the level at other turns"
    assert WORDS in run.warning


def test_a_touch_late_in_a_run_is_told_all_the_same():
    """From where the orbit touches the circle it comes back to it after each turn, at a shift in time."""
    x = float(np.roots([3.0, 2.0, -3.0]).min())  # where x² + y² is largest on the curve y² = x³ − 3x − 1
    radius = float(np.sqrt(x**2 + x**3 - 3 * x - 1))
    assert radius == pytest.approx(1.5545, abs=1e-3)
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=radius + 1e-9)
    run = core.integrate(system, (0.0, 60.0), (-1.0, -1.0), tau=0.02, method="rk4")
    assert WORDS in run.warning or run.status is core.Status.GRAZING


def test_a_pass_that_is_within_the_error_of_many_steps_is_told():
    """Two swings under a threshold that falls: x + y comes to 0.0063 below it, and the errors of 9,400 steps are more.

    The run in half steps crosses it, too; from there on a push leads both away.
    """
    w1, w2, c, fall = 0.9471745592604729, 1.810999232903939, 5.886193338935695, 0.022830271790112065
    start = (1.4366457169539582, 0.10521918766348708, 0.03488576106773776, 1.268305889387341, 0.0)
    below, above = (("v", f"-{w1**2!r}*x + {push}", "u", f"-{w2**2!r}*y", "1") for push in ("0", "3.4"))
    g = f"x + y + {fall!r}*z - {c!r}"
    kept = f"v**2 + {w1**2!r}*x**2", f"u**2 + {w2**2!r}*y**2"
    system = core.PiecewiseSystem("Threshold", ("x", "v", "y", "u", "z"), below, above, g, kept, kept[1:], x0=start)
    t = np.linspace(0.0, 188.0, 1_000_001)
    x = start[0] * np.cos(w1 * t) + start[1] / w1 * np.sin(w1 * t)
    y = start[2] * np.cos(w2 * t) + start[3] / w2 * np.sin(w2 * t)
    assert (x + y + fall * t < c).all(), "the solution stays below"
    for method in ("dmm2", "rk2"):
        run = core.integrate(system, (0.0, 188.0), tau=0.02, method=method)
        assert WORDS in run.warning, (method, run.crossing_count, run.warning)


@pytest.mark.parametrize(("method", "tau"), [("rk8", 0.15), ("gauss4", 0.075), ("rk4", 0.075)])
def test_a_crossing_beyond_which_the_law_would_come_to_a_least_height_far_away_is_no_pass(method, tau):
    """x relaxes to y and crosses at 0.038; with the law before, g would come to −1.0 later."""
    law = ("(y - x)/0.15", "-x")
    relaxing = core.PiecewiseSystem("Relaxing", ("x", "y"), law, law, "x + 0.13*y - 0.4", x0=(-0.2, 1.57))
    run = core.integrate(relaxing, (0.0, 3.0), tau=tau, method=method)
    assert run.crossings.t == pytest.approx([0.037953, 1.590238], abs=1e-5)
    assert WORDS not in run.warning, run.warning


@pytest.mark.parametrize("beyond", ["3", "-3"])
@pytest.mark.parametrize("tau", [0.05, 0.0625, 0.1])
@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_touch_at_the_end_of_a_step_is_told(method, tau, beyond):
    """y = −x² touches y = 0 at x = 0, where all methods are exact but for rounding: of what y was, not is."""
    system = core.PiecewiseSystem("Touch", ("x", "y"), ("1", "-2*x"), ("1", beyond), "y")
    for n in range(1, 16):
        run = core.integrate(system, (0.0, n * tau + 1.0), (-n * tau, -((n * tau) ** 2)), tau, method)
        assert run.status is core.Status.GRAZING or WORDS in run.warning, f"{n} steps before it: {run.message}"


@pytest.mark.parametrize("power", [3, 5])
@pytest.mark.parametrize("seed", range(3))
def test_a_touch_of_a_power_of_the_distance_is_told_of_the_longest_steps(power, seed):
    rng = np.random.default_rng(seed)
    for _ in range(12):
        w, r, phase = rng.uniform(0.5, 2.0), rng.uniform(0.5, 2.0), rng.uniform(-2.0, 2.0)
        x0, end = (r * np.cos(phase), -w * r * np.sin(phase)), (2.0 + 2.0 * np.pi * (phase > 0.0)) / w
        for a, told in ((float(np.hypot(x0[0], x0[1] / w)), True), (1.3 * r, False)):
            system = core.PiecewiseSystem(
                "Touch", ("x", "y"), ("y", "-w**2*x"), ("y", "-w**2*x - 1"), f"(x - a)**{power}",
                parameters={"w": w, "a": a}, x0=x0,
            )  # fmt: skip
            run = core.integrate(system, (0.0, 1.3 * end), method="taylor")
            assert bool(run.warning) is told, (w, x0, run.message)


def test_what_is_told_of_an_instant_that_hardly_comes_does_not_name_the_start():
    wave = core.PiecewiseSystem("wave", ("x",), ("-x",), ("1",), "sin(t) + 0.999999999999999", x0=(1.0,))
    warning = core.integrate(wave, (0.0, 10.0), tau=0.01, method="rk4").warning
    assert WORDS in warning
    assert "no step size helps: change a parameter" in warning


@pytest.mark.parametrize("method", ["taylor", "prk8", "rk4"])
@pytest.mark.parametrize("g", ["cosh({a}*(x - ({b}))) - {c}", "exp({a}*(x - ({b}))) + exp(-{a}*(x - ({b}))) - 2*{c}"])
def test_a_surface_whose_g_is_very_large_elsewhere_is_not_said_to_be_met_by_rounding(g, method):
    """x = sin t passes x = b, where g is least, far from the surface: its rounding where g is 10⁸ does not matter."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        a, b, c = rng.uniform(5.0, 40.0), rng.uniform(-1.1, 1.1), rng.uniform(1.05, 3.0)
        surface = g.format(a=repr(float(a)), b=repr(float(b)), c=repr(float(c)))
        circle = core.PiecewiseSystem("circle", ("x", "y"), ("y", "-x"), ("y", "-x"), surface, ("x**2 + y**2",))
        tau = None if method == "taylor" else 0.01
        run = core.integrate(circle, (0.0, 12.0), (0.0, 1.0), tau=tau, method=method)
        assert run.status is core.Status.COMPLETED
        assert WORDS not in run.message, surface
