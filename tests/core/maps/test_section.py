"""Poincaré sections: the points at which runs meet a surface, whether anything switches there or not."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status

FINE = {"method": "taylor", "tolerance": 1e-13}
VAN_DER_POL = core.PiecewiseSystem(
    "Van der Pol", ("x", "v"), g="x - 50", f_minus=("v", "mu*(1 - x**2)*v - x"), f_plus=("v", "-x"),
    parameters={"mu": 1.0}, x0=(0.5, 0.0),
)  # fmt: skip


def found_by_scipy(system, side, h, x0, t_end, direction):
    """States at which h vanishes, by DOP853 within one region."""
    event = h
    event.direction = direction
    return solve_ivp(
        lambda t, x: system.field(side, t, x), (0.0, t_end), x0, "DOP853", events=event, rtol=1e-12, atol=1e-14
    ).y_events[0]


@pytest.mark.parametrize("direction", [1, -1, 0])
def test_a_surface_at_which_nothing_switches_is_met_where_an_event_of_scipy_is(direction):
    found = core.section(VAN_DER_POL, (0.0, 50.0), of="v - x/4", points=100, direction=direction, **FINE)
    wanted = found_by_scipy(VAN_DER_POL, -1, lambda t, x: x[1] - x[0] / 4, (0.5, 0.0), 50.0, direction)
    assert len(found) == len(wanted) > 6
    assert np.abs(found.points - wanted).max() < 1e-9
    assert found.ensemble.outcomes == {Status.COMPLETED: 1}


def test_the_own_surface_gives_the_crossings_of_integrate_that_go_its_way():
    x0 = [[-1.0, -1.0], [-1.1, -0.9]]
    found = core.section("elliptic_curve", (0.0, 60.0), x0, points=5, discard=2, direction=-1, tau=0.02)
    for k, start in enumerate(x0):
        run = core.integrate("elliptic_curve", (0.0, 60.0), start, tau=0.02)
        inward = run.crossings[run.crossings.side == -1]
        assert np.array_equal(found.points[found.member == k], inward.x[2:7])
    assert (found.ensemble.status == Status.CROSSING_LIMIT).all()


#: System, sliding, tau, number of points.
ENDING = [
    ("elliptic_curve", "stop", 0.02, 3), ("bouncing_ball", "stop", 0.01, 7), ("two_walls", "stop", 0.02, 4),
    ("thermostat", "stop", 0.02, 5), ("gene_ring", "stop", 0.02, 9), ("stick_slip", "continue", 0.01, 4),
    ("diode_bridge", "stop", 0.02, 6),
]  # fmt: skip


@pytest.mark.parametrize(("name", "sliding", "tau", "points"), ENDING)
@pytest.mark.parametrize("method", ["rk4", "taylor"])
@pytest.mark.parametrize("direction", [1, -1, 0])
def test_a_member_ends_with_its_last_point(name, sliding, tau, points, method, direction):
    """As a run of `integrate` that is told after how many crossings to end."""
    tau = None if method == "taylor" else tau
    common = {"method": method, "tau": tau, "sliding": sliding}
    found = core.section(name, (0.0, 300.0), points=points, discard=2, direction=direction, **common)
    end = found.ensemble
    whole = bool(end.status[0] == Status.CROSSING_LIMIT)
    limit = {"max_crossings": int(end.crossing_count[0])} if whole else {}
    run = core.integrate(name, (0.0, 300.0), **limit, **common)
    assert run.status is Status(int(end.status[0]))
    assert whole is (len(found) == points)
    assert not whole or end.t[0] == found.t[-1] < 300.0
    assert (run.t[-1], run.steps) == (end.t[0], end.steps[0])
    assert np.array_equal(run.x[-1], end.x[0])
    assert end.warning(0) == run.warning


@pytest.mark.parametrize("direction", [1, -1, 0])
def test_points_of_all_surfaces_are_those_of_each_and_none_where_sliding_ends_by_itself(direction):
    rubbing = core.PiecewiseSystem.from_field(
        ("x", "y", "u", "v"),
        ("u", "v", "-x - 0.3*sign(u) + 0.5*cos(t) + 0.2*y", "-2*y - 0.2*sign(v) + 0.4*sin(1.3*t) + 0.2*x"),
        x0=(1.0, 1.0, 0.2, 0.1),
    )
    how = {"points": 100, "direction": direction, "method": "rk4", "tau": 0.01, "sliding": "continue"}
    each, all_of_them = ([core.section(rubbing, (0.0, 50.0), of=of, **how).t for of in some] for some in ("uv", [None]))
    assert len(all_of_them[0]) > 10
    assert np.array_equal(np.sort(np.concatenate(each)), all_of_them[0])
    kinds = core.integrate(rubbing, (0.0, 50.0), method="rk4", tau=0.01, sliding="continue").crossings.kind
    assert "leaving" in kinds, "sliding ends by itself somewhere"


def test_states_keep_their_invariants_through_surfaces_of_sections():
    start = core.CATALOGUE["henon_heiles"].x0
    found = core.section("henon_heiles", (0.0, 1e5), of="y", points=300, direction=1, coordinates=("x", "u"), tau=0.05)
    assert found.coordinates == ("x", "u")
    assert found.points.shape == (300, 2)
    energy = core.CATALOGUE["henon_heiles"].conserved(-1, 0.0, found.ensemble.events.x)
    assert np.abs(energy - core.CATALOGUE["henon_heiles"].conserved(-1, 0.0, np.array(start))).max() < 1e-15


def test_sections_go_through_walls_and_through_regions_with_names():
    walls = core.section("two_walls", (0.0, 40.0), of="x", points=50, **FINE)
    run = core.integrate("two_walls", (0.0, 40.0), **FINE)
    speed = np.abs(walls.points[:, 1])
    assert len(walls) > 10
    assert np.abs(walls.points[:, 0]).max() < 1e-12
    for k, t in enumerate(walls.t):
        assert run.at(t) == pytest.approx(walls.points[k], abs=1e-9)
    assert (np.diff(speed) <= 1e-9).all() or (np.diff(speed) >= -1e-9).all() or len(np.unique(speed.round(9))) > 1
    room = core.section("thermostat", (0.0, 30.0), of="T", points=50, direction=1, **FINE)
    run = core.integrate("thermostat", (0.0, 30.0), **FINE)
    assert len(room) > 3
    for k, t in enumerate(room.t):
        assert run.at(t) == pytest.approx(room.points[k], abs=1e-9)
        assert run.at(t + 1e-3)[0] > 0.0 > run.at(t - 1e-3)[0]


def test_a_section_that_a_parameter_makes_the_switching_surface_has_the_same_points():
    """Both are met at once then, at what is a corner."""
    pendulum = core.CATALOGUE["pendulum"].with_parameters(angle=0.0)
    for direction in (1, -1, 0):
        settings = {"points": 40, "direction": direction, "method": "rk4", "tau": 0.01}
        own, other = (core.section(pendulum, (0.0, 20.0), of=of, **settings) for of in ("q - angle", "q"))
        assert len(own) > 6
        assert np.abs(own.points - other.points).max() < 1e-12
        assert np.array_equal(own.points, core.section(pendulum, (0.0, 20.0), **settings).points)


@pytest.mark.parametrize("of", ["q-angle", " (q - angle)*2", "angle/3 - q/3"])
def test_a_multiple_of_the_switching_function_is_that_surface(of):
    way = -1 if of.startswith("angle") else 1
    settings = {"points": 3, "method": "rk4", "tau": 0.01}
    found = core.section("pendulum", (0.0, 20.0), of=of, direction=way, **settings)
    assert np.array_equal(found.points, core.section("pendulum", (0.0, 20.0), direction=1, **settings).points)


@pytest.mark.parametrize("of", ["y - 9/10", "exp(y) - 2"])
def test_a_section_of_a_run_that_slides_has_the_points_of_that_run(of):
    found = core.section("stick_slip", (0.0, 60.0), of=of, points=50, sliding="continue", **FINE)
    run = core.integrate("stick_slip", (0.0, 60.0), sliding="continue", **FINE)
    assert len(found) > 6
    for t, x in zip(found.t, found.points, strict=True):
        assert run.at(t) == pytest.approx(x, abs=1e-8)


def test_a_return_map_pairs_each_point_with_the_next_of_its_member():
    x0 = [[0.5, 0.0], [1.0, 0.0]]
    found = core.section(VAN_DER_POL, (0.0, 100.0), x0, of="v", points=6, direction=-1, **FINE)
    pairs = found.return_map("x")
    assert pairs.shape == (10, 2)
    assert np.array_equal(pairs[:5, 1], found.points[1:6, 0])
    assert np.array_equal(pairs[5:, 0], found.points[6:11, 0])
    assert abs(pairs[-1, 1] - 2.0086198608748433) < 1e-6  # amplitude of the limit cycle at mu = 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"points": 0}, "points = 0"),
        ({"direction": 2}, "direction = 2"),
        ({"points": 2**70}, "points = "),
        ({"discard": -1}, "discard = -1"),
        ({"discard": 2**70}, "discard = "),
        ({"of": "x +"}, "of"),
        ({"of": "q"}, "q"),
        ({"coordinates": ("q",)}, "'q' is not a variable; coordinates are some of x, v"),
        ({"coordinates": ()}, "at least one"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_what_makes_no_sense_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        core.section(VAN_DER_POL, (0.0, 1.0), **{"points": 1, "method": "rk4", **arguments})


def test_a_coordinate_that_the_section_has_not_is_refused_by_its_return_map():
    found = core.section(VAN_DER_POL, (0.0, 20.0), of="v", points=2, coordinates=("x",), **FINE)
    with pytest.raises(ValueError, match="choose from x"):
        found.return_map("v")


def test_a_coordinate_given_twice_is_refused():
    with pytest.raises(ValueError, match="a variable is given twice"):
        core.section(VAN_DER_POL, (0.0, 1.0), points=1, of="x", coordinates=("x", "x"))


def test_points_on_a_surface_with_a_reset_map_are_the_states_after_it():
    found = core.section("two_walls", (0.0, 40.0), points=20, **FINE)
    crossings = found.ensemble.crossings
    assert np.array_equal(found.points, crossings.x_after)
    assert not np.array_equal(found.points, crossings.x)
