"""Warn where the errors of the steps have led a run off the solution, which a run in half steps tells.

A shift in time along the orbit is no such error: it grows on every periodic orbit, also with a method that keeps the
orbit itself, as conservative ones do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.diagnostics.kept_at_zero import with_units_of_others
from core.diagnostics.made_again import anew
from core.diagnostics.resolution import RUNS_AWAY, resolvable
from core.diagnostics.slow_passes import SlowPasses
from core.integration.crossings import Integers
from core.integration.trajectory import COMPARED, Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["led_astray"]

#: Distance from the run in finer steps, relative to the range of a variable, that is told.
_FAR = 0.1
#: The same for a method that keeps a tolerance, of which more is expected.
_FAR_KEPT = 0.01
#: Range of a variable, relative to its size, that may be rounding.
_RESTS = 2.0**-44
#: Number of equally spaced times at which both runs are compared …
_TIMES = 512
#: … which are this part of their distance earlier, so that impacts at even times are not among them.
_UNEVEN = 0.381966
#: Change of a shift in time, as part of the time between two of these, that is not counted.
_SHIFT = 0.1
#: How a run ends whose orbit is known in part only.
_UNFINISHED = (Status.NO_CONVERGENCE, Status.STEP_LIMIT)
#: Part of the tolerance with which a method that chooses its steps takes shorter ones …
_FINER = 2.0**-10
#: … and by which its longest step is divided.
_PARTS = 16.0
#: Pieces of a step that are taken to be straight, and most of those in which an orbit is looked at anew.
_PIECES, _MOST_PIECES = 32, 8192
_EPS = 2.0**-52


def led_astray(run: Trajectory) -> Iterator[str]:
    """Say from when on the errors of the steps have led a run off the solution.

    Yields
    ------
    str
        A sentence without the last full stop; none where the run in half steps stays near.
    """
    asked, adaptive = run.asked, METHODS[run.method].adaptive
    if asked is None or run.record != "steps" or not run.steps:
        return
    if adaptive and not asked.settings.transition:  # its steps are as exact as asked for, and the crossings are not
        return
    unmoved = replace(asked.settings, shift=0.0)
    base = run if asked.settings.shift == 0.0 else anew(run, asked, replace(unmoved, max_steps=COMPARED))
    if adaptive:
        longest = run.tau or abs(float(run.t[-1] - run.t[0]))  # 0 of a run that has ended in its first step
        finer = replace(unmoved, tolerance=max(_FINER * unmoved.tolerance, _EPS), tau=longest / _PARTS)
    else:
        finer = replace(unmoved, tau=0.5 * unmoved.tau)
    longer = 0.0 if run.system.laws.names_time else _SHIFT * (asked.t_end - asked.t0)  # the run may be early
    beyond = asked._replace(t_end=asked.t_end + longer)
    if (found := _astray(base, anew(run, beyond, replace(finer, max_steps=3 * COMPARED)))) is not None:
        t, slow = found
        shorter = f"take a smaller {'tolerance' if adaptive else 'tau'}"
        if slow:
            where = f"At t = {t:.6g} the run nearly comes to rest, and the errors of its steps decide where it goes on"
            yield f"{where}, as beside a saddle point: {shorter}"
        else:
            along = "" if run.system.laws.names_time else ", not counting a shift in time,"
            share = "a hundredth" if adaptive else "a tenth"
            grown = f"By t = {t:.3g} the errors of the steps{along} have grown to {share} of the range of the state"
            yield f"{grown}: {shorter}"


def _astray(run: Trajectory, finer: Trajectory) -> tuple[float, bool] | None:
    """The first time, of those compared, at which a run is far from the orbit of another, and False; or, with True,
    at which it nearly rests and the other passes at another distance from the rest.
    """
    way, last = 1.0 if run.t[-1] >= run.t[0] else -1.0, min(len(run.t), COMPARED) - 1
    times = run.t[0] + (run.t[last] - run.t[0]) * (np.arange(1, _TIMES + 1) - _UNEVEN) / (_TIMES - _UNEVEN)
    forced, jumps = run.system.laws.names_time, run.system.laws.jumps
    passes = None if forced or METHODS[run.method].adaptive else SlowPasses(run, finer)
    slow = [row for row in passes.rows if row < last] if passes else []
    rows = np.unique([*np.searchsorted(way * run.t[:last], way * times[:-1]), last, *slow])
    rows = rows[resolvable(run, run.t[rows]) & np.isfinite(run.x[rows]).all(axis=1)]  # at a pole every error grows
    low, high = np.minimum.accumulate(run.x), np.maximum.accumulate(run.x)
    # Where the solution grows without bound, its range so far; else that of all.
    low, high = (one[rows if run.status in RUNS_AWAY else [last] * len(rows)] for one in (low, high))
    moves = high - low > _RESTS * np.maximum(np.abs(low), np.abs(high))
    units = with_units_of_others(run, np.where(moves, high - low, np.inf))
    far = _FAR_KEPT if METHODS[run.method].adaptive else _FAR
    orbit, shift, before = _Orbit(finer, far), 0.0, run.t[0]
    for k, size in zip(rows.tolist(), units, strict=True):
        t = float(run.t[k])
        around = (0.0 if forced else _SHIFT * abs(t - before)) + (0.0 if forced and not jumps else 2.0 * finer.tau)
        if forced and not jumps and k == last and _apart_at(finer, t, run.x[k], far * size):
            return t, False
        if finer.status in _UNFINISHED and way * (t + shift) + around > way * finer.t[-1]:
            return None
        distance, found = orbit.nearest(t + shift, around, run.x[k], size)
        if distance >= far:
            return t, False
        if passes and not passes.alike(k, found):
            return t, True
        before, shift = t, 0.0 if forced else found - t
    return None


def _apart_at(finer: Trajectory, t: float, x: Floats, far: Floats) -> bool:
    """Whether a state is far from that of another run at the same time, which a step of that other may lead past."""
    reached = abs(t - finer.t[0]) <= abs(finer.t[-1] - finer.t[0])
    return bool(reached and (np.abs(finer.at(np.array([t]))[0] - x) >= far).any())


class _Orbit:
    """The recorded states of a run, with those where it met a surface, in order of time."""

    def __init__(self, run: Trajectory, far: float) -> None:
        self._far = far  # distance that is told
        met, self.way = run.crossings, 1.0 if run.t[-1] >= run.t[0] else -1.0
        of = np.arange(len(met))
        t, segment = np.concatenate([run.t, met.t, met.t]), np.concatenate([run.segment, of, of + 1])
        order = np.lexsort((self.way * t, segment))
        self.t, self.x, self.segment = t[order], np.concatenate([run.x, met.x, met.x_after])[order], segment[order]
        self._at = run.at

    def nearest(self, t: float, around: float, x: Floats, size: Floats) -> tuple[float, float]:
        """Least distance, in units of size, of a state from the orbit around a time, and the time there.

        Where it passes nearby several times, as a closed orbit does, that is the time next to the one asked for. Steps
        are taken to be straight, unless the distance is told: a long step of high order is not.
        """
        first, last = np.searchsorted(self.way * self.t, self.way * t + np.array([-around, around]))
        rows = slice(max(min(first, len(self.t) - 1) - 1, 0), last + 1)
        pieces = self.t[rows], self.x[rows], self.segment[rows]
        found = _nearest(*pieces, t, x, size)
        return found if found[0] < self._far else _nearest(*self._divided(*pieces), t, x, size)

    def _divided(self, t: Floats, x: Floats, segment: Integers) -> tuple[Floats, Floats, Integers]:
        """The orbit between some ends of steps, with places on the steps."""
        count = int(np.clip(_MOST_PIECES // max(len(t) - 1, 1), 1, _PIECES))
        parts = np.arange(count) / count
        times = t[:-1, None] + np.where(np.diff(segment) == 0, np.diff(t), 0.0)[:, None] * parts
        try:
            states = self._at(times.ravel()).reshape(len(times), count, x.shape[1])
        except ValueError:  # within a step there may be a place to which none leads: it stays straight
            return t, x, segment
        states[:, 0] = x[:-1]
        states[np.diff(segment) != 0] = x[:-1][np.diff(segment) != 0, None]
        return (
            np.append(times.ravel(), t[-1]),
            np.concatenate([states.reshape(-1, x.shape[1]), x[-1:]]),
            np.append(np.repeat(segment[:-1], count), segment[-1]),
        )


def _nearest(t: Floats, x: Floats, segment: Integers, asked: float, there: Floats, size: Floats) -> tuple[float, float]:
    """Least distance of a state `there` from a polygon, in units of size, and the time at it, next to the one asked.

    That itself, if it is near then: a state that hardly moves is near for long, and tells no time.
    """
    orbit, there = x / size, there / size
    chord = np.diff(orbit, axis=0)
    chord[np.diff(segment) != 0] = 0.0  # a jump
    along = ((there - orbit[:-1]) * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), np.finfo(float).tiny)
    along = np.append(np.clip(along, 0.0, 1.0), 0.0)
    chord = np.concatenate([chord, np.zeros((1, orbit.shape[1]))])  # the last state itself
    lasting = np.append(np.diff(t), 0.0)
    distance = np.nan_to_num(np.abs(orbit + along[:, None] * chord - there).max(axis=1), nan=np.inf)
    times = t + along * lasting
    if lasting.any():
        k = int(np.argmin(np.where(lasting != 0.0, np.abs(t + 0.5 * lasting - asked) - 0.5 * np.abs(lasting), np.inf)))
        then = orbit[k] + np.clip((asked - t[k]) / lasting[k], 0.0, 1.0) * chord[k]
        if np.abs(then - there).max() <= min(0.5 * _FAR, 2.0 * float(distance.min()) + 0.1 * _FAR):
            return float(distance.min()), asked
    near = np.flatnonzero(distance <= max(float(distance.min()), 0.5 * _FAR))
    return float(distance.min()), float(times[near[np.argmin(np.abs(times[near] - asked))]])
