"""Calls from threads into the event loop of a page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from threading import get_ident
from time import monotonic
from typing import Any

import panel as pn

from pwsviz.tasks.cancellation import never

__all__ = ["Delivery"]

LOOK_AGAIN = 0.005
"""Seconds after which it is asked again whether callbacks will come."""

TOGETHER = 0.1
"""Seconds at most that an outcome waits for others, to be shown with them: one message costs less than two."""


class Delivery:
    """Runs callbacks in the event loop of the page being served when it is made; at once if there is none.

    It avoids two losses. While the page is being made, its document is on hold and drops callbacks that a thread adds;
    so they are added from the event loop, which is free only afterwards, unless `run` takes them before. While the
    browser builds the page, Panel drops changes of it; so they wait until it reports that the page is complete.
    """

    def __init__(self) -> None:
        document = pn.state.curdoc
        self.document = document if document is not None and document.session_context is not None else None
        self._early: list[Callable[[], None]] = []
        self._waiting: SimpleQueue[Callable[[], None]] = SimpleQueue()
        if self.document is not None:
            self._loop, self._thread = asyncio.get_running_loop(), get_ident()
            pn.state.onload(self._catch_up)

    def __call__(self, show: Callable[..., None], *outcome: Any, lacking: Callable[[], bool] = never) -> None:
        """Call `show` in the event loop soon; may be called from any thread.

        Parameters
        ----------
        show : callable
            The callback.
        *outcome
            Its arguments.
        lacking : callable, optional
            Asked in the event loop: returns whether to wait up to `TOGETHER` seconds for another call, to show both
            together.
        """
        if self.document is None:
            show(*outcome)
        elif not self._loop.is_closed():
            self._waiting.put(partial(show, *outcome))
            here = get_ident() == self._thread
            (self._loop.call_soon if here else self._loop.call_soon_threadsafe)(self._add_unless, lacking)

    def later(self, seconds: float, show: Callable[[], None], wanted: Callable[[], bool]) -> None:
        """Call `show` in the event loop after so many seconds, if it is `wanted` then; not at all without a page.

        To be called in the event loop, as `wanted` is, which may look at anything but change nothing.
        """
        if self.document is not None:
            self._loop.call_later(seconds, lambda: self(show) if wanted() else None)

    def run(self, busy: Callable[[], bool], timeout: float) -> None:
        """Call back here and now; while the page is being made, so that it contains the changes.

        Parameters
        ----------
        busy : callable
            Returns whether further callbacks will come.
        timeout : float
            Seconds after which those still to come are left to the event loop.
        """
        deadline = monotonic() + timeout
        while (busy() or not self._waiting.empty()) and monotonic() < deadline:
            with suppress(Empty):
                self._waiting.get(timeout=LOOK_AGAIN)()

    def _add_unless(self, lacking: Callable[[], bool]) -> None:
        if lacking():
            self._loop.call_later(TOGETHER, self._add_next)  # what is lacking adds all when it comes before
        else:
            self._add_next()

    def _add_next(self) -> None:
        if self._session_has_ended() or self._waiting.empty():  # empty: `run` has called it, or an earlier tick will
            return
        self.document.add_next_tick_callback(self._apply)  # type: ignore[union-attr]

    def _apply(self) -> None:
        """Call back all that waits, and send the changes in one message: the browser paints each figure once."""
        with pn.io.hold(self.document):
            for _ in range(self._waiting.qsize()):  # what these add comes in its own time
                show = self._waiting.get()
                if self._being_built():
                    self._early.append(show)
                else:
                    show()

    def _session_has_ended(self) -> bool:
        """Whether Bokeh has destroyed the document, which then refuses callbacks."""
        return self.document is not None and self.document.session_context is None

    def _being_built(self) -> bool:
        """Whether a browser is connected and has not yet reported that the page is complete."""
        session = getattr(self.document and self.document.session_context, "session", None)
        return session is not None and session.connection_count > 0 and not pn.state.loaded

    def _catch_up(self) -> None:
        early, self._early = self._early, []
        for show in early:
            self(show)
