"""Keys on a figure: the focus comes to it by Tab, and the arrows move what it shows."""

from __future__ import annotations

from typing import Any

from bokeh.models import CustomJS
from bokeh.plotting import figure

from pwsviz.text.numbers import PRINTED

__all__ = ["FOCUS_CSS", "REACHED", "attach_keys"]

REACHED: dict[str, Any] = {
    "role": "application",  # of an image screen readers keep the arrow keys to themselves
    "aria-roledescription": "figure",
    "aria-keyshortcuts": "ArrowLeft ArrowRight ArrowUp ArrowDown + - 0",
}
"""HTML attributes of a figure that takes these keys.

The one by which the Tab key reaches it is set in the browser: of these Bokeh takes all off whenever one changes, and
without it the figure would lose the focus."""

FOCUS_CSS = """
:host(:focus-visible) { outline: none; }
:host(:focus-visible)::after { content: ""; position: absolute; inset: 0; z-index: 100; pointer-events: none;
                               border: 2px solid var(--mui-palette-primary-main, #1976d2); }
"""

KEYS = (
    PRINTED
    + """
const view = cb_context.index.find_one(cb_obj)
const { el, frame, canvas_view } = view ?? {}
if (el == null || el.dataset.keys) { return }
el.dataset.keys = "on"
el.tabIndex = 0
canvas_view.events_el.tabIndex = -1  // the figure itself is the one stop; after a click this has the focus, too
const STEP = 0.1, ZOOM = 1.25        // of what is seen
const MOVES = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowDown: [0, -STEP], ArrowUp: [0, STEP] }
const ZOOMS = { "+": 1 / ZOOM, "=": 1 / ZOOM, "-": ZOOM, "\\u2212": ZOOM }
const FITS = ["0", "f", "F"], SETTLED = 400, LATE = 10000  // milliseconds
// The ends of a range, moved and zoomed on the screen: where its scale is logarithmic, too.
const changed = (scale, by, factor) => {
  const range = scale.source_range, [low, high] = [range.start, range.end].map(end => scale.compute(end))
  const middle = (low + high) / 2 + by * (high - low), half = factor * (high - low) / 2
  return new Map([[range, { start: scale.invert(middle - half), end: scale.invert(middle + half) }]])
}
// What is seen now, for screen readers: once the ranges rest, of which the server may have a say, be it late.
let timer = 0, until = 0
const tell = () => { clearTimeout(timer); timer = setTimeout(say, SETTLED) }
const say = () => {
  const { below, left } = view.model, axes = [[below, frame.x_scale, "across"], [left, frame.y_scale, "up"]]
  const seen = axes.map(([[axis], { source_range }, way]) => {
    const name = typeof axis?.axis_label == "string" && !axis.axis_label.includes("$") ? axis.axis_label : way
    const [low, high] = [source_range.start, source_range.end].map(end => printed(String(Number(end.toPrecision(3)))))
    return `${name} from ${low} to ${high}`
  })
  document.dispatchEvent(new CustomEvent("seen", { detail: `In sight: ${seen.join(", ")}.` }))
}
for (const range of [view.model.x_range, view.model.y_range]) {
  range.change.connect(() => { if (performance.now() < until) { tell() } })
}
el.addEventListener("keydown", event => {
  if (event.ctrlKey || event.altKey || event.metaKey) { return }
  const { key } = event
  if (event.shiftKey && key in MOVES) { return }  // in the portrait these move a start
  if (FITS.includes(key)) {
    view.reset()
  } else if (key in MOVES || key in ZOOMS) {
    const [across, up] = MOVES[key] ?? [0, 0], factor = ZOOMS[key] ?? 1
    const xrs = changed(frame.x_scale, across, factor), yrs = changed(frame.y_scale, up, factor)
    view.update_range({ xrs, yrs }, { panning: key in MOVES, scrolling: key in ZOOMS })
    view.trigger_ranges_update_event()
  } else { return }
  event.preventDefault()
  until = performance.now() + LATE
  tell()
})
"""
)
"""JavaScript run when a figure is laid out, and its elements exist."""


def attach_keys(plot: figure) -> None:
    """Let the arrow keys move what a figure shows, + and − zoom, and 0 or F fit it again."""
    plot.js_on_change("inner_width", CustomJS(code=KEYS))
