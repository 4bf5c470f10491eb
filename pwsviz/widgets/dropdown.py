"""A list to choose one of: the browser's own, which opens and chooses by keyboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import panel as pn

from pwsviz.widgets.fields import FOCUS, FRAME, LABEL

__all__ = ["CHOOSER", "Dropdown"]

CHOOSER = "chooser"
"""CSS class of a list whose entries each have another picture."""

DROPDOWN_CSS = f"""
:host .bk-input-group {{ position: relative; width: 100%; padding: 8px 0 0; }}
:host .bk-input-group > label {{ {LABEL} transform: none; }}
select.bk-input:not([multiple]) {{
    height: 2.5rem; width: 100%; padding: 0 32px 0 14px; border: 1px solid {FRAME}; border-radius: 4px;
    font-family: inherit; font-size: 1rem; text-overflow: ellipsis; cursor: pointer; appearance: none;
    color: var(--mui-palette-text-primary); background-color: transparent; background-image: none !important; }}
select.bk-input:hover {{ border-color: var(--mui-palette-text-primary); }}
select.bk-input:not([multiple]):focus-visible {{ {FOCUS} }}
select.bk-input:disabled {{ color: var(--mui-palette-text-disabled); border-style: dashed; cursor: default; }}
option, optgroup {{ color: var(--mui-palette-text-primary); background: var(--mui-palette-background-paper); }}
.bk-input-group::after {{ content: ""; position: absolute; right: 14px; top: calc(6px + 1.25rem); pointer-events: none;
    border: 5px solid transparent; border-top-color: var(--mui-palette-text-secondary); border-bottom-width: 0; }}
.bk-input-group[data-about]:has(select:focus-visible)::before {{
    content: attr(data-about); position: absolute; inset: calc(100% + 4px) 0 auto; z-index: 1; padding: 4px 8px;
    white-space: normal; border-radius: 4px; font-size: 0.8rem; color: var(--mui-palette-background-paper);
    background: var(--mui-palette-text-primary); }}
@media (forced-colors: active) {{
  .bk-input-group::after {{ forced-color-adjust: none; border-top-color: CanvasText; }}
}}
"""


class Dropdown(pn.widgets.Select):
    """A labelled list of which one entry is chosen."""

    def __init__(self, label: str, **params: Any) -> None:
        look = {"stylesheets": [DROPDOWN_CSS], "sizing_mode": "stretch_width", "margin": (2, 0, 6, 0)}
        super().__init__(label=label, **look, **params)

    def offer(self, options: Mapping[str, Any], value: Any) -> None:
        """Show other options, and which of them is chosen.

        Panel tells the browser of a value only if it changes; here its name may change alone. Where neither changes,
        the browser is told nothing: a visitor may just have chosen another entry.
        """
        renamed = list(options.items()) != list(dict(self.options).items())
        self.param.update(options=dict(options), value=value)
        if renamed:
            self.param.trigger("value")
