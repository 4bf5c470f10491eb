"""Gestures on the stars: they are dragged, selected and removed in the browser, which reports that to the server."""

from __future__ import annotations

from bokeh.events import MouseEnter
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.plotting import figure

from pwsviz.text.numbers import PRINTED

__all__ = ["GESTURES", "MOVING_KEYS", "attach_gestures"]

MOVING_KEYS = "Shift+ArrowLeft Shift+ArrowRight Shift+ArrowUp Shift+ArrowDown"
"""The keys that move the selected start, for screen readers."""

GESTURES = (
    PRINTED
    + """
const view = cb_context.index.find_one(plot)
const ground = view?.canvas_view.events_el
if (ground == null || ground.dataset.gestures) { return }
ground.dataset.gestures = "on"
// Bokeh takes a button held for 0.3 s before it moves for a gesture of its own, and then neither pans nor clicks. No
// figure of the page has a use for that gesture, and a busy machine is as late.
view.canvas_view.ui_event_bus.ui_gestures.constructor.press_threshold = 2 ** 31 - 1

const FINGER = 22, MOUSE = 11, STILL = 4   // pixels
const DOUBLE = 400, PAUSE = 50             // milliseconds
let held = null      // the star being dragged or clicked
let dropped = null   // the star dropped last, until the server has confirmed it
let last_tap = null  // last tap of a finger on a star
let pressed = null   // the last press beside all stars: its place and time
let fitting = null   // the pointer whose second press it is, of a double click there
let pointed = false  // whether the pointer is over the figure

const reach = event => event.pointerType == "mouse" ? MOUSE : FINGER
const place = event => {
  const box = ground.getBoundingClientRect()
  return [event.clientX - box.left, event.clientY - box.top]
}
const near = (event, other, reach) => {
  const [sx, sy] = place(event)
  return Math.hypot(sx - other.sx, sy - other.sy) < reach
}
const screen = index =>
  [view.frame.x_scale.compute(starts.data.x[index]), view.frame.y_scale.compute(starts.data.y[index])]
const star_at = event => {
  const [sx, sy] = place(event)
  if (!view.frame.bbox.contains(sx, sy)) { return null }
  let found = null, least = reach(event)
  for (let index = 0; index < starts.data.x.length; index++) {
    const [x, y] = screen(index)
    const gap = Math.hypot(x - sx, y - sy) - (starts.data.chosen[index] ? 0.5 : 0)
    if (gap <= least) { least = gap; found = index }
  }
  return found
}
const say = (act, index, x, y) => {
  hand.data = { act: [act], index: [index], x: [x], y: [y], count: [hand.data.count[0] + 1] }
}
const put = star => {  // changed in place, so not sent; the server knows it from `say`
  if (star.index >= starts.data.x.length) { return }
  starts.data.x[star.index] = star.x
  starts.data.y[star.index] = star.y
  starts.change.emit()
}
const tell = act => {
  clearTimeout(held.timer)
  held.timer = null
  held.told = performance.now()
  say(act, held.index, held.x, held.y)
}
const stop = event => {
  event.stopImmediatePropagation()
  event.preventDefault()
}
const drop = () => {
  delete document.documentElement.dataset.dragging
  if (held.moved) {
    tell("drop")
    dropped = { ...held, count: hand.data.count[0] }
  }
  held = null
}

ground.addEventListener("pointerdown", event => {
  if (held != null) { return stop(event) }
  if (event.button != 0) { return }
  // The first click of two has placed a star, which the second finds there or not, depending on the server.
  if (pressed?.clicked && event.timeStamp - pressed.time < DOUBLE && near(event, pressed, reach(event))) {
    fitting = event.pointerId
    return stop(event)
  }
  const index = star_at(event), [sx, sy] = place(event)
  const beside = index == null && event.isPrimary && view.frame.bbox.contains(sx, sy)
  pressed = beside ? { sx, sy, time: event.timeStamp } : null
  if (index == null) { return }
  stop(event)
  ground.focus({ preventScroll: true })
  ground.setPointerCapture(event.pointerId)
  const [x, y] = screen(index)
  held = { index, pointer: event.pointerId, sx, sy, dx: x - sx, dy: y - sy, x: starts.data.x[index],
           y: starts.data.y[index], moved: false, told: -Infinity, timer: null }
}, { capture: true })

ground.addEventListener("pointermove", event => {
  if (held == null) { return }
  stop(event)
  if (event.pointerId != held.pointer) { return }
  const [sx, sy] = place(event), frame = view.frame.bbox
  if (!held.moved && Math.hypot(sx - held.sx, sy - held.sy) < STILL) { return }
  held.moved = true
  document.documentElement.dataset.dragging = ""
  ground.style.cursor = "grabbing"
  held.x = view.frame.x_scale.invert(Math.min(Math.max(sx + held.dx, frame.left), frame.right))
  held.y = view.frame.y_scale.invert(Math.min(Math.max(sy + held.dy, frame.top), frame.bottom))
  put(held)
  const wait = held.told + PAUSE - performance.now()
  if (wait <= 0) { tell("drag") } else { held.timer ??= setTimeout(() => tell("drag"), wait) }
}, { capture: true })

ground.addEventListener("pointerup", event => {
  if (pressed != null) { pressed = { ...pressed, time: event.timeStamp, clicked: near(event, pressed, STILL) } }
  if (event.pointerId == fitting) {
    fitting = null
    stop(event)
    return say("fit", 0, 0, 0)
  }
  if (held == null) { return }
  stop(event)
  if (event.pointerId != held.pointer) { return }
  const { index, moved } = held
  drop()
  if (moved) { return }
  const again = last_tap?.index == index && event.timeStamp - last_tap.time < DOUBLE
  last_tap = event.pointerType == "mouse" || again ? null : { index, time: event.timeStamp }
  say(again ? "remove" : "select", index, 0, 0)
}, { capture: true })

ground.addEventListener("pointercancel", event => {
  pressed = fitting = null
  if (held?.pointer == event.pointerId) { drop() }
}, { capture: true })

// Added after Bokeh's own listener, which sets the cursor, too.
ground.addEventListener("pointermove", event => { if (star_at(event) != null) { ground.style.cursor = "grab" } })
ground.addEventListener("pointerenter", () => { pointed = true })
ground.addEventListener("pointerleave", () => { pointed = false })

ground.addEventListener("touchstart", event => { if (held != null) { event.preventDefault() } }, { passive: false })

starts.connect(starts.properties.data.change, () => {  // the server's answer may be older than the drag
  if (held?.moved) {
    put(held)
  } else if (dropped != null && starts.data.heard[0] < dropped.count) {
    put(dropped)
  } else {
    dropped = null
  }
})

const NO_TEXT = ["range", "checkbox", "radio", "button", "submit"]
const typing = node => node.isContentEditable || ["TEXTAREA", "SELECT"].includes(node.tagName)
  || node.tagName == "INPUT" && !NO_TEXT.includes(node.type)
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }
const STEP = 0.02, FINE = 0.1  // of the shorter side of the frame, and of that
const RESTS = 400              // milliseconds without a key after which a start has been moved
let moving = null              // the star that keys are moving
let resting = 0
const arrive = () => {
  const { index } = moving
  tell_moved("drop")
  moving = null
  const { below, left } = view.model
  const at = [[below[0].axis_label, starts.data.x[index]], [left[0].axis_label, starts.data.y[index]]]
    .map(([name, value]) => `${name} = ${printed(String(Number(value.toPrecision(4))))}`)
  const detail = `Start ${index + 1} moved to ${at.join(", ")}.`
  document.dispatchEvent(new CustomEvent("seen", { detail }))
}
const tell_moved = act => {
  say(act, moving.index, moving.x, moving.y)
  dropped = { ...moving, count: hand.data.count[0] }
}
const move = (key, fine) => {
  const index = starts.data.chosen.indexOf(true), { bbox, x_scale, y_scale } = view.frame
  if (index < 0) { return }
  const by = Math.min(bbox.width, bbox.height) * STEP * (fine ? FINE : 1)
  const [dx, dy] = MOVES[key], [sx, sy] = screen(index)
  const within = (value, low, high) => Math.min(Math.max(value, low), high)
  const x = dx == 0 ? starts.data.x[index] : x_scale.invert(within(sx + dx * by, bbox.left, bbox.right))
  const y = dy == 0 ? starts.data.y[index] : y_scale.invert(within(sy + dy * by, bbox.top, bbox.bottom))
  moving = { index, x, y }
  put(moving)
  tell_moved("drag")
  clearTimeout(resting)
  resting = setTimeout(arrive, RESTS)
}
const keydown = event => {
  if (!ground.isConnected) { return document.removeEventListener("keydown", keydown) }  // the figure has been rebuilt
  if (event.shiftKey && event.key in MOVES && !event.altKey && held == null) {
    const path = event.composedPath()
    if (path.some(typing) || !path.includes(view.el)) { return }
    event.preventDefault()
    return move(event.key, event.ctrlKey || event.metaKey)
  }
  if (event.key != "Delete" && event.key != "Backspace" || event.repeat || held != null) { return }
  const path = event.composedPath()
  if (path.some(typing) || !(pointed || path[0] == ground)) { return }
  event.preventDefault()
  say("remove", starts.data.chosen.indexOf(true), 0, 0)
}
document.addEventListener("keydown", keydown)
"""
)
"""JavaScript that handles the keys of the stars, and gestures that begin on one before the tools of the figure, which
handle all others."""


def attach_gestures(plot: figure, starts: ColumnDataSource) -> ColumnDataSource:
    """Let the user drag, select and remove the stars of a figure.

    Parameters
    ----------
    plot : figure
        The figure.
    starts : ColumnDataSource
        A row for each star, with columns x, y, chosen (true of one star), and heard: the last `count` that the server
        had received when it sent the row.

    Returns
    -------
    ColumnDataSource
        One row, replaced at each gesture: act ("drag", "drop", "select", "remove", or "fit" after a double click
        beside the stars), index of the star, its place x, y after a drag or drop, and count of the gestures so far.
    """
    hand = ColumnDataSource({"act": [""], "index": [0], "x": [0.0], "y": [0.0], "count": [0]})
    attach = CustomJS(args={"plot": plot, "starts": starts, "hand": hand}, code=GESTURES)
    plot.js_on_change("inner_width", attach)  # when the figure is laid out, its element exists
    plot.js_on_event(MouseEnter, attach)  # and again if it was given a new element of the same size
    return hand
