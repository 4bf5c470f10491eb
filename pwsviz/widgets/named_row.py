"""A row of widgets that has a name."""

from __future__ import annotations

from typing import ClassVar

import panel as pn
import param

__all__ = ["NamedRow"]

_NAME_BUTTONS = """
// The buttons are made some time after the row, and keep their elements from then on.
const deep = node => [...node.querySelectorAll("*")].flatMap(
  part => part.shadowRoot ? [part, ...deep(part.shadowRoot)] : [part])
const name_buttons = looks => {
  for (const button of deep(flexbox).filter(part => part.matches("button:not([aria-label])"))) {
    const words = button.innerText.trim().split("\\n").at(-1)  // after the name of its icon
    if (/^[A-Z]{3}\\b/.test(words)) { button.ariaLabel = `Save ${words} of ${data.group}` }
  }
  if (looks < 100) { setTimeout(name_buttons, 100, looks + 1) }
}
name_buttons(0)
"""
"""JavaScript that lets the name of a button say what it saves: its own words, and those of the row."""


class NamedRow(pn.FlexBox):
    """A row that wraps, and is a group with a name for screen readers: its buttons may be called as those of others."""

    group = param.String(default="", doc="Name of the group.")

    _template = pn.FlexBox._template.replace(
        '<div id="flexbox"', '<div id="flexbox" role="group" aria-label="${group}"'
    )
    _scripts: ClassVar[dict[str, str]] = {"render": _NAME_BUTTONS}
