"""Words for screen readers alone: how a computation has ended, and what a figure moved by keys shows."""

from __future__ import annotations

from typing import ClassVar

import panel as pn
import param

__all__ = ["Announcer"]

RESTS = 700
"""Milliseconds without news after which they are told: not at each move of a slider."""

KEPT = 30_000
"""Milliseconds after which news are taken back: who reads the page later would find them beside another scene."""

UNSEEN = """
[role=status] { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%);
                white-space: nowrap; }
"""


class Announcer(pn.custom.JSComponent):
    """Invisible: says politely what was told last of the portrait, and of the view beside it."""

    page = param.List(default=[], doc="Words about the page itself, and how often there were any.")
    portrait = param.List(default=[], doc="The same about the runs of the portrait.")
    view = param.List(default=[], doc="The same about the view beside it.")

    _esm = """
export function render({ model, el }) {
  const region = Object.assign(document.createElement("div"), { role: "status" }), news = new Map()
  el.append(region)
  let timer = null, end = null
  const tell = () => {
    const words = Object.assign(document.createElement("p"), { textContent: [...news.values()].join(" ") })
    region.replaceChildren(words)  // a new element is told, be its words those of the last
    news.clear()
    clearTimeout(end)
    end = setTimeout(() => region.replaceChildren(), KEPT)
  }
  for (const source of ["page", "portrait", "view"]) {
    const take = () => {
      if (model[source].length == 0) return
      news.set(source, model[source][0])
      clearTimeout(timer)
      timer = setTimeout(tell, RESTS)
    }
    model.on(source, take)
    take()
  }
  const look = event => {  // a figure has been moved by keys
    news.set("figure", event.detail)
    clearTimeout(timer)
    timer = setTimeout(tell, RESTS)
  }
  document.addEventListener("seen", look)
  model.on("remove", () => {
    document.removeEventListener("seen", look)
    ;[timer, end].forEach(clearTimeout)
  })
}
""".replace("RESTS", str(RESTS)).replace("KEPT", str(KEPT))
    _stylesheets: ClassVar[list[str]] = [UNSEEN]

    def tell_of_page(self, words: str) -> None:
        """Say something of the page itself."""
        self.page = _next(self.page, words)

    def tell_of_portrait(self, words: str) -> None:
        """Say something of the runs of the portrait."""
        self.portrait = _next(self.portrait, words)

    def tell_of_view(self, words: str) -> None:
        """Say something of the view beside the portrait."""
        self.view = _next(self.view, words)


def _next(told: list[object], words: str) -> list[object]:
    """Return words and their number: the browser is told of a change alone, and the same may be said again."""
    return [words, told[1] + 1 if told and isinstance(told[1], int) else 1]
