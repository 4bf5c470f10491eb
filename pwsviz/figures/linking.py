"""Linking of two figures: a crossing under the pointer in one is marked in the other, in the browser alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bokeh.events import MouseLeave
from bokeh.models import CustomJS

if TYPE_CHECKING:
    from pwsviz.figures.conserved import ConservedView
    from pwsviz.figures.portrait import PortraitView

__all__ = ["link_crossings"]

POINT = """
const put = (source, columns) => {
  const name = Object.keys(columns)[0], before = source.data[name], after = columns[name]
  if (before.length == after.length && after.every((value, k) => value == before[k])) { return }
  source.setv({ data: columns }, { sync: false })  // not needed by the server
}
const point = (x, y, t) => {
  put(portrait, x == null || !Number.isFinite(x) ? { x: [], y: [] } : { x: [x], y: [y] })
  put(conserved, t == null ? { t: [] } : { t: [t] })
}
"""

POINT_FROM_PORTRAIT = """
const [i] = cb_data?.index?.indices ?? []
const { x, y, time, chosen } = marks.data
if (i == null) { point() } else { point(x[i], y[i], chosen[i] ? time[i] : null) }  // the other view is of one start
"""

POINT_FROM_CONSERVED = """
const [i] = cb_data?.index?.indices ?? []
if (i == null) { point() } else {
  const { t, x, y, number, method } = ticks.data
  let place = [x[i], y[i]]
  if (!Number.isFinite(x[i])) {  // place unknown: use the mark of this crossing in the portrait, if any
    const { number: numbers, method: methods, chosen } = marks.data
    const j = numbers.findIndex((other, k) => other == number[i] && methods[k] == method[i] && chosen[k])
    place = j < 0 ? [null, null] : [marks.data.x[j], marks.data.y[j]]
  }
  point(...place, t[i])
}
"""


def link_crossings(portrait: PortraitView, conserved: ConservedView) -> None:
    """Let a crossing under the pointer in one figure be marked in both, without the server."""
    args = {
        "portrait": portrait.pointed, "conserved": conserved.pointed,
        "marks": portrait.crossings, "ticks": conserved.instants,
    }  # fmt: skip
    from_portrait = CustomJS(args=args, code=POINT + POINT_FROM_PORTRAIT)
    from_conserved = CustomJS(args=args, code=POINT + POINT_FROM_CONSERVED)
    for view, callback in ((portrait, from_portrait), (conserved, from_conserved)):
        view.hover.callback = callback
        view.figure.js_on_event(MouseLeave, CustomJS(args=args, code=POINT + "point()"))
