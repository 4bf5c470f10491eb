"""Where the focus goes when the button that has it can no longer be pressed, and what the space bar then means."""

from __future__ import annotations

import json
from typing import Any

from pwsviz.widgets.browser import FIND

__all__ = ["SPACE", "hand_on"]

SPACE = """
const TAKES_SPACE = "input, textarea, select, button, summary, a, [role], [contenteditable]"
const LEAVES_SPACE = "[role=application], [role=tab][aria-selected=true], [role=tablist]"
// Whether the space bar, pressed where it was, means nothing else: figures take other keys, an open tab is open.
const is_free = event => !event.composedPath().filter(node => node instanceof Element).slice(0, 3)
  .some(node => node.matches(TAKES_SPACE) && !node.matches(LEAVES_SPACE))
"""
"""JavaScript that tells a space bar that is free to play from one that presses a button or writes."""

_GIVE = """
FIND
let focused = document.activeElement
while (focused?.shadowRoot?.activeElement) { focused = focused.shadowRoot.activeElement }
const [own, other] = NAMES.map(name => find(document, `button[aria-label="${name}"]`))
let looks = 0
const give = () => {  // the other one may be enabled a moment later
  if (!other.disabled) { other.focus() } else if (looks++ < 60) { requestAnimationFrame(give) }
}
if (cb_obj.disabled && focused == own && other != null) { give() }
""".replace("FIND", FIND)


def hand_on(button: Any, other: Any) -> None:
    """Give the focus to another button when this one has it and is disabled: the browser would drop it.

    Parameters
    ----------
    button, other : IconButton
        Known in the browser by their descriptions.
    """
    button.jscallback(disabled=_GIVE.replace("NAMES", json.dumps([button.description, other.description])))
