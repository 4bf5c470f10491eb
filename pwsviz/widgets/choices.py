"""A group of check boxes."""

from __future__ import annotations

from typing import ClassVar

import panel as pn
import param

from pwsviz.widgets.widths import NARROW

__all__ = ["SEEN_NAME", "Choices"]

CHOICES_CSS = """
fieldset { position: relative; display: flex; flex-wrap: wrap; gap: 2px 12px; margin: 0; padding: 2px; border: none;
           font-size: 0.875rem; color: var(--mui-palette-text-primary); }
fieldset:has([role=group]) { padding: 0; gap: 4px 12px; }
[role=group] > b { display: block; font-weight: normal; font-size: 0.8rem; color: var(--mui-palette-text-secondary); }
[role=group] > span { margin-right: 7px; }
[role=group] input { margin-right: 4px; }
legend { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
label { display: inline-flex; align-items: center; min-width: 24px; min-height: 26px; cursor: pointer; }
input { margin: 0 6px 0 0; flex: none; cursor: pointer; accent-color: var(--mui-palette-primary-main); }
@media (pointer: coarse) or (width < NARROWpx) {
    input { min-width: 24px; min-height: 24px; } label { min-height: 32px; }
}
label:has(input:disabled), input:disabled { opacity: 0.6; cursor: default; }
input:focus-visible { outline: 2px solid var(--mui-palette-primary-main); outline-offset: 2px; }
span[title]:not([title=""]):has(input:focus-visible)::after {
    content: attr(title); position: absolute; inset: calc(100% + 4px) 0 auto; z-index: 1; padding: 4px 8px;
    white-space: normal; border-radius: 4px; font-size: 0.8rem; color: var(--mui-palette-background-paper);
    background: var(--mui-palette-text-primary); }
""".replace("NARROW", str(NARROW))


SEEN_NAME = """
legend { position: static; float: left; width: auto; height: auto; clip-path: none; margin: 0 4px 0 0;
         line-height: 26px; color: var(--mui-palette-text-secondary); }
"""
"""Style sheet of a group whose name is seen, before the boxes."""


class Choices(pn.custom.JSComponent):
    """Check boxes, each with a tip at the pointer or the keyboard; screen readers are told the name of the group."""

    label = param.String(default="", doc="Name of the group.")
    options = param.List(default=[], item_type=str, doc="Names of the boxes.")
    about = param.Dict(default={}, doc="What each option is.")
    barred = param.Dict(default={}, doc="Why options have no effect that cannot be chosen now; their value stays.")
    groups = param.Dict(default={}, doc="The name of the group of each option; none for a list without groups.")
    value = param.List(default=[], doc="The boxes that are checked, in the order of the options.")
    disabled = param.Boolean(default=False, doc="Whether nothing can be chosen.")

    _bundle = "choices.js"  # fetched once by the browser
    _stylesheets: ClassVar[list[str]] = [CHOICES_CSS]
