"""Sessions and the pages that are sent for them."""

from __future__ import annotations

import asyncio
from contextvars import Context

import panel as pn

__all__ = ["send_pages_at_once"]


def send_pages_at_once() -> None:
    """Let the server send a page before its session is made, which it then makes while the browser loads the scripts.

    The first page serves all visitors, as it holds no part of a scene. Panel takes this setting for a single session
    where one is being made, as in the application; so it is set right after, in a context without a session.
    """
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:  # no server runs
        return
    loop.call_soon(setattr, pn.config, "reuse_sessions", True, context=Context())
