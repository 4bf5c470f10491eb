"""Curves are the solution's, also between long steps; of many short steps nothing more is asked."""

import numpy as np
import pytest

import core
from pwsviz.geometry.plane import XY
from pwsviz.geometry.polyline_reduction import RESOLUTION, screen_path
from pwsviz.results.curves import LONG_STEPS, curve


def long_steps(method, tau, system="elliptic_curve", **options):
    return core.integrate(core.CATALOGUE[system], (0.0, 10.0), tau=tau, method=method, **options)


def distance(point, path):
    """Distance of a point from a polyline, nan where it has a gap."""
    a, b = path[:-1], path[1:]
    share = np.clip(((point - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.nanmin(np.linalg.norm(a + share[:, None] * (b - a) - point, axis=1))


@pytest.mark.parametrize(
    ("method", "tau", "system"),
    [("taylor", 1.0, "elliptic_curve"), ("dmm2", 0.25, "elliptic_curve"), ("taylor", 1.0, "bouncing_ball")],
)
def test_the_curve_between_long_steps_is_that_of_the_method(method, tau, system):
    run = long_steps(method, tau, system)
    path = curve(run, XY).points
    pixel = np.nanmax(np.ptp(path[np.isfinite(path).all(axis=1)], axis=0)) / RESOLUTION
    times = np.linspace(run.t[0], run.t[-1], 501)
    assert max(distance(point, path) for point in run.at(times)) < pixel
    assert len(path) > len(run.t)


def test_short_steps_are_drawn_as_they_are():
    run = long_steps("dmm2", 1e-2)
    assert len(run.t) < LONG_STEPS
    assert len(curve(run, XY).points) == len(run.t) + len(run.crossings)


def test_a_step_without_solution_between_its_ends_is_left_a_chord(monkeypatch):
    run = long_steps("dmm2", 0.25)

    def refuse(_self, _times):
        raise ValueError

    monkeypatch.setattr(core.Trajectory, "at", refuse)
    assert len(curve(run, XY).points) == len(run.t) + len(run.crossings)


def test_where_a_step_leaps_from_one_solution_to_another_the_curve_is_soon_done(monkeypatch):
    run, asked = long_steps("rk2", 0.25, "harmonic_oscillator"), []
    leap, at = run.t[4] + 0.1, core.Trajectory.at

    def leaping(self, times):
        asked.append(times)
        return at(self, times) + (times > leap)[:, None] * (times < run.t[5])[:, None]

    monkeypatch.setattr(core.Trajectory, "at", leaping)
    curve(run, XY)
    assert len(asked) < 20


@pytest.mark.parametrize(
    ("method", "tau", "t_end"), [("taylor", 1.0, 1000.0), ("dmm2", 0.1, 420.0), ("rk8", 0.25, 1100)]
)
def test_of_very_many_long_steps_the_curve_is_that_of_the_method_and_complete(method, tau, t_end):
    system = core.CATALOGUE["elliptic_curve"]
    run = core.integrate(system, (0.0, t_end), tau=tau, method=method)
    assert len(run.t) > LONG_STEPS
    given = curve(run, XY)
    assert not given.whole
    path = screen_path(given.points, given.kinks)
    orbit = core.integrate(system, (0.0, 20.0), tau=1e-3, method="rk8").x
    pixel = np.ptp(orbit, axis=0).max() / RESOLUTION
    assert max(distance(point, path) for point in orbit[::29]) < 3 * pixel
    middles = (path[1:] + path[:-1]) / 2
    assert max(distance(point, orbit) for point in middles[np.isfinite(middles[:, 0])]) < 2 * pixel
    assert np.all(np.diff(given.t) >= 0.0)
