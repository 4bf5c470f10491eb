"""Systems drawn at random that slide: what a run says of them is what their exact solutions do."""

import mpmath as mp
import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import core
from core import Status
from tests.core.sliding_solutions import Exact
from tests.levels import deep_but

#: Method -> its settings, and the error allowed at the end time and in the times of events, relative to the state.
METHODS = {
    "rk8": ({"tau": 0.02}, 1e-12), "taylor": ({"tolerance": 1e-12}, 1e-12), "rk4": ({"tau": 2e-3}, 1e-10),
    "gauss4": ({"tau": 4e-3}, 1e-10),
}  # fmt: skip
END = 8.0
#: An event whose rates are below this part of the largest is a tangency: round-off may decide what follows.
TANGENT = 1e-3
#: Largest state.
LARGEST = 100.0


def drawn(rng):
    """A linear plant with a relay, pushed to and fro, in coordinates bent by a shear: the system and its solution."""
    d = int(rng.integers(2, 5))
    a = np.round(rng.normal(size=(d, d)) - np.eye(d), 3)
    k, n, load, offset = (np.round(rng.normal(size=d), 3) for _ in range(4))
    n[np.abs(n) < 0.1] = 0.5
    k *= -np.sign(n @ k) * rng.uniform(0.5, 3.0)  # the fields differ by k, towards the surface
    k, w = np.round(k, 3), round(float(rng.uniform(0.5, 3.0)), 3)
    x0 = np.round(rng.normal(size=d) * 1.5, 3)
    bend, (i, j) = round(float(rng.uniform(-0.4, 0.4)), 3), rng.choice(d, 2, replace=False)

    def law(part):
        rows = [[*map(repr, map(float, a[r])), repr(float(load[r])), "0", repr(float(offset[r]))] for r in range(d)]
        rows = [[mp.mpf(v) for v in row] for row in rows]
        for r in range(d):
            rows[r][-1] += part * mp.mpf(repr(float(k[r])))
        forcing = [[0] * d + [0, -mp.mpf(repr(w)), 0], [0] * d + [mp.mpf(repr(w)), 0, 0], [0] * (d + 3)]
        return [*rows, *forcing]

    start = [*(mp.mpf(repr(float(v))) for v in x0), 1, 0, 1]
    normal = [*(mp.mpf(repr(float(v))) for v in n), 0, 0, 0]
    exact = Exact(law(0), law(1), normal, start, END)

    def system():
        y = sympy.symbols(f"y:{d}")
        z = [v - sympy.Float(bend) * y[j] ** 2 if r == i else v for r, v in enumerate(y)]
        rates = {}
        for side, part in ((-1, 0), (1, 1)):
            zdot = [
                sum(sympy.Float(float(a[r, c])) * z[c] for c in range(d))
                + sympy.Float(float(load[r])) * sympy.cos(w * sympy.Symbol("t")) + float(offset[r]) + part * float(k[r])
                for r in range(d)
            ]  # fmt: skip
            rates[side] = [q + 2 * sympy.Float(bend) * y[j] * zdot[j] if r == i else q for r, q in enumerate(zdot)]
        return core.PiecewiseSystem(
            name="Drawn", variables=tuple(map(str, y)), f_minus=tuple(rates[-1]), f_plus=tuple(rates[1]),
            g=sum(sympy.Float(float(m)) * v for m, v in zip(n, z, strict=True)), x0=tuple(bent(x0, i, j, bend)),
        )  # fmt: skip

    return system, exact, lambda x: bent(x, i, j, bend)


def bent(x, i, j, bend):
    out = np.array(x, dtype=float)
    out[i] += bend * out[j] ** 2
    return out


def is_clear(exact):
    """Whether every event is far from a tangency, and from the one before it."""
    times = np.array([0.0, *exact.times, END])
    rates = [exact.rates(z) for _, z, *_ in exact.arcs[1:]]
    largest = max((abs(float(r)) for pair in rates for r in pair), default=1.0)
    for (below, above), kind in zip(rates, exact.kinds, strict=True):
        least = max(abs(below), abs(above)) if kind == "leaving" else min(abs(below), abs(above))
        if least < TANGENT * largest:
            return False
    # What grows for long after the last event, unlike what events keep in bounds, magnifies the error without bound.
    states = [z for _, z, *_ in exact.arcs] + [exact.state(END, len(exact.z0))]
    size = max(abs(float(v)) for z in states for v in z)
    return len(times) < 60 and np.diff(times).min() > 0.05 and size < LARGEST


def clear(rng):
    """A drawn case that slides, and of which every event can be told."""
    while True:
        system, exact, place = drawn(rng)
        if "sliding" in exact.kinds and is_clear(exact):
            return system(), exact, place


@pytest.mark.parametrize("method", deep_but(("rk8", "taylor"), METHODS))
def test_runs_slide_where_the_exact_solution_does(method, draws):
    settings, allowed = METHODS[method]
    for rng in draws(2):
        system, exact, place = clear(rng)
        run = core.integrate(system, (0.0, END), method=method, sliding="continue", **settings)
        assert run.status is Status.COMPLETED, run.message
        assert run.crossings.kind.tolist() == exact.kinds
        allowance = 20 * allowed * float(np.abs(run.x).max()) * (1.0 + len(exact.kinds))
        assert np.abs(run.crossings.t - exact.times).max(initial=0.0) < allowance
        for t in (*(0.5 * (exact.times[1:] + exact.times[:-1])), END):
            assert np.abs(run.at(t) - place(exact.state(float(t), system.dimension))).max() < allowance, (t, system)


@pytest.mark.parametrize("above", [True, False])
def test_a_start_where_one_field_is_tangent_and_both_lead_to_the_surface_slides(above, draws):
    """Filippov's speed along y = 0, where the tangent field comes to point to it with the rate −b x."""
    up = "+" if above else "-"  # the fold lies above the surface, or, mirrored, below it
    tangent, pointing = ("s*a", f"-s*b*({up}x)"), ("s*c", f"{up}s*d")
    minus, plus = (pointing, tangent) if above else (tangent, pointing)
    system = core.PiecewiseSystem(
        "Fold", ("x", "y"), f_minus=minus, f_plus=plus, g="y", x0=(0.0, 0.0),
        parameters=dict.fromkeys("abcds", 1.0),
    )  # fmt: skip
    for rng in draws(12):
        a, b, d = rng.uniform(0.3, 2.0, 3).tolist()
        c, sign = float(rng.uniform(-0.2, 2.0)), float(rng.choice([-1.0, 1.0]))
        run = core.integrate(
            system.with_parameters(a=a, b=b, c=c, d=d, s=sign), (0.0, 0.5 * sign), tau=0.005, method="rk4",
            sliding="continue",
        )  # fmt: skip
        case = (a, b, c, d, sign, run.message)
        speed = lambda _, x, a=a, b=b, c=c, d=d: (b * c * x + a * d) / (b * x + d)  # noqa: E731
        wanted = solve_ivp(speed, (0.0, 0.5), [0.0], rtol=1e-11, atol=1e-13)
        assert run.status is Status.COMPLETED, case
        assert (run.mode == 2).all(), case
        assert run.x[-1] == pytest.approx([wanted.y[0, -1], 0.0], abs=1e-7), case
        assert core.integrate(run.system, (0.0, 0.5 * sign), tau=0.02, method="rk4").status is Status.SLIDING
