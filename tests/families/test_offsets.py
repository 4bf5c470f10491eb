"""A law written about a point far from the origin is integrated as about the origin; of one multiplied out it is said.

Its ψ is found about that point, too.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import core

END = 5.0


def force(rng: np.random.Generator) -> list[float]:
    """Coefficients of a force −a u − b u² − c u³ that does not let go: those of u, u² and u³."""
    a, c = round(rng.uniform(0.5, 3.0), 3), round(rng.uniform(0.1, 1.0), 3)
    return [-a, round(rng.uniform(-0.3, 0.3), 3), -c]


def motion(forces: list[list[float]], edge: float, start: tuple[float, float]) -> tuple[int, np.ndarray]:
    """How often u'' = F(u) crosses u = edge up to the end, where F is the first or second law there, and the end."""
    t, state, crossings = 0.0, np.array(start), 0
    side = int(state[0] > edge)
    while True:

        def beside(_t: float, z: np.ndarray) -> float:
            return float(z[0] - edge)

        beside.terminal, beside.direction = True, (1, -1)[side]  # type: ignore[attr-defined]
        law = forces[side]
        found = solve_ivp(
            lambda _t, z, law=law: (z[1], law[0] * z[0] + law[1] * z[0] ** 2 + law[2] * z[0] ** 3), (t, END), state,
            "DOP853", events=beside, rtol=1e-13, atol=1e-13, max_step=0.1,
        )  # fmt: skip
        t, state = float(found.t[-1]), found.y[:, -1]
        if found.status == 0:
            return crossings, state
        side, crossings = 1 - side, crossings + 1


@pytest.mark.parametrize("method", ["taylor", "prk8", "dmm4", "dmm8", "rk8"])
def test_where_a_law_is_written_about_makes_no_difference_but_by_the_rounding_of_the_state(draws, method):
    for rng in draws(8):
        forces, edge = [force(rng), force(rng)], round(rng.uniform(-0.4, 0.4), 3)
        start, offset = (round(rng.uniform(0.5, 1.0), 3), round(rng.uniform(-1, 1), 3)), round(10 ** rng.uniform(1, 5))
        u = f"(x - {offset})"
        laws = [("y", f"{a}*{u} + ({b})*{u}**2 + ({c})*{u}**3") for a, b, c in forces]
        system = core.PiecewiseSystem("Far", ("x", "y"), *laws, f"{u} - ({edge})", x0=(offset + start[0], start[1]))
        run = core.integrate(system, (0.0, END), method=method, tau=0.005)
        crossings, end = motion(forces, edge, (system.x0[0] - offset, start[1]))
        said = f"{laws}, edge {edge}, start {start}, offset {offset}: {run.message}"
        assert run.status is core.Status.COMPLETED, said
        assert run.crossing_count == crossings, said
        error = np.abs(run.x[-1] - (offset, 0.0) - end).max()
        rounding = 1e-14 if method == "rk8" else 1e-13  # of the state, in a thousand steps to the level of ψ
        assert error <= (1e-7 if method == "dmm4" else 1e-10) + rounding * offset, f"{said}: {error}"


@pytest.mark.parametrize("method", ["taylor", "rk4", "rk8"])
@pytest.mark.parametrize("of_psi", [False, True])
def test_a_law_or_a_quantity_whose_terms_cancel_is_wrong_by_no_more_than_is_said(draws, method, of_psi):
    x = sympy.Symbol("x")
    method = {"rk4": "dmm4", "rk8": "prk8"}.get(method, method) if of_psi else method
    for rng in draws(8):
        a, b, c = (sympy.Rational(str(one)) for one in force(rng))
        offset, start = round(10 ** rng.uniform(0, 5)), (round(rng.uniform(0.5, 1.0), 3), round(rng.uniform(-1, 1), 3))
        u = x - offset
        exact, energy = a * u + b * u**2 + c * u**3, -a * u**2 / 2 - b * u**3 / 3 - c * u**4 / 4
        law = ("y", str(exact if of_psi else sympy.expand(exact)))
        psi = (f"y**2/2 + {sympy.expand(energy)}",) if of_psi else ()
        state = (offset + start[0], start[1])
        system = core.PiecewiseSystem("Far", ("x", "y"), law, law, "x + 10", psi_minus=psi, psi_plus=psi, x0=state)
        run = core.integrate(system, (0.0, END), method=method, tau=0.005)
        coefficients = [float(one) for one in (a, b, c)]
        _, end = motion([coefficients, coefficients], -1e3, (state[0] - offset, start[1]))
        failed = run.status is not core.Status.COMPLETED
        wrong = offset > 3000 if failed else np.abs(run.x[-1] - (offset, 0.0) - end).max() > 1e-6
        said = f"{law}, {psi}, start {state}: {run.message}"
        assert "cancel" in run.warning if wrong else True, said
        assert "cancel" not in run.warning if offset < 30 else True, said


@pytest.mark.parametrize("method", ["rk8", "dmm2"])
def test_a_reset_map_whose_terms_cancel_is_wrong_by_no_more_than_is_said(draws, method):
    """In a frame that moves with speed a, u = v − a: a ball falls by u' = −1, and u ↦ −e u − q u³ where it bounces.

    With e ≥ 0.6 the bounces would come to rest at t ≥ √2 + 2√2 e/(1 − e) = 5.65 at the earliest, after the end.
    """
    v = sympy.Symbol("v")
    for rng in draws(8):
        a, e, q = round(10 ** rng.uniform(0, 6)), round(rng.uniform(0.6, 0.9), 2), round(rng.uniform(0.01, 0.1), 3)
        after = str(sympy.expand(a - sympy.Rational(str(e)) * (v - a) - sympy.Rational(str(q)) * (v - a) ** 3))
        law = (f"v - {a}", "-1")
        system = core.PiecewiseSystem("Ball", ("x", "v"), law, law, "x", jump=("0", after), x0=(1.0, float(a)))
        run = core.integrate(system, (0.0, END), method=method, tau=0.01)
        t, u = np.sqrt(2.0), np.sqrt(2.0)
        while t + 2 * (u := e * u + q * u**3) < END:
            t += 2 * u
        error = np.abs(run.x[-1] - (u * (END - t) - (END - t) ** 2 / 2, u - (END - t) + a)).max()
        said = f"{law}, {after}: {run.message} {error}"
        assert run.status is not core.Status.COMPLETED or error < 1e-6 or "after a reset cancel" in run.warning, said
        assert a > 30 or "cancel" not in run.warning, said


def slide(rng: np.random.Generator, origin: tuple[float, ...], units: tuple[float, ...] = ()) -> core.PiecewiseSystem:
    """A system that slides on the surface w = p u² + q v, where u = x − a or x/k − a and so on; it does so at once."""
    laws = np.round(rng.uniform(-1.0, 1.0, (3, 3)) - 1.2 * np.eye(3), 2)
    p, q, bend, push = (round(float(rng.uniform(*ends)), 2) for ends in ((0.2, 0.8), (0.2, 0.8), (0.5, 1.5), (3, 5)))
    values = dict(zip(("a", "b", "c", "k", "l", "m"), (*origin, *units), strict=False))
    u, v, w = places = ("(x/k - a)", "(y/l - b)", "(z/m - c)") if units else ("(x - a)", "(y - b)", "(z - c)")
    lin = [" + ".join(f"({k})*{place}" for k, place in zip(row, places, strict=True)) for row in laws]
    first = f"{lin[0]} + {bend}*sin({v})*{u}" if rng.integers(2) else lin[0]
    minus, plus = (first, lin[1], f"{lin[2]} + {push}"), (f"{first} + 0.3", f"{lin[1]} + 0.1*{u}", f"{lin[2]} - {push}")
    curve = f"{w} - {p}*{u}**2 - {q}*{v}" if rng.integers(2) else f"{w} - {q}*{v}"
    fields = [tuple(f"{s}*({f})" for s, f in zip("klm", law, strict=True)) if units else law for law in (minus, plus)]
    start = (0.3, 0.2, p * 0.09 + q * 0.2 if "**" in curve else q * 0.2)
    x0 = tuple((o + c) * s for o, c, s in zip(origin, start, units or (1.0,) * 3, strict=True))
    return core.PiecewiseSystem("Slide", ("x", "y", "z"), *fields, curve, parameters=values, x0=x0)


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
def test_where_and_in_which_units_a_slide_is_written_makes_no_difference_but_by_the_rounding_of_the_state(
    draws, method
):
    tau = {} if method == "taylor" else {"tau": 0.02}
    for rng in draws(4):
        seed, near = int(rng.integers(2**32)), (0.0, 0.0, 0.0)
        far = tuple(float(round(o)) for o in 10.0 ** rng.uniform(3, 5.5, 3))
        units = tuple(float(s) for s in 10.0 ** rng.uniform(-3, 3, 3))
        about = core.integrate(
            slide(np.random.default_rng(seed), near), (0.0, 4.0), method=method, sliding="continue", **tau
        )
        assert about.status is core.Status.COMPLETED, about.message
        for origin, scale in ((far, ()), (near, units)):
            system = slide(np.random.default_rng(seed), origin, scale)
            run = core.integrate(system, (0.0, 4.0), method=method, sliding="continue", **tau)
            said = f"{system.f_minus}, {system.f_plus}, {system.g}, {system.values}: {run.message}"
            assert run.status is about.status, said
            assert run.crossing_count == about.crossing_count, said
            assert run.steps <= 2 * about.steps, said
            error = np.abs(run.x[-1] / (scale or 1.0) - origin - about.x[-1]).max()
            assert error <= (1e-14 if method != "taylor" else 1e-12) * (10 + max(origin)), f"{said}: {error}"
