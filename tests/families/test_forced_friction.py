"""Forced dry friction: slides that end tangentially, against SciPy's events, and what is said of the steps there."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import core

SYSTEM = core.PiecewiseSystem(
    "Forced friction",
    ("x", "v"),
    ("v", "-c*x + k + a*cos(w*t)"),
    ("v", "-c*x - k + a*cos(w*t)"),
    "v",
    parameters={"k": 0.4, "a": 0.3, "c": 1.0, "w": 1.0},
    x0=(2.0, 0.0),
)
END = 25.0


def exact_times(p: dict[str, float], x: float) -> list[float]:
    """Times at which the velocity vanishes, or the block breaks away, from rest at x."""

    def force(t: float, x: float) -> float:
        return -p["c"] * x + p["a"] * math.cos(p["w"] * t)

    t, found = 0.0, []
    while t < END:
        if abs(force(t, x)) < p["k"]:
            times = np.linspace(t, END, 20001)
            over = np.abs(-p["c"] * x + p["a"] * np.cos(p["w"] * times)) > p["k"]
            if not over.any():
                break
            j = int(over.argmax())
            t = brentq(lambda s, x=x: abs(force(s, x)) - p["k"], times[j - 1], times[j], xtol=1e-14)
            found.append(t)
        way = math.copysign(1.0, force(t, x))
        stops = _stop(t, way)
        field = lambda s, y, way=way: (y[1], force(s, y[0]) - p["k"] * way)  # noqa: E731
        run = solve_ivp(field, (t, END), (x, 0.0), "DOP853", rtol=1e-12, atol=1e-14, events=stops, max_step=0.05)
        if not run.t_events[0].size:
            break
        t, x = float(run.t_events[0][0]), float(run.y_events[0][0][0])
        found.append(t)
    return found


def _stop(begin: float, way: float) -> Callable[[float, np.ndarray], float]:
    def stop(t: float, y: np.ndarray) -> float:
        return float(y[1]) if t > begin + 1e-7 else way * 1e-9

    stop.terminal, stop.direction = True, -way  # type: ignore[attr-defined]
    return stop


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_nothing_is_said_to_be_missed_or_astray_where_slides_end_and_all_is_found(draws, method):
    left = 0
    for rng in draws(12):
        p = {"k": rng.uniform(0.1, 0.8), "a": rng.uniform(0.1, 1.5), "c": rng.uniform(0.5, 2), "w": rng.uniform(0.5, 2)}
        x, tau = float(rng.uniform(-3, 3)), float(10 ** rng.uniform(-3, -2))
        run = core.integrate(SYSTEM.with_parameters(**p), (0.0, END), (x, 0.0), tau, method, sliding="continue")
        times = exact_times(p, x)
        assert len(run.crossings) == len(times), (p, x, tau)
        assert np.abs(run.crossings.t - times).max(initial=0.0) < 1e-2, (p, x, tau)
        assert "too long" not in run.warning, (p, x, tau, run.message)
        left += "leaving" in run.crossings.kind
    assert left > 0


@pytest.mark.parametrize(("method", "tau"), [("rk2", 0.01), ("rk2", 0.001), ("rk4", 0.01)])
def test_the_first_step_after_a_slide_is_short_enough(method, tau):
    run = core.integrate(SYSTEM, (0.0, 20.0), tau=tau, method=method, sliding="continue")
    assert run.crossings.t == pytest.approx([3.48787, 7.13627, 10.76835, 11.01414, 14.13706], abs=1e-4)
    assert run.warning == ""


def test_a_dip_leapt_over_in_the_first_step_after_a_slide_is_told():
    # x slides on g = 0 until t = 1, leaves as (t − 1)²/2, and dips by 1e-4 at t = 1.005, for a hundredth of the step.
    leaves = "t - 1 + 2e4*(t - 1.005)*exp(-((t - 1.005)/1e-4)**2)"
    system = core.PiecewiseSystem("Dip", ("x",), ("2",), (leaves,), "x", x0=(-0.5,))
    run = core.integrate(system, (0.0, 2.0), tau=0.01, method="rk4", sliding="continue")
    assert run.crossings.kind.tolist() == ["sliding", "leaving"]
    assert "too long" in run.warning, run.message
