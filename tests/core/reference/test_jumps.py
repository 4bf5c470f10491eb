"""Solutions that jump at the surface, against closed forms: impacts, and where they accumulate."""

from collections.abc import Sequence

import mpmath as mp
import numpy as np
import pytest
import sympy

from core.reference import ReferenceSolution, exact_solution, two_sides
from tests.core.reference.by_sides import by_sides

mp.mp.dps = 40
X, Y = VARIABLES = sympy.symbols("x y")
T = sympy.Symbol("t")
ULP = float(np.finfo(float).eps)
GRAVITY = sympy.Float(9.8)


def exact(
    field: Sequence[sympy.Expr], g: sympy.Expr, jump: Sequence[sympy.Expr], x0: Sequence[float], t0: float = 0.0
) -> ReferenceSolution:
    """The same field on both sides."""
    same, after = tuple(map(sympy.sympify, field)), tuple(map(sympy.sympify, jump))
    solution = exact_solution(two_sides(same, same, sympy.sympify(g), VARIABLES, after), t0, x0)
    assert solution is not None
    return solution


def ball(left: float, t0: float = 0.0) -> ReferenceSolution:
    """From height 1 at rest; `left` of the speed is left after a bounce."""
    return exact((Y, -GRAVITY), X, (0, -sympy.Float(left) * Y), (1.0, 0.0), t0)


def peer_ball(left: float) -> ReferenceSolution:
    return by_sides(
        lambda side, t, x: [x[1], -9.8], lambda t, x: x[0], lambda side, t, x: x[1], 0.0, (1.0, 0.0),
        jump=lambda t, x: [0.0, -left * x[1]],
    )  # fmt: skip


@pytest.mark.parametrize("k", [1, 2, 3, 10, 25])
@pytest.mark.parametrize("left", [0.5, 0.9])
def test_bounces_are_exact(k: int, left: float) -> None:
    fall = mp.sqrt(2 / mp.mpf(9.8))
    solution = ball(left)
    t, x = solution.crossing(k)
    assert abs(t - fall * (1 + 2 * mp.fsum(mp.mpf(left) ** j for j in range(1, k)))) <= np.spacing(t)
    speed = 9.8 * fall * mp.mpf(left) ** (k - 1)
    assert abs(x[0]) <= 4 * ULP * float(speed)  # met to an ulp of time
    assert abs(x[1] + speed) <= 2 * ULP * speed
    assert solution.after(k)[0] == 0
    assert abs(solution.after(k)[1] - left * speed) <= 2 * ULP * speed
    assert solution.side(t) == solution.side(np.nextafter(t, 0)) == 1


def test_height_between_bounces_is_a_parabola() -> None:
    solution, fall = ball(0.5), mp.sqrt(2 / mp.mpf(9.8))
    # half a flight after the first bounce: a quarter of the height, at rest
    assert np.abs(solution.state(float(fall * mp.mpf(1.5))) - [0.25, 0]).max() <= 8 * ULP
    t, _ = solution.crossing(1)
    assert np.abs(solution.state(t) - solution.after(1)).max() <= 4 * ULP  # t is rounded to double


def test_bounces_accumulate_and_the_solution_ends_there_in_words() -> None:
    solution = ball(0.5)
    end = 3 * mp.sqrt(2 / mp.mpf(9.8))
    assert float(end) == pytest.approx(1.3552618543578767, rel=1e-16)
    with pytest.raises(ValueError, match=r"ends at t = 1\.35526185435.*accumulate"):
        solution.state(2.0)
    assert solution.stop is not None
    # the last of ten bounces within 1e-9 of the time: a flight of 2⁻⁹ of that is still to come
    assert 0 <= end - solution.stop.t <= 1e-9 / 2**9 * float(end)
    assert abs(solution.state(1.0)[0]) < 1
    with pytest.raises(ValueError, match="accumulate"):
        solution.crossing(200)
    late = ball(0.5, t0=1e6)  # an ulp of 1e6 is 1e-10: three bounces within 1000 of them end it
    with pytest.raises(ValueError, match="accumulate"):
        late.state(1e6 + 2)
    assert late.stop is not None
    assert abs(late.stop.t - 1e6 - end) < 1000 * np.spacing(1e6)


def test_bounces_that_lose_nothing_go_on() -> None:
    t, x = ball(1.0).crossing(200)
    assert abs(t - 399 * mp.sqrt(2 / mp.mpf(9.8))) <= np.spacing(t)
    assert abs(x[1] + mp.sqrt(2 * mp.mpf(9.8))) <= 4 * ULP


def test_peer_bounces_as_the_exact_ball_and_ends_where_it_does() -> None:
    peer, solution = peer_ball(0.5), ball(0.5)
    for k in (1, 5, 20):
        assert peer.crossing(k)[0] == pytest.approx(solution.crossing(k)[0], abs=1e-13)
        assert peer.after(k) == pytest.approx(solution.after(k), abs=1e-13)
    with pytest.raises(ValueError, match="accumulate"):
        peer.state(2.0)
    assert peer.stop is not None
    assert peer.stop.t == pytest.approx(1.3552618543578767, abs=1e-11)


def test_bounces_that_lose_nearly_all_end_within_round_off_of_time() -> None:
    # a tenth left: flights below an ulp of the external one time before ten bounces lie close together
    peer, end = peer_ball(0.1), mp.sqrt(2 / mp.mpf(9.8)) * (1 + mp.mpf(2) / 9)
    with pytest.raises(ValueError, match="accumulate"):
        peer.state(2.0)
    assert peer.stop is not None
    assert abs(peer.stop.t - end) <= 1000 * np.spacing(1.0)


def test_bouncing_oscillator_hits_its_wall_every_half_turn() -> None:
    # x'' = −4x, wall at 0, 0.8 of the speed left: all flights take π/2, the first one to the wall (x0 at rest) π/4
    solution = exact((Y, -4 * X), X, (X, -sympy.Float(0.8) * Y), (1.5, 0.0))
    for k in (1, 2, 7, 30):
        t, x = solution.crossing(k)
        assert abs(t - mp.pi * (2 * k - 1) / 4) <= np.spacing(t)
        assert abs(x[1] + 3 * mp.mpf(0.8) ** (k - 1)) <= 2 * ULP * abs(x[1])
    middle = (solution.crossing(7)[0] + solution.crossing(8)[0]) / 2
    assert abs(solution.state(middle)[0] - mp.mpf(1.5) * mp.mpf(0.8) ** 7) <= 8 * ULP


def test_pendulum_against_a_wall_swings_in_halves_of_its_period() -> None:
    # an elastic wall at the bottom: from rest at 2 rad it hits after a quarter period, then every half of one
    solution = exact((Y, -sympy.sin(X)), X, (X, -Y), (2.0, 0.0))
    quarter = mp.ellipk(mp.sin(1) ** 2)
    for k in (1, 2, 11):
        assert abs(solution.crossing(k)[0] - (2 * k - 1) * quarter) <= np.spacing(solution.crossing(k)[0])
    assert solution.name == "exact (Jacobi am)"


def test_ball_on_a_table_that_sinks_is_hit_where_it_then_is() -> None:
    # the table is at −t; relative to it the speed is reversed, y → −y − 2
    solution = exact((Y, -GRAVITY), X + T, (X, -Y - 2), (1.0, 0.0))
    # 1 − 4.9 t² = −t; in the table's frame an elastic ball of energy 1/2 + 9.8: flights of 2 √(1 + 19.6) / 9.8
    first = (1 + mp.sqrt(1 + 4 * mp.mpf(9.8) / 2)) / mp.mpf(9.8)
    flight = 2 * mp.sqrt(1 + 2 * mp.mpf(9.8)) / mp.mpf(9.8)
    for k in (1, 2, 9):
        t, x = solution.crossing(k)
        assert abs(t - first - (k - 1) * flight) <= np.spacing(t)
        assert abs(x[0] + t) <= 4 * np.spacing(t)


def test_jump_enters_the_side_where_the_fields_lead() -> None:
    # y upward is kept by the jump: the surface is crossed, to the other side
    solution = exact((Y, 0), X, (0, Y / 2), (-1.0, 2.0))
    t, _ = solution.crossing(1)
    assert (solution.side(t), t) == (1, 0.5)
    assert np.abs(solution.state(1.5) - [1, 1]).max() <= 2 * ULP


def test_jump_off_the_surface_goes_on_from_the_side_it_leads_to() -> None:
    # a clock: x runs to 1 and starts again from 0
    solution = exact((1, 0), X - 1, (0, Y + 1), (0.0, 0.0))
    for k in (1, 2, 12):
        t, x = solution.crossing(k)
        assert (t, x[0], solution.side(t)) == (k, 1, -1)
        assert np.array_equal(solution.after(k), [0, k])


@pytest.mark.parametrize(
    ("minus", "plus", "start", "after", "words"),
    [
        ((Y, -1), (Y, -1), (1.0, 0.0), (X, 0), "neither field leads away"),
        ((2 * Y - 1, 0), (1, 0), (-1.0, 1.0), (X, -Y), "both fields lead away"),
        ((Y, -1), (Y, -1), (1.0, 0.0), (sympy.sqrt(X - 1), Y), "nothing is defined"),
    ],
)
def test_jump_from_which_nothing_leads_on_ends_the_solution(
    minus: Sequence[sympy.Expr],
    plus: Sequence[sympy.Expr],
    start: Sequence[float],
    after: Sequence[sympy.Expr],
    words: str,
) -> None:
    below, above, jump = (tuple(map(sympy.sympify, f)) for f in (minus, plus, after))
    solution = exact_solution(two_sides(below, above, X, VARIABLES, jump), 0.0, start)
    assert solution is not None
    with pytest.raises(ValueError, match=words):
        solution.crossing(1)
    assert solution.stop is not None
