"""Pendulums, rigid bodies and moving surfaces in pieces, against SciPy's DOP853 and closed forms."""

from collections.abc import Sequence

import mpmath as mp
import numpy as np
import pytest
import sympy

import core
from core.reference import ReferenceSolution, exact_solution, two_sides
from tests.core.reference.by_sides import by_sides

mp.mp.dps = 40
X, Y, Z = VARIABLES = sympy.symbols("x y z")
T = sympy.Symbol("t")
ULP = float(np.finfo(float).eps)


def both(
    minus: Sequence[sympy.Expr], plus: Sequence[sympy.Expr], g: sympy.Expr, x0: Sequence[float]
) -> tuple[ReferenceSolution, ReferenceSolution]:
    """The exact solution and the external one."""
    d = len(x0)
    names, fields = VARIABLES[:d], {-1: minus, 1: plus}
    solution = exact_solution(two_sides(tuple(minus), tuple(plus), g, names), 0.0, x0)
    assert solution is not None
    rates = {s: sum((g.diff(v) * u for v, u in zip(names, f, strict=True)), g.diff(T)) for s, f in fields.items()}
    field = {s: sympy.lambdify([T, *names], list(f), "math") for s, f in fields.items()}
    rate = {s: sympy.lambdify([T, *names], r, "math") for s, r in rates.items()}
    height = sympy.lambdify([T, *names], g, "math")
    return solution, by_sides(
        lambda s, t, x: field[s](t, *x), lambda t, x: height(t, *x), lambda s, t, x: rate[s](t, *x), 0.0, x0
    )


PIECES = {
    "pendulums": ((Y, -sympy.Float(3.7) * sympy.sin(X)), (Y, -sympy.Float(9.8) * sympy.sin(X)), X - 0.5, (-2.0, 0.0)),
    "over the top": ((Y, -sympy.sin(X)), (Y, -2 * sympy.sin(X)), sympy.sin(X - 0.4), (0.0, 3.5)),
    "pendulum beside an oscillator": ((Y, -4 * X), (Y, -4 * sympy.sin(X)), X, (-1.5, 0.3)),
    "rigid bodies": (
        (Y * Z, -X * Z, -sympy.Float(0.51) * X * Y),
        (Y * Z, -X * Z, -sympy.Float(0.9) * X * Y),
        X - 0.6,
        (0.0, 2.0, 2.0),
    ),
    "rigid bodies, other order": (
        (X * 0 - Y * Z, 2 * X * Z, X * Y),
        (-Y * Z, X * Z * 3, -X * Y / 2),
        X + Z / 4,
        (0.7, 0.2, 1.1),
    ),
    "moving line": ((Y, -3 * X), (Y, -X), Y - sympy.sin(sympy.Float(0.7) * T) / 2, (1.5, 1.0)),
}


@pytest.mark.parametrize("name", PIECES)
def test_exact_pieces_agree_with_the_peer(name: str) -> None:
    # rtol 1e-13 a step over 12 crossings, each turning an error of the state into one of time: 1e-11
    solution, peer = both(*PIECES[name])
    for k in (1, 2, 12):
        (t, x), (t_peer, x_peer) = solution.crossing(k), peer.crossing(k)
        assert t == pytest.approx(t_peer, abs=1e-11)
        assert x == pytest.approx(x_peer, abs=1e-11)
        assert solution.side(t) == peer.side(np.nextafter(t_peer, 99))
    middle = (solution.crossing(11)[0] + t) / 2
    assert solution.state(middle) == pytest.approx(peer.state(middle), abs=1e-11)
    assert solution.exact


def test_pendulum_crossings_are_exact() -> None:
    # ω² = 1 above the bottom, 4 below: half periods 2K(k) and K(k') with sin(a/2) halved by ω: v is kept
    solution = exact_solution(two_sides((Y, -4 * sympy.sin(X)), (Y, -sympy.sin(X)), X, (X, Y)), 0.0, (2.0, 0.0))
    assert solution is not None
    k = mp.sin(1)
    above, below = 2 * mp.ellipk(k**2), mp.ellipk((k / 2) ** 2)
    for n in (1, 2, 3, 30):
        t, x = solution.crossing(n)
        assert abs(t - above / 2 - (n // 2) * below - ((n - 1) // 2) * above) <= np.spacing(t)
        assert abs(abs(x[1]) - 2 * k) <= np.spacing(2 * float(k))


def test_rigid_body_crossings_are_exact() -> None:
    # x = sn on both sides of x = 0: y = cn and z = dn are ±1 and 1 there, the half periods 2K(m)
    body = [(Y * Z, -X * Z, -sympy.Float(m) * X * Y) for m in (0.51, 0.9)]
    solution = exact_solution(two_sides(body[0], body[1], X, VARIABLES), 0.0, (0.0, 1.0, 1.0))
    assert solution is not None
    below, above = (2 * mp.ellipk(mp.mpf(m)) for m in (0.51, 0.9))
    for n in (1, 2, 3, 30):
        t, x = solution.crossing(n)
        assert abs(t - ((n + 1) // 2) * above - (n // 2) * below) <= np.spacing(t)
        assert np.abs(x - [0, (-1) ** n, 1]).max() <= 2 * ULP


def test_moving_surface_is_met_where_it_is() -> None:
    # x = cos t meets the line x = sin(3t) where 3t = π/2 ± t + 2πn: at π/8, π/4, 5π/8, 9π/8, 5π/4, …; fields alike
    solution = exact_solution(two_sides((Y, -X), (Y, -X), X - sympy.sin(3 * T), (X, Y)), 0.0, (1.0, 0.0))
    assert solution is not None
    meetings = sorted([mp.pi / 8 + n * mp.pi / 2 for n in range(8)] + [mp.pi / 4 + n * mp.pi for n in range(4)])
    for k, exact in enumerate(meetings, start=1):
        assert abs(solution.crossing(k)[0] - exact) <= np.spacing(float(exact))


def test_fast_surface_is_watched_at_its_own_pace() -> None:
    # y sinks evenly, without a rate of its own, and the surface swings: 3 − t = sin 50t in the 17th swing first
    fall = (sympy.Integer(0), sympy.Integer(-1))
    solution = exact_solution(two_sides(fall, fall, Y - sympy.sin(50 * T), (X, Y)), 0.0, (0.0, 3.0))
    assert solution is not None
    crest = (mp.pi / 2 + 32 * mp.pi) / 50
    exact = mp.findroot(lambda t: 3 - t - mp.sin(50 * t), (crest - mp.mpf("0.02"), crest), solver="anderson")
    assert abs(solution.crossing(1)[0] - exact) <= np.spacing(2.0)


def test_surface_that_comes_down_on_a_closed_orbit_meets_it_after_many_periods() -> None:
    # cos t = 5 − t/10, before the crest at 14π, where the surface stands at 0.6; at 12π it stood at 1.23
    solution = exact_solution(two_sides((Y, -X), (Y, -X), X - 5 + T / 10, (X, Y)), 0.0, (1.0, 0.0))
    assert solution is not None
    exact = mp.findroot(lambda t: mp.cos(t) - 5 + t / 10, (42, 14 * mp.pi), solver="anderson")
    assert abs(solution.crossing(1)[0] - exact) <= np.spacing(float(exact))


def test_clock_that_switches_a_field_is_exact() -> None:
    # reference values: y'' = 0.2y' − (π² + 0.01)y ± 1, + while ⌊t⌋ is even
    square = sympy.pi**2 + sympy.Rational(1, 100)
    fields = [(Y, Y / 5 - square * X + sign) for sign in (-1, 1)]
    solution = exact_solution(two_sides(fields[0], fields[1], sympy.sin(sympy.pi * T) + 0 * X, (X, Y)), 0.0, (0.0, 0.0))
    assert solution is not None
    assert solution.state(20.0) == pytest.approx([-12.94460621213470, 0], abs=1e-13)
    assert [solution.crossing(k)[0] for k in (1, 7, 19)] == [1, 7, 19]


@pytest.mark.parametrize("name", ["pendulum", "rigid_body", "moving_interface", "bouncing_ball"])
def test_catalogue_is_exact_where_it_can_be(name: str) -> None:
    if name not in core.CATALOGUE:
        pytest.skip("not in the catalogue")
    solution = core.reference_solution(core.CATALOGUE[name])
    assert solution.exact
    assert solution.name.startswith("exact")
    assert np.isfinite(solution.crossing(10)[1]).all()
