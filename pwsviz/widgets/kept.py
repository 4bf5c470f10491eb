"""Settings of a widget that are as the server wants them, whatever a busy browser makes of two changes at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["kept"]


def kept(widget: Any, **wanted: Callable[[], Any]) -> Callable[..., None]:
    """Return a function that sets settings of a widget, to be called where what they depend on has changed.

    The settings are also set again whenever the browser reports others: of two changes that it handles together, at
    most some 10 ms apart, the widgets of panel-material-ui restore the first, and report that as the user's.

    Parameters
    ----------
    widget : Widget
        The widget; what else watches these settings, as the user may change them, is to watch them before.
    **wanted : callable
        For each setting, returns what it shall be.
    """

    def settle(*_: Any) -> None:
        changes = {name: value for name, of in wanted.items() if getattr(widget, name) != (value := of())}
        if changes:
            widget.param.update(**changes)

    settle()
    widget.param.watch(settle, list(wanted))
    return settle
