"""A run is compared with one in half steps where that is at the same place, though earlier or later."""

import numpy as np
import pytest

import core

WORDS = "at a distance below its numerical error"


@pytest.mark.parametrize("radius", [0.2203, 0.5812, 1.30301, 1.58872, 1.66391])
@pytest.mark.parametrize("method", ["dmm2", "dmm4"])
def test_a_shift_in_time_along_the_orbit_is_not_taken_for_a_distance_from_the_surface(radius, method):
    """The orbit from (−1, −1) is closed, and DMM stay on it: they cross, or pass, as the reference does."""
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=radius)
    exact = core.integrate(system, (0.0, 12.0), (-1.0, -1.0), method="taylor", tolerance=1e-14)
    g = (exact.at(np.linspace(0.0, 12.0, 2001)) ** 2).sum(axis=1) - radius**2
    rates = np.abs(exact.crossings.rate_before)
    assert rates.min(initial=np.inf) > 0.5, "it crosses steeply"
    assert len(rates) or g.min() > 0.1 or g.max() < -0.1, "or it stays away"
    run = core.integrate(system, (0.0, 300.0), (-1.0, -1.0), tau=0.08, method=method)
    assert WORDS not in run.warning, run.warning


def test_a_touch_late_in_a_run_is_told_all_the_same():
    """From where the orbit touches the circle it comes back to it after each turn, at a shift in time."""
    x = float(np.roots([3.0, 2.0, -3.0]).min())  # where x² + y² is largest on the curve y² = x³ − 3x − 1
    radius = float(np.sqrt(x**2 + x**3 - 3 * x - 1))
    assert radius == pytest.approx(1.5545, abs=1e-3)
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=radius + 1e-9)
    run = core.integrate(system, (0.0, 60.0), (-1.0, -1.0), tau=0.02, method="rk4")
    assert WORDS in run.warning or run.status is core.Status.GRAZING
