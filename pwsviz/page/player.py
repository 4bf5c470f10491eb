"""The player: moves a marker along each trajectory in time, in the browser alone."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, ClassVar

import panel as pn
import panel_material_ui as pmui
import param

from pwsviz.figures.lines import Line, line_of, together
from pwsviz.figures.orbit_lines import OF_OTHERS
from pwsviz.figures.portrait import OTHERS_ALPHA, PortraitView
from pwsviz.page.look import FOR_TOUCH
from pwsviz.results.animation import MET, Frames
from pwsviz.text.numbers import PRINTED
from pwsviz.text.words import listed
from pwsviz.widgets.focus import SPACE

SPEEDS = {"¼×": 0.25, "½×": 0.5, "1×": 1.0, "2×": 2.0, "4×": 4.0}
"""Offered speeds, by label."""

WHOLE = 12.0
"""Seconds that the whole run takes to play at speed 1."""

TRAIL = 0.6
"""Seconds of playing at speed 1 that the trail behind a marker lasts."""

LARGEST, LARGE = (18, 8), (10, 4)
"""Diameter in pixels of the first integrator's marker, of the selected start and of others, and by how much that of the
next one is smaller: where they agree, each is seen around the next."""

SMALLEST = 5
"""Diameter in pixels of the smallest marker."""

FAINT = 0.3
"""Opacity of the curves under the trails, relative to what it is otherwise."""

_ESM = (
    PRINTED
    + SPACE
    + f"const MET = {json.dumps(MET)}  // what is counted, one of it and several\n"
    + """
export function render({ model, data, el }) {
  el.innerHTML = `
    <div class="player" role="group" aria-label="Animation">
      <button type="button" class="play"></button>
      <input type="range" class="scrub" min="0" step="any" aria-label="Time">
      <output class="now" aria-live="off"></output>
      <label>Speed <select class="speed"></select></label>
      <span class="note"></span>
    </div>`
  const part = name => el.querySelector("." + name)
  const [player, play, scrub, now, speed, note] = ["player", "play", "scrub", "now", "speed", "note"].map(part)
  for (const [name, factor] of Object.entries(model.speeds)) { speed.add(new Option(name, factor)) }
  speed.value = "1"

  const calm = window.matchMedia("(prefers-reduced-motion: reduce)")
  const CALM = 0.5  // seconds between pictures where the user prefers reduced motion
  let time = 0, end = 0, ways = [], playing = false, before = null, request = null, begun = 0

  // Index of the last step not after t, or -1.
  const last = (t, steps) => {
    let low = 0, high = steps.length
    while (low < high) {
      const middle = (low + high) >> 1
      if (steps[middle] <= t) { low = middle + 1 } else { high = middle }
    }
    return low - 1
  }
  const show = () => {
    const there = ways.filter(way => way.t.length > 0)
    const drawn = [...there.filter(way => !way.chosen), ...there.filter(way => way.chosen)]  // the selected on top
    const at = drawn.map(way => Math.max(0, last(time, way.t)))
    const since = drawn.map(way => Math.max(0, last(time - end * model.trail / model.whole, way.t)))
    const tail = name => drawn.map((way, k) => way.traced ? Array.from(way[name].slice(since[k], at[k] + 1)) : [])
    const each = (...names) => Object.fromEntries(names.map(name => [name, drawn.map(way => way[name])]))
    const shown = {
      t: there.length > 0 ? time : null,
      x: drawn.map((way, k) => way.x[at[k]]), y: drawn.map((way, k) => way.y[at[k]]),
      ...each("colour", "alpha", "marker", "size"),
      traced: there.some(way => way.traced),
      trails: { xs: tail("x"), ys: tail("y"), ...each("colour", "alpha", "dash", "width") },
    }
    scrub.max = end
    scrub.value = time.toPrecision(4)  // as it is told
    const counts = MET.map((_, k) => there.length > 0 ? last(time, there[0].met[k]) + 1 : 0)
    const told = counts.map((count, k) => {
      const many = count > 0 && count == there[0].met[k].length && there[0].tally[k] > count ? "more than " : ""
      return `${many}${count.toLocaleString("en")} ${MET[k][count == 1 ? 0 : 1]}`
    })
    const usual = Math.max(0, there[0]?.met.findIndex(times => times.length > 0) ?? 0)  // the run may have jumps only
    const words = told.filter((_, k) => counts[k] > 0).join(", ") || told[usual]
    const last_time = there[0]?.t[there[0].t.length - 1]
    const until = time > last_time ? ` until it ended at t = ${printed(`${Number(last_time.toPrecision(4))}`)}` : ""
    now.textContent = `t = ${printed(time.toPrecision(4))}, ${words}${until}${there[0]?.whose ?? ""}`
    scrub.setAttribute("aria-valuetext", now.textContent)
    data.setv({ now: shown }, { sync: false })  // not needed by the server
  }
  const label = () => {
    play.innerHTML = `<svg viewBox="0 0 16 16" width="16" aria-hidden="true"><path fill="currentColor"
      d="${playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M3 1.5l11 6.5-11 6.5z"}"/></svg>`
    play.setAttribute("aria-label", playing ? "Pause" : "Play")
  }
  const pause = () => {
    playing = false
    if (request != null) { cancelAnimationFrame(request) }
    request = null
    label()
  }
  const tick = stamp => {
    const passed = before == null ? 0 : (stamp - before) / 1000
    if (calm.matches && passed < CALM && before != null) { request = requestAnimationFrame(tick); return }
    before = stamp
    time = Math.min(end, time + passed * speed.value * end / model.whole)
    show()
    if (time >= end) { pause() } else { request = requestAnimationFrame(tick) }
  }
  const start = () => {
    if (end == 0) { return }
    if (time >= end) { time = 0 }
    playing = true
    before = null
    label()
    request = requestAnimationFrame(tick)
  }
  const toggle = () => { if (playing) { pause() } else { start() } }
  const met = way => way.met.flatMap(times => Array.from(times)).sort((a, b) => a - b)
  // Go to the next step of the first integrator, or to its next crossing.
  const step = (direction, by_crossings) => {
    const stops = ways.length == 0 ? [] : by_crossings ? met(ways[0]) : ways[0].steps
    const here = last(time, stops)
    const next = direction > 0 ? here + 1 : stops[here] < time ? here : here - 1
    pause()
    time = next < 0 ? 0 : next >= stops.length ? end : stops[next]
    show()
  }

  play.addEventListener("click", toggle)
  scrub.addEventListener("input", () => { pause(); time = Math.min(end, scrub.valueAsNumber); show() })
  const space = event => {  // anywhere on the page but where space means something else
    if (event.key != " " || event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) { return }
    if (!is_free(event)) { return }
    event.preventDefault()
    toggle()
  }
  document.addEventListener("keydown", space)
  player.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target == speed) { return }
    if (event.key == " " && event.target != play) { toggle() }
    else if (event.key == "ArrowRight" || event.key == "ArrowUp") { step(1, event.shiftKey) }
    else if (event.key == "ArrowLeft" || event.key == "ArrowDown") { step(-1, event.shiftKey) }
    else { return }
    event.preventDefault()
  })
  // The space bar is for the player now, unless the user writes elsewhere; a button takes the focus once it is enabled.
  const await_space = () => requestAnimationFrame(() => {
    let focused = document.activeElement
    while (focused?.shadowRoot?.activeElement) { focused = focused.shadowRoot.activeElement }
    if (!focused?.matches("input, textarea, select, [contenteditable]")) { play.focus({ preventScroll: true }) }
  })
  const take = () => {
    ways = model.ways
    note.textContent = model.note
    end = Math.max(0, ...ways.map(way => way.t.length > 0 ? way.t[way.t.length - 1] : 0))
    time = Math.min(time, end)
    play.disabled = scrub.disabled = end == 0
    if (end == 0) { pause() }
    show()
    if (end > 0 && begun != model.begun) { begun = model.begun; time = 0; start(); await_space() }
  }
  model.on("ways", take)
  model.on("remove", () => {
    document.removeEventListener("keydown", space)
    ways = []
    pause()
    show()
  })
  label()
  take()
}
"""
)

_CSS = """
.player { display: flex; flex-wrap: wrap; align-items: center; gap: 4px 10px; font-size: 0.875rem;
          color: var(--mui-palette-text-primary, inherit); }
.scrub { flex: 1 1 140px; min-width: 100px; height: 24px; accent-color: var(--mui-palette-primary-main, #0072B2); }
.play { width: 40px; height: 36px; border-radius: 6px; cursor: pointer; font-size: 1rem; background: none;
        color: inherit; border: 1px solid var(--mui-palette-divider, #808080); }
.play:disabled { opacity: 0.5; cursor: default; }
.speed { font: inherit; color: inherit; background: var(--mui-palette-background-paper, Canvas); height: 30px;
         border: 1px solid var(--mui-palette-divider, #808080); border-radius: 6px; }
.note { flex-basis: 100%; color: var(--mui-palette-text-secondary, inherit); } .note:empty { display: none; }
.now { min-width: 12em; font-variant-numeric: tabular-nums; }
:focus-visible { outline: 2px solid var(--mui-palette-primary-main, #0072B2); outline-offset: 2px; }
"""

_MOVE = """
const { t, traced, trails: ways, ...markers } = cb_obj.now
moving.setv({ data: markers }, { sync: false })
trails.setv({ data: ways }, { sync: false })
played_time.setv({ data: { t: t == null ? [] : [t] } }, { sync: false })
for (const [curve, alpha] of [[curves, 1.0], [beside, BESIDE]]) {  // faint under the trails
  const line_alpha = { value: traced ? FAINT * alpha : alpha }
  if (curve.glyph.line_alpha?.value != line_alpha.value) { curve.glyph.setv({ line_alpha }, { sync: false }) }
}
clock.setv({ data: { t: [t ?? 0], running: [t != null] } }, { sync: false })
""".replace("FAINT", str(FAINT)).replace("BESIDE", str(OTHERS_ALPHA))


class Bar(pn.custom.JSComponent):
    """Button, slider and speed; runs in the browser, and sends nothing to the server."""

    ways = param.List(default=[], doc="The frames and the look of each run; the first is that of which is spoken.")
    note = param.String(default="", doc="What is not shown of them; set with `ways`.")
    begun = param.Integer(default=0, doc="How often the player was opened; each time it begins to play.")
    trail = param.Number(default=TRAIL)
    speeds = param.Dict(default=SPEEDS)
    whole = param.Number(default=WHOLE)
    now = param.Dict(default={}, doc="Time, places of the markers, and trails; set in the browser, never sent.")

    _esm = _ESM
    _stylesheets: ClassVar[list[str]] = [_CSS]


class Player(pn.viewable.Viewer):
    """Moves a marker with a trail for each run in the portrait, and a line in each view that time runs across.

    While it is open, space plays and pauses; with the focus in it the arrow keys move by one step, with shift by one
    crossing.

    Parameters
    ----------
    portrait : PortraitView
        The figure in which it moves markers; the others follow its `played_time`.
    """

    open = param.Boolean(default=False, doc="Whether the controls are shown; they are made when first shown.")

    def __init__(self, portrait: PortraitView) -> None:
        super().__init__()
        self._targets = {
            "moving": portrait.moving, "trails": portrait.trails, "clock": portrait.ground.clock,
            "played_time": portrait.played_time, "curves": portrait.curves, "beside": portrait.beside,
        }  # fmt: skip
        self.bar: Bar | None = None
        self.button = pmui.Button(
            label="Animate",
            icon="play_circle",
            variant="text",
            size="small",
            margin=(0, 4),
            sx=FOR_TOUCH,
            on_click=self._toggle,
        )
        self._place = pn.Column(margin=0, sizing_mode="stretch_width")
        self.param.watch(lambda _: self._follow(), "open")

    @property
    def wanted(self) -> bool:
        """Whether it needs frames."""
        return bool(self.open)

    def show(self, frames: Sequence[Frames], selected: int = 0, whose: str = "") -> None:  # type: ignore[override]
        """Set the frames; the time shown stays, if the frames reach it.

        Parameters
        ----------
        frames : sequence of Frames
            One of each run, those of the selected start first.
        selected : int
            How many those are; by default all.
        whose : str
            Which run the first is, in words to follow a count of its crossings.
        """
        if self.wanted and self.bar is not None:
            count = selected or len(frames)
            lines = together(line_of(one.method) for one in frames[:count])
            ways = [
                _way(one, lines[k % count], k < count) | {"size": _size(k, count), "whose": whose}
                for k, one in enumerate(frames)
            ]
            self.bar.param.update(note=without_trail(frames), ways=ways)

    def _toggle(self, _event: Any) -> None:
        self.open = not self.open

    def _follow(self) -> None:
        label, icon = ("Close the animation", "close") if self.open else ("Animate", "play_circle")
        self.button.param.update(label=label, icon=icon)
        if self.open and self.bar is None:
            self.bar = Bar(sizing_mode="stretch_width", margin=(2, 8))
            self.bar.jscallback(args=self._targets, now=_MOVE)
        if self.bar is not None:
            self.bar.param.update(note="", ways=[])
            self.bar.begun += self.open
            self._place.objects = [self.bar] if self.open else []

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the controls, if it is open; the button that opens it stands elsewhere."""
        return self._place


def without_trail(frames: Sequence[Frames]) -> str:
    """Say which integrators have no trail, and why; empty if all have one."""
    bare = list(dict.fromkeys(one.method for one in frames if not one.traced))
    if not bare:
        return ""
    several = len({one.method for one in frames}) > 1
    whose = f" of {listed(bare)}" if several else ""
    return f"No trail{whose}: the run has too many turns. A shorter one has a trail."


def _size(index: int, count: int) -> int:
    """Return the size of the marker of a run, of which the first `count` are those of the selected start."""
    first, less = LARGEST if index < count else LARGE
    return max(SMALLEST, first - less * (index % count))


def _way(one: Frames, line: Line, chosen: bool) -> dict[str, Any]:
    """Return frames in the form that the browser takes; arrays are sent as they are, without writing out digits.

    The trail has the dash and the width of the curve, so that runs which agree are both seen; of starts that are not
    `chosen` it is thinner and paler.
    """
    x, y = one.places.T.copy()
    return {
        "t": one.t, "x": x, "y": y, "steps": one.steps, "met": list(one.met), "tally": list(one.tally),
        "traced": one.traced, "chosen": chosen, "colour": line.colour, "marker": line.marker, "dash": list(line.dash),
        "width": line.width if chosen else OF_OTHERS * line.width, "alpha": 1.0 if chosen else OTHERS_ALPHA,
    }  # fmt: skip
