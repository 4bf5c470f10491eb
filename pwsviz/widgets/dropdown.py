"""A list to choose one of: the browser's own, which opens and chooses by keyboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import panel as pn

__all__ = ["Dropdown"]

DROPDOWN_CSS = """
:host { --line: color-mix(in srgb, var(--mui-palette-text-primary) 23%, transparent); font: inherit; }
:host .bk-input-group { position: relative; width: 100%; padding: 8px 0 0; }
:host label { position: absolute; top: 0; left: 9px; z-index: 1; padding: 0 5px; max-width: calc(100% - 18px);
        overflow: hidden; text-overflow: ellipsis; white-space: nowrap; font-size: 0.75rem; line-height: 16px;
        color: var(--mui-palette-text-secondary); background: var(--mui-palette-background-default); }
select.bk-input:not([multiple]) {
         height: 40px; width: 100%; padding: 0 32px 0 14px; border: 1px solid var(--line); border-radius: 4px;
         font-family: inherit; font-size: 1rem; text-overflow: ellipsis; cursor: pointer; appearance: none;
         color: var(--mui-palette-text-primary); background-color: transparent; background-image: none !important; }
select.bk-input:hover { border-color: var(--mui-palette-text-primary); }
select.bk-input:focus-visible { border-color: var(--mui-palette-primary-main); outline: none;
         box-shadow: 0 0 0 1px var(--mui-palette-primary-main); }
option, optgroup { color: var(--mui-palette-text-primary); background: var(--mui-palette-background-paper); }
.bk-input-group::after { content: ""; position: absolute; right: 14px; top: 26px; pointer-events: none;
         border: 5px solid transparent; border-top-color: var(--mui-palette-text-secondary); border-bottom-width: 0; }
"""


class Dropdown(pn.widgets.Select):
    """A labelled list of which one entry is chosen."""

    def __init__(self, label: str, **params: Any) -> None:
        look = {"stylesheets": [DROPDOWN_CSS], "sizing_mode": "stretch_width", "margin": (2, 0, 6, 0)}
        super().__init__(label=label, **look, **params)

    def offer(self, options: Mapping[str, Any], value: Any) -> None:
        """Show other options, and which of them is chosen.

        Panel tells the browser of a value only if it changes; here its name may change alone.
        """
        self.param.update(options=dict(options), value=value)
        self.param.trigger("value")
