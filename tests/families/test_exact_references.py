"""Exact references of random systems, against power series of 40 digits and a dense look at the surface."""

import re
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

import core

MP = mpmath.MPContext()
MP.dps = 50
ULP = np.finfo(float).eps
DENSE = 1500  # looks at g in a step of the oracle

IN_DOUBLES = {name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")}
IN_DIGITS = {name: getattr(MP, name) for name in IN_DOUBLES}


class UndecidedError(Exception):
    """The oracle's looks are too far apart for this case."""


def dyadic(rng: np.random.Generator, low: float, high: float) -> float:
    """A number that is the same in text, in doubles and in 50 digits."""
    return round(float(rng.uniform(low, high)) * 64) / 64


# ---- the oracle: hand-written power series of each kind of field, one after another --------------------------------


def linear(a: list[list[float]], b: list[float]) -> tuple[list[str], Callable[[list[list[Any]], int], list[Any]]]:
    """x' = a x + b as text, and its recurrence."""
    names = "xyzw"[: len(b)]
    texts = [
        "+".join([f"({c!r})*{n}" for c, n in zip(row, names, strict=True)] + [f"({e!r})"])
        for row, e in zip(a, b, strict=True)
    ]

    def rate(x: list[list[Any]], k: int) -> list[Any]:
        return [
            sum(c * u[k] for c, u in zip(row, x, strict=True)) + (e if k == 0 else 0)
            for row, e in zip(a, b, strict=True)
        ]

    return texts, rate


def product(u: list[Any], v: list[Any], k: int) -> Any:
    return MP.fsum(u[j] * v[k - j] for j in range(k + 1))


def elliptic(a: float) -> tuple[list[str], Callable[[list[list[Any]], int], list[Any]]]:
    return ["2*y", f"3*x**2+({a!r})"], lambda x, k: [2 * x[1][k], 3 * product(x[0], x[0], k) + (a if k == 0 else 0)]


def pendulum(kappa: float) -> tuple[list[str], Callable[[list[list[Any]], int], list[Any]]]:
    """With sine and cosine as further unknowns of the oracle: s' = yc, c' = −ys."""

    def rate(x: list[list[Any]], k: int) -> list[Any]:
        if len(x) == 2:
            x += [[MP.sin(x[0][0])], [MP.cos(x[0][0])]]
        _, y, s, c = x
        return [y[k], -kappa * s[k], product(y, c, k), -product(y, s, k)]

    return ["y", f"-({kappa!r})*sin(x)"], rate


def body(m: float) -> tuple[list[str], Callable[[list[list[Any]], int], list[Any]]]:
    return (
        ["y*z", "-x*z", f"-({m!r})*x*y"],
        lambda x, k: [product(x[1], x[2], k), -product(x[0], x[2], k), -m * product(x[0], x[1], k)],
    )


class Oracle:
    """Crossings one after another by fixed steps, each looked at densely."""

    def __init__(
        self, fields: dict[int, Any], g: str, t0: float, x0: list[float], h: float, order: int, jump: Any = None
    ):
        self.fields, self.t, self.x, self.h, self.order, self.jump = (
            fields,
            MP.mpf(t0),
            [MP.mpf(u) for u in x0],
            h,
            order,
            jump,
        )
        self.code = compile(g, "g", "eval")
        self.side = 1 if self.g(self.t, self.x) > 0 else -1
        self.names = "xyzw"[: len(x0)]

    def g(self, t: Any, x: Any, functions: dict[str, Any] = IN_DIGITS) -> Any:
        """The switching function, by Python itself."""
        return eval(self.code, dict(functions), {"t": t, **dict(zip("xyzw", x, strict=False))})  # noqa: S307 - our own text

    def series(self) -> list[list[Any]]:
        """Coefficients of the solution from where it is."""
        x = [[u] for u in self.x]
        for k in range(self.order):
            for u, v in zip(x, self.fields[self.side](x, k), strict=True):
                u.append(v / (k + 1))
        return x[: len(self.x)]

    def next(self, until: float) -> tuple[Any, list[Any]] | None:
        """Time and state of the next crossing, the solution then being on the other side; None after `until`."""
        leaving = True
        while self.t < until:
            x = self.series()
            s = np.linspace(0, self.h, DENSE)
            states = [np.polynomial.polynomial.polyval(s, [float(c) for c in u]) for u in x]
            depth = self.side * (self.g(float(self.t) + s, states, IN_DOUBLES) + 0 * s)
            if leaving:
                depth[0] = np.inf
            below = np.flatnonzero(depth <= 0)
            last = below[0] if len(below) else DENSE
            inner = depth[1:last]
            dips = inner[1:-1][(inner[1:-1] < inner[:-2]) & (inner[1:-1] < inner[2:])]
            if (leaving and below.size and last == 1) or (dips.size and dips.min() < 1e-3 * np.abs(inner).max()):
                raise UndecidedError
            if len(below):
                return self.cross(x, s[last - 1], s[last])
            self.t, self.x = self.t + MP.mpf(self.h), [MP.polyval(u[::-1], MP.mpf(self.h)) for u in x]
            leaving = False
        return None

    def cross(self, x: list[list[Any]], low: float, high: float) -> tuple[Any, list[Any]]:
        """Go to the crossing between two times of the step, and over to the other side."""

        def at(s: Any) -> list[Any]:
            return [MP.polyval(u[::-1], s) for u in x]

        s = MP.findroot(
            lambda s: self.g(self.t + s, at(s)),
            (MP.mpf(low), MP.mpf(high)),
            solver="anderson",
            tol=1e-80,
            maxsteps=60,
            verify=False,
        )
        t, place = self.t + s, at(s)
        self.t, self.x = t, self.jump(t, place) if self.jump else place
        self.side = -self.side if self.jump is None else self.side
        return t, place


def compare(
    kinds: list[Any], g: str, x0: list[float], t0: float, until: float, most: int, h: float, order: int = 45
) -> int:
    """Hold the reference of fields of two kinds against the oracle; how many crossings were compared."""
    (minus, below), (plus, above) = kinds
    names = "xyzw"[: len(x0)]
    system = core.PiecewiseSystem(
        name="drawn", variables=tuple(names), f_minus=tuple(minus), f_plus=tuple(plus), g=g, x0=tuple(x0),
    )  # fmt: skip
    case = f"f_minus={minus} f_plus={plus} g={g!r} x0={x0} t0={t0}"
    oracle = Oracle({-1: below, 1: above}, g, t0, x0, h, order)
    reference = core.reference_solution(system, x0, t0)
    assert reference.name.startswith("exact"), case
    for k in range(1, most + 1):
        try:
            wanted = oracle.next(until)
        except UndecidedError:
            return k - 1
        try:
            t, x = reference.crossing(k)
        except ValueError as end:
            if wanted is None or re.search("tangent|slides", str(end)):
                return k - 1
            pytest.fail(f"{case}: crossing {k}: {end}")
        if wanted is None:
            assert t > until - 2 * h, f"{case}: crossing {k} at {t}, none to be expected before {until}"
            return k - 1
        assert reference.exact, case
        assert reference.error <= ULP * (abs(t) + np.abs(x).max()), case
        assert abs(t - wanted[0]) <= np.spacing(abs(t)), f"{case}: crossing {k} at {t!r}, not {MP.nstr(wanted[0], 20)}"
        size = max(abs(u) for u in wanted[1])
        assert max(abs(u - v) for u, v in zip(x, wanted[1], strict=True)) <= ULP * size, f"{case}: crossing {k} at {x}"
    return most


def curved(rng: np.random.Generator) -> str:
    """A surface of the plane: wavy, with bumps, roots, logarithms, steps, or of high degree; it may move."""
    a, k, c = dyadic(rng, 0.1, 1.5), dyadic(rng, 1, 25), dyadic(rng, -2, 2)
    return rng.choice([
        f"y - {a}*sin({k}*x)", f"y - {a}*sin({k}*x - {c}*t)", f"y - {a}*exp(-{4 * k}*(x - ({c}))**2)",
        f"y - {a}*tanh({k}*(x - ({c})))", f"y - {a}*log(1 + {k}*x**2)", f"y - {a}*sqrt(0.0625 + (x - ({c}))**2)",
        f"y - {a}*cos({k}*x*y)", f"x**2 + y**2 - 1 - {a / 2}*sin({k}*x)*cos({k}*y)",
        f"y - {a}*(64*(x/8)**7 - 112*(x/8)**5 + 56*(x/8)**3 - 7*x/8)", f"y - {a}*sin({k}*t)",
        f"y - {a}/(1 + {k}*(x - ({c}))**2)", f"y + 2 - {a}*exp(sin({k}*x))",
    ])  # fmt: skip


def test_flights_over_any_surface_miss_no_crossing(draws):
    compared = 0
    for rng in draws(20):
        fall = dyadic(rng, -1, 0) * int(rng.integers(2))
        flight = [linear([[0, 0], [c, 0]], [dyadic(rng, 0.2, 2), dyadic(rng, -0.5, 0.5)]) for c in (fall, fall)]
        x0 = [dyadic(rng, -6, 0), dyadic(rng, 0, 3)]
        compared += compare(flight, curved(rng), x0, 0.0, 8.0, 6, 0.25, 4)
    assert compared > 2


def test_linear_fields_with_any_eigenvalues_under_any_surface(draws):
    compared = 0
    for rng in draws(14):
        kinds = []
        for _ in range(2):
            p, q, r = dyadic(rng, -0.5, 0.2), dyadic(rng, 0.5, 3), dyadic(rng, -1, 1)
            matrix = [[[p, q], [-q, p]], [[p, 1.0], [0.0, p]], [[p, 0.5], [r, -q / 2]]][rng.integers(3)]
            kinds.append(linear(matrix, [dyadic(rng, -1, 1), dyadic(rng, -1, 1)]))
        kinds = kinds if rng.integers(2) else [kinds[0], kinds[0]]
        compared += compare(kinds, curved(rng), [dyadic(rng, -2, 2), dyadic(rng, -2, 2)], 0.0, 6.0, 5, 0.25, 36)
    assert compared > 1


def test_second_passages_of_a_saddle_keep_their_digits(draws):
    # near a separatrix a passage takes as long as the logarithm of the distance from it: 64 bits lose that, and so does
    # an oracle of 40 terms, whose truncation (7e-28 a step) two passages enlarge by the square of that distance
    compared = 0
    for rng in draws(1):
        near = float(10 ** rng.uniform(-7, -4))
        k, m = dyadic(rng, 0.75, 2), dyadic(rng, 0.25, 0.75)
        cases = [
            ([body(m), body(m)], f"x - {dyadic(rng, -0.3, 0.3)}", [1.0, near, near], 0.25),
            ([pendulum(k), pendulum(k)], f"x - {dyadic(rng, -1, 1)}", [float(np.pi) - near, 0.0], 0.25),
            ([elliptic(-3.0), elliptic(-3.0)], f"x - {dyadic(rng, -0.5, 0.5)}", [1.0 - near, 0.0], 0.125),
        ]
        for kinds, g, x0, h in cases:
            compared += compare(kinds, g, x0, 0.0, 60.0, 3, h, 60)
    assert compared >= 6


def test_kinds_of_fields_beside_each_other_and_moving_surfaces_from_late_starts(draws):
    compared = 0
    for rng in draws(15):
        make = [
            lambda rng: pendulum(dyadic(rng, 0.5, 3)),
            lambda rng: linear([[0.0, 1.0], [-dyadic(rng, 0.5, 3), -dyadic(rng, 0, 0.25)]], [0.0, 0.0]),
            lambda rng: elliptic(-dyadic(rng, 2, 4)),
        ]
        kinds = [make[rng.integers(3)](rng) for _ in range(2)]
        w, a = dyadic(rng, 1, 30), dyadic(rng, 0.05, 0.5)
        g = rng.choice([f"y - {a}*sin({w}*t)", f"x - {a}*cos({w}*t)", f"y - {a}*sin({w}*x - t)", "x**2 + y**2 - 1"])
        t0 = float(rng.choice([0.0, 1e4]))
        compared += compare(kinds, str(g), [dyadic(rng, -1, 0.5), dyadic(rng, -1, 1)], t0, t0 + 6, 6, 0.0625, 30)
    assert compared > 2


def test_balls_on_a_moving_table_hit_it_where_it_is(draws):
    compared = 0
    for rng in draws(8):
        a, w, r, t0 = dyadic(rng, 0.05, 0.3), dyadic(rng, 1, 12), dyadic(rng, 0.5, 1), float(rng.choice([0.0, 1e4]))
        g, x0, speed = f"x - {a}*sin({w}*t)", [dyadic(rng, 0.5, 2), 0.0], f"{a * w}*cos({w}*t)"
        fall = linear([[0.0, 1.0], [0.0, 0.0]], [0.0, -9.75])
        system = core.PiecewiseSystem(
            name="table", variables=("x", "y"), f_minus=tuple(fall[0]), f_plus=tuple(fall[0]), g=g, x0=tuple(x0),
            jump=("x", f"{speed} - {r}*(y - {speed})"),
        )  # fmt: skip

        def land(t, x, a=a, w=w, r=r):
            table = MP.mpf(a) * w * MP.cos(w * t)
            return [x[0], table - r * (x[1] - table)]

        oracle, reference = (
            Oracle({1: fall[1], -1: fall[1]}, g, t0, x0, 0.0625, 6, land),
            core.reference_solution(system, x0, t0),
        )
        for k in range(1, 7):
            case = f"a={a} w={w} r={r} x0={x0} t0={t0}: impact {k}"
            try:
                wanted = oracle.next(t0 + 10)
                t, x = reference.crossing(k)
            except UndecidedError:
                break
            if wanted is None and t > t0 + 9.9:
                break
            assert wanted is not None, f"{case} at {t!r}: none to be expected"
            assert abs(t - wanted[0]) <= np.spacing(abs(t)), f"{case} at {t!r}, not {MP.nstr(wanted[0], 20)}"
            assert np.abs(reference.after(k) - np.array(oracle.x, dtype=float)).max() <= 4 * ULP * np.abs(x).max(), case
            compared += 1
    assert compared > 6


@pytest.mark.parametrize("depth", [1e-13, 1e-9, 1e-5])
def test_a_shallow_dip_below_a_narrow_bump_is_seen(depth):
    # flight at a height of 1 under the tip of a bump of the surface, wherever the samples of a search may fall
    for place in (0.3, 7.0, 333.0):
        flight = {"f_minus": ("1", "0"), "f_plus": ("1", "0"), "g": f"y - (1 + {depth!r})*exp(-40000*(x - {place})**2)"}
        system = core.PiecewiseSystem(name="bump", variables=("x", "y"), x0=(0.0, 1.0), **flight)
        solution = core.reference_solution(system)
        half = float(mpmath.sqrt(mpmath.log1p(mpmath.mpf(repr(depth))) / 40000))
        (first, _), (second, _) = solution.crossing(1), solution.crossing(2)
        assert second - first == pytest.approx(2 * half, abs=2 * np.spacing(place))


def test_a_tangency_of_a_surface_ends_the_solution_in_words(draws):
    for rng in draws(10):
        k = dyadic(rng, 0.5, 4)
        system = core.PiecewiseSystem(
            name="touch",
            variables=("x", "y"),
            f_minus=("1", "0"),
            f_plus=("1", "0"),
            g=f"y + cos({k}*x)",
            x0=(0.0, 1.0),
        )
        with pytest.raises(ValueError, match="tangent"):
            core.reference_solution(system).crossing(1)
