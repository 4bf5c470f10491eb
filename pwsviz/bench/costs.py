"""Cost of a step, of a first call, and of a moved slider."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

import numpy as np

import core
from pwsviz.bench.plan import Plan
from pwsviz.bench.table import Table, milliseconds

__all__ = ["call_costs", "first_calls", "moved_slider", "step_costs"]

#: Step size.
_TAU = 1e-3
#: Number of calls of which the fastest counts.
_CALLS = 1000
#: Number of moves of a slider, of which the median counts.
_MOVES = 12
#: Program that prints the seconds to import core and to call it for the first time.
_FIRST_CALL = """
import sys, time
start = time.perf_counter()
import core
imported = time.perf_counter()
core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 60.0), method=sys.argv[1], record="end")
print(imported - start, time.perf_counter() - imported)
"""


def step_costs(plan: Plan) -> Table:
    """Processor time and evaluations per step of every method."""
    rows = []
    for name in plan.seeds:
        for method in plan.methods:
            runs = [_run(name, method, plan.steps, 1.0, "end") for _ in range(plan.repeats + 1)]
            cost = min(run.seconds for run in runs) / runs[0].steps
            rows.append([name, method, f"{1e9 * cost:.1f}", f"{runs[0].evaluations / runs[0].steps:.2f}"])
    return Table(
        "Cost of a step",
        f"processor time of the time loop in nanoseconds per step, and evaluations of the field per step; "
        f"{plan.steps} steps of tau = {_TAU:g}, the least of {plan.repeats + 1} runs. taylor chooses its steps by "
        "tolerance = 1e-12, to the same time.",
        ("system", "method", "ns a step", "evaluations a step"),
        rows,
    )


def call_costs(plan: Plan) -> Table:
    """Time of a call that takes one step, besides that of the time loop."""
    rows = []
    for method in plan.methods:
        for record in ("end", "crossings", "steps"):
            calls, loops = zip(*(_call(plan.seeds[0], method, record) for _ in range(_CALLS)), strict=True)
            rows.append(
                [method, record, *(f"{1e6 * seconds:.1f}" for seconds in (min(calls) - min(loops), min(loops)))]
            )
    return Table(
        "Cost of a call",
        f"wall-clock microseconds of a call of core.integrate that takes one step, besides the time loop, and the "
        f"processor time of that; {core.CATALOGUE[plan.seeds[0]].name}, the least of {_CALLS} calls.",
        ("method", "record", "besides", "loop"),
        rows,
    )


def first_calls(plan: Plan) -> Table:
    """Time of a first call in a fresh process, with and without compiled code from an earlier one."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for method in plan.first_calls:
            (imported, compiles), (_, loads) = (_first_call(method, folder) for _ in range(2))
            rows.append([method, *(f"{seconds:.2f}" for seconds in (imported, compiles, loads))])
    return Table(
        "First call",
        "seconds to import core, to integrate the elliptic curve to T = 60 in a fresh process, which compiles the "
        "method, and in another, which loads it. The cache folder is empty before the first method: it compiles the "
        "loops too, which all methods share.",
        ("method", "import", "compiles", "loads"),
        rows,
    )


def moved_slider(plan: Plan) -> Table:
    """Time from moving the slider of the step size, or of the tolerance, to the new arrays."""
    rows = []
    for name in plan.seeds:
        for method in plan.methods:
            moves = [_moved(name, method, plan.steps, 1 + k / 1e4) for k in range(_MOVES + 1)]
            rows.append([name, method, milliseconds(float(np.median(moves[1:])))])
    return Table(
        "Moved slider",
        f"milliseconds from a new tau to the arrays of {plan.steps} steps and their error of psi (taylor: from a new "
        f"tolerance, to the same time); the median of {_MOVES}.",
        ("system", "method", "run + errors"),
        rows,
    )


def _run(name: str, method: str, steps: int, factor: float, record: str) -> core.Trajectory:
    """A run of `steps` steps of size `_TAU` times `factor`; with a variable-step method, to the same time."""
    settings = {"tolerance": 1e-12 * factor} if core.METHODS[method].adaptive else {"tau": _TAU * factor}
    end = _TAU * factor * steps
    return core.integrate(core.CATALOGUE[name], (0.0, end), method=method, record=record, **settings)  # type: ignore[arg-type]


def _call(name: str, method: str, record: str) -> tuple[float, float]:
    """Seconds of a call, and of the time loop in it."""
    started = time.perf_counter()
    run = _run(name, method, 1, 1.0, record)
    return time.perf_counter() - started, run.seconds


def _moved(name: str, method: str, steps: int, factor: float) -> float:
    started = time.perf_counter()
    _run(name, method, steps, factor, "steps").conserved_error()
    return time.perf_counter() - started


def _first_call(method: str, folder: str) -> tuple[float, float]:
    """Seconds to import core, and to call it for the first time, in a new process."""
    environment = {**os.environ, "PWSVIZ_CACHE": folder, "NUMBA_CACHE_DIR": folder}
    command = [sys.executable, "-c", _FIRST_CALL, method]
    out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)  # noqa: S603 - our own text
    imported, called = map(float, out.stdout.split())
    return imported, called
