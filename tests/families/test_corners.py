"""Corners that a solution meets, or misses by any distance, on an arc of a circle: a run tells where it cannot tell."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import core
from core import PiecewiseSystem, Region, Status
from tests.levels import deep_but

NAMES = [f"{letter}{n}" for n in range(1, 4) for letter in "uv"]
#: A circular motion around (a, b) where x < 0 and y < 0, with constant fields around.
CIRCLE = PiecewiseSystem(
    "Arc to a corner", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
    regions={"--": Region(("y - b", "a - x"), psi=("(x - a)**2 + (y - b)**2",)),
             **{key: Region((f"u{n}", f"v{n}")) for n, key in enumerate(("-+", "+-", "++"), start=1)}},
    parameters=dict.fromkeys(["a", "b", *NAMES], 1.0),
)  # fmt: skip
T_END = 3.0
#: Where a run can go on: into "-+" if it meets y = 0 first, else into "+-".
FIRST = {"y": 1, "x": 2}


def arc_to(rng: np.random.Generator, miss: float) -> tuple[PiecewiseSystem, tuple[float, float], str, float]:
    """A system, a start whose arc meets a surface at a distance from the corner, which one, and when."""
    fields = {"u1": -1, "v1": 1, "u2": 1, "v2": -1, "u3": 1, "v3": 1}
    values = {name: sign * float(rng.integers(2, 9)) / 4 for name, sign in fields.items()}
    met = str(rng.choice(["x", "y"]))
    place = np.array([0.0, -miss] if met == "x" else [-miss, 0.0])
    while True:
        angle = rng.uniform(0.2, 1.2)
        centre = rng.uniform(1.0, 3.0, 2) * [1, -1]  # so that the motion at the corner is up and to the right
        turned = np.linspace(0.0, angle, 50)[:, None]
        back = place - centre
        arc = centre + np.cos(turned) * back + np.sin(turned) * np.array([-back[1], back[0]])
        if (arc[1:] < 0.0).all() and arc[-1].max() < -0.1:
            break
    values |= {"a": float(centre[0]), "b": float(centre[1])}
    return CIRCLE.with_parameters(**values), tuple(arc[-1].tolist()), met, angle


#: Each method with its shortest step and its longest; of the Taylor method, tolerances.
METHODS = {
    "rk2": (1e-3, 0.3), "rk4": (1e-2, 0.5), "dmm2": (1e-3, 0.3), "rk8": (0.05, 0.7), "prk8": (0.05, 0.7),
    "taylor": (1e-13, 1e-6),
}  # fmt: skip
QUICK = ("rk4", "rk8", "taylor")


@pytest.mark.parametrize("method", deep_but(QUICK, METHODS))
def test_a_run_that_cannot_tell_the_side_on_which_it_passes_a_corner_says_so(method, draws):
    seen: Counter[str] = Counter()
    for rng in draws(60):
        miss = float(rng.choice([0.0, 10 ** rng.uniform(-15, -1)]))
        system, x0, met, time = arc_to(rng, miss)
        step = {"tolerance" if method == "taylor" else "tau": float(np.exp(rng.uniform(*np.log(METHODS[method]))))}
        run = core.integrate(system, (0.0, T_END), x0, method=method, **step)
        silent = run.message == run.outcome and run.status is Status.COMPLETED
        case = (miss, system.values, x0, step, met, run.crossings.mode.tolist(), run.message)
        if miss == 0.0:
            assert not silent, case
        elif silent:
            assert run.crossings.mode[0] == FIRST[met], case
            # Of order 2 the phase is off by τ²/6 a radian, and the crossing by so much over the sine of its angle.
            assert abs(run.crossings.t[0] - time) < max(0.01, step.get("tau", 0.0) ** 2), case
        seen["silent" if silent else "told"] += 1
    assert len(seen) == 2


def test_corners_missed_by_more_than_the_error_of_the_run_are_passed_in_silence(draws):
    for rng in draws(20):
        system, x0, met, _ = arc_to(rng, 10 ** rng.uniform(-6, -2))
        run = core.integrate(system, (0.0, T_END), x0, method="rk8", tau=0.1)
        assert run.message == run.outcome, run.message
        assert run.crossings.mode[0] == FIRST[met]


def test_two_parallel_surfaces_within_a_step_are_no_corner():
    # a chaotic run, which one with half the step leaves: crossings of the two planes of the diode cannot be compared
    run = core.integrate("chua", (0.0, 200.0), method="taylor")
    assert "met first" not in run.message
