"""The studies that views ask `core` for, with the settings of the page."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

import core
from core.diagnostics import times_of_near_touches
from core.studies import default_taus
from pwsviz.results.requests import CostInputs, StabilityInputs, StudyInputs, sliding_of, transition_of
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import MAX_STEPS
from pwsviz.tasks.cancellation import Cancel, Cancelled, Report

__all__ = [
    "BEFORE_THE_END", "LIMITS_OF_TAU", "STUDY_CROSSINGS", "STUDY_HORIZON", "STUDY_PROBE", "STUDY_TAUS", "Compared",
    "compared_crossings", "studied_cost", "studied_order", "studied_stability",
]  # fmt: skip

STUDY_CROSSINGS = (10, 20, 30)
"""Crossings at which the order is studied, as in the paper."""

STUDY_TAUS = tuple(float(tau) for tau in 2.0 ** -np.arange(3.0, 13.5, 0.5))
"""Step sizes of the order study: twenty-one, from 1/8 down to 1/8192."""

STUDY_HORIZON = 500.0
"""Time up to which the order study looks for crossings."""

STUDY_PROBE = 1e-2
"""Step size of the run with which the order study and the comparison of run times look for crossings and the end."""

LIMITS_OF_TAU = tuple(map(float, Scene.param["tau"].bounds))
"""The least and the largest step size that the page accepts."""

BEFORE_THE_END = 0.9
"""Part of the lifetime of a solution that ends early over which run times, or orders, are compared."""


class Compared(NamedTuple):
    """What an order study compares."""

    crossings: tuple[int, ...]
    """Numbers of the crossings."""
    until: float | None
    """Time of the last state; None if that is halfway between the last crossing and the next."""


def compared_crossings(inputs: StudyInputs, cancel: Cancel) -> Compared:
    """Return which crossings to study: those of the paper, or earlier ones if the trajectory has fewer.

    Of a trajectory with less than two, the state is compared at the end time, or earlier if the trajectory ends before.
    They are counted on a run, since the reference solution might look for a next crossing forever.
    """
    run = core.integrate(
        inputs.problem.build(),
        (0.0, STUDY_HORIZON),
        x0=inputs.problem.x0,
        tau=STUDY_PROBE,
        method=inputs.scheme.method,
        record="crossings",
        max_crossings=STUDY_CROSSINGS[-1] + 1,
        sliding=inputs.scheme.sliding,
        cancel=cancel,
    )
    if cancel():
        raise Cancelled
    end, status = _end_of_solution(run)
    met = run.crossings.passed
    passed = int((met.t <= end).sum())
    if passed < 2:
        until = min(inputs.t_end, BEFORE_THE_END * end)
        if not until > 0.0:
            raise ValueError(f"This trajectory stops at once: {status.reason}. There is no order to study.")
        return Compared((1,) if (met.t < until).any() else (), until)
    last = passed - 1  # the segment after it is studied, too
    usual = last >= STUDY_CROSSINGS[-1]
    return Compared(STUDY_CROSSINGS if usual else tuple(sorted({-(-last // 3), -(-2 * last // 3), last})), None)


def _end_of_solution(run: core.Trajectory) -> tuple[float, core.Status]:
    """Return where a run ends and how; of one that touches a surface, where it does: rounding decides what follows."""
    touch = next(times_of_near_touches(run), math.inf)
    return (touch, core.Status.GRAZING) if touch < run.t[-1] else (float(run.t[-1]), run.status)


def studied_order(inputs: StudyInputs, compared: Compared, cancel: Cancel, report: Report) -> core.OrderStudy:
    """Study the order of an integrator."""
    return core.order_study(
        inputs.problem.build(),
        STUDY_TAUS,
        x0=inputs.problem.x0,
        crossings=compared.crossings,
        until=compared.until,
        cancel=cancel,
        progress=report,
        **inputs.scheme.arguments(),
    )


def studied_cost(inputs: CostInputs, pool: Executor, cancel: Cancel, report: Report) -> core.WorkPrecision:
    """Compare run times and errors, up to the end time or to where a solution that ends before is near its end."""
    system, start = inputs.problem.build(), inputs.problem.x0
    probe = core.integrate(
        system,
        (0.0, inputs.t_end),
        start,
        STUDY_PROBE,
        inputs.methods[0],
        record="end",
        sliding=sliding_of(inputs.slide),
        cancel=cancel,
        max_steps=MAX_STEPS,
    )
    end, status = _end_of_solution(probe)
    there = status in (core.Status.COMPLETED, core.Status.STEP_LIMIT)
    return core.work_precision(
        system,
        (0.0, inputs.t_end if there else BEFORE_THE_END * end),
        x0=start,
        methods=inputs.methods,
        peers=inputs.peers,
        transition=transition_of(inputs.locate),
        sliding=sliding_of(inputs.slide),
        executor=pool,
        cancel=cancel,
        progress=report,
    )


def studied_stability(inputs: StabilityInputs, pool: Executor, cancel: Cancel, report: Report) -> core.StabilityStudy:
    """Compute one part of a stability study."""
    many = inputs.part in ("map", "largest_tau")
    return core.stability_study(
        inputs.problem.build(),
        (0.0, inputs.t_end),
        x0=inputs.problem.x0,
        methods=inputs.methods,
        taus=default_taus(inputs.t_end, *LIMITS_OF_TAU) if many else None,
        coordinate=inputs.coordinate,
        parts=(inputs.part,),
        tau=inputs.tau,
        transition=transition_of(inputs.locate),
        sliding=sliding_of(inputs.slide),
        executor=pool,
        cancel=cancel,
        progress=report,
    )
