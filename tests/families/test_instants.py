"""Laws that switch at instants, drawn at random, against DOP853 started anew at each of the exact instants."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status
from tests.levels import deep_but

Vector = np.ndarray

#: Longest error of an instant, in roundings of the times on the way.
ROUNDINGS = 8.0 * float(np.finfo(float).eps)

#: Switching functions of time, with their zeros.
INSTANTS: dict[str, Callable[[dict[str, float]], Vector]] = {
    "t - a": lambda p: np.array([p["a"]]),
    "a - t": lambda p: np.array([p["a"]]),
    "t*(t - a)": lambda p: np.array([0.0, p["a"]]),
    "exp(-t) - exp(-a)": lambda p: np.array([p["a"]]),
    "sin(t)": lambda p: np.pi * np.arange(-9, 10),
    "sin(w*t + q)": lambda p: (np.pi * np.arange(-50, 51) - p["q"]) / p["w"],
    "cos(w*t) - c": lambda p: (
        np.add.outer(2 * np.pi * np.arange(-9, 10), np.arccos(p["c"]) * np.array([-1, 1])).ravel() / p["w"]
    ),
}


class Law(NamedTuple):
    """Fields and conserved quantities where g < 0 and where g > 0; s is the sign of g."""

    minus: tuple[str, ...]
    plus: tuple[str, ...]
    psi_minus: tuple[str, ...]
    psi_plus: tuple[str, ...]
    field: Callable[[float, float, float, Vector], list[float]]


LAWS = {
    "springs": Law(
        ("y", "-k*x"), ("y", "-x"), ("k*x**2 + y**2",), ("x**2 + y**2",),
        lambda s, k, t, x: [x[1], -(k if s < 0 else 1.0) * x[0]],
    ),
    "cubic": Law(
        ("y", "-x**3"), ("y", "-k*x"), ("x**4/4 + y**2/2",), ("k*x**2 + y**2",),
        lambda s, k, t, x: [x[1], -(x[0] ** 3) if s < 0 else -k * x[0]],
    ),
    "tilted pendulum": Law(
        ("y", "k - sin(x)"), ("y", "-k - sin(x)"), ("y**2/2 - cos(x) - k*x",), ("y**2/2 - cos(x) + k*x",),
        lambda s, k, t, x: [x[1], -s * k - np.sin(x[0])],
    ),
    "rigid body": Law(
        ("y*z", "-2*x*z", "x*y"), ("k*y*z", "-x*z", "x*y"),
        ("2*x**2 + y**2", "x**2 - z**2"), ("x**2 + k*y**2", "y**2 + z**2"),
        lambda s, k, t, x: [(1.0 if s < 0 else k) * x[1] * x[2], (-2.0 if s < 0 else -1.0) * x[0] * x[2], x[0] * x[1]],
    ),
    "driven": Law(
        ("y", "k*cos(t) - x"), ("y", "sin(t) - sin(x)"), (), (),
        lambda s, k, t, x: [x[1], k * np.cos(t) - x[0] if s < 0 else np.sin(t) - np.sin(x[0])],
    ),
}  # fmt: skip
KICK = np.array([0.3, -0.2, 0.1])

#: Step size, and bound on the error of the state, relative to its size; the laws have rates of up to about 3.
METHODS = {
    "dmm2": (2e-3, 2e-3), "rk2": (2e-3, 2e-3), "dmm4": (1e-2, 1e-5), "rk4": (1e-2, 1e-5), "gauss4": (1e-2, 1e-5),
    "dmm6": (2e-2, 1e-6), "dmm8": (4e-2, 1e-6), "rk8": (4e-2, 1e-8), "prk8": (4e-2, 1e-8), "taylor": (None, 1e-9),
}  # fmt: skip


class Case:
    """A system that switches at instants, and a time span, forward or backward in time."""

    def __init__(self, rng: np.random.Generator, conservative: bool) -> None:
        self.g, names = str(rng.choice(list(INSTANTS))), list(LAWS)[: -1 if conservative else None]
        self.law, self.kicked = LAWS[str(rng.choice(names))], rng.random() < 0.4
        ranges = {"a": (0.5, 4.0), "w": (0.5, 4.0), "q": (-3.0, 3.0), "c": (-0.9, 0.9), "k": (0.3, 3.0)}
        values = {name: float(rng.uniform(*ends)) for name, ends in ranges.items()}
        self.d, self.k, self.instants = len(self.law.minus), values["k"], np.sort(INSTANTS[self.g](values))
        self.t0 = 0.0 if rng.random() < 0.5 else float(rng.uniform(-1.0, 1.0))
        self.t1 = self.t0 + float(rng.choice([1.0, 1.0, -1.0])) * float(rng.uniform(3.0, 8.0))
        start = rng.uniform(0.3, 1.5, self.d)
        jump = tuple(f"{x} + {u}" for x, u in zip("xyz", KICK.tolist(), strict=True))[: self.d]
        self.system = core.PiecewiseSystem(
            "instants", ("x", "y", "z")[: self.d], self.law.minus, self.law.plus, self.g,
            self.law.psi_minus, self.law.psi_plus, parameters=values, x0=tuple(start.tolist()),
            jump=jump if self.kicked else None,
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"<{self.system!r} from {self.t0!r} to {self.t1!r}>"

    def exact(self) -> tuple[Vector, Vector]:
        """Instants on the way, without that of the start, and the state at the end."""
        low, high = sorted((self.t0, self.t1))
        met = self.instants[(low < self.instants) & (self.instants < high)][:: 1 if self.t1 > self.t0 else -1]
        x, ends = np.array(self.system.x0), [self.t0, *met.tolist(), self.t1]
        for n, (start, end) in enumerate(pairwise(ends)):
            side = float(np.sign(self.system.switching((start + end) / 2, x)))
            x = x + KICK[: self.d] * (self.kicked and n > 0)
            field = lambda t, x, side=side: self.law.field(side, self.k, t, x)  # noqa: E731
            x = solve_ivp(field, (start, end), x, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
        return met, x


def off(run: core.Trajectory, exact: Vector) -> float:
    """Error of the last state, relative to the size of the states."""
    return float(np.abs(run.x[-1] - exact).max() / (1.0 + np.abs(run.x).max()))


@pytest.mark.parametrize("method", deep_but(("rk8", "dmm4", "taylor"), METHODS))
def test_the_law_switches_at_the_instants_and_the_order_is_kept(method, draws):
    tau, bound = METHODS[method]
    for rng in draws(30):
        case = Case(rng, core.METHODS[method].needs_conserved)
        instants, exact = case.exact()
        run = core.integrate(case.system, (case.t0, case.t1), tau=tau, method=method, sliding="continue")
        assert run.status is Status.COMPLETED, (case, run.message)
        assert len(run.crossings.t) == len(instants), case
        assert np.abs(run.crossings.t - instants).max(initial=0.0) < ROUNDINGS * (1.0 + np.abs(instants).max(initial=0))
        assert off(run, exact) < bound, (case, off(run, exact))
        if core.METHODS[method].conservative:
            assert np.nanmax(np.abs(run.conserved_error()), initial=0.0) < 1e-13 * (1.0 + np.abs(run.x).max() ** 4)


@pytest.mark.parametrize("method", deep_but(("rk4", "prk8"), METHODS))
def test_members_of_an_ensemble_are_the_runs_bit_by_bit(method, draws):
    for rng in draws(12):
        case = Case(rng, core.METHODS[method].needs_conserved)
        starts, span = np.array(case.system.x0) * rng.uniform(0.8, 1.2, (5, case.d)), (case.t0, case.t1)
        how = {"tau": METHODS[method][0], "method": method, "record": "end"}
        members = core.ensemble(case.system, span, x0=starts, **how)
        for start, end in zip(starts, members.x, strict=True):
            run = core.integrate(case.system, span, tuple(start.tolist()), **how)
            np.testing.assert_array_equal(run.x[-1], end, err_msg=str(case))


def test_references_and_sections_meet_the_same_instants(draws):
    for rng in draws(30):
        case = Case(rng, conservative=False)
        case.t1 = case.t0 + abs(case.t1 - case.t0)
        instants, exact = case.exact()
        found = core.reference_solution(case.system, t0=case.t0)
        assert np.abs(found.state(case.t1) - exact).max() < 1e-9 * (1.0 + np.abs(exact).max()), case
        assert [found.crossing(n + 1)[0] for n in range(len(instants))] == pytest.approx(instants.tolist(), abs=1e-13)
        section = core.section(case.system, (case.t0, case.t1), points=100, tau=0.02, method="rk8")
        assert section.t == pytest.approx(instants, abs=1e-13), case


def between(x: Vector, span: tuple[float, float], k: dict[int, float], c: float) -> tuple[list[float], Vector]:
    """Times at which x'' = −k x + c crosses x = 0, with a k for each sign of x, and the state at the end."""
    (t, end), times = span, []
    while True:
        a = int(np.sign(x[0] or x[1] * (end - t)))

        def leaves(s: float, x: Vector, a: int = a, begin: float = t) -> float:
            return float(x[0] * a + (1e-9 if s == begin else 0.0))

        leaves.terminal, leaves.direction = True, -1.0  # type: ignore[attr-defined]
        found = solve_ivp(lambda _, x, k=k[a]: [x[1], c - k * x[0]], (t, end), x, method="DOP853", rtol=1e-13,
                          atol=1e-14, events=leaves)  # fmt: skip
        t, x = float(found.t[-1]), found.y[:, -1]
        if found.status != 1:
            return times, x
        times.append(t)
        x[0] = 0.0


@pytest.mark.parametrize(
    ("method", "tau", "bound"), [("taylor", None, 1e-9), ("rk8", 0.04, 1e-8), ("dmm2", 2e-3, 1e-2)]
)
def test_instants_among_surfaces_change_the_law_between_their_crossings(method, tau, bound, draws):
    """x'' = −k x + c, where k depends on the sides of x = 0 and of an instant, and c on that of the instant alone."""
    for rng in draws(30):
        w, q, c = float(rng.uniform(0.5, 3.0)), float(rng.uniform(-3.0, 3.0)), float(rng.uniform(-0.3, 0.3))
        k = {a + b: float(rng.uniform(0.5, 3.0)) for a in "-+" for b in "-+"}
        force = {name: f"{b}c - {k[name]!r}*x" for name in k for b in name[1]}
        energy = {name: f"v**2/2 + {k[name]!r}*x**2/2 - ({b}c)*x" for name in k for b in name[1]}
        system = core.PiecewiseSystem(
            "among", ("x", "v"), surfaces=("x", "sin(w*t + q)"), parameters={"w": w, "q": q, "c": c},
            regions={name: core.Region(("v", force[name]), (energy[name],)) for name in k}, x0=(1.0, 0.1),
        )  # fmt: skip
        end = float(rng.choice([-1.0, 1.0])) * float(rng.uniform(4.0, 9.0))
        instants = (np.pi * np.arange(-20, 21) - q) / w
        instants = np.sort(instants[(instants * np.sign(end) > 0) & (abs(instants) < abs(end))])[:: int(np.sign(end))]
        x, crossed = np.array(system.x0), []
        for start, until in pairwise([0.0, *instants.tolist(), end]):
            b = 1.0 if np.sin(w * (start + until) / 2 + q) > 0 else -1.0
            times, x = between(x, (start, until), {a: k["-+"[a > 0] + "-+"[b > 0]] for a in (-1, 1)}, b * c)
            crossed += times
        run = core.integrate(system, (0.0, end), tau=tau, method=method)
        assert run.status is Status.COMPLETED, (system, end, run.message)
        assert np.sort(run.crossings.t) == pytest.approx(np.sort([*instants, *crossed]), abs=bound), (system, end)
        assert off(run, x) < bound, (system, end)
