"""Surfaces met as a power of time, t³, t⁵ or t⁷: all rates vanish where the solution crosses."""

import numpy as np
import pytest

import core
from core import PiecewiseSystem, Status

METHODS = ("rk2", "rk4", "rk8", "gauss4", "taylor")
#: The motion is along y = d with the same speed on both sides.
POWERS = {
    n: PiecewiseSystem(
        f"power {n}", ("x", "y"), f_minus=("u", "0"), f_plus=("u", "0"), g=f"s*(a*(x - c)**{n} - (y - d))",
        x0=(0.0, 0.0), parameters=dict.fromkeys("uacds", 1.0),
    )
    for n in (3, 5, 7)
}  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("power", POWERS)
def test_a_surface_met_as_a_power_of_time_is_crossed_or_called_a_touch(power, method, draws):
    for rng in draws(12):
        u, time, tau = float(rng.uniform(0.5, 2)), float(rng.uniform(0.1, 0.9)), float(10 ** rng.uniform(-2, 0))
        c, d = (float(rng.uniform(-2, 2)) * int(rng.integers(2)) for _ in range(2))
        a = float(10 ** rng.uniform(-2, 2))
        system = POWERS[power].with_parameters(u=u, a=a, c=c, d=d, s=float(rng.choice([-1, 1])))
        run = core.integrate(system, (0.0, 1.0), (c - u * time, d), method=method, tau=tau)
        case = (dict(system.values), time, tau, run.message)
        assert run.status in (Status.COMPLETED, Status.GRAZING), case
        hidden = (64 * np.finfo(float).eps * (abs(d) + a * u**power) / a) ** (1 / power) / u  # by the rounding of g
        assert run.crossings.t == pytest.approx([time], abs=hidden + 1e-14), case
