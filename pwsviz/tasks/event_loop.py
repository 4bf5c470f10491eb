"""From threads to the event loop of a page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn

__all__ = ["Delivery"]


class Delivery:
    """Brings outcomes to the page that it is made for; where none is served, at once.

    Two things would be lost otherwise. While the page is being made its document is on hold, and forgets callbacks that
    a thread adds: so they are added in the event loop, which is free again when all is made. And while a browser builds
    what it was sent, Panel drops what changes meanwhile: so that waits until the browser says that the page is there.
    """

    def __init__(self) -> None:
        document = pn.state.curdoc
        self.document = document if document is not None and document.session_context is not None else None
        self._early: list[Callable[[], None]] = []
        if self.document is not None:
            self._loop = asyncio.get_running_loop()
            pn.state.onload(self._catch_up)

    def __call__(self, show: Callable[..., None], *outcome: Any) -> None:
        """Have an outcome shown soon; from any thread.

        Parameters
        ----------
        show : callable
            Called with the outcome, in the event loop.
        *outcome
            What to show.
        """
        if self.document is None:
            show(*outcome)
        elif not self._loop.is_closed():
            tick = partial(self._apply, partial(show, *outcome))
            self._loop.call_soon_threadsafe(self.document.add_next_tick_callback, tick)

    def _apply(self, show: Callable[[], None]) -> None:
        """Send all changes in one message: the browser then paints each figure once."""
        if self._being_built():
            self._early.append(show)
            return
        with pn.io.hold(self.document):
            show()

    def _being_built(self) -> bool:
        """Whether a browser has fetched this page, or is about to, and has not said yet that all of it is there."""
        session = getattr(self.document and self.document.session_context, "session", None)
        return session is not None and session.connection_count > 0 and not pn.state.loaded

    def _catch_up(self) -> None:
        early, self._early = self._early, []
        for show in early:
            self(show)
