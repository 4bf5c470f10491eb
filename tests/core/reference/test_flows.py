"""Exact flows against mpmath in 50 digits: power series, matrix exponentials and elliptic integrals."""

from collections.abc import Sequence

import mpmath as mp
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from core.reference.flows import Flow, LinearFlow, PendulumFlow, RigidBodyFlow, WeierstrassFlow
from core.reference.recognition import recognise
from tests.levels import tries

mp.mp.dps = 50
X, Y, Z, T = sympy.symbols("x y z t")
# Errors relative to the condition number measure 8 roundings of long double on random orbits; 1,000 leave room
# for what hypothesis finds.  On x86 that is 1e-16, half an ulp of double: rounding the result costs as much.
TOLERANCE = 1000 * float(np.finfo(np.longdouble).eps)
PARAMETER = st.floats(-4, 4).map(lambda v: round(v, 6))
COORDINATE = st.floats(-1.5, 1.5).map(lambda v: round(v, 6))


def flow_of(*field: sympy.Expr, variables: Sequence[sympy.Symbol] = (X, Y)) -> Flow:
    flow = recognise(tuple(map(sympy.sympify, field)), tuple(variables))
    assert flow is not None
    return flow


def cubic(alpha: float, beta: float, gamma: float, delta: float) -> Flow:
    """The flow of u' = αv, v' = βu² + γu + δ, for floats taken at their exact binary values."""
    a, b, c, d = map(sympy.Float, (alpha, beta, gamma, delta))
    return flow_of(a * Y, b * X**2 + c * X + d)


def series(c: Sequence[float], start: Sequence[mp.mpf], t: float) -> tuple[mp.mpf, mp.mpf]:
    """State after t of u' = αv, v' = βu² + γu + δ, by power series of degree 40 with steps R/10: 1e-40."""
    alpha, beta, gamma, delta = map(mp.mpf, c)
    u, v = map(mp.mpf, start)
    done, end, sign = mp.mpf(0), abs(mp.mpf(t)), mp.sign(t)
    while done < end:
        a, b = [u], [v]
        for k in range(40):
            square = mp.fsum(a[i] * a[k - i] for i in range(k + 1))
            a.append(alpha * b[k] / (k + 1))
            b.append((beta * square + gamma * a[k] + (delta if k == 0 else 0)) / (k + 1))
        # One coefficient may vanish by symmetry: of several, the largest tells the radius of convergence.
        sizes = [abs(s[k]) ** (-mp.mpf(1) / k) for s in (a, b) for k in range(30, 41) if s[k] != 0]
        radius = min(sizes, default=mp.mpf(10))
        h = min(radius / 10, end - done)
        u, v = mp.polyval(a[::-1], sign * h), mp.polyval(b[::-1], sign * h)
        done += h
    return u, v


def condition(c: Sequence[float], start: Sequence[float], t: float, end: Sequence[mp.mpf]) -> float:
    """How much the flow magnifies a change of its start, or the size of its end if that is more."""
    tiny = mp.mpf(10) ** -22
    moved = [series(c, [start[0] + du, start[1] + dv], t) for du, dv in ((tiny, mp.mpf(0)), (mp.mpf(0), tiny))]
    growth = max(abs(m - e) / tiny for state in moved for m, e in zip(state, end, strict=True))
    return float(max(growth, *map(abs, end), 1))


def assert_state(flow: Flow, c: Sequence[float], start: Sequence[float], t: float) -> None:
    end = series(c, [mp.mpf(s) for s in start], t)
    got = [mp.mpf(str(s)) for s in flow(start, [t])[0]]
    error = max(abs(a - b) for a, b in zip(got, end, strict=True))
    # a rounding of a coefficient acts for all of t
    assert error <= TOLERANCE * condition(c, start, t, end) * (1 + abs(t))


def roots_of(c: Sequence[float], start: Sequence[float]) -> tuple[mp.mpf, mp.mpf, list[mp.mpc]]:
    """X, X' of the start and the roots of the cubic, real ones in decreasing order first."""
    alpha, beta, gamma, delta = map(mp.mpf, c)
    scale, shift = 6 / (alpha * beta), -gamma / (2 * beta)
    x, y = (start[0] - shift) / scale, alpha * start[1] / scale
    g2 = -2 * alpha * (beta * shift**2 + gamma * shift + delta) / scale
    roots = mp.polyroots([4, 0, -g2, y**2 + g2 * x - 4 * x**3], maxsteps=500, extraprec=300)
    return x, y, sorted(roots, key=lambda r: (abs(mp.im(r)) > mp.mpf(10) ** -30, -mp.re(r)))


@given(
    st.integers(1, 4).flatmap(lambda d: st.lists(st.floats(-2, 2), min_size=d * (d + 2), max_size=d * (d + 2))),
    st.floats(-5, 5),
)
@tries(30)
def test_affine_flow_is_the_matrix_exponential_for_any_matrix(numbers: list[float], t: float) -> None:
    d = int(np.sqrt(len(numbers) + 1)) - 1
    values = np.round(np.array(numbers), 3)  # singular and defective matrices among them
    a, b, x0 = values[: d * d].reshape(d, d), values[d * d : d * d + d], values[d * d + d :]
    block = mp.zeros(d + 1)
    for i in range(d):
        block[i, d] = mp.mpf(b[i])
        for j in range(d):
            block[i, j] = mp.mpf(a[i, j])
    exponential = mp.expm(block * mp.mpf(t))
    exact = exponential * mp.matrix([mp.mpf(v) for v in (*x0, 1.0)])
    got = LinearFlow(a.astype(np.longdouble), b.astype(np.longdouble))(x0, [t])[0]
    size = mp.mnorm(exponential, 1) * max(1, np.abs(x0).max())
    assert max(abs(mp.mpf(str(got[i])) - exact[i]) for i in range(d)) <= TOLERANCE * size


def test_ten_thousand_radians_of_oscillation_lose_no_digit_of_double() -> None:
    # phase error: 1e4 rad × 2⁻⁶⁴ × about 4 roundings; plain double would lose four digits
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("long double is double here")
    flow = flow_of(Y, -3 * X)
    w = mp.sqrt(3)
    got = flow([1.0, 1.0], [1e4 / float(w)])[0]
    t = mp.mpf(1e4 / float(w))
    assert abs(mp.mpf(str(got[0])) - (mp.cos(w * t) + mp.sin(w * t) / w)) < 1e-14


@given(PARAMETER, COORDINATE, COORDINATE, st.floats(-0.95, 0.95))
@tries(30)
def test_elliptic_states_agree_with_power_series_on_oval_and_unbounded_branch(
    a: float, x: float, y: float, part: float
) -> None:
    flow = cubic(2, 3, 0, a)
    span = flow.lifetime((x, y)) if part > 0 else flow.lifetime((x, -y))
    assert_state(flow, (2, 3, 0, a), (x, y), part * min(span, 8.0))


@given(
    st.sampled_from([2.0, -1.5, 0.3]), st.sampled_from([3.0, -1.0, 0.7]), st.sampled_from([0.0, 0.5, -1.0]),
    st.floats(0.05, 3), st.sampled_from([1, -1]), st.sampled_from([1e-2, -1e-4, 1e-6, -1e-8, 0.0]),
    st.sampled_from([0.0, 1e-3, -1e-7]),
)  # fmt: skip
@tries(30)
def test_states_near_saddle_and_centre_are_right_to_their_condition(
    alpha: float, beta: float, gamma: float, depth: float, sign: int, du: float, dv: float
) -> None:
    delta = float(gamma**2 / (4 * beta) - np.copysign(depth, beta))  # two equilibria
    equilibrium = (-gamma + sign * np.sqrt(gamma**2 - 4 * beta * delta)) / (2 * beta)
    c, start = (alpha, beta, gamma, delta), (float(equilibrium + du), dv)
    flow = cubic(*c)
    assert_state(flow, c, start, min(0.9 * flow.lifetime(start), 8.0))


def test_state_is_right_where_the_two_points_of_the_chord_meet() -> None:
    # a move by the time since the pole doubles the point: the chord's slope is 0/0, the tangent's is not
    start = (5.0, -11.0)
    flow = cubic(2, 3, 0, 1)
    for t in flow.lifetime((5.0, 11.0)) * np.array([1, 1 + 1e-15, 1 - 1e-12, 1 + 1e-8]):
        assert_state(flow, (2, 3, 0, 1), start, float(t))


def test_elliptic_state_agrees_with_mpmath_odefun() -> None:
    # odefun's own tolerance is 1e-25; the state is rounded to double: an ulp of 1 times a condition of 5
    path = mp.odefun(lambda t, s: [2 * s[1], 3 * s[0] ** 2 - 2], 0, [-1, -1], tol=mp.mpf(10) ** -25)
    got = flow_of(2 * Y, 3 * X**2 - 2)([-1.0, -1.0], [0.9])[0]
    assert max(abs(float(g) - p) for g, p in zip(got, path(mp.mpf(0.9)), strict=True)) < 1e-15


@given(PARAMETER, COORDINATE, COORDINATE, st.floats(0.05, 0.9), st.floats(0.05, 0.9))
@tries(30)
def test_flow_is_a_group(a: float, x: float, y: float, part: float, split: float) -> None:
    flow = cubic(2, 3, 0, a)
    t = part * min(flow.lifetime((x, y)), 4.0)
    whole = flow([x, y], [t])[0]
    halfway = flow([x, y], [t * split])[0]
    end = flow(halfway, [t - t * split])[0]
    c = (2, 3, 0, a)
    # the split times are rounded to double: their sum is off by an ulp of t, hence |f|·ulp(t) in the state
    speed = max(abs(2 * whole[1]), abs(3 * whole[0] ** 2 + a))
    rounding = speed * np.spacing(t) + TOLERANCE * condition(c, (x, y), t, series(c, [x, y], t)) * (1 + t)
    assert np.abs(end - whole).max() <= rounding


@given(PARAMETER, COORDINATE, COORDINATE)
@tries(30)
def test_elliptic_invariant_is_kept_within_an_ulp_of_its_terms(a: float, x: float, y: float) -> None:
    flow = cubic(2, 3, 0, a)
    states = flow([x, y], np.linspace(0, 0.9 * min(flow.lifetime((x, y)), 10.0), 50))
    u, v = states.T
    terms = v**2 + np.abs(u**3) + np.abs(a * u) + 1
    assert np.all(np.abs((v**2 - u**3 - a * u) - (v[0] ** 2 - u[0] ** 3 - a * u[0])) <= 2 * TOLERANCE * terms)


@given(PARAMETER, COORDINATE, COORDINATE)
@tries(30)
def test_time_to_the_pole_and_period_are_carlson_integrals(a: float, x: float, y: float) -> None:
    big_x, big_y, e = roots_of((2, 3, 0, a), (x, y))
    tied = min(abs(e[0] - e[1]), abs(big_x - e[0]) + abs(big_y)) < 1e-6  # near a separatrix: tested below
    assume(not tied)
    half = mp.re(mp.elliprf(0, e[0] - e[1], e[0] - e[2]))
    flow = cubic(2, 3, 0, a)
    if mp.im(e[1]) == 0 and 2 * big_x < mp.re(e[0] + e[1]):
        assert flow.lifetime((x, y)) == np.inf
        assert flow.period((x, y)) == pytest.approx(float(2 * half), rel=4e-16)  # two ulps
        return
    u = mp.re(mp.elliprf(*(abs(big_x - e[0]) if k == 0 else big_x - r for k, r in enumerate(e))))
    assert flow.period((x, y)) == np.inf
    assert flow.lifetime((x, y)) == pytest.approx(float(u if big_y >= 0 else 2 * half - u), rel=4e-16)


@pytest.mark.parametrize("offset", [1e-3, 1e-5, 1e-7, -1e-3, -1e-5, -1e-7])
def test_period_and_lifetime_are_right_near_the_separatrix(offset: float) -> None:
    # started at rest η from the saddle: T grows as log 1/η, so a change ε of the start is one of ε/η in T
    start = (1 + offset, 0.0)
    e = roots_of((2, 3, 0, -3), start)[2]
    flow = flow_of(2 * Y, 3 * X**2 - 3)
    half = mp.re(mp.elliprf(0, e[0] - e[1], e[0] - e[2]))
    got, exact = (flow.period(start), 2 * half) if offset < 0 else (flow.lifetime(start), half)
    assert abs(got - exact) < 1e-15 * float(exact) + TOLERANCE / abs(offset)


@pytest.mark.parametrize(("y", "sign"), [(1.0, 1), (-1.0, 1), (1.0, -1), (-1.0, -1)])
def test_nothing_is_evaluated_at_or_past_a_pole(y: float, sign: int) -> None:
    flow = flow_of(2 * Y, 3 * X**2 + 1)
    life = flow.lifetime((0.3, sign * y))
    assert np.isfinite(flow([0.3, y], [sign * life * (1 - 1e-12)])).all()
    for factor in (1 + 1e-12, 1.5, 100):
        with pytest.raises(ValueError, match="finite only for elapsed times"):
            flow([0.3, y], [0.0, sign * life * factor])


def test_state_grows_as_the_inverse_square_of_the_time_left_before_the_pole() -> None:
    # x = 1/(t* − t)² (1 + O((t* − t)⁴)); t* in double is off by 1e-16, at 1e-6 before by 2e-10 of x
    flow = flow_of(2 * Y, 3 * X**2 + 1)
    life = flow.lifetime((0.3, 1.0))
    left = 1e-6
    assert float(flow([0.3, 1.0], [life - left])[0, 0]) * left**2 == pytest.approx(1, abs=1e-9)


def test_orbit_on_the_oval_comes_back_after_a_million_periods() -> None:
    flow = flow_of(2 * Y, 3 * X**2 - 3)
    period = flow.period((-1.4, 0.2))
    # the period is rounded to double: 1e6 periods are off by up to 1e6·ulp(T)/2, times a speed below 4
    back = flow([-1.4, 0.2], [1e6 * period])[0]
    assert np.abs(back - [-1.4, 0.2]).max() < 4e6 * np.spacing(period)


@pytest.mark.parametrize("x", [1.0, -1.0])
def test_equilibria_stay_for_ever(x: float) -> None:
    flow = flow_of(2 * Y, 3 * X**2 - 3)
    assert flow.lifetime((x, 0.0)) == np.inf
    assert np.abs(flow([x, 0.0], [1.0, 10.0, 1e6]) - [x, 0.0]).max() < 1e-17 + TOLERANCE


def test_cuspidal_cubic_is_the_inverse_square_of_time() -> None:
    # g₂ = g₃ = 0: x = 1/(1 ± t)² from (1, ±1)
    flow = flow_of(2 * Y, 3 * X**2)
    assert flow.lifetime((1.0, 1.0)) == pytest.approx(1.0, rel=1e-15)
    assert flow.lifetime((1.0, -1.0)) == np.inf
    got = flow([1.0, -1.0], [0.5, 3.0])[:, 0]
    assert np.abs(got - 1 / np.array([1.5, 4.0]) ** 2).max() < 1e-16
    assert (flow([0.0, 0.0], [5.0]) == 0).all()


def test_either_order_of_the_variables_gives_the_same_orbit() -> None:
    one, other = flow_of(2 * Y, 3 * X**2 + X - 2), flow_of(3 * Y**2 + Y - 2, 2 * X)
    t = np.linspace(-0.5, 0.5, 9)
    assert np.array_equal(one([-1.0, 0.4], t), other([0.4, -1.0], t)[:, ::-1])


@pytest.mark.parametrize(
    ("field", "variables", "kind"),
    [
        ((Y, -3 * X), (X, Y), LinearFlow),
        ((sympy.Integer(0), sympy.Integer(1)), (X, Y), LinearFlow),
        ((X - Y + sympy.pi, X * sympy.sqrt(2), Z), (X, Y, Z), LinearFlow),
        ((2 * Y, 3 * X**2 - 2), (X, Y), WeierstrassFlow),
        ((-(X - X) + Y * 2, (X + 1) ** 2), (X, Y), WeierstrassFlow),
        ((2 * Y, 3 * X**2 + T), (X, Y), type(None)),
        ((2 * Y, 3 * X**2 + Y), (X, Y), type(None)),
        ((2 * Y + X, 3 * X**2), (X, Y), type(None)),
        ((Y, X**3), (X, Y), type(None)),
        ((Y, -sympy.sin(X)), (X, Y), PendulumFlow),
        ((3 * sympy.cos(1 - 2 * Y), -X / 2), (X, Y), PendulumFlow),
        ((Y, -sympy.sin(X) - Y), (X, Y), type(None)),
        ((Y, -sympy.sin(X) + 1), (X, Y), type(None)),
        ((Y, -sympy.sin(X**2)), (X, Y), type(None)),
        ((Y, -sympy.sin(X + Y)), (X, Y), type(None)),
        ((Y, -sympy.sin(X + T)), (X, Y), type(None)),
        ((Y, -sympy.tan(X)), (X, Y), type(None)),
        ((Y * Z, -Z * X, -X * Y / 2), (X, Y, Z), RigidBodyFlow),
        ((Y * Z, -Z * X, sympy.Integer(0)), (X, Y, Z), RigidBodyFlow),
        ((Y * Z, Z * X, X * Y), (X, Y, Z), type(None)),
        ((Y * Z, Z * X, sympy.Integer(0)), (X, Y, Z), type(None)),
        ((Y * Z, -Z * X, -X * Y / 2 + 1), (X, Y, Z), type(None)),
        ((Y * Z, -Z * X, -(X**2)), (X, Y, Z), type(None)),
        ((Y, 1 / X), (X, Y), type(None)),
        ((Y, X**2, Z), (X, Y, Z), type(None)),
        ((Y, sympy.I * X), (X, Y), type(None)),
    ],
)
def test_fields_are_recognised_by_their_form_and_no_others(
    field: tuple[sympy.Expr, ...], variables: tuple[sympy.Symbol, ...], kind: type
) -> None:
    assert isinstance(recognise(field, variables), kind)
