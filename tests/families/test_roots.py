"""Fields with a root, which have no real value beyond their surface, are crossed as by their solution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import beta

import core

TURNS = 2.125
"""Length of a run in periods: it crosses four times and ends an eighth of a period after its last turn."""


def root_force(rng: np.random.Generator) -> tuple[core.PiecewiseSystem, float, float]:
    """x'' = −c sign(x)|x|^q from rest at x₀: the system, its speed at x = 0, and a quarter of its period."""
    q, c, x0 = round(rng.uniform(0.1, 0.9), 2), round(10 ** rng.uniform(-1, 1), 3), round(10 ** rng.uniform(-1, 1), 3)
    system = core.PiecewiseSystem("Root", ("x", "v"), ("v", f"{c}*(-x)**{q}"), ("v", f"-{c}*x**{q}"), "x", x0=(x0, 0.0))
    speed = np.sqrt(2 * c / (q + 1)) * x0 ** ((q + 1) / 2)
    return system, float(speed), float(x0 / speed * beta(1 / (q + 1), 0.5) / (q + 1))


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_field_that_ends_at_its_surface_is_left_there_with_the_speed_of_its_solution(draws, method):
    for rng in draws(40):
        system, speed, quarter = root_force(rng)
        tau = quarter / 10 ** rng.uniform(1.3, 3.3)
        run = core.integrate(system, (0.0, 4 * TURNS * quarter), method=method, tau=tau)
        said = f"{system.law_arguments()}, x0 = {system.x0}, tau = {tau}: {run.message}"
        assert run.status is core.Status.COMPLETED, said
        assert run.crossing_count == 4, said
        assert np.abs(run.crossings.x[:, 1]) == pytest.approx(np.full(4, speed), rel=1e-2), said
        assert "second crossing" not in run.warning, said


def root_speed(rng: np.random.Generator) -> tuple[core.PiecewiseSystem, float, float, float]:
    """x' = a − c(s − x)^q | b + d(x − s)^q from s − L: the system, t₀, how long it takes to s, and then to s + R."""
    q = rng.choice([0.5, round(rng.uniform(0.3, 0.9), 2)])
    a, b, length = (round(10 ** rng.uniform(-1, 1), 3) for _ in range(3))
    c, d = round(rng.uniform(-0.4, 0.8) * a / length**q, 4), round(rng.uniform(-0.4, 0.9) * b, 3)
    s, t0 = rng.choice([0.0, round(rng.uniform(-3, 3), 2)]), rng.choice([0.0, round(10 ** rng.uniform(0, 3), 2)])
    laws = (f"{a} - ({c})*({s} - x)**{q}",), (f"{b} + ({d})*(x - ({s}))**{q}",)
    system = core.PiecewiseSystem("Root", ("x",), *laws, f"x - ({s})", x0=(s - length,))
    reach = length if d >= 0 else min(length, 0.8 * (b / -d) ** (1 / q))
    before = quad(lambda y: 1 / (a - c * y**q), 0, length)[0]
    after = quad(lambda y: 1 / (b + d * y**q), 0, reach)[0]
    return system, float(t0), before, after


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_in_one_variable_a_speed_with_a_root_leads_across_the_surface_at_which_it_ends(draws, method):
    for rng in draws(12):
        system, t0, before, after = root_speed(rng)
        tau = min(before, after) / 10 ** rng.uniform(1.6, 3.3)
        run = core.integrate(system, (t0, t0 + before + after), method=method, tau=tau)
        said = f"{system.law_arguments()}, x0 = {system.x0}, t0 = {t0}, tau = {tau}: {run.status} {run.message}"
        assert run.status is core.Status.COMPLETED, said
        assert run.crossing_count == 1, said
        assert run.crossings.t[0] == pytest.approx(t0 + before, abs=1e-2 * before), said
        assert "surface" not in run.warning, said
        assert "crossing" not in run.warning, said
