"""Corners of two surfaces, against systems in which smooth steps of small width replace the switches."""

from collections import Counter
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import PiecewiseSystem, Region
from core.integration.starting import onto_surfaces
from tests.levels import deep_but

SIGNS = tuple(product((-1, 1), repeat=2))
KEYS = tuple("".join("-+"[s > 0] for s in signs) for signs in SIGNS)
#: Width of the smooth steps.
WIDTH = 1e-6
#: The corner is met at t = 1; shortly later the solutions are compared.
T_END = 1.25


class Case:
    """Fields c + A x of the four regions around the corner of x + z/4 = 0 and y - z/2 = 0; in the plane z = 0.

    The start lies in a region whose field is constant, and leads to the corner at t = 1.
    """

    def __init__(self, rng: np.random.Generator, d: int) -> None:
        self.d, names = d, ("x", "y", "z")[:d]
        self.normals = np.array([[1.0, 0.0, 0.25], [0.0, 1.0, -0.5]])[:, :d]
        self.constant = (rng.integers(-12, 13, (4, d)) + 0.5) / 8
        self.slope = rng.integers(-4, 5, (4, d, d)) / 4
        start = (rng.integers(-12, 13, d) + 0.5) / 8
        first = SIGNS.index(tuple(1 if u > 0 else -1 for u in self.normals @ start))
        self.constant[first], self.slope[first] = -start, 0.0
        terms = [[" + ".join([f"({c})", *(f"({a})*{v}" for a, v in zip(row, names, strict=True))])
                  for c, row in zip(cs, rows, strict=True)]
                 for cs, rows in zip(self.constant.tolist(), self.slope.tolist(), strict=True)]  # fmt: skip
        surfaces = ("x", "y") if d == 2 else ("x + z/4", "y - z/2")
        regions = {key: Region(tuple(f)) for key, f in zip(KEYS, terms, strict=True)}
        self.system = PiecewiseSystem("case", names, surfaces=surfaces, regions=regions, x0=tuple(start.tolist()))

    def smoothed(self, ratio: float) -> np.ndarray:
        """The state at the end if sign(g) becomes tanh(g/width), the second width `ratio` times the first."""
        widths = WIDTH * np.array([1.0, ratio])

        def field(_t: float, x: np.ndarray) -> np.ndarray:
            u, v = np.tanh(self.normals @ x / widths)
            weights = [(1 + a * u) * (1 + b * v) / 4 for a, b in SIGNS]
            return sum(w * (c + slope @ x) for w, c, slope in zip(weights, self.constant, self.slope, strict=True))

        ends = [(0.0, 0.999), (0.999, T_END)]  # the way to the corner is straight; its neighbourhood is not missed
        x = np.array(self.system.x0)
        for span in ends:
            found = solve_ivp(field, span, x, "LSODA", rtol=1e-8, atol=1e-10, max_step=0.01)
            assert found.success
            x = found.y[:, -1]
        return x


def answer(case: Case) -> tuple[str, np.ndarray | None]:
    """What the exact solution says: "passed" and where it is at the end, or why it stops at the corner."""
    solution = core.reference_solution(case.system, sliding="continue")
    try:
        return "passed", solution.state(T_END)
    except ValueError as stopped:
        words = str(stopped)
        assert "ends at t = 1," in words
        return next(
            w for w in ("neither does sliding", "more than one way", "may stay", "not clear") if w in words
        ), None


@pytest.mark.parametrize(("d", "count"), deep_but([(2, 6)], [(2, 6), (2, 60), (3, 25)]))
def test_solutions_leave_corners_as_those_of_smooth_steps_of_any_widths(d, count):
    rng, seen = np.random.default_rng(d + count), Counter()
    for _ in range(count):
        case = Case(rng, d)
        said, state = answer(case)
        seen[said] += 1
        for ratio in (0.5, 2.0):
            if state is not None:
                assert np.abs(case.smoothed(ratio) - state).max() < 1e-3, (case.constant.tolist(), said)
            elif said == "neither does sliding" and d == 2:
                assert np.abs(case.smoothed(ratio)).max() < 1e-3, (case.constant.tolist(), said)
    assert seen["passed"] >= count // 6
    assert len(seen) > 1


# The compiled loop ---------------------------------------------------------------------------------------------------

FIELDS = PiecewiseSystem(
    "quadrants", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
    regions={key: Region((f"a{n}", f"b{n}")) for n, key in enumerate(KEYS)},
    parameters={f"{letter}{n}": 1.0 for n in range(4) for letter in "ab"},
)  # fmt: skip


def quadrants(*fields):
    """Constant fields of the quadrants --, -+, +-, ++."""
    values = {f"{w}{n}": float(u) for n, f in enumerate(fields) for w, u in zip("ab", f, strict=True)}
    return FIELDS.with_parameters(**values)


def run_of(system, x0, t_end=2.0, sliding="continue"):
    return core.integrate(system, (0.0, t_end), x0, tau=0.125, method="rk2", sliding=sliding)


def names_of(run):
    return [run.system.laws.name(int(mode)) for mode in run.crossings.mode]


def test_a_corner_with_one_region_that_leads_out_is_passed_though_other_fields_do_not_point_there():
    # Of "-+" and "+-" each points into the other's neighbour, but not to "++" as the rest does.
    run = run_of(quadrants((1, 1), (2, -1), (-1, 2), (1, 1)), (-1.0, -1.0))
    assert run.status is core.Status.COMPLETED
    assert names_of(run) == ["++"]
    assert run.crossings.kind.tolist() == ["corner"]
    assert run.x[-1] == pytest.approx([1.0, 1.0], abs=1e-14)


def test_a_corner_is_left_along_a_surface_if_the_run_slides_and_else_ends_there_as_sliding():
    system = quadrants((1, 1), (1, 1), (1, 1), (-1, 2))  # "-+" and "++" point to x = 0, and up
    run = run_of(system, (-1.0, -1.0))
    assert run.status is core.Status.COMPLETED
    assert names_of(run) == ["0+"]
    assert run.x[-1] == pytest.approx([0.0, 1.5], abs=1e-14)
    assert str(run.tally) == "1 slide"
    stopped = run_of(system, (-1.0, -1.0), sliding="stop")
    assert stopped.status is core.Status.SLIDING
    assert stopped.t[-1] == pytest.approx(1.0)
    begun = run_of(system, (0.0, 0.0))
    assert begun.status is core.Status.COMPLETED
    assert begun.x[-1] == pytest.approx([0.0, 3.0], abs=1e-14)
    assert run_of(system, (0.0, 0.0), sliding="stop").status is core.Status.SLIDING


def test_sliding_into_a_corner_leaves_it_into_the_one_region_that_leads_out():
    # It slides up x = 0 from y = -1 at rate 1; beyond y = 0 both fields lead to x > 0.
    run = run_of(quadrants((1, 1), (1, 1), (-1, 1), (1, 1)), (0.0, -1.0))
    assert run.status is core.Status.COMPLETED
    assert names_of(run) == ["++"]
    assert run.x[-1] == pytest.approx([1.0, 1.0], abs=1e-14)


def test_sliding_turns_at_a_corner_along_the_other_surface():
    # Up x = 0; beyond y = 0 fields lead back down, and on both sides of y = 0, x > 0 to it and to the right.
    run = run_of(quadrants((1, 1), (3, -1), (-1, 1), (3, -1)), (0.0, -1.0), 1.5)
    exact = core.reference_solution(run.system, (0.0, -1.0), sliding="continue")
    assert names_of(run) == [run.system.laws.name(exact.entered(1))] == ["+0"]
    assert run.x[-1] == pytest.approx(exact.state(1.5), abs=1e-14)


def test_time_running_back_leaves_a_corner_by_the_reversed_fields():
    system = quadrants((-1, -1), (-2, 1), (1, -2), (-1, -1))
    run = core.integrate(system, (0.0, -2.0), (-1.0, -1.0), tau=0.125, method="rk2")
    assert names_of(run) == ["++"]
    assert run.x[-1] == pytest.approx([1.0, 1.0], abs=1e-14)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        (((1, 1), (-1, 1), (1, -1), (1, 1)), "more than one way"),
        (((1, 1), (1, -1), (-1, 1), (-1, -1)), "neither does sliding"),
        (((1, 1), (1, 1), (1, 1), (1, 0)), "tangent to one of them"),
        (((1, 1), (1, 1), (-1, 1), (-1, -1)), "sliding along one of them is at rest"),
    ],
)
def test_a_run_that_stops_at_a_corner_says_why(fields, words):
    run = run_of(quadrants(*fields), (-1.0, -1.0))
    assert run.status is core.Status.CORNER
    assert words in run.message
    with pytest.raises(ValueError, match=words):
        core.reference_solution(run.system, (-1.0, -1.0), sliding="continue").state(2.0)


@pytest.mark.parametrize(
    ("fields", "x0", "method", "tau"),
    [
        (((-2, -3), (1, -3), (-2, 2), (-1, 1)), (-1.0, 3.0), "taylor", 0.01),
        (((1, 3), (3, -1), (3, -1), (-1, -3)), (-3.0, 1.0), "rk4", 0.1),
        (((-2, -3), (1, -3), (-2, 2), (-1, 1)), (-1.0, 3.0), "rk8", 0.25),
    ],
)
def test_a_corner_at_the_origin_is_passed_whatever_part_of_a_step_is_left(fields, x0, method, tau):
    system = quadrants(*fields)
    run = core.integrate(system, (0.0, 3.0), x0, tau=tau, method=method, sliding="continue")
    exact = core.reference_solution(system, x0, sliding="continue").state(3.0)
    assert run.message == "t = 3: reached the end time."
    assert run.x[-1] == pytest.approx(exact, abs=1e-13)


def test_a_corner_at_the_origin_is_passed_at_every_step_size():
    system = quadrants((-2, -3), (1, -3), (-2, 2), (-1, 1))
    for parts in range(3, 60):
        run = core.integrate(system, (0.0, 3.0), (-1.0, 3.0), tau=1 / parts, method="rk4", sliding="continue")
        assert run.message == "t = 3: reached the end time."
        assert run.x[-1] == pytest.approx([-4.0, -6.0], abs=1e-13)


def test_a_corner_at_which_the_state_would_jump_is_not_passed():
    regions = {key: Region(("1", "1")) for key in KEYS}
    system = PiecewiseSystem("jump", ("x", "y"), surfaces=("x", "y"), regions=regions, x0=(-1.0, -1.0),
                             jumps={0: ("x", "y + 1")})  # fmt: skip
    run = core.integrate(system, (0.0, 2.0), tau=0.125, method="rk2")
    assert run.status is core.Status.CORNER
    assert "the state jumps" in run.message


def _neurons(
    surfaces: tuple[str, ...], kick: tuple[str, str], rates: tuple[str, str] = ("0.3", "0.2")
) -> core.Trajectory:
    """Where x comes to 1 it kicks the others; one that comes to 1 falls back, and kicks the other back."""
    jumps = {"x - 1": ("0", *kick), "y - 1": ("x", "0", "z - 1"), "z - 1": ("x", "y - 1", "0")}
    system = PiecewiseSystem(
        "neurons", ("x", "y", "z"), surfaces=surfaces, regions={"---": Region(("1", *rates))}, x0=(0.0, 0.6, 0.65),
        jumps={k: jumps[name] for k, name in enumerate(surfaces)},
    )  # fmt: skip
    return core.integrate(system, (0.0, 1.5), method="rk4", tau=0.01)


@pytest.mark.parametrize("rates", [("0.3", "0.2"), ("0", "0")])
@pytest.mark.parametrize("surfaces", [("x - 1", "y - 1", "z - 1"), ("x - 1", "z - 1", "y - 1")])
def test_a_jump_beyond_several_walls_ends_the_run_whatever_their_order(surfaces, rates):
    run = _neurons(surfaces, ("y + 0.5", "z + 0.6"), rates)
    assert run.status is core.Status.CORNER
    assert "beyond several surfaces at once" in run.message
    assert run.warning == ""
    assert run.t[-1] == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("surfaces", [("x - 1", "y - 1", "z - 1"), ("x - 1", "z - 1", "y - 1")])
def test_a_jump_beyond_one_wall_leads_on_by_the_jump_of_that_wall(surfaces):
    run = _neurons(surfaces, ("y + 0.5", "z"), ("0", "0"))
    assert run.message == "t = 1.5: reached the end time."
    assert [run.system.surfaces[k] for k in run.crossings.surface_met] == ["x - 1", "y - 1"]
    assert run.x[-1] == pytest.approx([0.5, 0.0, -0.35], abs=1e-14)


def test_at_an_instant_the_state_is_put_on_the_other_surfaces_of_the_corner():
    names = dict.fromkeys(("--", "-+", "+-", "++"), Region(("1", "1")))
    corner = PiecewiseSystem("instant", ("x", "y"), surfaces=("y + x**3", "t - 2"), regions=names)
    x = onto_surfaces(corner, 2.0, np.array([1.0, -1.0 + 1e-9]), (0, 1))
    assert x[1] + x[0] ** 3 == pytest.approx(0.0, abs=1e-15)
    assert onto_surfaces(corner, 2.0, x, (1,)).tolist() == x.tolist()
