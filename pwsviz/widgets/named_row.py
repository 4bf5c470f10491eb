"""A row of widgets that has a name."""

from __future__ import annotations

import panel as pn
import param

__all__ = ["NamedRow"]


class NamedRow(pn.FlexBox):
    """A row that wraps, and is a group with a name for screen readers: its buttons may be called as those of others."""

    group = param.String(default="", doc="Name of the group.")

    _template = pn.FlexBox._template.replace(
        '<div id="flexbox"', '<div id="flexbox" role="group" aria-label="${group}"'
    )
