"""Surfaces that move, met late: rounding of the times at which they are met does not add up in the state.

The fields are constant, and their directions span a plane; g depends on the state by its distance z from that plane,
which the flow keeps, and on time by a cosine. So z and the time spent in each region are known. One more variable, of
any size, only counts.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import core
from tests.levels import deep_but

EPS = 2.0**-52
#: Of z - a·cos t, increasing functions: the surface is the same.
SHAPES = ("{u}", "sinh({u})", "({u})**3 + 2*({u})", "exp({u}) - 1")
TURNS = 60  #: periods of a run, two crossings each


def drawn(rng, conserved):
    """A system whose flow keeps z exactly, declared as ψ or not; the normal of the plane, fields and start."""
    d = 3 if conserved else int(rng.integers(2, 5))
    normal = rng.choice([-1, 1], size=d) * rng.integers(1, 5, size=d)
    planar = [[normal[k + 1] * (j == k) - normal[k] * (j == k + 1) for j in range(d)] for k in range(d - 1)]
    minus, plus = rng.integers(-8, 9, size=(2, d - 1)) / 16 @ np.array(planar)
    normal, minus, plus = (np.append(v, n) for v, n in ((normal, 0), (minus, rng.integers(1, 9)), (plus, 0)))
    names = "wxyzs"[-d - 1 :]
    z = " + ".join(f"({n})*{v}" for n, v in zip(normal[:d].tolist(), names, strict=False))
    g = rng.choice(SHAPES).format(u=f"{z} - 2*cos(t)")
    x0 = np.append(rng.uniform(-1, 1, size=d), 10 ** rng.uniform(0, 7))
    x0 += (rng.uniform(-1.5, 1.5) - x0 @ normal) * normal / (normal @ normal)
    psi = {"psi_minus": (z,), "psi_plus": (z,)} if conserved else {}
    fields = [tuple(map(repr, v.tolist())) for v in (minus, plus)]
    system = core.PiecewiseSystem("late", tuple(names), fields[0], fields[1], g, **psi, x0=tuple(x0.tolist()))
    return system, normal, minus, plus, x0


@pytest.mark.parametrize("method", deep_but(("rk4", "dmm2"), core.METHODS))
def test_what_the_flow_keeps_does_not_drift_by_the_rounding_of_crossing_times(draws, method):
    kind = core.METHODS[method]
    for rng in draws(3):
        system, normal, minus, plus, x0 = drawn(rng, kind.needs_conserved)
        start = 2 * math.pi * round(10 ** rng.uniform(0, 6))
        end = start + 2 * math.pi * TURNS
        run = core.integrate(system, (start, end), method=method, tau=0.2)
        assert run.status is core.Status.COMPLETED, (run.message, system)
        assert len(run.crossings) == 2 * TURNS
        sizes = np.abs(run.x).max(axis=0)
        terms = float(np.abs(normal) @ sizes)  # of which z is the sum; a run's steps all round alike
        assert np.abs((run.x - x0) @ normal).max() <= 4 * EPS * terms * TURNS, (start, system.g)
        half = math.acos(float(x0 @ normal) / 2.0)  # g < 0 while cos t > z/2
        exact = x0 + 2 * math.pi * TURNS * plus + 2 * half * TURNS * (minus - plus)
        late = 2 * TURNS * EPS * (end + terms) * np.abs(minus - plus).max()
        assert (np.abs(run.x[-1] - exact) <= late + EPS * len(run.t) * sizes).all(), (start, system.g)
