"""A run whose errors decide on which side it passes a saddle says so, though one in half steps takes the same side."""

import numpy as np
import pytest

import core

SLOW = "nearly comes to rest"


def _pendulum():
    """Energy cos(0) is the separatrix: with less of it |x| stays below π, and with more it comes to 4.5."""
    return core.PiecewiseSystem(
        "Over or not", ("x", "v"), ("v", "-sin(x)"), ("v", "-sin(x) - v/10"), "x**2 - 4.5**2", x0=(1.0, 0.0)
    )  # fmt: skip


#: Method, tau, end, start; of each a run in half steps takes the wrong side, too.
WRONG = [
    ("rk4", 0.4, 30.0, (1.1601652759870635, 1.6728339298991055)),
    ("gauss4", 0.4, 60.0, (0.050220547864090914, 1.9993693647791069)),
    ("rk2", 0.05, 60.0, (-0.12199235134378883, -1.9962813749399342)),
]


@pytest.mark.parametrize(("method", "tau", "end", "start"), WRONG)
def test_a_pendulum_that_errors_carry_to_the_other_side_of_its_upper_rest_is_told(method, tau, end, start):
    energy = start[1] ** 2 / 2 - np.cos(start[0]) - 1.0  # above that of the upper rest
    run = core.integrate(_pendulum(), (0.0, end), start, tau=tau, method=method)
    assert (run.crossing_count > 0) != (energy > 0.0), "it takes the wrong side"
    assert SLOW in run.warning, run.warning


@pytest.mark.parametrize("part", [-1e-2, 1e-2])
@pytest.mark.parametrize(("method", "tau"), [("rk2", 0.01), ("rk4", 0.1), ("gauss4", 0.1)])
def test_one_that_passes_its_rest_farther_away_than_its_errors_is_not(method, tau, part):
    run = core.integrate(_pendulum(), (0.0, 12.0), (0.0, float(np.sqrt(4.0 + 2.0 * part))), tau=tau, method=method)
    assert (run.crossing_count > 0) == (part > 0.0), "it takes the right side"
    assert run.warning == ""


@pytest.mark.parametrize("method", ["rk2", "rk4"])
def test_a_slow_pass_that_leads_on_along_one_way_only_is_not(method):
    """x' = ε + x² is slow near 0, and every solution goes on through it; a swing that dies out is slow for ever."""
    for field, x0 in ((("1/1000 + x**2", "-y"), (-1.0, 1.0)), (("y", "-x - y/5"), (1.0, 0.0))):
        system = core.PiecewiseSystem("Slow", ("x", "y"), field, field, "x - 3", x0=x0)
        run = core.integrate(system, (0.0, 90.0), tau=0.02, method=method)
        assert SLOW not in run.warning, run.warning


@pytest.mark.parametrize("beside", ["1", "s/20", "-s/20"])
def test_variables_beside_the_saddle_that_go_on_hide_nothing(beside):
    """Two wells, with energy 1.9e-7 above the saddle at x = 0: the run turns back there, and one in half steps, too."""
    field, start = ("v", "x - x**3", beside), (-1.0253021895567906, 0.7061780036617021, 1.0)
    system = core.PiecewiseSystem("Wells", ("x", "v", "s"), field, field, "x - 3/10", x0=start)
    assert start[1] ** 2 / 2 - start[0] ** 2 / 2 + start[0] ** 4 / 4 > 0.0
    run = core.integrate(system, (0.0, 16.93), tau=0.08851171752845383, method="rk2")
    assert run.crossing_count == 0
    assert SLOW in run.warning, run.warning


def test_what_rests_at_the_end_is_not_said_to_go_on():
    """On the unit circle a slide comes to rest, and so does a spiral: what follows is round-off."""
    circle = core.PiecewiseSystem(
        "Circle", ("x", "y"), ("-w*y + k*x + h", "w*x + k*y"), ("-w*y - k*x + h", "w*x - k*y"), "x**2 + y**2 - 1",
        parameters={"w": 0.4466698735208987, "k": 3.5167347727274794, "h": 1.6580184613531936},
        x0=(-0.6662760212798241, 0.7457052121767203),
    )  # fmt: skip
    slid = core.integrate(circle, (0.0, 53.4), tau=0.015, method="rk4", sliding="continue")
    law = ("y", "-3*x - a*y + b", "-s")
    spiral = core.PiecewiseSystem("Spiral", ("x", "y", "s"), law, law, "x + 5", parameters={"a": 1.1042, "b": 2.2222})
    spirals = [
        core.integrate(spiral, (0.0, 47.4), (1.756178924237274, y, 1.0), tau=0.018065, method="rk2")
        for y in np.linspace(0.6, 0.7, 11)
    ]
    assert all(SLOW not in run.warning for run in (slid, *spirals))


@pytest.mark.parametrize(("method", "tau"), [("prk8", 0.1), ("prk8", 0.3), ("dmm4", 0.3), ("dmm8", 0.3)])
def test_a_speed_that_is_constant_between_walls_is_no_rest_and_its_rounding_no_loss_of_order(method, tau):
    g, square = "1 - x**2 - y**2", "(x**2 + y**2)"
    mirror = [f"{u} - 2*(x*u + y*v)*{x}/{square}" for u, x in (("u", "x"), ("v", "y"))]
    system = core.PiecewiseSystem(
        "Billiard", ("x", "y", "u", "v"), surfaces=(g,),
        regions={"+": core.Region(("u", "v", "0", "0"), ("x*v - y*u",))},
        jumps={0: ("x", "y", *mirror)},
    )  # fmt: skip
    for k in range(8):  # numbers of three decimals, so that the speed after each reflection is rounded anew
        start = np.random.default_rng(k).uniform(-0.6, 0.6, 2).round(3)
        way = np.round([np.cos(0.77 * k + 0.1), np.sin(0.77 * k + 0.1)], 3)
        run = core.integrate(system, (0.0, 600.0), (*start, *way), tau=tau, method=method)
        assert run.warning == "", run.warning
