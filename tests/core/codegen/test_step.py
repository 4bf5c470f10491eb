"""One compiled step of each method: what it conserves, that it can be undone, and that it is the scheme it claims."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy

from core import METHODS, PiecewiseSystem, integrate
from core.kernels.abi import NO_SOLUTION
from tests.core.exact import EPS
from tests.core.frames import Framed
from tests.core.sample_systems import ALL, DAMPED, ELLIPTIC, HARMONIC, KEPLER, RIGID_BODY

SIDES = [
    pytest.param(system, side, id=f"{system.name} {side:+d}", marks=pytest.mark.deep if side > 0 else ())
    for system in ALL
    for side in (-1, 1)
]
#: Kepler's gradients are dependent on a circular orbit: kept away from, and tested apart.
SPREAD = {"Kepler": 0.15}


def step(
    system: PiecewiseSystem, side: int, method: str, h: float, x: Any, carry: Any = 0.0, t: float = 0.25
) -> tuple[int, np.ndarray]:
    """Verdict and increment of one compiled step."""
    framed = Framed(system, method, side, x, carry)
    framed.call("set_levels", t)
    return framed.call("step", t, h), framed.part("increment").copy()


def starts(system: PiecewiseSystem, steps: tuple[float, ...], count: int = 60) -> Iterator[tuple[np.ndarray, float]]:
    """States around the system's own, and step sizes of both signs."""
    generator = np.random.default_rng(20260101)
    spread = SPREAD.get(system.name, 0.35)
    for k in range(count):
        size = steps[k // 2 % len(steps)]
        yield np.array(system.x0) * (1 + generator.uniform(-spread, spread, system.dimension)), size * (-1) ** k


def exact_values(system: PiecewiseSystem, side: int, derivatives: bool = False) -> Any:
    """ψ of (t, x), or its gradient and its derivative in t, in mpmath."""
    laws = system.laws
    psi = sympy.Matrix(laws.modes[side].conserved)
    wanted = psi.jacobian([*laws.x, sympy.Symbol("t")]) if derivatives else psi
    values = {p: mp.mpf(v) for p, v in zip(laws.p, system.parameter_array, strict=True)}
    function = sympy.lambdify([sympy.Symbol("t"), *laws.x, *laws.p], wanted, "mpmath")
    return lambda t, x: function(t, *x, *values.values())


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_dmm2_conserves_to_a_few_eps_of_the_increment(system: PiecewiseSystem, side: int) -> None:
    psi, gradient = exact_values(system, side), exact_values(system, side, derivatives=True)
    solved = {"small": 0, "large": 0}
    with mp.workdps(50):
        for x, h in starts(system, (1e-6, 1e-3, 0.03, 0.1, 0.4, 1.0)):
            verdict, dx = step(system, side, "dmm2", h, x)
            size = "small" if abs(h) <= 0.1 else "large"
            if verdict == NO_SOLUTION:
                assert size == "large"
                continue
            solved[size] += 1
            # Exactly at x + dx, which need not be a double: the loop keeps the rest in its carry.
            t0, t1 = mp.mpf(0.25), mp.mpf(0.25) + mp.mpf(h)
            x0 = [mp.mpf(v) for v in x]
            x1 = [u + mp.mpf(v) for u, v in zip(x0, dx, strict=True)]
            ends = [gradient(t0, x0), gradient(t1, x1)]
            change = psi(t1, x1) - psi(t0, x0)
            whole = max(*map(abs, dx), abs(h))
            for k in range(len(change)):
                slope = sum(max(abs(end[k, i]) for end in ends) for i in range(len(x) + 1))
                # Measured: 1.0 eps at most. Each term of Λ·Δ carries a few roundings, of the slopes and of Δ.
                assert abs(change[k]) <= 4 * EPS * slope * whole
    assert solved["small"] == 40
    assert solved["large"] >= 10


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_dmm2_backwards_undoes_the_step_to_a_few_ulps(system: PiecewiseSystem, side: int) -> None:
    for x, h in starts(system, (1e-3, 0.03, 0.1), count=30):
        _, dx = step(system, side, "dmm2", h, x)
        reached = x + dx
        left = dx - (reached - x)  # exact where |dx| ≤ |x|: the rest goes into the carry
        verdict, back = step(system, side, "dmm2", -h, reached, left, t=0.25 + h)
        assert verdict != NO_SOLUTION
        # Measured: 1.6 eps at most of the increment and of what h f takes from the rounding of the state.
        assert np.max(np.abs(back + dx)) <= 4 * EPS * (np.max(np.abs(dx)) + abs(h) * np.max(np.abs(x)))


def rk2(f: Any, t: float, x: np.ndarray, h: float) -> np.ndarray:
    return h * f(t + h / 2, x + h / 2 * f(t, x))


def rk4(f: Any, t: float, x: np.ndarray, h: float) -> np.ndarray:
    k1 = f(t, x)
    k2 = f(t + h / 2, x + h / 2 * k1)
    k3 = f(t + h / 2, x + h / 2 * k2)
    k4 = f(t + h, x + h * k3)
    return h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


FORCED = PiecewiseSystem(
    name="Forced", variables=("x", "y"), f_minus=("y", "a*cos(t)-x"), f_plus=("y*t", "exp(-t)/(1+x**2)"), g="x",
    parameters={"a": 0.7}, x0=(0.8, 0.6),
)  # fmt: skip


@pytest.mark.parametrize("system", [ELLIPTIC, KEPLER, FORCED], ids=lambda s: s.name)
@pytest.mark.parametrize("reference", [rk2, rk4])
@pytest.mark.parametrize("side", [-1, 1])
def test_explicit_methods_are_their_textbook_formulas(system: PiecewiseSystem, reference: Any, side: int) -> None:
    for x, h in starts(system, (1e-3, 0.1, 0.7), count=20):
        verdict, dx = step(system, side, reference.__name__, h, x)
        assert verdict == METHODS[reference.__name__].order
        wanted = reference(lambda t, u: system.field(side, t, u), 0.25, x, h)
        # The same operations in another order. Measured: 1.0 eps at most.
        np.testing.assert_allclose(dx, wanted, rtol=0, atol=4 * EPS * abs(h) * (1 + np.max(np.abs(wanted / h))))


def printed(name: str, a: Any, start: Any, end: Any) -> tuple[Any, Any]:
    """The right-hand sides of the schemes as the paper prints them."""
    (x0, y0), (x1, y1) = start, end
    if name == HARMONIC.name:
        return (y0 + y1) / 2, -a * (x0 + x1) / 2
    return y0 + y1, x1**2 + x1 * x0 + x0**2 + a


@pytest.mark.parametrize("system", [HARMONIC, ELLIPTIC], ids=lambda s: s.name)
@pytest.mark.parametrize("side", [-1, 1])
def test_dmm2_solves_the_printed_scheme(system: PiecewiseSystem, side: int) -> None:
    a = mp.mpf(system.parameter_array[int(side > 0)])
    with mp.workdps(40):
        for x, h in starts(system, (1e-9, 1e-3, 0.1, 0.3), count=16):
            start = [mp.mpf(v) for v in x]

            def residual(dx: Any, dy: Any, start: Any = start, h: float = h) -> list[Any]:
                f = printed(system.name, a, start, (start[0] + dx, start[1] + dy))
                return [dx - h * f[0], dy - h * f[1]]

            guess = [h * v for v in printed(system.name, a, start, start)]
            wanted = mp.findroot(residual, guess, tol=1e-60)
            verdict, dx = step(system, side, "dmm2", h, x)
            assert verdict != NO_SOLUTION
            largest = max(map(abs, wanted))
            # Measured: 0.8 eps of the increment; what cancels in f is of the size of the state.
            assert max(abs(u - v) for u, v in zip(map(mp.mpf, dx), wanted, strict=True)) <= 4 * EPS * (largest + abs(h))


@pytest.mark.parametrize(
    ("system", "x"),
    [
        (HARMONIC, (0.0, 0.0)),  # ∇ψ = 0
        (ELLIPTIC.with_parameters(a_minus=-3, a_plus=-3), (1.0, 0.0)),  # ∇ψ = 0
        (RIGID_BODY, (0.0, 0.0, 1.5)),  # the two gradients are parallel
        (RIGID_BODY, (0.0, 0.0, 0.0)),
        (DAMPED, (0.0, 0.0)),  # nothing to bind the multiplier
    ],
    ids=str,
)
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("h", [0.1, -1e-6])
def test_equilibria_stay_where_they_are(system: PiecewiseSystem, x: tuple[float, ...], side: int, h: float) -> None:
    verdict, dx = step(system, side, "dmm2", h, x)
    assert verdict >= 1
    assert not np.any(dx)


@pytest.mark.parametrize("side", [-1, 1])
def test_the_end_of_the_step_starts_from_state_and_carry(side: int) -> None:
    h, x, carry = 0.1, np.array([0.8, -0.3]), np.array([2.0**-20, -(2.0**-22)])
    matrix = np.array([[0, 1], [-HARMONIC.parameter_array[int(side > 0)], 0]])
    # Δ = h A (x + (x + carry + Δ))/2
    wanted = np.linalg.solve(np.eye(2) - h / 2 * matrix, h / 2 * matrix @ (2 * x + carry))
    _, dx = step(HARMONIC, side, "dmm2", h, x, carry)
    np.testing.assert_allclose(dx, wanted, rtol=0, atol=4 * EPS)


def test_a_step_without_solution_says_so() -> None:
    verdict, dx = step(ELLIPTIC, 1, "dmm2", 50.0, (3.0, 4.0))
    assert verdict == NO_SOLUTION
    assert not np.any(dx)
    assert step(ELLIPTIC, 1, "dmm2", 0.1, (np.inf, 1.0))[0] == NO_SOLUTION
    assert step(KEPLER, 1, "dmm2", 0.1, (0.0, 0.0, 1.0, 0.0))[0] == NO_SOLUTION  # where the field has no value


CIRCULAR = [(np.cos(a), np.sin(a), -np.sin(a), np.cos(a)) for a in (0.0, 0.7, 2.4, 4.0)]


@pytest.mark.parametrize("x", CIRCULAR)
@pytest.mark.parametrize("h", [1e-6, 1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.3])
def test_dependent_gradients_cost_no_accuracy_or_are_reported(x: tuple[float, ...], h: float) -> None:
    # On a circular orbit energy and angular momentum have parallel gradients: one of the two binds nothing.
    verdict, dx = step(KEPLER, 1, "dmm2", h, x)
    if verdict == NO_SOLUTION:
        assert h > 0.01
        return
    turn = np.exp(1j * h) - 1
    place, speed = turn * complex(x[0], x[1]), turn * complex(x[2], x[3])
    exact = np.array([place.real, place.imag, speed.real, speed.imag])
    # Local error: measured 0.25 h³, beside the round-off of the state.
    assert np.max(np.abs(dx - exact)) <= 0.5 * h**3 + 4 * EPS
    psi = exact_values(KEPLER, 1)
    with mp.workdps(50):
        start = [mp.mpf(float(v)) for v in x]
        end = [u + mp.mpf(float(v)) for u, v in zip(start, dx, strict=True)]
        assert max(map(abs, psi(0, end) - psi(0, start))) <= 24 * EPS  # 16 are accepted, before the last correction


def test_names_that_the_generated_code_uses_too_change_nothing() -> None:
    plain = PiecewiseSystem("plain", ("x", "y"), ("y", "-k*x"), ("y", "-x"), "y - t/100",
                                 ("k*x**2 + y**2",), ("x**2 + y**2",), {"k": 3.0}, (1.0, 1.0))  # fmt: skip
    names = {"x": "d0", "y": "x0", "k": "h"}

    def renamed(text: str) -> str:
        return "".join(names.get(c, c) for c in text)

    texts = [tuple(map(renamed, e)) for e in (plain.f_minus, plain.f_plus, plain.psi_minus, plain.psi_plus)]
    clashing = PiecewiseSystem("clashing", ("d0", "x0"), texts[0], texts[1], renamed(plain.g), texts[2], texts[3],
                                    {"h": 3.0}, (1.0, 1.0))  # fmt: skip
    for method in METHODS:
        runs = [integrate(s, (0.0, 10.0), tau=0.1, method=method, record="end") for s in (plain, clashing)]
        assert np.abs(runs[0].x[-1] - runs[1].x[-1]).max() <= 1e-13  # terms may be added in another order
