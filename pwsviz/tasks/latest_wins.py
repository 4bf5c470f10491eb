"""Computations in a thread, where only the newest request counts."""

from __future__ import annotations

import logging
from _thread import start_new_thread
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from threading import Condition, Event
from time import monotonic
from typing import Any

from pwsviz.tasks.cancellation import Cancel, Cancelled

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Job:
    """One request.

    Parameters
    ----------
    compute : callable
        Takes a function that returns whether to stop, and returns the value.
    deliver : callable
        Called with the value, or the exception raised instead; not called if the job was cancelled.
    quiet : float
        Seconds without a newer job before this one is started, so that a dragged slider starts long work only when it
        rests.
    patience : float
        Seconds that this job may run while a newer one waits. Work as short as a few frames is finished and shown, so
        that the picture keeps moving under a dragged slider.
    """

    compute: Callable[[Cancel], Any]
    deliver: Callable[[Any], None]
    quiet: float = 0.0
    patience: float = 0.0
    given_up: Event = field(default_factory=Event)  # set from outside, to stop it
    computed: Event = field(default_factory=Event)


class Lane:
    """Runs one job at a time in a thread; a newer job replaces a waiting one."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._waiting: Job | None = None
        self._running: Job | None = None
        self._draining = False
        self._joining = 0
        self._failure: Exception | None = None

    @property
    def busy(self) -> bool:
        """Whether a job is waiting or running."""
        with self._changed:
            return self._waiting is not None or self._running is not None

    @property
    def due(self) -> bool:
        """Whether a job that is started at once has still to be computed."""
        with self._changed:
            jobs = (self._waiting, self._running)
            return any(job is not None and job.quiet == 0.0 and not job.computed.is_set() for job in jobs)

    @property
    def resting(self) -> bool:
        """Whether all there is to do waits for quiet."""
        with self._changed:
            return self._running is None and (self._waiting is None or self._waiting.quiet > 0.0)

    def submit(self, job: Job) -> None:
        """Submit `job`, in place of any that is still waiting."""
        with self._changed:
            self._waiting = job
            if not self._draining:
                self._draining = True
                start_new_thread(self._drain, ())  # `Thread.start` keeps the event loop waiting until the thread runs
            self._changed.notify_all()

    def cancel(self) -> None:
        """Drop the waiting job and stop the running one."""
        with self._changed:
            self._waiting = None
            if self._running is not None:
                self._running.given_up.set()
            self._changed.notify_all()

    def join(self, timeout: float | None = None) -> bool:
        """Wait at most `timeout` seconds; return whether all jobs are done. What a delivery raised is raised again.

        A job that waits for quiet is started at once: nothing else will come.
        """
        with self._changed:
            self._joining += 1
            self._changed.notify_all()
            done = self._changed.wait_for(lambda: not self._draining, timeout)
            self._joining -= 1
            failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
        return done

    def _drain(self) -> None:
        while (job := self._next()) is not None:
            try:
                outcome = job.compute(partial(self._given_up, job, monotonic()))
            except Cancelled:
                continue
            except Exception as reason:  # any failure has to reach the user, not end the thread unseen
                if not isinstance(reason, ValueError):
                    logger.exception("A computation failed")
                outcome = reason
            job.computed.set()
            try:
                job.deliver(outcome)
            except Exception as reason:
                logger.exception("A result could not be shown")
                self._failure = reason

    def _given_up(self, job: Job, started: float) -> bool:
        return job.given_up.is_set() or (self._waiting is not None and monotonic() - started > job.patience)

    def _rested(self, job: Job) -> bool:
        """Whether the quiet of a waiting job is over before its time."""
        return self._waiting is not job or self._joining > 0

    def _next(self) -> Job | None:
        with self._changed:
            self._running = None
            while self._waiting is not None:
                candidate = self._waiting
                self._changed.wait_for(partial(self._rested, candidate), candidate.quiet)
                if self._waiting is candidate:
                    self._running, self._waiting = candidate, None
                    return candidate
            self._draining = False
            self._changed.notify_all()
            return None
