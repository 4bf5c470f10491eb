"""What a run records makes no difference to what it warns of."""

import pickle

import numpy as np
import pytest

import core
from core import Status
from core.diagnostics.made_again import with_steps
from core.integration.trajectory import COMPARED

RECORDS = ("steps", "crossings", "end")
FORCED = core.PiecewiseSystem(
    "forced", ("x", "v"), ("v", "-3.8*x - 0.09*v - 0.01*x**3 - 0.05 + 0.66*cos(0.85*t)"),
    ("v", "-3.35*x - 0.07*x**3 + 0.29 + 0.66*cos(0.85*t)"), "x - 0.69", x0=(1.48, 0.96),
)  # fmt: skip
WAVES = "sin(15.36*x + 10.36*v + 5.9)"
SPAN = (20.6, 35.6)


def test_events_that_are_missed_are_told_whatever_is_recorded_and_by_all_that_integrates():
    options = {"tau": 0.1, "method": "rk8"}
    runs = [core.integrate(FORCED, SPAN, events=WAVES, record=record, **options) for record in RECORDS]
    assert len(runs[0].events) < len(core.integrate(FORCED, SPAN, tau=0.01, method="rk8", events=WAVES).events)
    messages = [run.message for run in runs]
    messages.append(core.integrate(FORCED, SPAN, events=WAVES, t_eval=[25.0], **options).message)
    messages.append(core.section(FORCED, SPAN, of=WAVES, points=5000, **options).message)
    messages.append(core.ensemble(FORCED, SPAN, events=WAVES, record="events", max_events=5000, **options).message)
    assert all("events may have been missed" in message for message in messages), messages


@pytest.mark.parametrize("seed", range(12))
def test_a_run_warns_of_the_same_whatever_is_recorded(seed):
    rng = np.random.default_rng(seed)
    stiffness, other, place, wave = rng.uniform((1.0, 1.0, -0.5, 2.0), (40.0, 40.0, 0.5, 20.0))
    system = core.PiecewiseSystem(
        "drawn", ("x", "v"), ("v", f"-{stiffness}*x"), ("v", f"-{other}*x + 0.3*cos(t)"), f"x - {place}", x0=(1.0, 0.5)
    )
    options = {"tau": float(rng.choice([0.3, 0.1, 0.03])), "method": str(rng.choice(["rk2", "rk4", "rk8", "taylor"]))}
    told = {
        core.integrate(system, (0.0, 30.0), record=record, events=f"sin({wave}*x)", **options).message
        for record in RECORDS
    }
    assert len(told) == 1, told


def test_steps_made_again_are_the_same_bit_by_bit_and_end_as_the_run_did():
    options = {"tau": 0.01, "method": "rk4", "perturbation_order": 2}
    whole, end = (core.integrate("kepler", (0.0, 20.0), record=record, **options) for record in ("steps", "end"))
    again = with_steps(pickle.loads(pickle.dumps(end)))  # noqa: S301 - our own
    assert np.array_equal(again.x, whole.x)
    assert (again.status, again.message) == (whole.status, whole.message)
    assert with_steps(whole) is whole


def test_the_crossing_at_which_a_run_ends_is_made_again():
    options = {"tau": 0.04, "method": "taylor", "max_crossings": 1}
    for record in ("crossings", "end"):
        run = core.integrate("vibrating_table", (3.7, 91.0), x0=(-0.18, 3.45, 0.08), record=record, **options)
        again = with_steps(run)
        assert len(again.crossings) == run.crossing_count == 1
        assert np.array_equal(again.x[-1], run.x[-1])


def test_of_a_long_run_the_first_steps_are_made_again():
    run = core.integrate("elliptic_curve", (0.0, 1000.0), tau=0.01, record="end")
    again = with_steps(run)
    assert (run.steps, again.steps, again.status) == (100_000, COMPARED, Status.STEP_LIMIT)


def test_why_a_step_has_failed_is_not_found_out_again():
    run = core.integrate("elliptic_curve", (0.0, 20.0), x0=(3.0, 1.0), tau=0.01, record="end")
    assert run.status in (Status.ESCAPED, Status.NO_CONVERGENCE)
    again = with_steps(run)
    assert (again.steps, again.status, again.outcome) == (run.steps, run.status, run.outcome)
