"""Computes for one page off the event loop, and brings the outcomes back to it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial
from threading import Lock
from time import monotonic
from typing import Any

from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.tasks.event_loop import Delivery
from pwsviz.tasks.latest_wins import Job, Lane

BETWEEN_REPORTS = 0.15
"""Seconds at least: a browser cannot paint partial results faster."""


class Scheduler:
    """Lanes of work by name; within each only the newest request counts.

    Made while a page is served, it hands outcomes to the event loop of that page; else it delivers them at once.
    """

    def __init__(self) -> None:
        self._delivery = Delivery()
        self.closed = False
        self._lanes: dict[str, Lane] = {}
        self._submitted: dict[str, Hashable] = {}
        self._numbers: dict[str, int] = {}
        self._shown: dict[str, int] = {}
        self._short = Lock()

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
        """Have something computed unless it is what was submitted last; return whether it was not.

        Parameters
        ----------
        compute : callable
            Takes a question whether to give up, and whom to tell of progress.
        show : callable
            Is told the outcome, or the exception that came instead, in the event loop.
        advance : callable, optional
            Is told of progress there, as long as nothing else was submitted.
        quiet, patience : float
            As in `latest_wins.Job`; what starts at once is taken to be short.
        """
        if self._submitted.get(lane) == inputs:
            return False
        self._submitted[lane] = inputs
        if quiet == 0.0:
            compute = partial(self._in_turn, compute)
        told = _Seldom(lambda *news: self._deliver(partial(self._pass_on, lane, inputs, advance), *news))
        report = told if advance is not None else _nobody
        self._numbers[lane] = number = self._numbers.get(lane, 0) + 1
        deliver = partial(self._deliver, partial(self._show_latest, lane, number, show))
        job = Job(lambda cancel: compute(cancel, report), deliver, quiet, patience)
        self._lanes.setdefault(lane, Lane()).submit(job)
        return True

    def submitted(self, lane: str) -> Hashable:
        """Return what was submitted last."""
        return self._submitted.get(lane)

    def busy(self, lane: str) -> bool:
        """Whether something waits or is under way."""
        return lane in self._lanes and self._lanes[lane].busy

    def cancel(self, lane: str) -> bool:
        """Give up what is submitted and not there yet, and return whether there was such; it may be submitted again."""
        if not self.busy(lane):
            return False
        self._lanes[lane].cancel()
        self._submitted.pop(lane, None)
        return True

    def forget(self, lane: str) -> None:
        """Let the same be submitted again."""
        self._submitted.pop(lane, None)

    def call_soon(self, callback: Callable[[], None]) -> None:
        """Call back from the event loop as soon as it is free, where figures may be changed; at once without one.

        Panel calls what a click does without that right, if a field was left for it and has a change to tell yet.
        """
        self._deliver(callback)

    def call_later(self, milliseconds: int, callback: Callable[[], None]) -> None:
        """Call back from the event loop after a while; not at all where there is none."""
        if self._delivery.document is not None:
            self._delivery.document.add_timeout_callback(callback, milliseconds)

    def settle(self, timeout: float) -> bool:
        """Wait until nothing is left to compute; return whether that came true in time. For use without a server."""
        deadline = monotonic() + timeout
        while busy := [lane for lane in list(self._lanes.values()) if lane.busy]:  # one may bring work for another
            if not all(lane.join(deadline - monotonic()) for lane in busy):
                return False
        return all(lane.join(deadline - monotonic()) for lane in list(self._lanes.values()))

    def close(self) -> None:
        """Give up all work: the person has left."""
        self.closed = True
        for lane in self._lanes.values():
            lane.cancel()

    def _in_turn(self, compute: Callable[[Cancel, Report], Any], cancel: Cancel, report: Report) -> Any:
        """Compute something short, one at a time: threads that take turns every other moment take longer together."""
        with self._short:
            return compute(cancel, report)

    def _show_latest(self, lane: str, number: int, show: Callable[[Any], None], outcome: Any) -> None:
        """Show an outcome, unless a later one came before it: event loops promise no order."""
        if number >= self._shown.get(lane, 0):
            self._shown[lane] = number
            show(outcome)

    def _pass_on(self, lane: str, inputs: Hashable, advance: Callable[..., None] | None, *news: Any) -> None:
        """Tell of progress, unless it is of something no longer wanted."""
        if advance is not None and self._submitted.get(lane) == inputs and self.busy(lane):
            advance(*news)

    def _deliver(self, show: Callable[..., None], *outcome: Any) -> None:
        """Hand an outcome from a thread to this page, unless it is gone meanwhile."""
        self._delivery(partial(self._while_open, show), *outcome)

    def _while_open(self, show: Callable[..., None], *outcome: Any) -> None:
        if not self.closed:
            show(*outcome)


class _Seldom:
    """Passes news on, but for those that follow others too soon."""

    def __init__(self, tell: Callable[..., None]) -> None:
        self._tell, self._last, self._lock = tell, -1.0, Lock()

    def __call__(self, done: int, total: int, part: object) -> None:
        with self._lock:
            if monotonic() - self._last < BETWEEN_REPORTS:
                return
            self._last = monotonic()
        self._tell(done, total, part)


def _nobody(_done: int, _total: int, _partial: object) -> None:
    """Leave progress unsaid."""
