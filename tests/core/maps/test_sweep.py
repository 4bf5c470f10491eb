"""Sweeps: what runs leave on a surface for each value of a parameter."""

from dataclasses import replace

import numpy as np
import pytest

import core
from core import Status

#: x' = x (a + 2 r² − r⁴) and so on with r² = x² + y²: for −1 < a < 0 the origin and a cycle r² = 1 + √(1 + a) attract.
BOTH = core.PiecewiseSystem(
    "Subcritical", ("x", "y"), g="x - 40",
    f_minus=("x*(a + 2*(x**2 + y**2) - (x**2 + y**2)**2) - y", "y*(a + 2*(x**2 + y**2) - (x**2 + y**2)**2) + x"),
    f_plus=("-x", "-y"), parameters={"a": -0.5}, x0=(0.01, 0.0),
)  # fmt: skip
VALUES = np.array([-1.2, -0.6, 0.3, 0.6])
SETTINGS = {"of": "y", "direction": 1, "points": 3, "discard": 12, "method": "taylor", "tolerance": 1e-12}


def test_each_value_has_the_points_of_its_own_section():
    found = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", **SETTINGS)
    assert found.statuses == (Status.EVENT_LIMIT,) * 4
    for a in VALUES:
        alone = core.section(BOTH, (0.0, 1e3), None, {"a": a}, coordinates=("x",), **SETTINGS)
        assert np.array_equal(found.points[found.value == a], alone.points[:, 0])


def test_a_continuation_stays_on_its_branch_which_depends_on_the_way():
    """Upwards the run stays at the origin until a = 0; downwards on the cycle until a = −1."""
    up = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="up", **SETTINGS)
    down = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="down", **SETTINGS)
    cycle = {a: np.sqrt(1 + np.sqrt(1 + a)) for a in VALUES if a > -1}
    assert np.abs(up.points[up.value < 0]).max() < 1e-3
    for a, radius in cycle.items():
        assert down.points[down.value == a] == pytest.approx(radius, abs=1e-6)
    assert np.abs(down.points[down.value == -1.2]).max() < 1e-2


@pytest.mark.parametrize("method", ["taylor", "rk4", "dmm2"])
def test_a_continuation_goes_on_where_the_last_point_is_and_not_from_what_would_come_later(method):
    """A ball at rest after ever lower bounces has no way on, and one on a spring without damping blows up."""
    ball = core.PiecewiseSystem(
        "ball", ("x", "v"), g="x", f_minus=("v", "-1"), f_plus=("v", "-1"), jump=("x", "-r*v"),
        psi_minus=("v**2/2 + x",), psi_plus=("v**2/2 + x",), parameters={"r": 0.5}, x0=(1.0, 0.0),
    )  # fmt: skip
    values, how = [0.3, 0.4, 0.5, 0.6], {"method": method, "tau": None if method == "taylor" else 0.01}
    found = core.sweep(ball, (0.0, 100.0), "r", values, "v", points=2, continuation="up", **how)
    at, wanted = ball.x0, []
    for r in values:
        run = core.integrate(ball.with_parameters(r=r), (0.0, 100.0), at, max_crossings=2, **how)
        at = run.x[-1]
        wanted += run.crossings.x_after[:, 1].tolist()
    assert found.points.tolist() == wanted
    speeds = np.cumprod(np.repeat(values, 2)) * np.sqrt(2.0)  # each bounce keeps r of it
    assert found.points == pytest.approx(speeds, rel=1e-9)


#: A swing that meets a wall at x = p loses nothing: from x = 0.5 at rest, v² = 0.25 − p² there. Nothing is beyond it.
WALL = core.PiecewiseSystem(
    "A wall", ("x", "v"), surfaces=("x - p",), regions={"+": core.Region(f=("v", "-x"))}, jumps={0: ("x", "-v")},
    parameters={"p": 0.0}, x0=(0.5, 0.0),
)  # fmt: skip


@pytest.mark.parametrize("continuation", ["up", "down"])
def test_a_continuation_goes_on_beside_a_surface_that_the_parameter_moves(continuation):
    values = np.linspace(-0.4, 0.4, 9)
    found = core.sweep(
        WALL, (0.0, 1e3), "p", values, "v", points=6, continuation=continuation, method="taylor", tolerance=1e-13
    )
    assert found.statuses == (Status.CROSSING_LIMIT,) * 9
    assert found.points == pytest.approx(np.sqrt(0.25 - found.value**2), abs=1e-10), "after the reset map"


def test_a_continuation_begins_anew_where_the_surface_has_moved_over_its_state():
    """From x = 1.4 the swing about 1 would be behind the wall at 1.45; from x0 = 1.5 it meets it from above."""
    both = core.PiecewiseSystem(
        "A wall with two sides", ("x", "v"), f_minus=("v", "-x"), f_plus=("v", "1 - x"), g="x - p", jump=("x", "-v"),
        parameters={"p": 0.0}, x0=(1.5, 0.0),
    )  # fmt: skip
    settings = {"points": 4, "continuation": "up", "method": "taylor", "tolerance": 1e-13}
    first = core.sweep(both, (0.0, 1e2), "p", [0.6], "v", **settings)
    moved = core.sweep(
        both, (0.0, 1e2), "p", [1.45], "v", after=replace(first, following=np.array([1.4, 0.0])), **settings
    )
    assert len(moved) == 4
    assert moved.points == pytest.approx(np.sqrt(0.25 - 0.45**2), abs=1e-10)


def test_of_laws_that_contain_the_time_a_continuation_goes_on_in_time():
    table = core.PiecewiseSystem(
        name="ball on a moving table", variables=("y", "v"), surfaces=("y - a*sin(t)",),
        regions={"+": core.Region(f=("v", "-1")), "-": core.Region(f=("v", "-1"))},
        jumps={0: ("y", "(1 + r)*a*cos(t) - r*v")}, parameters={"a": 0.5, "r": 0.3}, x0=(2.0, 0.0),
    )  # fmt: skip
    settings = {"points": 2, "method": "taylor"}
    found = core.sweep(table, (0.0, 50.0), "r", [0.6, 0.7, 0.8], "v", continuation="up", **settings)
    t, x, points = 0.0, table.x0, []
    for r in (0.6, 0.7, 0.8):
        one = core.section(table, (t, t + 50.0), x, {"r": [r]}, coordinates=("v",), **settings)
        t, x = float(one.ensemble.t[0]), one.ensemble.x[0]
        points += one.points[:, 0].tolist()
    assert found.points.tolist() == points
    assert found.statuses == (Status.CROSSING_LIMIT,) * 3
    assert found.begins == t


@pytest.mark.parametrize("continuation", ["up", "down"])
@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_a_continuation_goes_on_in_the_region_of_the_end_whichever_is_declared_first(continuation, method):
    """Both regions contain the places where h = v = 0; the section is inside them, not at a guard."""
    laws = {
        "up": core.Region(f=("v", "-0.2*v - (x - 0.5) + a*cos(t)")),
        "down": core.Region(f=("v", "-0.2*v - (x + 0.5) + a*cos(t)")),
    }
    ways = (core.Transition("up", "x + 0.6", "down"), core.Transition("down", "0.6 - x", "up"))
    values, found = np.linspace(0.05, 0.09, 5), []
    for names in (("up", "down"), ("down", "up")):
        system = core.PiecewiseSystem(
            "relay", ("x", "v"), regions={name: laws[name] for name in names}, transitions=ways,
            parameters={"a": 0.1}, x0=(-0.55, 0.0),
        )  # fmt: skip
        steps = {} if method == "taylor" else {"tau": 0.01}
        found.append(
            core.sweep(
                system, (0.0, 300.0), "a", values, "x", of="v", points=4, discard=2, continuation=continuation,
                method=method, region="down", **steps,
            )
        )  # fmt: skip
    assert found[0].points.mean() < -0.4
    assert np.array_equal(found[0].points, found[1].points)
    assert found[0].region == found[1].region == "down"


def test_a_guard_of_another_region_that_moves_over_the_state_does_not_end_a_continuation():
    """Down, about x = −1.2, the guard x + h of the other region changes its sign as h grows; from x0 runs begin up."""
    laws = {"up": ("v", "-0.5*v - (x - 1.2)"), "down": ("v", "0.4*v*(0.01 - v**2) - x - 1.2")}
    system = core.PiecewiseSystem(
        "relay", ("x", "v"), regions={name: core.Region(f) for name, f in laws.items()}, x0=(-0.9, 0.0),
        transitions=(core.Transition("up", "x + h", "down"), core.Transition("down", "2 - x", "up")),
        parameters={"h": 0.8},
    )  # fmt: skip
    settings = {"of": "v", "points": 3, "discard": 60, "continuation": "up", "method": "taylor"}
    found = core.sweep(system, (0.0, 400.0), "h", [0.8, 1.0, 1.4], "x", **settings)
    assert len(found) == 9
    assert np.abs(found.points + 1.2).max() < 0.3
    assert found.region == "down"


def test_a_continuation_in_parts_is_that_of_the_whole():
    whole = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="down", **SETTINGS)
    found, points = None, []
    for part in (VALUES[2:], VALUES[:2]):
        found = core.sweep(BOTH, (0.0, 1e3), "a", part, "x", continuation="down", after=found, **SETTINGS)
        points = [found.points, *points]
    assert np.array_equal(np.concatenate(points), whole.points)
    assert np.array_equal(found.following, whole.following)
    assert (found.begins, found.region) == (whole.begins, whole.region)


def test_a_cancelled_sweep_has_the_points_of_the_values_that_are_done():
    heard = []
    found = core.sweep(
        BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="up", progress=heard.append,
        cancel=lambda: len(heard) == 2, **SETTINGS,
    )  # fmt: skip
    assert heard == [0.25, 0.5]
    assert found.statuses[2:] == (Status.CANCELLED,) * 2
    assert set(found.value) == {-1.2, -0.6}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"parameter": "b"}, "unknown parameter 'b'"),
        ({"values": [[1.0]]}, "values has shape"),
        ({"values": [np.inf]}, "finite"),
        ({"coordinate": "z"}, "'z' is not a variable"),
        ({"foo": 1}, "foo is not an argument of a sweep"),
        ({"events": "x"}, "events is not an argument of a sweep"),
        ({"coordinates": ("x",)}, "coordinates is not an argument of a sweep"),
        ({"continuation": "sideways"}, "choose from none, up, down"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_what_makes_no_sense_is_refused(arguments, words):
    given = {"system": BOTH, "t_span": (0.0, 1.0), "parameter": "a", "values": [1.0], "coordinate": "x"}
    with pytest.raises(ValueError, match=words):
        core.sweep(**{**given, **SETTINGS, **arguments})
