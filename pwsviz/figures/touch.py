"""Touch: one finger scrolls the page over a figure, two fingers move what the figure shows."""

from __future__ import annotations

from bokeh.models import CustomJS
from bokeh.plotting import figure

__all__ = ["attach_touch"]

TOUCH = """
const view = cb_context.index.find_one(plot)
const ground = view?.canvas_view.events_el
if (ground == null || ground.dataset.touch || !window.matchMedia("(pointer: coarse)").matches) { return }
ground.dataset.touch = "on"
// While a tool takes a finger that pans, the browser does not scroll.
for (const tool of plot.toolbar.tools) { if (tool.type == "PanTool") { tool.active = false } }
let before = null  // the place between the two fingers
const between = ([one, other]) => [(one.clientX + other.clientX) / 2, (one.clientY + other.clientY) / 2]
const move = (range, scale, pixels) => {
  const by = scale.invert(0) - scale.invert(pixels)
  range.have_updated_interactively = true  // the data no longer set it
  range.setv({ start: range.start + by, end: range.end + by })
}
ground.addEventListener("touchstart", event => {
  if (event.touches.length == 2) { event.preventDefault() }
  before = event.touches.length == 2 ? between(event.touches) : null
}, { passive: false })
ground.addEventListener("touchmove", event => {
  if (before == null || event.touches.length != 2) { return }
  event.preventDefault()
  const now = between(event.touches), { x_range, y_range, x_scale, y_scale } = view.frame
  move(x_range, x_scale, now[0] - before[0])
  move(y_range, y_scale, now[1] - before[1])
  before = now
}, { passive: false })
"""
"""JavaScript for screens that are touched; elsewhere it does nothing."""


def attach_touch(plot: figure) -> None:
    """Let a finger scroll the page, and two of them move the figure; its axes have to be linear."""
    plot.js_on_change("inner_width", CustomJS(args={"plot": plot}, code=TOUCH))  # when laid out, its element exists
