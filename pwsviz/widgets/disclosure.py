"""What tells screen readers whether the part of the page that a button shows and hides is shown."""

from __future__ import annotations

from typing import Any

import panel as pn
import param

__all__ = ["Disclosure"]


class Disclosure(pn.custom.JSComponent):
    """Invisible, beside a button: keeps its `aria-expanded`, which the buttons of panel-material-ui do not take.

    Parameters
    ----------
    button : Button or IconButton
        It is known in the browser by its description, or else by its label, in the same part of the page.
    box : viewable
        What the button shows and hides.
    """

    name_of_button = param.String()
    expanded = param.Boolean(default=False)

    _esm = """
export function render({ model, el }) {
  let looks = 0
  const named = part => [part.ariaLabel, part.innerText].some(words => words?.endsWith(model.name_of_button))
  const button = () => {  // in the smallest part of the page that has it
    for (let root = el.getRootNode(); root != null; root = root.host?.getRootNode()) {
      const found = all(root).find(named)
      if (found != null) return found
    }
  }
  const all = node => [...node.querySelectorAll("*")].flatMap(part =>
    [...(part.nodeName == "BUTTON" ? [part] : []), ...(part.shadowRoot ? all(part.shadowRoot) : [])])
  const say = () => {
    const found = el.isConnected ? button() : null
    if (found != null) found.setAttribute("aria-expanded", model.expanded)
    else if (looks++ < 100) setTimeout(say, 100)
  }
  model.on("expanded", say)
  say()
}
"""

    def __init__(self, button: Any, box: Any) -> None:
        name = getattr(button, "description", None) or button.label
        super().__init__(
            name_of_button=name, expanded=bool(box.visible), sizing_mode="fixed", width=0, height=0, margin=0
        )
        box.param.watch(lambda event: self.param.update(expanded=bool(event.new)), "visible")
