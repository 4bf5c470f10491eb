"""Record the states of a run at given times while it advances; its steps are not kept."""

from __future__ import annotations

import numpy as np

from core.integration.dense_output import Stepper, Track
from core.integration.recorded import Chunk, Entry
from core.integration.runner import Runner
from core.integration.trajectory import Status
from core.kernels.arrays import Floats
from core.methods import Method
from core.transition.records import NO_MODE, ROW

__all__ = ["Sampler"]


class Sampler:
    """Replaces the rows that a run's loop has written by states at given times.

    Between calls it keeps the last row, and the crossings since the segment of that row was entered.

    Parameters
    ----------
    times
        (k,) in the order of the run, after its start.

    Attributes
    ----------
    rows
        States at the given times that the run has passed.
    entered
        The segments in which these lie.
    """

    def __init__(self, runner: Runner, method: Method, times: Floats) -> None:
        self._runner, self._times, self._done = runner, times, 0
        self._stepper = Stepper(runner.system, method, runner.settings.tolerance)
        self._crossings = 0
        self._track = _point(runner.t, runner.x, NO_MODE, 0)
        self.rows: list[Chunk] = []
        self.entered: list[Entry] = []

    def take(self, final: bool = False) -> None:
        """Evaluate the states at times that the loop has passed; if `final`, also those up to where it stopped."""
        runner, track = self._runner, self._go_on()
        if final:
            track = _joined(track, _point(runner.t, runner.x, runner.mode, runner.segment))
        along = 1.0 if self._times[-1] >= self._track.t[0] else -1.0
        # A crossing may follow at exactly the time of the last row, so that time waits for the next call.
        end = int(np.searchsorted(along * self._times, along * track.t[-1], "right" if final else "left"))
        if end > self._done:
            self._put(track, self._times[self._done : end])
        self._track = _tail(track)

    def _go_on(self) -> Track:
        """The part of the run since the last row of the previous call; removes the rows written since."""
        runner, known = self._runner, self._track
        if known.mode[0] == NO_MODE:
            first = np.array([runner.first_mode])
            known = known._replace(mode=first, entered_mode=first)
        written, runner.rows = runner.rows, []
        new = runner.latest(runner.crossing_count - self._crossings)
        self._crossings = runner.crossing_count
        return Track(
            np.concatenate([known.t, *(rows["t"] for rows, _ in written)]),
            np.concatenate([known.x, *(x for _, x in written)]),
            np.concatenate([known.mode, *(rows["mode"] for rows, _ in written)]),
            np.concatenate([known.segment, *(rows["segment"] for rows, _ in written)]),
            np.concatenate([known.entered_t, new.t]),
            np.concatenate([known.entered_x, new.x_after]),
            np.concatenate([known.entered_mode, new.mode]),
            known.first,
        )

    def _put(self, track: Track, times: Floats) -> None:
        found = self._stepper.find(track, times)
        n = found.solved
        rows = np.empty(n, dtype=ROW)
        rows["t"], rows["mode"], rows["segment"] = times[:n], found.mode[:n], found.segment[:n]
        self.rows.append((rows, found.x[:n]))
        for k in np.unique(found.segment[:n]).tolist():
            if not self.entered or self.entered[-1].segment != k:
                entry = k - track.first
                self.entered.append(Entry(k, float(track.entered_t[entry]), tuple(track.entered_x[entry].tolist())))
        self._done += n
        if n < len(times):
            self._runner.status = Status.NO_CONVERGENCE


def _point(t: float, x: Floats, mode: int, segment: int) -> Track:
    """The track of one state at which its segment is entered."""
    times, states = np.array([t]), x[None].copy()
    modes, segments = np.array([mode]), np.array([segment])
    return Track(times, states, modes, segments, times, states, modes, segment)


def _joined(track: Track, last: Track) -> Track:
    """A track and one more row."""
    return track._replace(
        t=np.concatenate([track.t, last.t]),
        x=np.concatenate([track.x, last.x]),
        mode=np.concatenate([track.mode, last.mode]),
        segment=np.concatenate([track.segment, last.segment]),
    )


def _tail(track: Track) -> Track:
    """The last row, and the entries from that of its segment on; copies, so that the rest can be freed."""
    first = int(track.segment[-1])
    entry = first - track.first
    return Track(
        track.t[-1:].copy(),
        track.x[-1:].copy(),
        track.mode[-1:].copy(),
        track.segment[-1:].copy(),
        track.entered_t[entry:].copy(),
        track.entered_x[entry:].copy(),
        track.entered_mode[entry:].copy(),
        first,
    )
