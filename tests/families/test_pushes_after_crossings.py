"""A narrow push of the field behind the last crossing of a run is felt as by the solution, or told."""

from __future__ import annotations

import math

import pytest

import core


@pytest.mark.parametrize("method", ["rk2", "rk4", "gauss4"])
def test_a_push_behind_the_surface_that_steps_leap_over_or_meet_by_a_stage_is_told(draws, method):
    wrong = 0
    for rng in draws(20):
        c, b, surface = 10 ** rng.uniform(2, 6), rng.uniform(0.1, 0.8), rng.uniform(0.0, 0.4)
        push, place = rng.uniform(0.05, 5) * math.sqrt(c), surface + rng.uniform(0.01, 0.6)

        def energy(x: float, v: float, b=b, c=c, push=push, place=place) -> float:
            pushed = push * math.sqrt(math.pi / c) / 2 * math.erf(math.sqrt(c) * (x - place))
            return v**2 / 2 - b * x - pushed

        field = ("v", f"{b} + {push}*exp(-{c}*(x - {place})**2)")
        start = (float(rng.uniform(-1.2, -0.4)), float(rng.uniform(0.2, 1.0)))
        system = core.PiecewiseSystem("Pushed", ("x", "v"), field, field, f"x - {surface}", x0=start)
        tau = float(10 ** rng.uniform(-1.3, -0.2))
        run = core.integrate(system, (0.0, 4.0), method=method, tau=tau)
        x, v = run.x[-1].tolist()
        off = abs(energy(x, v) - energy(*start)) / v**2
        wrong += off > 0.1
        assert off < 0.1 or run.warning or run.status is not core.Status.COMPLETED, f"{field}, {start}, tau = {tau}"
    assert wrong > 0, "some steps are far too long"
