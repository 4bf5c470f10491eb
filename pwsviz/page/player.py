"""The player: moves a marker along each trajectory in time, in the browser alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import panel as pn
import panel_material_ui as pmui
import param
from bokeh.models.annotations import Span

from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.style import line_of
from pwsviz.results.animation import Frames

SPEEDS = {"¼×": 0.25, "½×": 0.5, "1×": 1.0, "2×": 2.0, "4×": 4.0}
"""Offered speeds, by label."""

WHOLE = 12.0
"""Seconds that the whole run takes to play at speed 1."""

_ESM = """
export function render({ model, data, el }) {
  el.innerHTML = `
    <div class="player" role="group" aria-label="Play the trajectory in time">
      <button type="button" class="play"></button>
      <input type="range" class="scrub" min="0" step="any" aria-label="Time">
      <output class="now" aria-live="off"></output>
      <label>Speed <select class="speed"></select></label>
    </div>`
  const part = name => el.querySelector("." + name)
  const [player, play, scrub, now, speed] = ["player", "play", "scrub", "now", "speed"].map(part)
  for (const [name, factor] of Object.entries(model.speeds)) { speed.add(new Option(name, factor)) }
  speed.value = "1"

  const calm = window.matchMedia("(prefers-reduced-motion: reduce)")
  const CALM = 0.5  // seconds between pictures where the user prefers reduced motion
  let time = 0, end = 0, ways = [], playing = false, before = null, due = 0, request = null

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
    const at = there.map(way => Math.max(0, last(time, way.t)))
    const shown = {
      t: there.length > 0 ? time : null,
      x: there.map((way, k) => way.x[at[k]]), y: there.map((way, k) => way.y[at[k]]),
      colour: there.map(way => way.colour), marker: there.map(way => way.marker),
      size: there.map((way, k) => Math.max(6, 18 - 8 * k)),  // smaller for later ones, so that none hides another
    }
    scrub.max = end
    scrub.value = time
    const crossed = there.length > 0 ? last(time, there[0].crossings) + 1 : 0
    const words = `t = ${time.toPrecision(4)}`
    now.textContent = `${words}, ${crossed} crossing${crossed == 1 ? "" : "s"}`
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
  // Go to the next step of the first integrator, or to its next crossing.
  const step = (direction, by_crossings) => {
    const stops = ways.length == 0 ? [] : by_crossings ? ways[0].crossings : ways[0].t
    const here = last(time, stops)
    const next = direction > 0 ? here + 1 : stops[here] < time ? here : here - 1
    pause()
    time = next < 0 ? 0 : next >= stops.length ? end : stops[next]
    show()
  }

  play.addEventListener("click", toggle)
  scrub.addEventListener("input", () => { pause(); time = Math.min(end, scrub.valueAsNumber); show() })
  player.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target == speed) { return }
    if (event.key == " " && event.target != play) { toggle() }
    else if (event.key == "ArrowRight" || event.key == "ArrowUp") { step(1, event.shiftKey) }
    else if (event.key == "ArrowLeft" || event.key == "ArrowDown") { step(-1, event.shiftKey) }
    else { return }
    event.preventDefault()
  })
  const take = () => {
    ways = model.ways
    end = Math.max(0, ...ways.map(way => way.t.length > 0 ? way.t[way.t.length - 1] : 0))
    time = Math.min(time, end)
    play.disabled = scrub.disabled = end == 0
    if (end == 0) { pause() }
    show()
  }
  model.on("ways", take)
  model.on("remove", () => {
    ways = []
    pause()
    show()
  })
  label()
  take()
}
"""

_CSS = """
.player { display: flex; flex-wrap: wrap; align-items: center; gap: 4px 10px; font-size: 0.875rem;
          color: var(--mui-palette-text-primary, inherit); }
.scrub { flex: 1 1 140px; min-width: 100px; accent-color: var(--mui-palette-primary-main, #0072B2); }
.play { width: 40px; height: 36px; border-radius: 6px; cursor: pointer; font-size: 1rem; background: none;
        color: inherit; border: 1px solid var(--mui-palette-divider, #808080); }
.play:disabled { opacity: 0.5; cursor: default; }
.speed { font: inherit; color: inherit; background: var(--mui-palette-background-paper, Canvas); height: 30px;
         border: 1px solid var(--mui-palette-divider, #808080); border-radius: 6px; }
.now { min-width: 12em; font-variant-numeric: tabular-nums; }
:focus-visible { outline: 2px solid var(--mui-palette-primary-main, #0072B2); outline-offset: 2px; }
"""

_MOVE = """
const { t, ...markers } = cb_obj.now
moving.setv({ data: markers }, { sync: false })
for (const line of lines) {
  line.setv(t == null ? { visible: false } : { location: t, visible: true }, { sync: false })
}
"""


class Bar(pn.custom.JSComponent):
    """Button, slider and speed; runs in the browser, and sends nothing to the server."""

    ways = param.List(default=[], doc="The frames and the look of each integrator, as plain lists.")
    speeds = param.Dict(default=SPEEDS)
    whole = param.Number(default=WHOLE)
    now = param.Dict(default={}, doc="Time and places of the markers; set in the browser, never sent.")

    _esm = _ESM
    _stylesheets: ClassVar[list[str]] = [_CSS]


class Player(pn.viewable.Viewer):
    """Moves a marker for each integrator in the portrait, and a line in each view that time runs across.

    With the focus in it, space plays and pauses; the arrow keys move by one step, with shift by one crossing.

    Parameters
    ----------
    portrait : PortraitView
        The figure in which it moves markers.
    lines : sequence of Span
        The lines it moves; none of them need be on the screen.
    """

    open = param.Boolean(default=False, doc="Whether the controls are shown; they are made when first shown.")

    def __init__(self, portrait: PortraitView, lines: Sequence[Span]) -> None:
        super().__init__()
        self._targets = {"moving": portrait.moving, "lines": list(lines)}
        self.bar: Bar | None = None
        self.button = pmui.Button(
            label="Animate", icon="play_circle", variant="text", size="small", margin=(0, 4), on_click=self._toggle
        )
        self._place = pn.Column(margin=0, sizing_mode="stretch_width")
        self.param.watch(lambda _: self._follow(), "open")

    @property
    def wanted(self) -> bool:
        """Whether it needs frames."""
        return bool(self.open)

    def show(self, frames: Sequence[Frames]) -> None:  # type: ignore[override]  # Viewer.show starts a server
        """Set the frames of each integrator; the time shown stays, if the frames reach it."""
        if self.wanted and self.bar is not None:
            self.bar.ways = [_way(one) for one in frames]

    def _toggle(self, _event: Any) -> None:
        self.open = not self.open

    def _follow(self) -> None:
        self.button.label = "Close the player" if self.open else "Animate"
        if self.open and self.bar is None:
            self.bar = Bar(sizing_mode="stretch_width", margin=(2, 8))
            self.bar.jscallback(args=self._targets, now=_MOVE)
        if self.bar is not None:
            self.bar.ways = []
            self._place.objects = [self.bar] if self.open else []

    def __panel__(self) -> pn.viewable.Viewable:
        """Return a button and, while open, the controls below it."""
        return pn.Column(self.button, self._place, margin=0, sizing_mode="stretch_width")


def _way(one: Frames) -> dict[str, Any]:
    """Return frames in the form that the browser takes."""
    x, y = one.places.T
    line = line_of(one.method)
    return {
        "t": one.t.tolist(), "x": x.tolist(), "y": y.tolist(), "crossings": one.crossings.tolist(),
        "colour": line.colour, "marker": line.marker,
    }  # fmt: skip
