"""Jacobi functions, the pendulum and the free rigid body against mpmath in 40 digits and more."""

from collections.abc import Sequence

import mpmath as mp
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from core.reference.flows import Flow
from core.reference.jacobi import jacobi_functions, quarter_period
from core.reference.recognition import recognise
from tests.levels import tries

mp.mp.dps = 40
X, Y, Z = sympy.symbols("x y z")
EPS = float(np.finfo(np.longdouble).eps)
COORDINATE = st.floats(-2, 2).map(lambda v: round(v, 6))
CONSTANT = st.sampled_from([0.3, 0.51, 1.0, 2.5])
TIME = st.floats(-15, 15)


def exactly(number: np.longdouble) -> mp.mpf:
    """An extended number as it is."""
    high = float(number)
    return mp.mpf(high) + mp.mpf(float(number - np.longdouble(high)))


def flow_of(*field: sympy.Expr, variables: Sequence[sympy.Symbol]) -> Flow:
    flow = recognise(tuple(map(sympy.sympify, field)), tuple(variables))
    assert flow is not None
    return flow


def rigid_body(c: Sequence[float]) -> Flow:
    a, b, d = map(sympy.Float, c)
    return flow_of(a * Y * Z, b * Z * X, d * X * Y, variables=(X, Y, Z))


def pendulum(a: float, b: float, c: float) -> Flow:
    return flow_of(sympy.Float(a) * Y, -sympy.Float(b) * sympy.sin(sympy.Float(c) * X), variables=(X, Y))


def radius(rows: Sequence[Sequence[mp.mpf]]) -> mp.mpf:
    """Radius of convergence, by the last two coefficients: one of them is 0 for a function odd or even."""
    roots = [abs(r[k]) ** (-mp.mpf(1) / k) for r in rows for k in (39, 40) if r[k] != 0]
    return min(roots, default=mp.mpf(10))


def body_series(c: Sequence[float], start: Sequence[mp.mpf], t: float) -> list[mp.mpf]:
    """State of the rigid body after t, by power series of degree 40 with steps R/6: 1e-31."""
    state, done, end, sign = [mp.mpf(v) for v in start], mp.mpf(0), abs(mp.mpf(t)), mp.sign(t)
    while done < end:
        rows = [[v] for v in state]
        for k in range(40):
            pairs = ((1, 2), (2, 0), (0, 1))
            sums = [mp.fsum(rows[i][n] * rows[j][k - n] for n in range(k + 1)) for i, j in pairs]
            for row, factor, value in zip(rows, c, sums, strict=True):
                row.append(mp.mpf(factor) * value / (k + 1))
        h = min(radius(rows) / 6, end - done)
        state = [mp.polyval(row[::-1], sign * h) for row in rows]
        done += h
    return state


def pendulum_series(a: float, b: float, c: float, start: Sequence[mp.mpf], t: float) -> list[mp.mpf]:
    """State of the pendulum after t, by power series of degree 40."""
    a, b, c = mp.mpf(a), mp.mpf(b), mp.mpf(c)
    (u, v), done, end, sign = map(mp.mpf, start), mp.mpf(0), abs(mp.mpf(t)), mp.sign(t)
    while done < end:
        p, q, sine, cosine = [u], [v], [mp.sin(c * u)], [mp.cos(c * u)]
        for k in range(40):
            p.append(a * q[k] / (k + 1))
            q.append(-b * sine[k] / (k + 1))
            turn = [c * (n + 1) * p[n + 1] for n in range(k + 1)]
            sine.append(mp.fsum(turn[n] * cosine[k - n] for n in range(k + 1)) / (k + 1))
            cosine.append(-mp.fsum(turn[n] * sine[k - n] for n in range(k + 1)) / (k + 1))
        h = min(radius([p, q]) / 6, end - done)
        u, v = mp.polyval(p[::-1], sign * h), mp.polyval(q[::-1], sign * h)
        done += h
    return [u, v]


def assert_follows(flow: Flow, solve, start: Sequence[float], t: float, roundings: float) -> None:
    """The state is right to so many roundings of itself, of the time, and of the start as the flow magnifies them."""
    exact, tiny = solve([mp.mpf(v) for v in start], t), mp.mpf(10) ** -25
    growth = 1.0
    for i in range(len(start)):
        moved = solve([mp.mpf(v) + (tiny if i == j else 0) for j, v in enumerate(start)], t)
        growth = max(growth, float(max(abs(a - b) for a, b in zip(moved, exact, strict=True)) / tiny))
    error = max(abs(exactly(a) - b) for a, b in zip(flow(start, [t])[0], exact, strict=True))
    size = 1 + max(float(max(map(abs, exact))), *map(abs, start))
    assert error <= roundings * EPS * size * growth * (1 + abs(t))


@pytest.mark.parametrize("complement", ["1", "0.999999", "0.7", "1e-3", "1e-9", "1e-15", "1e-24"])
def test_jacobi_functions_and_their_period_agree_with_mpmath(complement: str) -> None:
    # relative errors of cn and dn: a rounding of u is one of their exponents where k is near 1, |u| ≤ 2K = 113
    with mp.workdps(100):
        k1 = np.longdouble(complement)
        m, period = 1 - exactly(k1) ** 2, quarter_period(k1)
        assert abs(exactly(period) / mp.ellipk(m) - 1) <= 4 * EPS
        u = 2 * period * np.array([-0.93, -0.4, -1e-3, 1e-11, 0.1, 0.5, 0.77, 0.999], dtype=np.longdouble)
        for kind, values in zip(("sn", "cn", "dn"), jacobi_functions(u, k1), strict=True):
            for argument, value in zip(u, values, strict=True):
                exact = mp.ellipfun(kind, exactly(argument), m=m)
                size = abs(exact) * (4 + abs(exactly(argument))) + (abs(exactly(argument)) if kind != "dn" else 0)
                assert abs(exactly(value) - exact) <= 4 * EPS * size


@pytest.mark.parametrize("complement", [1.0, 0.7, 0.316, 0.1, 1e-5])
def test_signs_are_right_a_rounding_before_and_beyond_half_the_period(complement: float) -> None:
    k1 = np.longdouble(complement)
    half = 2 * quarter_period(k1)
    for sign in (1, -1):
        u = sign * half * (1 + EPS * np.arange(-4, 5, dtype=np.longdouble))
        sn, cn, dn = jacobi_functions(u, k1)
        assert np.abs(sn).max() <= 16 * EPS * half
        assert np.abs(cn + 1).max() <= 2 * EPS
        assert np.abs(dn - 1).max() <= 2 * EPS


def test_jacobi_functions_of_modulus_one_are_hyperbolic() -> None:
    u = np.linspace(-20, 20, 9, dtype=np.longdouble)
    sn, cn, dn = jacobi_functions(u, np.longdouble(0))
    assert quarter_period(np.longdouble(0)) == np.inf
    for argument, s, c, d in zip(u, sn, cn, dn, strict=True):
        assert abs(exactly(s) - mp.tanh(exactly(argument))) <= 2 * EPS
        assert abs(exactly(c) * mp.cosh(exactly(argument)) - 1) <= 8 * EPS
        assert c == d


def test_rigid_body_follows_the_jacobi_functions() -> None:
    # the reference values: y(20) for m = 0.51, given to 16 digits
    got = rigid_body((1, -1, -0.51))([0, 1, 1], [20.0])[0]
    assert got.astype(float) == pytest.approx([-0.9396570798729202, -0.3421177754000749, 0.7414126596199953], abs=2e-16)
    m, t = mp.mpf(0.51), np.array([-7.5, 0.25, 20.0, 300.0])
    for time, state in zip(t, rigid_body((1, -1, -0.51))([0, 1, 1], t), strict=True):
        for kind, value in zip(("sn", "cn", "dn"), state, strict=True):
            assert abs(exactly(value) - mp.ellipfun(kind, time, m=m)) <= 2 * EPS * (1 + abs(time))


@given(
    st.permutations([1, 1, -1]), st.sampled_from([1, -1]), st.tuples(*[CONSTANT] * 3),
    st.tuples(*[COORDINATE] * 3), TIME,
)  # fmt: skip
@tries(12)
def test_rigid_body_agrees_with_power_series_for_any_constants(
    signs: list[int], sign: int, sizes: Sequence[float], start: Sequence[float], t: float
) -> None:
    c = [sign * s * v for s, v in zip(signs, sizes, strict=True)]
    flow = rigid_body(c)
    t = t / (1 + float(np.abs(start).max()))
    assert_follows(flow, lambda x, u: body_series(c, x, u), start, t, 20)
    assert flow.lifetime(start) == np.inf


@pytest.mark.parametrize(
    "start",
    [(0.5, 0.5, 0.5), (-0.9, 1e-8, 2e-8), (0.9, 1e-3, -1e-3), (1e-9, 0.3, -0.7), (0.2, 0.7, 0.7000000000000001)],
)
def test_rigid_body_is_right_on_and_near_its_separatrix_and_its_axes(start: Sequence[float]) -> None:
    flow = rigid_body((1, -1, -1))
    for t in (-3.0, 9.0):
        assert_follows(flow, lambda x, u: body_series((1, -1, -1), x, u), start, t, 20)


@pytest.mark.parametrize("gap", [1e-2, 1e-8, -1e-8])
def test_period_is_right_to_the_last_digit_near_the_separatrix(gap: float) -> None:
    # k'² = (z² − y²)/B² has lost no digit of the gap between y and z, the one thing the period hangs on there
    low = mp.mpf(1e-8)
    start = (-0.9, 1e-8, 1e-8 + gap) if gap > 0 else (-0.9, 1e-8 - gap, 1e-8)
    high = mp.mpf(max(start[1:]))
    b = mp.hypot(mp.mpf(0.9), high)
    exact = 4 * mp.ellipk(1 - (high - low) * (high + low) / b**2) / b
    assert abs(rigid_body((1, -1, -1)).period(start) - exact) <= np.spacing(float(exact))


def test_symmetric_top_precesses_evenly() -> None:
    # c₃ = 0: the spin about the third axis stays, and the others turn with it
    got = rigid_body((2, -2, 0))([0.3, 0.4, 1.5], [7.0])[0]
    s, c = mp.sin(21), mp.cos(21)
    exact = [mp.mpf(0.3) * c + mp.mpf(0.4) * s, mp.mpf(0.4) * c - mp.mpf(0.3) * s, mp.mpf(1.5)]
    assert max(abs(exactly(g) - e) for g, e in zip(got, exact, strict=True)) <= 21 * EPS


@pytest.mark.parametrize("start", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 0.0)])
def test_rotation_about_an_axis_stays(start: Sequence[float]) -> None:
    assert (rigid_body((1, -1, -0.5))(start, [1.0, -1e6]) == np.array(start)).all()


def test_rigid_body_comes_back_after_a_million_periods() -> None:
    flow, start = rigid_body((1, -1, -0.51)), (0.0, 1.0, 1.0)
    period = flow.period(start)
    assert period == pytest.approx(float(4 * mp.ellipk(mp.mpf(0.51))), rel=2e-16)
    # the period is rounded to double: half an ulp of it a million times, at a speed of 1
    assert np.abs(flow(start, [1e6 * period])[0] - start).max() <= 1e6 * np.spacing(period)


@given(
    *[st.tuples(CONSTANT, st.sampled_from([1, -1])).map(lambda v: v[0] * v[1])] * 3, st.floats(-3, 3), COORDINATE, TIME
)
@tries(12)
def test_pendulum_agrees_with_power_series_swinging_or_turning_over(
    a: float, b: float, c: float, u: float, v: float, t: float
) -> None:
    flow, t = pendulum(a, b, c), t / 3
    assert_follows(flow, lambda x, s: pendulum_series(a, b, c, x, s), (u, v), t, 20)
    assert flow.lifetime((u, v)) == np.inf


@pytest.mark.parametrize(
    "start", [(0.0, 2.0), (0.0, -2.0), (3.0, 1e-9), (0.0, 2.0000001), (0.0, 1.9999999), (8.0, 5.0)]
)
def test_pendulum_is_right_on_and_near_its_separatrix_and_beyond_a_turn(start: Sequence[float]) -> None:
    flow = pendulum(1, 1, 1)
    for t in (-2.0, 9.0):
        assert_follows(flow, lambda x, s: pendulum_series(1, 1, 1, x, s), start, t, 20)


def test_pendulum_from_rest_is_twice_the_arcsine_of_k_sn() -> None:
    # reference values: q = 2 asin(k sn(t, k)) from the bottom with speed 2k
    k = mp.mpf(0.8)
    for t, (q, _) in zip((0.3, 4.0, 50.0), pendulum(1, 1, 1)([0.0, 1.6], [0.3, 4.0, 50.0]), strict=True):
        assert abs(exactly(q) - 2 * mp.asin(k * mp.ellipfun("sn", t, m=k**2))) <= 4 * EPS * (1 + t)
    amplitude, period = 0.05, pendulum(1, 9.8, 1).period((0.05, 0.0))
    assert period == pytest.approx(2.00740357588013012, rel=2e-16)
    assert abs(period - 4 * mp.ellipk(mp.sin(mp.mpf(amplitude) / 2) ** 2) / mp.sqrt(9.8)) <= np.spacing(period)


def test_whole_turns_are_counted() -> None:
    # over the top a turn takes 2K(1/k)/k, k = 3/2: the angle grows by 2π in each, however many
    flow, k = pendulum(1, 1, 1), mp.mpf(1.5)
    turn = 2 * mp.ellipk(1 / k**2) / k
    for count in (1, 7, 10**6):
        q, p = flow([0.0, 3.0], [float(count * turn)])[0]
        assert abs(exactly(q) - 2 * mp.pi * count) <= 3 * np.spacing(float(count * turn))
        assert abs(p - 3) <= np.spacing(float(count * turn))
        assert abs(exactly(flow([0.0, -3.0], [float(count * turn)])[0, 0]) + exactly(q)) <= EPS * float(q)
    assert flow.period((0.0, 3.0)) == np.inf


def test_pendulum_agrees_with_mpmath_odefun() -> None:
    # odefun's own tolerance is 1e-25
    with mp.workdps(30):
        path = mp.odefun(lambda t, s: [s[1], -mp.sin(s[0])], 0, [2, mp.mpf("0.5")], tol=mp.mpf(10) ** -25)
        got = pendulum(1, 1, 1)([2.0, 0.5], [3.0])[0]
        assert max(abs(exactly(g) - p) for g, p in zip(got, path(3), strict=True)) < 20 * EPS
