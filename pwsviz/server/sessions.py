"""Sessions, and how pages and messages are sent for them."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from contextvars import Context
from functools import cache
from typing import Any

import panel as pn
from bokeh.application.application import Application, SessionContext
from bokeh.application.handlers.handler import Handler
from bokeh.document import Document
from bokeh.server.views.ws import WSHandler
from panel.io import document as messages
from tornado.websocket import WebSocketClosedError

__all__ = ["send_every_message", "send_messages_at_once", "send_pages_at_once"]

LOADING = 0.1
"""Seconds from a page to its session, whose making stops the server: until then the browser fetches the scripts."""


@cache
def send_messages_at_once() -> None:
    """Let connections opened from now on send every part of a message at once.

    Bokeh sends a message in several parts. With Nagle's algorithm, which it leaves on, a part waits until the browser
    acknowledges the one before: for a round trip, and often 40 ms more.
    """
    opened = WSHandler.open

    def open_without_delay(handler: WSHandler, *args: Any) -> None:
        opened(handler, *args)
        handler.set_nodelay(True)

    WSHandler.open = open_without_delay  # type: ignore[method-assign]


@cache
def send_every_message() -> None:
    """Let Panel keep no message back that it has put off because the connection was in use.

    A task sends such messages, and opens the way for others when the browser has taken them. If that comes just before
    the next message is put off, its own task finds the way open, takes this to mean that all has been sent, and ends:
    the browser would see the last change only together with the next one.
    """
    dispatch = getattr(messages, "_dispatch_msgs", None)
    if dispatch is None:  # another version of Panel sends messages in another way
        return

    async def dispatch_what_waits(document: Document) -> None:
        if document in messages._WRITE_MSGS:
            messages._WRITE_BLOCK[document] = True
        with suppress(WebSocketClosedError):  # the visitor has left
            await dispatch(document)

    messages._dispatch_msgs = dispatch_what_waits


def send_pages_at_once() -> None:
    """Let the server send a page before its session is made, which it then makes while the browser runs the scripts.

    The first page serves all visitors, as it holds no part of a scene. Panel takes this setting for a single session
    where one is being made, as in the application; so it is set right after, in a context without a session.
    """
    session: Any = pn.state.curdoc.session_context if pn.state.curdoc is not None else None
    if session is None or session.server_context is None:  # no server runs
        return
    asyncio.get_running_loop().call_soon(setattr, pn.config, "reuse_sessions", "warm", context=Context())
    application: Application = session.server_context.application_context.application
    if not any(isinstance(handler, _ScriptsFirst) for handler in application.handlers):
        application.add(_ScriptsFirst())


class _ScriptsFirst(Handler):
    """Part of the application that delays sessions."""

    def modify_document(self, doc: Document) -> None:
        """Add nothing to the page."""

    async def on_session_created(self, session_context: SessionContext) -> None:
        """Let the server send scripts first."""
        await asyncio.sleep(LOADING)
