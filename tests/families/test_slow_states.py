"""Exact references of states that move slowly, or rest, beside surfaces that do not, against the roots of mpmath."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

import core

MP = mpmath.MPContext()
MP.dps = 160
#: Looks at g for its first zero.
LOOKS = 6000
Height = Callable[[Any, Any, Any], Any]  # (time, state, arithmetic) -> g
Path = Callable[[Any, Any], Any]  # (time, arithmetic) -> state


def state(rng: np.random.Generator) -> tuple[str, float, Path]:
    """A field, its start, and the solution (time, arithmetic) -> x: a drift, or a decay of any speed to 1/4."""
    speed = 2.0 ** -float(rng.integers(-20, 200))
    start = float(rng.integers(-16, 17)) / 8
    if rng.integers(2):
        return f"({speed!r})", start, lambda t, m: start + speed * t
    return f"-({speed!r})*(x - 0.25)", start, lambda t, m: 0.25 + (start - 0.25) * m.exp(-speed * t)


def surface(rng: np.random.Generator) -> tuple[str, float, Height]:
    """A surface that moves, the time in which it is looked at, and g."""
    a, w, c = (float(rng.integers(1, 17)) / 8 for _ in range(3))
    kind = int(rng.integers(3))
    if kind == 0:
        return f"x + ({c}) - ({a})*sin(({w})*t)", 12 / w, lambda t, x, m: x + c - a * m.sin(w * t)
    if kind == 1:
        return f"x + ({c}) - ({a / 64})*exp(({w})*t)", 9 / w, lambda t, x, m: x + c - a / 64 * m.exp(w * t)
    return f"x + ({c}) - ({w})*t", 8 / w, lambda t, x, m: x + c - w * t


def first_zero(height: Height, solution: Path, end: float) -> Any | None:
    """The first zero of g; None if the looks are too far apart to tell, or there is none."""
    looks = np.union1d(np.geomspace(1e-9, end, LOOKS), np.linspace(0.0, end, LOOKS))
    values = height(looks, solution(looks, np), np) * np.sign(height(0.0, solution(0.0, np), np))
    below = np.flatnonzero(values <= 0)
    last = below[0] if len(below) else len(values)
    dips = values[1 : last - 1][(values[1 : last - 1] < values[: last - 2]) & (values[1 : last - 1] < values[2:last])]
    if not 2 <= last < len(values) or (dips < 1e-4 * np.abs(values).max()).any():
        return None
    bracket = [MP.mpf(looks[k]) for k in (last - 1, last)]
    return MP.findroot(
        lambda t: height(t, solution(t, MP), MP), bracket, solver="anderson", tol=1e-200, maxsteps=120, verify=False
    )


@pytest.mark.parametrize("idle", [False, True], ids=["alone", "beside a fast part"])
def test_states_that_hardly_move_meet_moving_surfaces_where_mpmath_finds_them(idle, draws):
    """The steps of a power series are as long as its state allows: 2²⁰⁰ units of time here, many turns of the surface.

    In the second case another coordinate decays at once, so that the series goes on with what is left.
    """
    compared = 0
    for rng in draws(40):
        (field, start, solution), (g, end, height) = state(rng), surface(rng)
        if height(0.0, start, MP) == 0 or (wanted := first_zero(height, solution, end)) is None:
            continue
        more = ("-(1048576.0)*y",) if idle else ()
        system = core.PiecewiseSystem(
            name="slow", variables=("x", "y")[: 1 + idle], f_minus=(field, *more), f_plus=(field, *more), g=g,
            x0=(start, 1.0)[: 1 + idle],
        )  # fmt: skip
        reference = core.reference_solution(system)
        t, x = reference.crossing(1)
        at, case = solution(wanted, MP), f"x' = {field}, g = {g}, x0 = {start}"
        assert reference.exact, case
        assert abs(t - wanted) <= np.spacing(t), f"{case}: crossing at {t!r}, not {wanted}"
        assert abs(x[0] - at) <= np.finfo(float).eps * max(abs(at), float(np.abs(x).max())), f"{case}: {x}, not {at}"
        compared += 1
    assert compared > 4
