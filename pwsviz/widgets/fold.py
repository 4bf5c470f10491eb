"""A paragraph that is read on demand: folded under a line that names it."""

from __future__ import annotations

from typing import ClassVar

import panel as pn
import param

from pwsviz.widgets.panes import TEXT_CSS

__all__ = ["Fold"]

FOLD_CSS = """
details { display: var(--usual, block); margin: 2px 0 6px 0; color: var(--mui-palette-text-secondary); }
details[hidden] { display: none; }
summary { cursor: pointer; width: max-content; padding: 3px 0; }
summary:hover { text-decoration: underline; }
"""
"""A lecture, which says what is needed only, does without it."""


class Fold(pn.custom.JSComponent):
    """A line that unfolds the words below it, and stays as the reader has left it when other words come.

    Parameters
    ----------
    title : str
        What the line says.
    markup : str
        The words, as trusted markup; empty if there are none, and nothing is seen.
    """

    title = param.String()
    markup = param.String()

    _esm = """
export function render({ model, el }) {
  const box = document.createElement("details"), title = document.createElement("summary")
  const words = document.createElement("div")
  title.textContent = model.title
  box.append(title, words)
  el.append(box)
  const show = () => { [box.hidden, words.innerHTML] = [model.markup == "", model.markup] }
  model.on("markup", show)
  show()
}
"""
    _stylesheets: ClassVar[list[str]] = [TEXT_CSS, FOLD_CSS]
