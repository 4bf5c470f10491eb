"""Calls from threads into the event loop of a page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn

__all__ = ["Delivery"]


class Delivery:
    """Runs callbacks in the event loop of the page being served when it is made; at once if there is none.

    It avoids two losses. While the page is being made, its document is on hold and drops callbacks that a thread adds;
    so they are added from the event loop, which is free only afterwards. While the browser builds the page, Panel drops
    changes of it; so they wait until the browser reports that the page is complete.
    """

    def __init__(self) -> None:
        document = pn.state.curdoc
        self.document = document if document is not None and document.session_context is not None else None
        self._early: list[Callable[[], None]] = []
        if self.document is not None:
            self._loop = asyncio.get_running_loop()
            pn.state.onload(self._catch_up)

    def __call__(self, show: Callable[..., None], *outcome: Any) -> None:
        """Call `show` in the event loop soon; may be called from any thread.

        Parameters
        ----------
        show : callable
            The callback.
        *outcome
            Its arguments.
        """
        if self.document is None:
            show(*outcome)
        elif not self._loop.is_closed():
            tick = partial(self._apply, partial(show, *outcome))
            self._loop.call_soon_threadsafe(self.document.add_next_tick_callback, tick)

    def _apply(self, show: Callable[[], None]) -> None:
        """Call back, and send all its changes in one message, so that the browser paints each figure once."""
        if self._being_built():
            self._early.append(show)
            return
        with pn.io.hold(self.document):
            show()

    def _being_built(self) -> bool:
        """Whether a browser is connected and has not yet reported that the page is complete."""
        session = getattr(self.document and self.document.session_context, "session", None)
        return session is not None and session.connection_count > 0 and not pn.state.loaded

    def _catch_up(self) -> None:
        early, self._early = self._early, []
        for show in early:
            self(show)
