"""Computes for one page in threads, and delivers the results in its event loop."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial
from threading import Lock
from time import monotonic
from typing import Any

from pwsviz.tasks.cancellation import Cancel, Report, never
from pwsviz.tasks.event_loop import Delivery
from pwsviz.tasks.latest_wins import Job, Lane
from pwsviz.tasks.turns import Turns

BETWEEN_REPORTS = 0.15
"""Least seconds between two partial results: a browser cannot paint them faster."""


TURNS = Turns()
"""Of the short computations of all pages of this process."""


class Scheduler:
    """Lanes of computations by name; in each only the newest request counts.

    If a page is being served when this is made, results are delivered in its event loop; else at once, in the thread.
    """

    def __init__(self) -> None:
        self._delivery = Delivery()
        self.closed = False
        self._lanes: dict[str, Lane] = {}
        self._submitted: dict[str, Hashable] = {}
        self._numbers: dict[str, int] = {}
        self._shown: dict[str, int] = {}
        self._come: set[str] = set()  # lanes whose outcomes wait to be shown

    def submit(
        self,
        lane: str,
        inputs: Hashable,
        compute: Callable[[Cancel, Report], Any],
        show: Callable[[Any], None],
        advance: Callable[[int, int, Any], None] | None = None,
        quiet: float = 0.0,
        patience: float = 0.0,
    ) -> bool:
        """Submit a computation, unless its inputs are those submitted last in this lane; return whether it was new.

        Parameters
        ----------
        lane : str
            Name of the lane.
        inputs : hashable
            What the result depends on.
        compute : callable
            Takes a function that returns whether to stop, and a function to report progress to.
        show : callable
            Called in the event loop with the result, or the exception raised instead.
        advance : callable, optional
            Called there with progress, as long as nothing else was submitted.
        quiet, patience : float
            Seconds, as in `latest_wins.Job`; computations with quiet = 0 are taken to be short.
        """
        if self._submitted.get(lane) == inputs:
            return False
        self._submitted[lane] = inputs
        if quiet == 0.0:
            compute = partial(self._in_turn, compute)
        throttled = _Throttle(lambda *news: self._deliver(partial(self._pass_on, lane, inputs, advance), *news))
        report = throttled if advance is not None else _ignore
        self._numbers[lane] = number = self._numbers.get(lane, 0) + 1
        deliver = partial(self._deliver_with_others, lane, partial(self._show_latest, lane, number, show))
        job = Job(lambda cancel: compute(cancel, report), deliver, quiet, patience)
        self._lanes.setdefault(lane, Lane()).submit(job)
        return True

    def busy(self, lane: str, inputs: Hashable = None) -> bool:
        """Whether a computation is waiting or running; with inputs, whether they are those submitted last, too."""
        return lane in self._lanes and self._lanes[lane].busy and inputs in (None, self._submitted.get(lane))

    def cancel(self, lane: str) -> bool:
        """Cancel what is waiting or running, and return whether there was any; it may be submitted again."""
        if not self.busy(lane):
            return False
        self._lanes[lane].cancel()
        self._submitted.pop(lane, None)
        return True

    def forget(self, lane: str) -> None:
        """Let the same inputs be submitted again, and show nothing of what was submitted before."""
        self._submitted.pop(lane, None)
        self._numbers[lane] = self._shown[lane] = self._numbers.get(lane, 0) + 1

    def call_soon(self, callback: Callable[[], None]) -> None:
        """Call back from the event loop as soon as it is free, where figures may be changed; at once if there is none.

        A click handler has to use this: Panel calls it where figures may not be changed, if the click took the focus
        from a field with a pending change.
        """
        self._deliver(callback)

    def call_together(self, callback: Callable[[], None]) -> None:
        """Call back together with the outcomes of short computations under way, or soon if there are none."""
        self._deliver(callback, lacking=self._lacks)

    def call_later(self, milliseconds: int, callback: Callable[[], None], wanted: Callable[[], bool]) -> None:
        """Call back from the event loop after a delay, if `wanted` then; not at all if there is none."""
        self._delivery.later(milliseconds / 1000, callback, lambda: not self.closed and wanted())

    def settle(self, timeout: float) -> bool:
        """Wait at most `timeout` seconds; return whether all computations are done. For use without a server."""
        deadline = monotonic() + timeout
        while busy := [lane for lane in list(self._lanes.values()) if lane.busy]:  # one may bring work for another
            if not all(lane.join(deadline - monotonic()) for lane in busy):
                return False
        return all(lane.join(deadline - monotonic()) for lane in list(self._lanes.values()))

    def draw_first(self, timeout: float) -> None:
        """Wait at most `timeout` seconds, while the page is being made, for results that it shall contain.

        Those of computations that wait for quiet come later.
        """
        self._delivery.run(lambda: not all(lane.resting for lane in self._lanes.values()), timeout)

    def close(self) -> None:
        """Cancel all computations: the session has ended."""
        self.closed = True
        for lane in self._lanes.values():
            lane.cancel()

    def _in_turn(self, compute: Callable[[Cancel, Report], Any], cancel: Cancel, report: Report) -> Any:
        with TURNS.one():
            return compute(cancel, report)

    def _show_latest(self, lane: str, number: int, show: Callable[[Any], None], outcome: Any) -> None:
        """Show a result unless a later one has been shown: event loops do not guarantee the order."""
        self._come.discard(lane)
        if number >= self._shown.get(lane, 0):
            self._shown[lane] = number
            show(outcome)

    def _pass_on(self, lane: str, inputs: Hashable, advance: Callable[..., None] | None, *news: Any) -> None:
        """Report progress, unless other inputs have been submitted since."""
        if advance is not None and self._submitted.get(lane) == inputs and self.busy(lane):
            advance(*news)

    def _deliver(self, show: Callable[..., None], *outcome: Any, lacking: Callable[[], bool] = never) -> None:
        """Deliver a result from a thread to this page, unless the page has been closed."""
        self._delivery(partial(self._while_open, show), *outcome, lacking=lacking)

    def _deliver_with_others(self, lane: str, show: Callable[..., None], outcome: Any) -> None:
        """Deliver the outcome of one lane together with those that other lanes will have soon."""
        self._come.add(lane)
        self._deliver(show, outcome, lacking=self._lacks)

    def _lacks(self) -> bool:
        """Whether a lane has still to compute something short, and no outcome that waits."""
        return any(lane.due for name, lane in self._lanes.items() if name not in self._come)

    def _while_open(self, show: Callable[..., None], *outcome: Any) -> None:
        if not self.closed:
            show(*outcome)


class _Throttle:
    """Passes progress on, but drops reports less than `BETWEEN_REPORTS` after the last."""

    def __init__(self, tell: Callable[..., None]) -> None:
        self._tell, self._last, self._lock = tell, -1.0, Lock()

    def __call__(self, done: int, total: int, part: object) -> None:
        with self._lock:
            if monotonic() - self._last < BETWEEN_REPORTS:
                return
            self._last = monotonic()
        self._tell(done, total, part)


def _ignore(_done: int, _total: int, _partial: object) -> None:
    """Ignore progress."""
