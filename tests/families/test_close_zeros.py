"""Zeros of g, or of an event function, so close that a step hardly tells them apart: all are met, or it is told.

The state moves along the unit circle, x = sin θ, so that all zeros are known in closed form.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import core

#: Positions of the zeros beside the first one, in units of their distance.
CLUSTERS = {"three": (0.0, 1.0, 2.0), "uneven": (0.0, 1.0, 1.3), "five": (0.0, 1.0, 2.0, 3.0, 4.0)}
#: Clusters after which a function has its sign again.
EVEN = {"four": (0.0, 1.0, 2.0, 3.0), "touch and two": (0.0, 0.0, 1.0, 2.0)}


def product(cluster: tuple[float, ...]) -> str:
    """A function of x with these zeros."""
    return "*".join(f"(x - a - {c}*d)" for c in cluster)


def passes(a: float, d: float, cluster: tuple[float, ...], end: float) -> list[float]:
    """Angles θ > 0 up to an end at which sin θ is one of the zeros."""
    zeros = [a + c * d for c in cluster]
    angles = [u + 2 * math.pi * k for z in zeros for u in (math.asin(z), math.pi - math.asin(z)) for k in range(-1, 12)]
    return sorted(u for u in angles if 0.0 < u <= end)


def cluster_of(rng: np.random.Generator, least: float) -> tuple[float, float]:
    """First zero and distance."""
    return float(rng.uniform(-0.8, 0.8)), float(10 ** rng.uniform(least, -2.0))


@pytest.mark.parametrize("cluster", CLUSTERS.values(), ids=CLUSTERS)
def test_taylor_steps_meet_each_of_several_sheets_of_a_surface(draws, cluster):
    for rng in draws(30):
        a, d = cluster_of(rng, -6.0)
        speed = float(rng.uniform(0.3, 8.0))
        system = core.PiecewiseSystem(
            "Sheets", ("x", "y"), ("y", "-x"), ("c*y", "-c*x"), product(cluster),
            parameters={"a": a, "d": d, "c": speed}, x0=(0.0, 1.0))  # fmt: skip
        t = angle = 0.0
        value = math.copysign(1.0, np.prod([-a - c * d for c in cluster]))
        met = []
        for after in passes(a, d, cluster, 70.0):
            rate = speed if value > 0.0 else 1.0
            if t + (after - angle) / rate > 9.0:
                break
            t, angle, value = t + (after - angle) / rate, after, -value
            met.append(t)
        rate = speed if value > 0.0 else 1.0
        angle += (9.0 - t) * rate
        run = core.integrate(system, (0.0, 9.0), method="taylor")
        assert run.warning or run.status is not core.Status.COMPLETED or len(run.crossings) == len(met), (a, d, speed)
        if len(run.crossings) == len(met):  # a sheet is met at 1e-12 of a rate that may be d² of that in between
            assert np.abs(run.x[-1] - [math.sin(angle), math.cos(angle)]).max() <= 1e-7, (a, d, speed)


@pytest.mark.parametrize("cluster", (CLUSTERS | EVEN).values(), ids=CLUSTERS | EVEN)
@pytest.mark.parametrize("method", ["rk4", "dmm4", "prk8", "taylor"])
def test_events_that_are_close_together_are_all_found_or_it_is_told(draws, method, cluster):
    told = 0
    for rng in draws(15):
        a, d = cluster_of(rng, -7.0)
        tau = None if method == "taylor" else float(10 ** rng.uniform(-2.5, -1.0))
        field, psi = ("y", "-x"), ("x**2 + y**2",)
        system = core.PiecewiseSystem(
            "Circle", ("x", "y"), field, field, "y - 50", psi, psi, {"a": a, "d": d}, x0=(0.0, 1.0))  # fmt: skip
        simple = tuple(c for c in cluster if cluster.count(c) == 1)
        times = passes(a, d, simple, 12.6)
        end = float(rng.uniform(9.0, 12.0))
        if min(abs(end - t) for t in times) < 0.1:  # the phase of a coarse run is off by less
            continue
        run = core.integrate(system, (0.0, end), tau=tau, method=method, events=product(cluster))
        told += bool(run.warning)
        wanted = sum(t < end for t in times)
        assert len(run.events) == wanted or "events may have been missed" in run.warning, (a, d, tau, end)
    assert told > 0 or method == "taylor", "some are far too close"
