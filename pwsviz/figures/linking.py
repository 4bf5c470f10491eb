"""Linking of figures: a crossing under the pointer in one is marked in all, in the browser alone."""

from __future__ import annotations

from typing import Protocol

from bokeh.events import MouseLeave
from bokeh.models import ColumnDataSource, CustomJS, HoverTool
from bokeh.models.glyphs import VSpan
from bokeh.plotting import figure

from pwsviz.figures.colours import PURPLE, VERMILION
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
  put(instant, t == null ? { t: [] } : { t: [t] })
}
"""

POINT_FROM_PORTRAIT = """
const [i] = cb_data?.index?.indices ?? []
const { x, y, time, chosen } = marks.data
if (i == null) { point() } else { point(x[i], y[i], chosen[i] ? time[i] : null) }  // the other view is of one start
"""

POINT_FROM_TICKS = """
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


class Linked(Protocol):
    """A figure with crossings that a pointer can be on."""

    figure: figure
    hover: HoverTool


def link_portrait(portrait: PortraitView) -> None:
    """Let a crossing under the pointer in the portrait be marked there and in all figures linked to it."""
    _follow(portrait, POINT_FROM_PORTRAIT, portrait, {"marks": portrait.crossings})


def link_crossings(portrait: PortraitView, view: Linked, ticks: ColumnDataSource) -> None:
    """Let a figure against time follow the player, and a crossing under the pointer in it be marked in all figures.

    Parameters
    ----------
    portrait : PortraitView
        The portrait.
    view : Linked
        The other figure.
    ticks : ColumnDataSource
        The crossings marked there: their times, places in the portrait, numbers and integrators.
    """
    view.figure.add_glyph(portrait.pointed_time, VSpan(x="t", line_color=VERMILION, line_width=2))
    view.figure.add_glyph(portrait.played_time, VSpan(x="t", line_color=PURPLE, line_width=2, line_dash="dashed"))
    _follow(view, POINT_FROM_TICKS, portrait, {"marks": portrait.crossings, "ticks": ticks})


def _follow(view: Linked, code: str, portrait: PortraitView, sources: dict[str, ColumnDataSource]) -> None:
    """Mark what the pointer is on in a figure, and nothing when it leaves; all in the browser."""
    args = {"portrait": portrait.pointed, "instant": portrait.pointed_time, **sources}
    view.hover.callback = CustomJS(args=args, code=POINT + code)
    view.figure.js_on_event(MouseLeave, CustomJS(args=args, code=POINT + "point()"))
