"""python -m pwsviz bench: the figures that this project states, measured here, as ratios where they are times."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from typing import TextIO

import numba
import numpy as np

import core

__all__ = ["report"]

_REPEATS = 9
_START = """
import time
start = time.perf_counter()
import core
imported = time.perf_counter()
core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 60.0), tau=1e-3)
print(imported - start, time.perf_counter() - imported)
"""
#: Orders of the perturbation, and the step sizes that show them: errors from 1e-2 down, far above round-off.
_PERTURBATIONS = {None: (3e-2, 1e-4), 1: (3e-3, 1e-5), 2: (3e-2, 1e-4), 3: (3e-2, 1e-4)}


def report(out: TextIO, start: bool = True) -> None:
    """Measure everything and write it as text.

    Parameters
    ----------
    start
        Whether to time a first call in fresh processes too, which compiles for some seconds.
    """
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}"
    print(f"{versions}, {platform.machine()} {platform.system()}, {os.cpu_count()} cores", file=out)
    sections = [_steps, _slider, _conservation, _orders]
    for section in [*([_first_call] if start else []), *sections]:
        print(file=out)
        for line in section():
            print(line, file=out, flush=True)


def _first_call() -> Iterable[str]:
    yield "First call: integrate the elliptic curve to T = 60 at tau = 1e-3"
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "PWSVIZ_CACHE": folder, "NUMBA_CACHE_DIR": folder}
        os.chmod(folder, 0o700)
        for what in ("fresh machine (compiles)", "second process (loads)"):
            command = [sys.executable, "-c", _START]
            out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)  # noqa: S603
            imported, called = map(float, out.stdout.split())
            yield f"  {what:26s} import {imported:5.2f} s   first call {called:5.2f} s"


def _steps() -> Iterable[str]:
    yield "Cost of a step: 100,000 steps of tau = 1e-3, nothing recorded; minimum of 9"
    yield "  system                 method   ns a step   times rk4   evaluations a step"
    for system in core.CATALOGUE.values():
        measured = {method: _step_cost(system, method) for method in core.METHODS}
        for method, (cost, evaluations) in measured.items():
            ratio = cost / measured["rk4"][0]
            yield f"  {system.name:22s} {method:6s} {cost:9.1f} {ratio:11.2f} {evaluations:14.2f}"


def _step_cost(system: core.PiecewiseSystem, method: str) -> tuple[float, float]:
    """Least ns a step of some runs, after one that is thrown away, and evaluations a step."""
    arguments = {"tau": 1e-3, "method": method, "record": "end"}
    runs = [core.integrate(system, (0.0, 100.0), **arguments) for _ in range(_REPEATS + 1)]  # type: ignore[arg-type]
    return min(run.seconds / run.steps for run in runs[1:]) * 1e9, runs[0].evaluations / runs[0].steps


def _slider() -> Iterable[str]:
    yield "Moved step-size slider: from a new tau to the arrays of 100,000 steps; median of 20 (ms)"
    yield "  system                 method   run + errors   of which loop"
    for system in core.CATALOGUE.values():
        for method in core.METHODS:
            whole, loop = np.median([_moved(system, method, 1e-3 * (1 + k / 1e4)) for k in range(20)], axis=0)
            yield f"  {system.name:22s} {method:6s} {1e3 * whole:12.1f} {1e3 * loop:14.1f}"


def _moved(system: core.PiecewiseSystem, method: str, tau: float) -> tuple[float, float]:
    started = time.perf_counter()
    run = core.integrate(system, (0.0, 1e5 * tau), tau=tau, method=method)
    run.conserved_error()
    return time.perf_counter() - started, run.seconds


def _conservation() -> Iterable[str]:
    yield "Conservation: largest |psi - exact level| at tau = 1e-3 to T = 100 (eps = 2.2e-16)"
    yield "  system                 method   side -1     side +1     crossings"
    for name, levels in (("harmonic_oscillator", (3.0, 1.0)), ("elliptic_curve", (2 * np.cos(4 * np.pi / 7), 0.0))):
        system = core.CATALOGUE[name]
        for method in core.METHODS:
            run = core.integrate(system, (0.0, 100.0), tau=1e-3, method=method)
            worst = []
            for side, level in zip((-1, 1), levels, strict=True):
                rows = run.side == side
                worst.append(np.abs(system.conserved(side, run.t[rows], run.x[rows]) - level).max())
            yield f"  {system.name:22s} {method:6s} {worst[0]:9.1e}   {worst[1]:9.1e} {len(run.crossings):9d}"


def _orders() -> Iterable[str]:
    yield "Order of dmm2 across crossings 10, 20, 30, crossing times moved by tau**p; fitted slopes"
    yield "  system                 p      crossing time          state: before   after 10, 20, 30       fit window"
    for system in core.CATALOGUE.values():
        for p, window in _PERTURBATIONS.items():
            study = core.order_study(system, np.geomspace(*window, 11), perturbation_order=p)
            times = " ".join(f"{s:6.3f}" for s in study.time_slope)
            states = " ".join(f"{s:6.3f}" for s in study.state_slope[1:])
            fit = f"{study.window[1:, 0].min():.1e} ... {study.window[1:, 1].max():.1e}"
            yield f"  {system.name:22s} {p!s:5s}  {times}   {study.state_slope[0]:12.3f}   {states}   {fit}"
        yield f"  {system.name:22s} measured against: {study.reference}; round-off floor {study.floor:.0e}"
