"""Reference solutions against closed forms, 50-digit arithmetic and known hard cases of event location."""

from collections.abc import Sequence

import mpmath as mp
import numpy as np
import pytest
import sympy
from hypothesis import assume, example, given
from hypothesis import strategies as st

from core.reference import ExactSolution, ReferenceSolution, exact_solution, two_sides
from tests.core.reference.by_sides import by_sides
from tests.levels import tries

mp.mp.dps = 50
X, Y, Z, T = VARIABLES = sympy.symbols("x y z t")
# Times and states are kept to many digits and rounded once: half an ulp, doubled for the comparison.
ULP = float(np.finfo(float).eps)
T1 = mp.mpf("0.97519090872044962090445276709712799991")
T_IN = mp.mpf("0.64180734567849246142808665628974067987")
T_OUT = mp.mpf("1.25168416780647347707382984803609488499")
X_STAR = mp.mpf("-0.44504186791262880857780512899358951893")
Y_STAR = mp.mpf("0.89550976309855955275748939745235014621")


def exact(
    minus: Sequence[sympy.Expr],
    plus: Sequence[sympy.Expr],
    g: sympy.Expr,
    x0: Sequence[float],
    t0: float = 0.0,
) -> ExactSolution:
    fields = [tuple(map(sympy.sympify, f)) for f in (minus, plus)]
    solution = exact_solution(two_sides(fields[0], fields[1], sympy.sympify(g), VARIABLES[: len(x0)]), t0, x0)
    assert solution is not None
    return solution


def oscillator(minus: float, plus: float, x0: Sequence[float]) -> ExactSolution:
    return exact((Y, -sympy.Float(minus) * X), (Y, -sympy.Float(plus) * X), Y, x0)


def elliptic(minus: float, plus: float, x0: Sequence[float], radius: float = 1.0) -> ExactSolution:
    fields = [(2 * Y, 3 * X**2 + sympy.Float(a)) for a in (minus, plus)]
    return exact(fields[0], fields[1], X**2 + Y**2 - sympy.Float(radius) ** 2, x0)


def peer_elliptic(x0: Sequence[float]) -> ReferenceSolution:
    a = {-1: -3.0, 1: -2.0}
    return by_sides(
        lambda side, t, x: [2 * x[1], 3 * x[0] ** 2 + a[side]],
        lambda t, x: x[0] ** 2 + x[1] ** 2 - 1,
        lambda side, t, x: 2 * x[1] * (2 * x[0] + 3 * x[0] ** 2 + a[side]),
        0.0, x0,
    )  # fmt: skip


def rounding(value: float) -> float:
    """An ulp of the value."""
    return float(np.spacing(abs(value)))


@pytest.mark.parametrize("k", [1, 2, 3, 10, 20, 30])
def test_oscillator_crossings_are_exact(k: int) -> None:
    t, x = oscillator(3, 1, (1, 1)).crossing(k)
    below, above = mp.pi / mp.sqrt(3), mp.pi
    expected = mp.pi / 4 + (k // 2) * below + ((k - 1) // 2) * above
    assert abs(mp.mpf(t) - expected) <= rounding(t)
    assert abs(mp.mpf(x[0]) + (-1) ** k * mp.sqrt(2)) <= rounding(x[0])
    assert abs(x[1]) < rounding(1.0)


@pytest.mark.parametrize("k", [1, 2, 3, 10, 20, 30])
def test_elliptic_curve_crossings_are_exact(k: int) -> None:
    t, x = elliptic(-3, -2, (-1, -1)).crossing(k)
    expected = T1 + (k // 2) * T_IN + ((k - 1) // 2) * T_OUT
    assert abs(mp.mpf(t) - expected) <= rounding(t)
    assert abs(mp.mpf(x[0]) - X_STAR) <= rounding(x[0])
    assert abs(mp.mpf(x[1]) + (-1) ** k * Y_STAR) <= rounding(x[1])


def test_elliptic_gaps_agree_with_carlson_integrals() -> None:
    # the second route to the times: both arcs lie on the oval e3 ≤ x ≤ e2 of (x')² = 4(x³ + ax + ψ). Adding
    # the half period (e3, 0) takes the oval to the unbounded branch, where R_F is the time to the pole (DLMF
    # 19.25.35): so from x* to e3, and from x* to e2 the half period less that.  Each arc goes there and back.
    def to_lowest_root(a: float, psi: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        e1, e2, e3 = sorted(map(mp.re, mp.polyroots([1, 0, a, psi], maxsteps=200, extraprec=200)), reverse=True)
        moved = e3 + (e3 - e1) * (e3 - e2) / (X_STAR - e3)
        return mp.elliprf(moved - e1, moved - e2, moved - e3), mp.elliprf(0, e1 - e2, e1 - e3)

    times = [elliptic(-3, -2, (-1, -1)).crossing(k)[0] for k in (1, 2, 3)]
    inside, half_period = to_lowest_root(-3, X_STAR)
    outside, _ = to_lowest_root(-2, mp.mpf(0))
    # the difference of two times rounded to double: two ulps of 3
    assert abs(times[1] - times[0] - 2 * (half_period - inside)) <= 2 * rounding(3.0)
    assert abs(times[2] - times[1] - 2 * outside) <= 2 * rounding(3.0)


@given(
    *[st.floats(0.1, 9).map(lambda v: round(v, 6))] * 2,
    st.floats(-2, 2),
    st.floats(0.1, 2),
    st.integers(1, 12),
)
@tries(25)
def test_oscillator_crossings_are_exact_for_any_parameters(
    minus: float, plus: float, x: float, y: float, k: int
) -> None:
    solution = oscillator(minus, plus, (x, y))
    below, above = mp.sqrt(minus), mp.sqrt(plus)
    phase = mp.atan2(above * mp.mpf(x), mp.mpf(y))  # x = R sin(φ + ω t) / ω, y = R cos(φ + ω t)
    first = (mp.pi / 2 - phase) / above
    expected = first + (k // 2) * mp.pi / below + ((k - 1) // 2) * mp.pi / above
    radius = mp.sqrt(mp.mpf(x) ** 2 + (mp.mpf(y) / above) ** 2)
    t, state = solution.crossing(k)
    assert abs(t - expected) <= rounding(t)
    assert abs(state[0] + (-1) ** k * radius) <= rounding(state[0])


def series(a: float, start: Sequence[mp.mpf], t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """State after t of x' = 2y, y' = 3x² + a, by power series of degree 40 with steps R/10."""
    u, v = map(mp.mpf, start)
    done = mp.mpf(0)
    while done < t:
        p, q = [u], [v]
        for k in range(40):
            p.append(2 * q[k] / (k + 1))
            square = mp.fsum(p[i] * p[k - i] for i in range(k + 1))
            q.append((3 * square + (a if k == 0 else 0)) / (k + 1))
        # One coefficient may vanish by symmetry: of several, the largest tells the radius of convergence.
        radius = min(abs(s[k]) ** (-mp.mpf(1) / k) for s in (p, q) for k in range(30, 41) if s[k] != 0)
        h = min(radius / 10, t - done)
        u, v = mp.polyval(p[::-1], h), mp.polyval(q[::-1], h)
        done += h
    return u, v


@given(st.floats(-3.5, -1), st.floats(-3.5, -1), st.floats(-1.2, 0), st.floats(-1, 1), st.floats(0.6, 1.2))
@tries(12)
@example(-1.5, -1.0, 0.0, 0.0, 1.125)  # at rest to begin with: coefficient 40 vanishes
def test_elliptic_arcs_agree_with_power_series_for_any_parameters(
    minus: float, plus: float, x: float, y: float, radius: float
) -> None:
    assume(abs(x * x + y * y - radius**2) > 1e-3)
    solution = elliptic(minus, plus, (x, y), radius)
    t, state = 0.0, (mp.mpf(x), mp.mpf(y))
    for k in (1, 2, 3):
        try:
            t_next, x_next = solution.crossing(k)
        except ValueError as end:
            assert any(word in str(end) for word in ("escapes", "closes", "slides", "tangent"))  # noqa: PT017
            return
        side, a = (-1, minus) if x * x + y * y < radius**2 else (1, plus)
        side, a = (side, a) if k % 2 else (-side, plus if side < 0 else minus)
        middle = series(a, state, mp.mpf(t_next - t) / 2)
        assert side * (middle[0] ** 2 + middle[1] ** 2 - radius**2) > 0
        # the state between crossings and the next one: the times' rounding (ulp 2e-16 × speed) and the growth
        # of the start's along an arc of this size
        for end, got in (
            (middle, solution.state(t + (t_next - t) / 2)),
            (series(a, state, mp.mpf(t_next - t)), x_next),
        ):
            scale = 1 + max(map(abs, end)) ** 2
            assert max(abs(e - s) for e, s in zip(end, got, strict=True)) <= 100 * ULP * scale * (1 + t_next)
        t, state = t_next, tuple(map(mp.mpf, x_next))


def test_states_between_crossings_agree_with_mpmath_odefun() -> None:
    # from the exact x* on S into the disc; odefun is good to 1e-20, the time of the crossing to an ulp of 1
    path = mp.odefun(lambda t, s: [2 * s[1], 3 * s[0] ** 2 - 3], 0, [X_STAR, Y_STAR], tol=mp.mpf(10) ** -20)
    solution = elliptic(-3, -2, (-1, -1))
    for part in (0.2, 0.6):
        got = solution.state(float(T1) + part)
        expected = path(mp.mpf(float(T1) + part) - T1)
        assert max(abs(g - e) for g, e in zip(got, expected, strict=True)) < 4 * ULP


def test_state_and_side_are_continuous_and_carried_through_crossings() -> None:
    solution = elliptic(-3, -2, (-1, -1))
    for k in (1, 2, 7):
        t, x = solution.crossing(k)
        before, after = np.nextafter(t, 0), np.nextafter(t, 99)
        assert (solution.side(before), solution.side(t), solution.side(after)) == (
            (-1) ** (k - 1),
            *[(-1) ** k] * 2,
        )
        for u in (before, t, after):  # an ulp of t at a speed below 3.6, and the rounding of two states
            assert np.abs(solution.state(u) - x).max() < 4 * np.spacing(t) + ULP
    assert np.array_equal(solution.state(0.0), [-1, -1])


def test_crossings_are_computed_once() -> None:
    solution = elliptic(-3, -2, (-1, -1))
    last = solution.crossing(30)
    arcs = list(solution._fine._arcs)
    assert solution.crossing(7)[0] < solution.crossing(30)[0] == last[0]
    assert all(a is b for a, b in zip(arcs, solution._fine._arcs, strict=True))


def test_start_time_is_added_to_all_times() -> None:
    early, late = (exact((Y, -3 * X), (Y, -X), Y, (1, 1), t0) for t0 in (0.0, 5.0))
    assert late.crossing(3)[0] == pytest.approx(5 + early.crossing(3)[0], abs=2e-15)  # two ulps of 10
    with pytest.raises(ValueError, match="at least 5"):
        late.state(4.0)


@pytest.mark.parametrize("exponent", [2, 6, 10, 14])
def test_grazing_ladder_has_twenty_crossings_in_ten_periods(exponent: int) -> None:
    delta = mp.mpf(10) ** -exponent
    g = X - 1 + sympy.Rational(1, 10**exponent)
    solution = exact((Y, -X), (Y, -X), g, (0, 1))
    times = np.array([solution.crossing(k)[0] for k in range(1, 22)])
    assert np.sum(times < 20 * np.pi) == 20
    assert abs(times[0] - (mp.pi / 2 - mp.acos(1 - delta))) <= rounding(times[0])


def test_spiral_crosses_the_circle_once_at_time_one() -> None:
    w = -2 * sympy.pi
    inside, outside = (X + w * Y, -w * X + Y), (X - w * Y, w * X + Y)
    solution = exact(inside, outside, X**2 + Y**2 - 1, (float(np.exp(-1)), 0.0))
    t, x = solution.crossing(1)
    # 1/e is rounded: t = 1 and the angle 2πt are off by up to an ulp of 1 and 7 of them
    assert abs(t - 1) <= ULP
    assert np.abs(x - [1, 0]).max() < 7 * ULP
    expected = np.exp(0.5) * np.array([np.cos(np.pi), np.sin(np.pi)])
    assert np.abs(solution.state(1.5) - expected).max() < 20 * ULP


def test_coulomb_friction_turns_three_times_and_sticks_at_four_pi() -> None:
    solution = exact((Y, -X + sympy.Rational(2, 5)), (Y, -X - sympy.Rational(2, 5)), Y, (3, 0))
    for k, turn in enumerate((-2.2, 1.4, -0.6), start=1):
        t, x = solution.crossing(k)
        assert abs(t - k * mp.pi) <= rounding(t)
        assert abs(x[0] - turn) <= 2 * ULP
    with pytest.raises(ValueError, match=r"ends at t = 12\.566.*slides along the surface"):
        solution.crossing(4)
    with pytest.raises(ValueError, match="slides along the surface"):
        solution.state(13.0)
    assert solution.stop is not None
    assert abs(solution.stop.t - 4 * mp.pi) <= rounding(12.0)
    assert abs(solution.stop.x[0] + 0.2) <= 2 * ULP
    assert abs(solution.state(12.5)[1]) > 0


def test_start_on_the_surface_follows_the_fields() -> None:
    # from (−√2, 0) both fields point up, from (√2, 0) down; half a turn later is the first crossing
    for x, side, gap in ((-np.sqrt(2), 1, np.pi), (np.sqrt(2), -1, np.pi / np.sqrt(3))):
        solution = oscillator(3, 1, (x, 0.0))
        assert solution.side(0.0) == side
        assert solution.crossing(1)[0] == pytest.approx(gap, abs=4e-16)
    angle = 2.0312  # on the circle but for the rounding of sin and cos: entered, not crossed at once
    solution = elliptic(-3, -2, (float(np.cos(angle)), float(np.sin(angle))))
    assert solution.side(0.0) == -1
    assert solution.crossing(1)[0] > 0.1


@pytest.mark.parametrize(
    ("minus", "plus", "words"),
    [
        ((1, 1), (1, -1), "attracts both fields"),
        ((1, -1), (1, 1), "repels both"),
        ((1, 0), (1, 1), "tangent to one"),
    ],
)
def test_start_on_the_surface_without_a_side_to_enter_is_refused(
    minus: Sequence[int], plus: Sequence[int], words: str
) -> None:
    fields = [tuple(map(sympy.Integer, f)) for f in (minus, plus)]
    with pytest.raises(ValueError, match=words):
        exact_solution(two_sides(fields[0], fields[1], Y, (X, Y)), 0.0, (0.0, 0.0))


def test_tangency_of_the_other_side_ends_the_solution() -> None:
    solution = exact((1, X - 1), (1, -1), Y, (0, 1))
    with pytest.raises(ValueError, match=r"t = 1,.*other side is tangent"):
        solution.crossing(1)


def test_touching_the_surface_from_inside_is_no_crossing() -> None:
    # x reaches 1 at π/2 with ẋ = 0: whichever way its rounding falls, there is no transversal crossing
    solution = exact((Y, -X), (Y, -X), X - 1, (0, 1))
    with pytest.raises(ValueError, match=r"tangent|closes"):
        solution.crossing(1)


def test_escape_to_infinity_is_reported_with_its_time() -> None:
    solution = exact((2 * Y, 3 * X**2 + 1), (2 * Y, 3 * X**2 + 1), X + 5, (1, 1))
    with pytest.raises(ValueError, match=r"no crossing follows.*escapes to infinity at t = 0\.97"):
        solution.crossing(1)
    with pytest.raises(ValueError, match="escapes to infinity"):
        solution.state(5.0)
    assert np.isfinite(solution.state(0.5)).all()


def test_closed_orbit_inside_one_side_is_reported_and_known_at_all_times() -> None:
    solution = exact((2 * Y, 3 * X**2 - 3), (2 * Y, 3 * X**2 - 3), X - 5, (-1.2, 0))
    with pytest.raises(ValueError, match="orbit closes after a period"):
        solution.crossing(1)
    assert np.abs(solution.state(1e5)).max() < 2


def test_search_without_end_is_cut_off() -> None:
    solution = exact((-X, -2 * Y), (-X, -2 * Y), X + 1, (1, 1))  # decays towards 0, never to x = −1
    with pytest.raises(ValueError, match=r"no crossing follows.*comes to rest"):
        solution.crossing(1)
    solution = exact((-X, -2 * Y), (-X, -2 * Y), X + 1 + T, (1, 1))  # and a surface that leaves it behind
    with pytest.raises(ValueError, match="no crossing found in 2000 steps"):
        solution.crossing(1)
    with pytest.raises(ValueError, match="crossing must be from 1"):
        solution.crossing(0)


@pytest.mark.parametrize("rate", [300, 1000])
def test_start_at_the_origin_beside_a_fast_mode_is_exact(rate: int) -> None:
    f = (sympy.Integer(1), 1 - rate * Y)
    solution = exact(f, f, X + Y - 2, (0.0, 0.0))
    assert solution.state(1.0) == pytest.approx([1.0, 1 / rate], rel=1e-15)
    assert solution.exact


def test_ballistic_arc_is_exact_from_metres_to_light_years() -> None:
    # v' = −g has no rate of its own: t = v/g + √(v² + 2gh)/g over sixteen decades
    for height in (1e-8, 1.0, 1e8):
        t, x = exact((Y, -10), (Y, -10), X, (height, 0)).crossing(1)
        assert t == pytest.approx(np.sqrt(height / 5), rel=4e-16)
        assert abs(x[0]) <= ULP * height


@pytest.mark.parametrize(("plus", "g"), [((Y, -sympy.tan(X)), Y), ((Y, -X), Y - Z), ((Y, -X + T), Y), ((Y, -Z * X), Y)])
def test_no_exact_solution_without_a_closed_form(plus: tuple[sympy.Expr, ...], g: sympy.Expr) -> None:
    assert exact_solution(two_sides((Y, -X), plus, g, (X, Y)), 0.0, (1.0, 1.0)) is None


def test_names_tell_what_a_solution_rests_on() -> None:
    assert oscillator(3, 1, (1, 1)).name == "exact (linear flow)"
    assert elliptic(-3, -2, (-1, -1)).name == "exact (Weierstrass ℘)"
    assert peer_elliptic((-1.0, -1.0)).name == "SciPy DOP853, rtol 1e-13"


def test_peer_agrees_with_the_exact_solution_to_its_tolerance() -> None:
    # rtol 1e-13 a step, some 20 steps a unit of time for 30 units, errors growing linearly: 1e-12
    peer, solution = peer_elliptic((-1.0, -1.0)), elliptic(-3, -2, (-1, -1))
    for k in (1, 10, 30):
        assert abs(peer.crossing(k)[0] - solution.crossing(k)[0]) < 1e-12
        assert np.abs(peer.crossing(k)[1] - solution.crossing(k)[1]).max() < 1e-12
    for t in (0.5, 13.3, 28.0):
        assert np.abs(peer.state(t) - solution.state(t)).max() < 2e-12
        assert peer.side(t) == solution.side(t)


def test_peer_finds_three_roots_that_fall_in_one_step() -> None:
    solution = by_sides(
        lambda side, t, x: [3 * t**2 + 12 * t - 4],
        lambda t, x: x[0],
        lambda side, t, x: 3 * t**2 + 12 * t - 4,
        -7.0,
        [(-7 + 6) * (-7 + 2) * (-7 - 2)],
    )
    # |y'| is at least 16 at the roots and |y| at most 45: rtol 1e-13 leaves 1e-12 in t
    assert [solution.crossing(k)[0] for k in (1, 2, 3)] == pytest.approx([-6, -2, 2], abs=1e-12)


def test_peer_follows_a_field_switched_by_the_clock() -> None:
    def field(side: int, t: float, x: np.ndarray) -> list[float]:
        return [x[1], 0.2 * x[1] - (np.pi**2 + 0.01) * x[0] + side]

    solution = by_sides(
        field,
        lambda t, x: float(np.sin(np.pi * t)),
        lambda side, t, x: float(np.pi * np.cos(np.pi * t)),
        0.0,
        (0, 0),
    )
    # the reference value; the solution grows to 13, rtol 1e-13 over some 1,000 steps, resonantly: 1e-10
    assert solution.state(20.0) == pytest.approx([-12.94460621213470, 0], abs=1e-10)
    assert solution.crossing(7)[0] == pytest.approx(7, abs=1e-14)


def test_peer_stops_on_a_sliding_surface_and_at_a_blow_up() -> None:
    slides = by_sides(lambda s, t, x: [1, -s], lambda t, x: x[1], lambda s, t, x: -s, 0.0, (0.0, 1.0))
    with pytest.raises(ValueError, match=r"ends at t = (1|0\.99999).*slides along the surface"):
        slides.crossing(1)
    bursts = by_sides(lambda s, t, x: [x[0] ** 2], lambda t, x: x[0], lambda s, t, x: x[0] ** 2, 0.0, (1.0,))
    with pytest.raises(ValueError, match=r"integrator stops at t = 0\.99|integrator stops at t = 1"):
        bursts.crossing(1)
