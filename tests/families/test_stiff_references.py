"""Exact references of stiff linear systems, against exponentials in 60 digits and a dense look at the surface."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

import core

MP = mpmath.MPContext()
MP.dps = 60
ULP = np.finfo(float).eps
T_END = 8.0
#: Times after a crossing at which g is looked at: the fast parts decay within decades of them.
LOOKS = np.union1d(np.geomspace(1e-12, T_END, 1500), np.linspace(0.0, T_END, 4001)[1:])


class Stiff:
    """x' = A (x − x*), A = V Λ V⁻¹ with small integers in V and V⁻¹, so that A is exact in doubles.

    Λ has decaying parts of any speed, and one that turns or decays slowly.
    """

    def __init__(self, rng: np.random.Generator, d: int) -> None:
        blocks: list[np.ndarray] = []
        if d > 2 or rng.integers(2):
            p, q = float(rng.integers(0, 3)) / 4, float(rng.integers(1, 9)) / 2
            blocks.append(np.array([[-p, q], [-q, -p]]) * (rng.choice([1.0, 1.0, 4096.0]) if d > 2 else 1.0))
        while sum(map(len, blocks)) < d:
            blocks.append(np.array([[-float(round(10 ** rng.uniform(0, 8)))]]))
        while True:
            shears = [np.eye(d) + np.outer(np.eye(d)[i], np.eye(d)[j]) * rng.integers(-2, 3)
                      for i, j in [rng.permutation(d)[:2] for _ in range(d)]]  # fmt: skip
            self.v = np.linalg.multi_dot([*shears, np.eye(d)])
            self.back = np.round(np.linalg.inv(self.v))
            if np.abs(self.v).max() < 8 and np.array_equal(self.v @ self.back, np.eye(d)):
                break
        self.blocks, self.rest = blocks, rng.integers(-(2**12), 2**12, d) / 2**13  # short, so that the text is exact
        block = np.zeros((d, d))
        at = 0
        for b in blocks:
            block[at : at + len(b), at : at + len(b)] = b
            at += len(b)
        self.a = self.v @ block @ self.back
        names = "xyzw"[:d]
        self.text = tuple(
            "+".join(f"({c!r})*({n}-({r!r}))" for c, n, r in zip(row, names, self.rest.tolist(), strict=True))
            for row in self.a.tolist()
        )

    def flow(self, start: list[Any]) -> Callable[[Any, Any], list[Any]]:
        """The solution from a start: (time or times, arithmetic) -> d coordinates."""
        moved = [u - MP.mpf(r) for u, r in zip(start, self.rest.tolist(), strict=True)]
        parts = [MP.fsum(MP.mpf(c) * u for c, u in zip(row, moved, strict=True)) for row in self.back.tolist()]

        def at(t: Any, m: Any) -> list[Any]:
            c = parts if m is MP else [float(u) for u in parts]
            modes: list[Any] = []
            for block in self.blocks:
                k, decay = len(modes), m.exp(float(block[0, 0]) * t)
                if len(block) == 1:
                    modes.append(decay * c[k])
                    continue
                s, o = m.sin(float(block[0, 1]) * t), m.cos(float(block[0, 1]) * t)
                modes += [decay * (o * c[k] + s * c[k + 1]), decay * (o * c[k + 1] - s * c[k])]
            return [
                sum(float(u) * w for u, w in zip(row, modes, strict=True)) + r
                for row, r in zip(self.v.tolist(), self.rest.tolist(), strict=True)
            ]

        return at


class UndecidedError(Exception):
    """The looks are too far apart for this case."""


def next_crossing(law: Stiff, height: Callable[..., Any], t: Any, x: list[Any], side: int) -> tuple[Any, Any] | None:
    """Time and state of the first crossing from a side, if there is one."""
    at = law.flow(x)
    values = side * height(float(t) + LOOKS, at(LOOKS, np), np)
    below = np.flatnonzero(values <= 0)
    last = below[0] if len(below) else len(values)
    dips = values[1 : last - 1][(values[1 : last - 1] < values[: last - 2]) & (values[1 : last - 1] < values[2:last])]
    least = 1e-3 * np.abs(values).max()
    if last < 2 or (dips < least).any() or (not len(below) and values[-1] < least):
        raise UndecidedError
    if not len(below):
        return None
    bracket = [MP.mpf(LOOKS[k]) for k in (last - 1, last)]
    s = MP.findroot(
        lambda s: height(t + s, at(s, MP), MP), bracket, solver="anderson", tol=1e-80, maxsteps=90, verify=False
    )
    return t + s, at(s, MP)


def looked_over(law: Stiff, height: Callable[..., Any], t: Any, x: list[Any], side: int, found: float) -> Any:
    """Time and state of the crossing within two spacings of a time, if there is one: a fast turn hides from looks."""
    at, width = law.flow(x), 2 * MP.mpf(float(np.spacing(found)))
    bracket = [MP.mpf(found) - t - width, MP.mpf(found) - t + width]
    before, after = (side * height(t + s, at(s, MP), MP) for s in bracket)
    if not (bracket[0] > 0 and before > 0 >= after):
        return None
    s = MP.findroot(
        lambda s: height(t + s, at(s, MP), MP), bracket, solver="anderson", tol=1e-80, maxsteps=90, verify=False
    )
    return t + s, at(s, MP)


def surface(rng: np.random.Generator, d: int) -> str:
    a, b, c = (float(rng.integers(-8, 9)) / 8 for _ in range(3))
    return str(rng.choice([
        f"x + ({a})*y + ({b or 0.5})", f"({a})*x + y*({b or 1.0}) + ({c})", f"y - ({c})*sin(3*t) + ({a or 0.25})",
        f"x*{'xyzw'[d - 1]} + y - ({c})", f"x**2 + y**2 - {1 + abs(c)}",
    ]))  # fmt: skip


def apart(found: np.ndarray, wanted: list[Any]) -> float:
    """Largest difference of two states, relative to their size."""
    return float(max(abs(u - v) for u, v in zip(found, wanted, strict=True)) / max(map(abs, wanted)))


def compare(system: core.PiecewiseSystem, laws: dict[int, Stiff], height: Callable[..., Any], most: int) -> int:
    """Hold the reference against the oracle; how many crossings, or ends without one, were compared."""
    reference = core.reference_solution(system)
    case = f"f={laws[-1].text}, {laws[1].text} g={system.g!r} x0={system.x0}"
    t, x = MP.mpf(0), [MP.mpf(u) for u in system.x0]
    side = 1 if height(t, x, MP) > 0 else -1
    for k in range(1, most + 1):
        try:
            wanted = next_crossing(laws[side], height, t, x, side)
            if wanted is None:
                end = float(t) + T_END
                found, x = reference.state(end), laws[side].flow(x)(end - t, MP)
                assert apart(found, x) <= ULP, f"{case}: without a crossing {k} it ends at {found}"
                return k
            found_t, found = reference.crossing(k)
        except UndecidedError:
            return k - 1
        except ValueError as end:
            if re.search("slides|tangent|no crossing found in", str(end)):  # it says that it does not know
                return k - 1
            pytest.fail(f"{case}: crossing {k}: {end}")
        if found_t < wanted[0]:
            wanted = looked_over(laws[side], height, t, x, side, found_t) or wanted
        (t, x), side = wanted, -side
        assert reference.exact, case
        assert abs(found_t - t) <= np.spacing(found_t), f"{case}: crossing {k} at {found_t!r}"
        assert apart(found, x) <= ULP, f"{case}: crossing {k} at {found}"
    return most


@pytest.mark.parametrize("d", [2, 3, 4])
def test_crossings_of_stiff_linear_fields_are_those_of_their_exponentials(d, draws):
    compared = 0
    for rng in draws(12):
        below, above = (Stiff(rng, d) for _ in range(2))
        laws = {-1: below, 1: below if rng.integers(2) else above}
        text, x0 = surface(rng, d), (rng.integers(-16, 17, d) / 8).tolist()
        code = compile(text, "g", "eval")

        def height(t: Any, x: list[Any], m: Any, code: Any = code) -> Any:
            return eval(code, {"sin": m.sin}, {"t": t, **dict(zip("xyzw", x, strict=False))})  # noqa: S307 - our own text

        if height(0.0, x0, MP) == 0:
            continue
        system = core.PiecewiseSystem(
            name="stiff", variables=tuple("xyzw"[:d]), f_minus=laws[-1].text, f_plus=laws[1].text, g=text, x0=tuple(x0),
        )  # fmt: skip
        compared += compare(system, laws, height, 4)
    assert compared > 3
