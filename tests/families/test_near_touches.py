"""A run that passes a surface on another side than the solution does, within its own error, says so."""

from __future__ import annotations

import math

import numpy as np
import pytest

import core

#: What the warning says.
WORDS = "at a distance below its accumulated error"
#: How a run may end that does not pass the surface at all.
TOUCHES = (core.Status.GRAZING, core.Status.ZENO)


def oscillator(rng: np.random.Generator, depth: float, jump: bool) -> tuple[core.PiecewiseSystem, float]:
    """u = A cos(wt − phase) comes to the wall u = A − depth: the system, and the time when u is largest.

    Beyond the wall another field leads away from it, or the velocity jumps there.
    """
    w, phase, amplitude = float(rng.uniform(0.6, 1.7)), float(rng.uniform(0.5, 2.5)), float(rng.uniform(0.5, 2.0))
    below = ("v", "-w**2*u")
    system = core.PiecewiseSystem(
        "Touch", ("u", "v"), below, below if jump else ("1 + v**2", "-v"), "u - wall",
        parameters={"w": w, "wall": amplitude - depth},
        x0=(amplitude * math.cos(phase), amplitude * w * math.sin(phase)),
        **({"jump": ("u", "v - 1")} if jump else {}),
    )  # fmt: skip
    return system, phase / w


@pytest.mark.parametrize("record", ["steps", "end"])
@pytest.mark.parametrize("jump", [False, True])
def test_a_run_that_decides_a_touch_otherwise_than_the_solution_says_so(draws, jump, record):
    for rng in draws(60):
        depth = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-15, -3))
        system, touch = oscillator(rng, depth, jump)
        method = str(rng.choice(["rk2", "rk4", "rk8", "gauss4", "taylor"]))
        settings = {} if method == "taylor" else {"tau": float(10 ** rng.uniform(-2.5, -0.7))}
        run = core.integrate(system, (0.0, touch + 0.3), method=method, record=record, **settings)
        crosses = run.crossing_count > 0
        if crosses != (depth > 0.0) and run.status not in TOUCHES:
            assert run.warning, f"{method}, {settings}, depth {depth:.3g}, {system.values}, {system.x0}: {run.message}"


@pytest.mark.parametrize("jump", [False, True])
def test_a_run_whose_error_is_far_smaller_than_the_pass_is_not_warned_of(draws, jump):
    for rng in draws(60):
        depth = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-9, -3))
        system, touch = oscillator(rng, depth, jump)
        run = core.integrate(system, (0.0, touch + 0.3), method="rk8", tau=0.02)
        assert WORDS not in run.message, f"depth {depth:.3g}, {system.values}, {system.x0}: {run.message}"
        assert (run.crossing_count > 0) == (depth > 0.0)


#: u = a sin t touches u = wall = a at t = π/2, or crosses or misses it by far; x = 1/(pole − t) then blows up.
BEFORE_A_POLE = core.PiecewiseSystem(
    "Touch before a pole", ("u", "v", "x"), ("v", "-u", "x**2"), ("v", "-2*u", "x**2"), "u - wall",
    parameters=(core.Parameter("wall", 1.0),),
)  # fmt: skip
#: Steps before a pole within which a touch need not be told: no step of that size resolves the solution there.
LAST_STEPS = 64


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_touch_is_told_although_the_solution_blows_up_later_and_what_is_clear_is_not(draws, method):
    for rng in draws(24):
        a, pole, tau = float(rng.uniform(0.5, 2.0)), float(rng.uniform(3.0, 6.0)), float(10 ** rng.uniform(-2.7, -1.9))
        assert pole - math.pi / 2 > (LAST_STEPS + 16) * tau
        for wall, touches in ((a, True), (float(rng.uniform(0.2, 0.8)) * a, False), (1.5 * a, False)):
            system = BEFORE_A_POLE.with_parameters(wall=wall)
            run = core.integrate(system, (0.0, 8.0), (0.0, a, 1.0 / pole), tau, method)
            about = f"{method}, tau = {tau}, {wall} of {a}, pole at {pole}: {run.message}"
            assert run.status is core.Status.ESCAPED or (touches and run.status in TOUCHES), about
            assert bool(run.warning) == (touches and run.status not in TOUCHES), about


#: y = sin t − c x² touches the moving surface y = sin t at x = 0.
MOVING = core.PiecewiseSystem(
    "Moving touch", ("x", "y"), ("1", "-2*c*x + cos(t)"), ("1", "3"), "y - sin(t)", parameters={"c": 1.0}
)
#: (x − a, y − b) turns on a circle, which touches y = b + top.
CIRCLE = core.PiecewiseSystem(
    "Circle", ("x", "y"), ("b - y", "x - a"), ("b - y + 1", "x - a + 2"), "y - b - top",
    parameters={"a": 0.0, "b": 0.0, "top": 1.0},
)  # fmt: skip


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4", "taylor"])
def test_a_touch_at_the_end_of_a_step_is_told_and_what_passes_by_more_than_rounding_is_not(draws, method):
    for rng in draws(40):
        steps, c = int(rng.integers(2, 60)), float(rng.uniform(0.3, 3.0))
        begin, top = float(rng.integers(1, 40)) / 16, 10.0 ** float(rng.uniform(-2.0, 2.0))
        a, b = (float(u) for u in rng.uniform(-2.0, 2.0, 2))
        moving, circle = MOVING.with_parameters(c=c), CIRCLE.with_parameters(a=a, b=b, top=top)
        for system, x0, touch in ((moving, (-begin, -c * begin**2), begin), (circle, (a + top, b), math.pi / 2)):
            tau = None if method == "taylor" else touch / steps
            run = core.integrate(system, (0.0, touch + 1.0), x0, tau, method)
            assert run.status is core.Status.GRAZING or run.warning, (
                f"{system.values}, {x0}, tau = {tau}: {run.message}"
            )
        if method == "rk8":
            passes = circle.with_parameters(a=a, b=b, top=top * (1.0 + 1e-9))
            run = core.integrate(passes, (0.0, math.pi / 2 + 1.0), (a + top, b), math.pi / 2 / max(steps, 16), method)
            assert (run.warning, run.crossing_count) == ("", 0), f"{passes.values}: {run.message}"
