"""Warn where a run cannot tell whether the solution crosses a surface or only touches it, or misses it.

There the height of a guard falls ever more slowly, and comes to its least within the error of the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from core.codegen.rounding import rounding_bound
from core.compilation.guards import guard_table
from core.diagnostics.resolution import resolvable
from core.integration.dense_output import Stepper, Track
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["near_touches", "times_of_near_touches"]

#: Bound on the error of a height, in units of the first-order bound on its rounding.
_ROUNDINGS = 16.0
#: A run is made again if a pass is slighter than this many times what its local errors add up to: errors may grow.
_GROWTH = 1e6
#: Largest least height of a slight pass, as part of the largest height of all.
_SLIGHT = 0.1
#: Most steps of a run that is made again: beyond, what its local errors add up to stands for its error.
_MOST_STEPS = 500_000
#: Part of the tolerance with which a method that chooses its steps makes a run again.
_FINER = 1.0 / 16.0
#: An error up to this many times the bound on rounding is about as small as that.
_HARDLY_MORE = 1e3
#: Longest time from a slight pass to its least height, in steps.
_NEAR = 8.0
#: Longest time before the least height at which another run is compared, in steps: of passes that are near, and of all.
_LEADS = (8.0, 64.0)
#: Time by which two runs of a method that chooses its steps meet a surface apart, in units of its longest step.
_LATER = 2.0**-7
#: Longest way to the least height, in steps.
_FARTHEST = 32
#: Time by which another run may be earlier or later, as part of the time since the start, and at most in steps.
_SHIFTED, _MOST_SHIFTED = 0.1, 512.0
#: Distance from a state, as part of the range of each coordinate, at which another run is near.
_NEARBY = 0.05
#: How often steps are halved, at most, to meet a tolerance.
_HALVINGS = 6
#: Trial steps to the least height.
_TRIALS = 12
#: Largest ratio of one trial step to the last that is taken for that in which they go on to shrink.
_RATIO = 0.99
#: How a run ends at a touch, which is told then.
_TOUCHES = (Status.GRAZING, Status.ZENO)
_EPS = 2.0**-52


class _Place(NamedTuple):
    """A state of a run, in a mode that the guard, given by its number in the mode, ends."""

    t: float
    x: Floats
    mode: int
    guard: int


class _There(NamedTuple):
    """A state of another run."""

    t: float
    x: Floats


class _Least(NamedTuple):
    """Where a height is least."""

    t: float
    height: float
    noise: float
    """Bound on its error by rounding."""
    bend: float
    """Rate of its rate."""
    instant: bool
    """Whether it depends on time alone."""


def near_touches(run: Trajectory, rounding: bool = False, far: bool = False) -> Iterator[str]:
    """Say where a run passes a surface by less than its own error.

    What half the step size changes, or a smaller tolerance, is taken for half the error.

    Parameters
    ----------
    run : Trajectory
    rounding : bool
        Say only where that error is about as small as that of rounding, so that smaller steps hardly help.
    far : bool
        Look at the passes that take more than some steps instead: within the error of many steps of order 2.

    Yields
    ------
    str
        Some sentences, without the last full stop, in the order of the run.
    """
    for least, error in _slight_passes(run, far):
        if error <= _HARDLY_MORE * least.noise or not rounding:
            yield _words(run, least, error)


def times_of_near_touches(run: Trajectory) -> Iterator[float]:
    """Times at which a run passes a surface by less than its own error, in its order."""
    yield from (least.t for least, _ in _slight_passes(run, far=False))


def _slight_passes(run: Trajectory, far: bool) -> Iterator[tuple[_Least, float]]:
    """The least heights that are within the error of a run, and the error of each; in the order of the run."""
    if run.passes is None or not len(run.passes) or run.t[-1] == run.t[0]:
        return
    search = _Search(run, run.passes[resolvable(run, run.passes[:, 0])])
    for place, since in search.places():
        least = search.least(place)
        if least is not None and search.is_slight(place, least, far):
            error = search.error(place, least, since)
            if not abs(least.height) > error + least.noise:
                yield least, error


def _again(run: Trajectory, longest: float) -> Runner:
    """The same run with steps half as long at most, before it has begun."""
    method = METHODS[run.method]
    most = 4 * (run.steps + int(_MOST_SHIFTED))  # beyond the end of the run there may be a pole
    settings = Settings(0.5 * longest, max(_FINER * run.tolerance, _EPS), max_steps=most, slides=run.slides)
    return Runner(run.system, method, float(run.t[0]), tuple(run.x[0].tolist()), settings, 0)


def _words(run: Trajectory, least: _Least, error: float) -> str:
    adaptive = METHODS[run.method].adaptive
    what = "a parameter" if least.instant else "the initial condition or a parameter"
    known = f", about {max(error, least.noise):.1g} in g" if math.isfinite(error) else ", as smaller steps show"
    return (
        f"At t = {least.t:.6g} the run passes the surface at a distance below its accumulated error{known}. The "
        f"solution may meet it there, touch it or miss it. If it touches it, no step size helps: change {what}. "
        f"Otherwise take {'a smaller tolerance' if adaptive else 'a smaller tau'}"
    )


class _Search:
    """Finds the least heights of the passes of a run."""

    def __init__(self, run: Trajectory, passes: Floats) -> None:
        self.run, self.passes, self.way = run, passes, 1.0 if run.t[-1] >= run.t[0] else -1.0
        self.longest = run.tau or abs(float(run.t[-1] - run.t[0]))  # of a run that has ended in its first step, 0
        self.stepper = Stepper(run.system, METHODS[run.method], run.tolerance)

    def places(self) -> Iterator[tuple[_Place, float]]:
        """The passes that the loop has kept, in the order of the run, with the times since the last crossing."""
        table, order = guard_table(self.run.system.laws), np.argsort(self.way * self.passes[:, 0], kind="stable")
        for t, _, row, since, *x in self.passes[order].tolist():
            mode = int(table.guards["mode"][int(row)])
            yield _Place(t, np.array(x), mode, int(row) - int(table.first_rows[mode])), since

    def least(self, place: _Place, low: float = 0.0) -> _Least | None:
        """The least height of a place, `low` after it at first: the zero of its rate, by the secant method.

        None if the height does not come to a least one there.
        """
        far = _FARTHEST * self.longest + abs(low)
        height, rate, noise = self.height(place, low)
        step = -self.way * math.copysign(2.0**-10 * self.longest, rate)
        bend = last = math.nan
        for _ in range(_TRIALS):
            s = low + step
            if not abs(s) <= far:
                return None
            height, after, noise = self.height(place, s)
            bend = (after - rate) / step * self.way
            if not bend > 0.0:
                return None
            low, rate, last = s, after, step
            step = -after / bend * self.way
            if abs(step) <= 4.0 * _EPS * abs(place.t) or 0.5 * bend * step * step <= _EPS * noise:
                break
        else:  # a multiple zero of the rate, to which steps shrink in a ratio: it may come lower on all of them
            noise = max(noise, abs(rate * step) / (1.0 - min(max(step / last, 0.0), _RATIO)))
        noise = max(noise, self.noise_of_states(place, low))
        instant = not self.run.system.laws.mode(place.mode).written.heights[place.guard].has(*self.run.system.laws.x)
        return _Least(place.t + low, height, noise, bend, instant)

    def height(self, place: _Place, s: float) -> tuple[float, float, float]:
        """Height, its rate along the run, and the bound on its rounding, at the end of steps of length s in all."""
        x, laws = self.after(place, s), self.run.system.laws
        law = laws.mode(place.mode).written
        height = law.heights[place.guard]
        wanted, p = (height, law.rate_of(height), rounding_bound(height)), self.run.system.parameter_array
        values = laws.evaluate(("least", place.mode, place.guard), wanted, np.array([place.t + s]), x[None], p)
        g, rate, noise = values[0].tolist()
        sign = self.way if law.turns(place.guard) else 1.0
        return sign * g, sign * self.way * rate, _ROUNDINGS * _EPS * noise

    def after(self, place: _Place, s: float, parts: int = 1) -> Floats:
        """State at the end of steps of length s in all, none longer than a step of the run.

        Those of a method that chooses its steps are halved until they meet its tolerance: its longest is too long
        elsewhere.
        """
        x = self._steps(place, s, parts)
        for _ in range(_HALVINGS if METHODS[self.run.method].adaptive else 0):
            parts *= 2
            before, x = x, self._steps(place, s, parts)
            if (np.abs(x - before) <= max(self.run.tolerance, _EPS) * np.abs(x).max()).all():
                break
        return x

    def _steps(self, place: _Place, s: float, parts: int) -> Floats:
        count = parts * max(1, math.ceil(abs(s) / self.longest - 1e-9))
        t, x = place.t, place.x
        for k in range(1, count + 1):
            begin, start, mode = np.array([t]), x[None], np.array([place.mode])
            time = place.t + s * (k / count)
            track = Track(begin, start, mode, np.zeros(1, dtype=np.int64), begin, start, mode)
            found = self.stepper.find(track, np.array([time]))
            t, x = time, found.x[0]
        return x

    def is_slight(self, place: _Place, least: _Least, far: bool) -> bool:
        """Whether the least height may be within the error of the run, and is reached within few steps, or more."""
        near = abs(place.t - least.t) <= _NEAR * self.longest
        near &= (_LEADS[0] if far else 0.0) < self.lead(place, least) / self.longest <= _LEADS[far]
        told = self.run.status in _TOUCHES and abs(self.run.t[-1] - least.t) <= self.longest
        if not near or told or abs(least.height) > _GROWTH * self.local_error(place, least):
            return False
        return abs(least.height) <= _SLIGHT * self.range_of_height(place)

    def range_of_height(self, place: _Place) -> float:
        """Largest size of a height at all states recorded: of a pass far from 0, no error that matters is as large."""
        return float(np.nanmax(np.abs(self.heights(place)), initial=0.0))

    def noise_of_states(self, place: _Place, low: float) -> float:
        """Bound on the error of a height, `low` after a place, by the rounding of the states before.

        The state there is the sum of their changes: each coordinate may be off by the rounding of its largest value. Of
        a power of a distance that is 0 there, as of (x - a)³, the slope alone would not tell.
        """
        laws, run = self.run.system.laws, self.run
        height, p = laws.mode(place.mode).written.heights[place.guard], run.system.parameter_array
        key, t, x = (place.mode, place.guard), np.full(3, place.t + low), self.after(place, low)
        slopes = tuple(height.diff(v) for v in laws.x)
        slope = laws.evaluate(("slopes of a height", *key), slopes, t[:1], x[None], p)[0]
        largest = np.abs(run.x[self.way * (place.t - run.t) >= 0.0]).max(axis=0, initial=0.0)
        off = _ROUNDINGS * _EPS * np.copysign(largest, slope)
        around = laws.evaluate(("heights", *key), (height,), t, np.array([x - off, x, x + off]), p)[:, 0]
        return float(np.nanmax(np.abs(around - around[1])))

    def heights(self, place: _Place) -> Floats:
        """A height at all states recorded, of shape (n,)."""
        laws, run = self.run.system.laws, self.run
        height, p = (laws.mode(place.mode).written.heights[place.guard],), run.system.parameter_array
        return laws.evaluate(("heights", place.mode, place.guard), height, run.t, run.x, p)[:, 0]

    def lead(self, place: _Place, least: _Least) -> float:
        """Time before the least height at which another run is compared: the height is some times as large then.

        Where a parabola with the bend at the least height is too flat to tell, as of (x - a)³, heights themselves do.
        """
        apart = _LATER * self.longest if METHODS[self.run.method].adaptive else self.longest
        several = 4.0 * (abs(least.height) + least.noise)
        by_bend, most = math.sqrt(2.0 * several / least.bend), _LEADS[1] * self.longest
        if by_bend <= most:
            return max(by_bend, apart)
        lead = apart
        while lead <= most:
            height, _, _ = self.height(place, least.t - self.way * lead - place.t)
            if height - least.height >= several:
                return lead
            lead *= 2.0
        return by_bend

    def local_error(self, place: _Place, least: _Least) -> float:
        """What the errors of a step, and its rounding, add up to over all steps, as an error of the height."""
        step = -self.way * self.longest
        apart = np.abs(self.after(place, step) - self.after(place, step, 2)).max()
        of_step = apart / (_ROUNDINGS * _EPS * np.abs(place.x).max() or 1.0)
        return float(self.run.steps * least.noise * (1.0 + np.nan_to_num(of_step, nan=np.inf)))

    def error(self, place: _Place, least: _Least, since: float) -> float:
        """Twice the change of the least height in a run with smaller steps; inf where that one leads elsewhere.

        Both go the last way to it with the same steps, whose error counts in proportion to the time. They are compared
        from a state on that the other run, too, has before it meets the surface, if it does. It may be earlier or later
        on the same way: that changes no height, unless the laws depend on the time.
        """
        if self.run.steps > _MOST_STEPS:
            return self.local_error(place, least)
        before = max(self.lead(place, least) - self.way * (least.t - place.t), 0.0)
        t = place.t - self.way * min(before, 0.5 * since)
        here = self.after(place, t - place.t)
        if (there := self.same_place(place.mode, t, here)) is None:
            return math.inf
        to_least = least.t - t - self.ahead(place, t, here, there.x)
        other = self.least(_Place(there.t, there.x, place.mode, place.guard), to_least)
        whole = abs((least.t - self.run.t[0]) / (t - self.run.t[0]))
        return math.inf if other is None else 2.0 * abs(other.height - least.height) * max(whole, 1.0)

    def same_place(self, mode: int, t: float, here: Floats) -> _There | None:
        """Where a run with smaller steps is in the same mode and place as this run; None if nowhere.

        That is at the same time, if the laws depend on it; else some time earlier or later: where it comes near to a
        state of this run, on its turn next in time, as another turn may be elsewhere.
        """
        again, shift = _again(self.run, self.longest), 0.0
        if not self.run.system.laws.names_time:
            shift = min(_SHIFTED * abs(t - self.run.t[0]) + _NEAR * self.longest, _MOST_SHIFTED * self.longest)
        begin = t - self.way * min(shift, abs(t - self.run.t[0]))
        if again.advance(begin, record=False, keep_hits=False) is not Status.COMPLETED:
            return None
        if shift == 0.0:
            return _There(begin, again.x) if again.mode == mode else None
        again.advance(t + self.way * shift, record=True, keep_hits=False)
        if not again.rows:
            return None
        rows, x = (np.concatenate(parts) for parts in zip(*again.rows, strict=True))
        times, x = rows["t"][rows["mode"] == mode], x[rows["mode"] == mode]
        if not len(times):
            return None
        size = np.ptp(x, axis=0)
        distance = np.abs((x - here) / np.where(size > 0.0, size, np.inf)).max(axis=1)
        near = np.flatnonzero(distance <= max(_NEARBY, 2.0 * float(distance.min())))
        k = int(near[np.argmin(np.abs(times[near] - t))])
        while (nearer := min(max(k - 1, 0), k, min(k + 1, len(times) - 1), key=distance.__getitem__)) != k:
            k = nearer
        return _There(float(times[k]), x[k])

    def ahead(self, place: _Place, t: float, here: Floats, x: Floats) -> float:
        """Time by which a state is ahead of one of the run, at time t, on the same way; 0 if that is far."""
        laws = self.run.system.laws
        field = laws.mode(place.mode).written.field
        f = laws.evaluate(("field", place.mode), field, np.array([t]), here[None], self.run.system.parameter_array)[0]
        with np.errstate(all="ignore"):
            ahead = float((x - here) @ f / (f @ f))
        return ahead if abs(ahead) <= _NEAR * self.longest else 0.0
