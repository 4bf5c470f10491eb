"""Orbits in a plane that the law keeps: their distance from it is round-off, and no warning tells of it."""

from __future__ import annotations

import numpy as np
import pytest

import core
from core import Status


@pytest.mark.parametrize(("method", "tau"), [("taylor", None), ("dmm2", 0.01), ("prk8", 0.05)])
def test_round_off_beside_an_invariant_plane_is_no_error(draws, method, tau):
    for rng in draws(3):
        a, b, c = (round(u, 2) for u in rng.uniform(0.5, 2.0, 3))
        below, above = (f"{a}*x**2 + y**2", f"{b}*x**2 + y**2")
        pairs = [(f"{psi} + {c}*z", f"{psi} - z") for psi in (below, above)]
        fields = [("y", f"-{k}*x", "0") for k in (a, b)]
        system = core.PiecewiseSystem("plane", ("x", "y", "z"), *fields, f"x - {round(c / 5, 3)}", *pairs, x0=(0, 1, 0))
        run = core.integrate(system, (0.0, 10.0), method=method, tau=tau)
        assert run.status is Status.COMPLETED, run.message
        assert np.abs(run.x[:, 2]).max() < 1e-30
        assert not run.warning


def test_noise_that_grows_from_an_invariant_plane_is_told():
    # The plane z = 0 repels: from 1e-33 or so on, to which the projection to ψ moves it, z grows as exp(6t).
    field = ("y", "-x", "6*z")
    psi = ("x**2 + y**2 + z**2*exp(-12*t)", "x**2 + y**2")
    system = core.PiecewiseSystem("repels", ("x", "y", "z"), field, field, "x - 0.2", psi, psi, x0=(0.0, 1.0, 0.0))
    run = core.integrate(system, (0.0, 20.0), method="taylor")
    assert run.warning or np.abs(run.x[:, 2]).max() == 0.0
