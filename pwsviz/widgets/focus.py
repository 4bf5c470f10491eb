"""Where the focus goes when the button that has it can no longer be pressed."""

from __future__ import annotations

import json
from typing import Any

from pwsviz.widgets.browser import FIND

__all__ = ["hand_on"]

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
