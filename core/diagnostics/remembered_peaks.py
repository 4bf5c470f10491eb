"""Warn where a state was far larger than it is at the end, and the errors made there have not decayed along with it.

Relative to the peak they may be rounding: at the end they are as large as what is left. Both are measured: by a run in
other steps, how far off the end is; by one that goes on beside the peak, whether what happens there is forgotten, as
it is where a solution decays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.diagnostics.made_again import anew
from core.diagnostics.resolution import RUNS_AWAY
from core.integration.run_settings import Asked
from core.integration.runner import Runner
from core.integration.trajectory import COMPARED, Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["remembered_peaks"]

#: Ratio of the peak of a variable to what is left of it, from which on it is examined …
_HIGH = 1e3
#: … and the same of what a change at the peak leaves at the end to such a change of what is left.
_KEPT = 1e3
#: What is left of such a change below which it is forgotten: rounding alone is left, as where a run slides to rest.
_FORGOTTEN = 1e-12
#: Distance of the end from that of a run in other steps, relative to what is left, that is told.
_SPOILT = 0.1
#: The same, relative to what is kept of the peak, below which it is zero up to rounding, as where a run comes to rest.
_ROUNDING = 16.0 * 2.0**-52
#: What is left is the largest value in this part of the time since the peak, at so many times.
_LAST, _TIMES = 0.05, 16
#: Change of the peak, relative to it: what has become of it can be told apart from rounding.
_BESIDE = 1e-7
#: Lengths of other steps of a fixed size, as parts of it: the errors of two runs may be the same by chance …
_OTHER = (0.5, 0.43)
#: … and of longest ones of a method that chooses its steps, as parts of the time.
_OTHER_LONGEST = (1.0 / 64.0, 1.0 / 71.0)
#: Tolerance of the latter, as a part of the method's own: at a narrow peak it alone decides on the steps.
_TIGHTER = 2.0**-6
_EPS = 2.0**-52


def remembered_peaks(run: Trajectory) -> Iterator[str]:
    """Say of which variable a peak has left no digit at the end.

    Yields
    ------
    str
        A sentence without the last full stop.
    """
    if run.asked is None or run.record != "steps" or len(run.t) < 2 or run.status in RUNS_AWAY:
        return
    size, end = np.abs(run.x), run.x[-1]
    if not np.isfinite(size).all():
        return
    rows = size.argmax(axis=0)
    for k in np.flatnonzero(size.max(axis=0) >= _HIGH * np.abs(end)).tolist():
        row, peak = int(rows[k]), float(size[rows[k], k])
        left = _left(run, row, k)
        if peak < _HIGH * left or not left:
            continue
        off = float(_off(run, run.asked)[k])
        kept = _remembered(run, run.asked, row, k) if off >= _SPOILT * left else np.nan
        if kept >= max(_KEPT * left / peak, _FORGOTTEN) and off >= _ROUNDING * peak * min(1.0, kept):
            name, t = run.system.variables[k], run.t
            yield (
                f"{name} is {peak:.1g} in size at t = {t[row]:.6g}, and errors that are small beside this do not decay "
                f"with it: at t = {t[-1]:.6g}, where it is {end[k]:.3g}, other steps lead to a value that differs by "
                f"{off:.1g}. If a smaller tau or tolerance does not change this, it is rounding at the peak"
            )


def _left(run: Trajectory, row: int, k: int) -> float:
    """Largest size of a variable in the last part of the time since its peak."""
    times = run.t[-1] - _LAST * (run.t[-1] - run.t[row]) * np.linspace(1.0, 0.0, _TIMES)
    return float(np.abs(run.at(times)[:, k]).max())


def _off(run: Trajectory, asked: Asked) -> Floats:
    """Largest distances of the last state from those that steps of other lengths lead to; nan if these do not."""
    asked, settings, off = asked._replace(t_end=float(run.t[-1])), asked.settings, np.zeros(run.system.dimension)
    longest = abs(float(run.t[-1] - run.t[0]))
    for part, of_all in zip(_OTHER, _OTHER_LONGEST, strict=True):
        adaptive = METHODS[run.method].adaptive
        tau = min(part * settings.tau, of_all * longest) if adaptive else part * settings.tau
        tolerance = max(part * _TIGHTER * settings.tolerance, _EPS) if adaptive else settings.tolerance
        other = anew(run, asked, replace(settings, tau=tau, tolerance=tolerance, max_steps=3 * COMPARED))
        off = np.maximum(off, np.abs(other.x[-1] - run.x[-1]) if other.status is Status.COMPLETED else np.nan)
    return off


def _remembered(run: Trajectory, asked: Asked, row: int, k: int) -> float:
    """Change of a variable at the end in units of its change at a peak; nan if that cannot be told."""
    settings, t_end = replace(asked.settings, max_steps=3 * COMPARED), float(run.t[-1])
    base = Runner(run.system, METHODS[run.method], asked.t0, asked.x0, settings)
    if base.advance(float(run.t[row])) is not Status.COMPLETED:
        return np.nan
    other, by = base.copy(), np.zeros(run.system.dimension)
    by[k] = _BESIDE * run.x[row, k]
    other.displace(by)
    reached = base.advance(t_end) is other.advance(t_end) is Status.COMPLETED
    change = abs(float(other.x[k] - base.x[k] if reached else np.nan))
    base.release()
    other.release()
    return change / abs(float(by[k]))
