"""A run that begins where another has met a wall goes on as that does: its start is on the wall, to rounding."""

from __future__ import annotations

import numpy as np
import pytest

import core
from core import Status

END = 200.0


def walls(rng: np.random.Generator) -> list[core.PiecewiseSystem]:
    """A ball above tables that rest or move in different ways, and one inside a ring."""
    a, w, k, r = (round(rng.uniform(*ends), 4) for ends in ((0.3, 0.6), (0.5, 2.0), (0.5, 2.0), (0.85, 1.0)))
    c, size = round(rng.uniform(-3.0, 3.0), 4), round(rng.uniform(0.5, 4.0), 4)
    height = {  # of the table, and its speed
        "c": "0",
        "c + a*sin(w*t)": "a*w*cos(w*t)",
        "c + a*sin(w*t) + a*cos(2*t)": "a*w*cos(w*t) - 2*a*sin(2*t)",
        "c + a*t": "a",
    }
    parameters = {"a": a, "w": w, "k": k, "r": r, "c": c, "R": size}
    tables = [
        core.PiecewiseSystem(
            name="ball on a table", variables=("y", "v"), surfaces=(f"y - ({table})",),
            regions={sign: core.Region(f=("v", f"-k*(y - ({table}))")) for sign in "+-"},
            jumps={0: ("y", f"{speed} - r*(v - ({speed}))")}, parameters=parameters, x0=(c + 2.5, 0.0),
        )
        for table, speed in height.items()
    ]  # fmt: skip
    turned = "2*(x*u + y*v)/(x**2 + y**2)"
    velocities = (round(speed, 4) for speed in rng.uniform(-1.0, 1.0, 2))
    ring = core.PiecewiseSystem(
        name="ball in a ring", variables=("x", "y", "u", "v"), surfaces=("R - x**2 - y**2",),
        regions={sign: core.Region(f=("u", "v", "0", "-k")) for sign in "+-"},
        jumps={0: ("x", "y", f"u - x*{turned}", f"v - y*{turned}")}, parameters=parameters,
        x0=(0.1, 0.2, *velocities),
    )  # fmt: skip
    return [*tables, ring]


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4", "taylor"])
def test_a_run_goes_on_from_where_another_has_met_a_wall(draws, method):
    went_on = 0
    for rng in draws(9):
        for system in walls(rng):
            most = int(rng.integers(1, 12))
            whole = core.integrate(system, (0.0, END), tau=0.02, method=method, max_crossings=most + 1)
            part = core.integrate(system, (0.0, END), tau=0.02, method=method, max_crossings=most)
            if (whole.status, part.status) != (Status.CROSSING_LIMIT,) * 2:
                continue
            rest = core.integrate(
                system, (part.t[-1], END), x0=part.x[-1], tau=0.02, method=method, max_crossings=1
            )  # fmt: skip
            assert "beyond a wall" not in rest.message, (system, part.t[-1])
            assert rest.status == Status.CROSSING_LIMIT, (system, part.t[-1], rest.message)
            assert rest.crossings.t[0] == pytest.approx(whole.crossings.t[-1], rel=1e-6), (system, part.t[-1])
            went_on += 1
    assert went_on > 10
