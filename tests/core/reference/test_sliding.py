"""Exact solutions along sliding: against matrix exponentials in 30 digits, and against what is found by hand."""

import mpmath as mp
import numpy as np
import pytest

import core
from core import Region
from tests.core.sliding_solutions import DIGITS, friction, relay


def linear(oracle, names, x0):
    """The system of an oracle, whose forcing is a part of the state."""
    d = len(names)
    terms = [f"*{name}" for name in names] + [""] * (len(oracle.n) - d)

    def text(row):
        return " + ".join(f"({float(c)!r}){term}" for c, term in zip(row, terms, strict=True))

    fields = {side: tuple(text(oracle.m[side].tolist()[r]) for r in range(d)) for side in (-1, 1)}
    return core.PiecewiseSystem("linear", tuple(names), fields[-1], fields[1], text(list(oracle.n)), x0=x0)


CASES = {
    "block": (lambda: friction("3", "-0.125", 14, "0.4", "0.6", "0.5"), "yvcs", (3.0, -0.125, 1.0, 0.0)),
    "relay": (lambda: relay(("0.5", "0", "0.3"), 9), "xyz", (0.5, 0.0, 0.3)),
}


@pytest.mark.parametrize("case", CASES)
def test_sliding_begins_and_ends_as_in_30_digits(case):
    make, names, x0 = CASES[case]
    with mp.workdps(DIGITS):
        expected = make()
    solution = core.reference_solution(linear(expected, names, x0), sliding="continue")
    for k, (t, z, side, _) in enumerate(expected.arcs[1:], start=1):
        found, x = solution.crossing(k)
        assert abs(found - t) <= np.spacing(float(t))
        assert np.abs(x - np.array(z[: len(x)], dtype=float)).max() <= 1e-15 * float(max(map(abs, z)))
        assert solution.entered(k) == side
        state = expected.state(float(t) + 0.05, len(x))
        assert np.abs(solution.state(float(t) + 0.05) - state).max() <= 1e-15 * np.abs(state).max()
        assert solution.side(float(t) + 0.05) == side
    assert "leaving" in expected.kinds
    assert solution.name == "exact (linear flow)"
    assert solution.exact
    assert 0.0 < solution.error < 1e-17


def test_a_block_that_sticks_rests():
    solution = core.reference_solution("coulomb_friction", sliding="continue")
    t, x = solution.crossing(4)
    assert t == pytest.approx(4 * np.pi, rel=1e-15)
    assert solution.entered(4) == solution.side(1e4) == 0
    assert np.abs(solution.state(1e4) - x).max() < 1e-25
    with pytest.raises(ValueError, match="at rest"):
        solution.crossing(5)


def test_the_relay_of_the_catalogue_slides_to_rest_as_an_exponential():
    # along x = −θv the state obeys x' = −x/θ
    solution = core.reference_solution("relay_feedback", sliding="continue")
    k = next(k for k in range(1, 20) if solution.entered(k) == 0)
    t, x = solution.crossing(k)
    for s in (0.5, 5.0):
        expected = x * np.exp(-s / 0.15)
        assert solution.state(t + s) == pytest.approx(expected, rel=1e-13)
    assert solution.exact


STRIPS = {"surfaces": ("x", "y"), "variables": ("x", "y"), "x0": (-1.0, 1.0)}


def strips(**fields):
    """Constant fields of the quadrants."""
    return core.PiecewiseSystem("strips", regions={key: Region(f=f) for key, f in fields.items()}, **STRIPS)


DOWN, UP = ("1", "-1"), ("1", "1")


def test_sliding_goes_on_beyond_another_surface_if_both_fields_there_point_to_it():
    system = strips(**{"--": UP, "-+": ("1/2", "-1"), "+-": UP, "++": ("3", "-1/2")})
    solution = core.reference_solution(system, sliding="continue")
    # y = 0 is met at x = −1/2, t = 1; along it x' = 3/4, and beyond x = 0 it is (1 · 3 + 1/2 · 1)/(3/2) = 7/3
    names = [system.laws.name(solution.entered(k)) for k in (1, 2)]
    assert names == ["-0", "+0"]
    assert [solution.crossing(k)[0] for k in (1, 2)] == pytest.approx([1.0, 1.0 + 2 / 3], rel=1e-16)
    assert solution.state(8 / 3) == pytest.approx([7 / 3, 0.0], rel=4e-16, abs=1e-25)
    assert solution.exact


def test_sliding_that_reaches_a_surface_beyond_which_it_does_not_go_on_ends_in_words():
    system = strips(**{"--": UP, "-+": DOWN, "+-": DOWN, "++": UP})
    with pytest.raises(ValueError, match=r"ends at t = 1,.*in more than one way"):
        core.reference_solution(system, (-1.0, 0.0), sliding="continue").state(2.0)


def test_a_start_on_the_surface_that_attracts_slides():
    system = strips(**{"--": UP, "-+": DOWN, "+-": UP, "++": DOWN})
    solution = core.reference_solution(system, (-1.0, 0.0), sliding="continue")
    assert system.laws.name(solution.side(0.5)) == "-0"
    assert np.array_equal(solution.state(3.0), [2.0, 0.0])
    with pytest.raises(ValueError, match="slides along"):
        core.reference_solution(system, (-1.0, 0.0)).state(3.0)


def test_where_both_fields_turn_at_once_sliding_ends_in_words():
    # along y = 0 the rates are ±(1 − x)
    system = core.PiecewiseSystem("fold", ("x", "y"), ("1", "1 - x"), ("1", "x - 1"), "y", x0=(0.0, 0.0))
    with pytest.raises(ValueError, match=r"ends at t = 1,.*both fields turn at once"):
        core.reference_solution(system, sliding="continue").state(2.0)


def test_sliding_along_a_circle_is_exact_where_it_is_a_rotation():
    # half the sum of both fields turns with half the speed
    system = core.PiecewiseSystem("ring", ("x", "y"), ("x", "y"), ("-x - y", "x - y"), "x**2 + y**2 - 1", x0=(0.5, 0.0))
    solution = core.reference_solution(system, sliding="continue")
    assert solution.crossing(1)[0] == pytest.approx(np.log(2.0), rel=1e-15)
    assert solution.state(np.log(2.0) + 1.0) == pytest.approx([np.cos(0.5), np.sin(0.5)], rel=4e-16)
    assert solution.exact


def test_a_field_that_is_linear_only_on_the_surface_is_exact_along_it():
    # (1 · (2 − y) + (1 + 3y)(1 + y))/(2 + 3y) is 3/2 where y = 0
    system = core.PiecewiseSystem("half", ("x", "y"), ("1 + y", "1"), ("2 - y", "-1 - 3*y"), "y", x0=(0.0, -1.0))
    solution = core.reference_solution(system, sliding="continue")
    assert solution.crossing(1)[0] == 1.0
    assert solution.state(3.0) == pytest.approx([3.5, 0.0], rel=4e-16, abs=1e-25)
    assert solution.exact


def test_the_taylor_method_goes_on_where_no_closed_form_of_sliding_is_known():
    # the circle is met at (0.8, 0.6); along it x' = 1 − x
    system = core.PiecewiseSystem("ring", ("x", "y"), ("1", "0"), ("-x", "-y"), "x**2 + y**2 - 1", x0=(0.0, 0.6))
    solution = core.reference_solution(system, sliding="continue")
    assert solution.state(0.5) == pytest.approx([0.5, 0.6], rel=1e-15)
    assert solution.exact
    assert solution.crossing(1)[0] == pytest.approx(0.8, rel=1e-12)
    x = 1.0 - 0.2 * np.exp(-1.0)
    assert solution.state(1.8) == pytest.approx([x, np.sqrt(1.0 - x * x)], rel=1e-11)
    assert not solution.exact
    assert "Taylor" in solution.name


def ends(solution):
    """What `.stop` is where the solution ends: time and reason are those of the error."""
    assert solution.stop is None
    with pytest.raises(ValueError, match="the solution ends at") as ended:
        solution.state(30.0)
    assert f"t = {solution.stop.t:.16g}, x = (" in str(ended.value)
    assert solution.stop.reason in str(ended.value)
    return solution.stop


def test_every_kind_of_reference_says_by_the_same_word_where_and_why_it_ends():
    # It slides along y = 0, by a field without a closed form, to x = 1, beyond which no law is declared.
    waves = {key: Region(("sin(x) + 1", v)) for key, v in (("--", "1"), ("-+", "-1"))}
    system = core.PiecewiseSystem("waves", ("x", "y"), surfaces=("x - 1", "y"), regions=waves, x0=(-1.0, 0.5))
    stops = [ends(core.reference_solution(system, sliding="continue", independent=u)) for u in (False, True)]
    assert stops[0].t == pytest.approx(stops[1].t, abs=1e-11)
    assert all("not declared" in stop.reason for stop in stops)
    leaves = strips(**{"--": UP, "-+": DOWN, "+-": DOWN, "++": UP})
    stop = ends(core.reference_solution(leaves, (-1.0, 0.0), sliding="continue"))
    assert (stop.t, stop.unknown) == (1.0, False)


@pytest.mark.parametrize("independent", [False, True])
def test_a_solution_that_is_continued_does_not_stop_where_closed_forms_do(independent):
    fields = {"f_minus": ("1", "1"), "f_plus": ("x", "x - 1")}
    system = core.PiecewiseSystem("turns", ("x", "y"), **fields, g="y", x0=(0.25, 0.5))
    solution = core.reference_solution(system, sliding="continue", independent=independent)
    assert [solution.entered(k) for k in (1, 2)] == [0, 1]
    assert not solution.exact
    assert solution.stop is None
