"""The cover of the page: the portrait of a fresh page, which stands there until the page itself is built.

The scripts of the page take seconds to load and to build it. The cover is part of the document, and seen at once. When
the portrait itself is painted the cover is lifted from it, and leaves grey where controls and view are still to come.
"""

from __future__ import annotations

from concurrent.futures import Future
from threading import Lock, Thread
from typing import Any

from pwsviz.figures.colours import ON_DARK
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.still import still
from pwsviz.figures.style import HEIGHT
from pwsviz.page.help import GREETING_CSS, greeting
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.first import first_scene
from pwsviz.scene.presets import FIRST_LOOK, PRESETS
from pwsviz.widgets.browser import CRAMPED, IS_DARK
from pwsviz.widgets.widths import LOW, NARROW

__all__ = ["COLUMNS", "LEAST", "SIDEBAR_WIDTH", "Cover", "portrait_of_a_fresh_page"]

COLUMNS = """display: grid !important; gap: 8px 20px; grid-auto-rows: max-content; align-items: start;
    grid-template-columns: repeat(auto-fit, minmax(min(100%, max(var(--column, 430px), 50% - 10px)), 1fr));"""
"""CSS of a portrait and the view beside it: two columns at most, one where the screen is narrow."""

LEAST = 340
"""Least width of a column in pixels on a screen that is low, such as a phone's on its side."""

TONES = "\n".join(f'#cover.dark [stroke="{colour}"] {{ stroke: {tone} }}' for colour, tone in ON_DARK.items())
"""CSS of the lines of the picture on a dark page."""

SIDEBAR_WIDTH = 300
"""Width of the sidebar in pixels."""

MARKUP = """
<style>
#cover { position: fixed; inset: 0; z-index: 1300; overflow: hidden; background: white; color: rgba(0, 0, 0, 0.87); }
GREETING_CSS
#cover aside, #cover .view { border-radius: 4px; background: rgba(128, 128, 128, 0.07); }
#cover aside { position: absolute; left: 12px; top: 70px; bottom: 24px; width: calc(SIDEBARpx - 30px);
    background: repeating-linear-gradient(rgba(128, 128, 128, 0.12) 0 40px, transparent 40px 58px); }
#cover .view { height: HEIGHT; margin-top: 40px; }
#cover.lifted { background: none; pointer-events: none; }
#cover.lifted > header, #cover.lifted > .greeting, #cover.lifted main > :not(.view) { visibility: hidden; }
#cover.dark:not(.lifted) { background: #121212; color: white; }
TONES
#cover header { font: 700 21.6px/48px Roboto, Helvetica, Arial, sans-serif; padding-left: 68px;
                border-bottom: 1px solid rgba(128, 128, 128, 0.3); }
#cover main { COLUMNS margin: 19px 16px 0 calc(SIDEBARpx + 16px); }
#cover figure { margin: 30px 12px 0 76px; height: calc(HEIGHT - 129px); overflow: hidden; }
#cover svg { width: 100%; height: 100%; }
#cover figure + p { margin: 12px 12px 0 76px; text-align: center; font: 16px Roboto, Helvetica, Arial, sans-serif; }
#cover .greeting { margin: 15px 16px -15px; }
#cover ~ #loader .spinner { display: none; }
@media (width < NARROWpx) {
  #cover aside, #cover.lifted .view { display: none; } #cover main { margin-left: 16px; }
  #cover figure { margin-top: 33px; } #cover header { padding-left: 60px; } }
@media (height < LOWpx) { #cover aside { display: none; } #cover main { margin-left: 16px; --column: LEASTpx; } }
</style>
<div id="cover" aria-hidden="true">
<header>pwsviz</header>
GREETING
<aside></aside>
<main><div><figure>PICTURE</figure><p>Loading …</p></div><div class="view"></div></main>
</div>
<script>{
  const cover = document.getElementById("cover"), begun = performance.now(), dark = (IS_DARK)()
  cover.classList.toggle("dark", dark)
  if (location.search.length > 1) { cover.querySelector("svg").remove() }  // a link shows another scene
  // Painted, and a star that is dragged is taken for one: see `gestures`.
  const ready = view => view.model.type == "Figure" && view.is_idle && view.canvas_view.events_el.dataset.gestures
  const painted = () => window.Bokeh?.index?.query_one?.(ready) != null
  const told = () => Bokeh.documents[0]?.roots().find(root => "sidebar_open" in (root.data ?? {}))?.data
  // The page learns from the browser that it is dark or narrow, and takes a moment to change its colours or controls.
  const fits = page => page?.dark_theme == dark && page.sidebar_open == !CRAMPED
  const furnished = () => Bokeh.index.query_one(view => view.model.type.endsWith("Select")) != null
  const lift = () => {
    if (performance.now() - begun > 120000 || cover.matches(".lifted") && furnished()) { return cover.remove() }
    const lifted = () => cover.classList.add("lifted")
    if (painted() && fits(told())) { setTimeout(lifted, dark || CRAMPED ? 400 : 0) }
    requestAnimationFrame(lift)
  }
  lift()
}</script>
"""
"""Measures are those of the page: its header, the margins, and the frame of the portrait among its axes and legend."""


class Cover:
    """The cover, drawn once and beside: a page that is asked for before has none.

    Parameters
    ----------
    results : Results
        Where the arrays come from.
    """

    def __init__(self, results: Results) -> None:
        self._results = results
        self._begun, self._picture = Lock(), Future[str]()

    def draw(self) -> None:
        """Draw the picture, unless that has been begun."""
        if self._begun.acquire(blocking=False):  # never released
            try:
                self._picture.set_result(portrait_of_a_fresh_page(self._results))
            except ValueError as reason:  # of the scene, which the page itself tells
                self._picture.set_exception(reason)

    def markup(self) -> str:
        """Return what belongs at the beginning of the body of a page; empty while the picture is being drawn."""
        if not self._picture.done():
            Thread(target=self.draw, name="pwsviz-cover", daemon=True).start()
            return ""
        return "" if self._picture.exception() else MARKUP_OF_THE_PAGE.replace("PICTURE", self._picture.result())


MARKUP_OF_THE_PAGE = (
    MARKUP.replace("TONES", TONES).replace("GREETING_CSS", GREETING_CSS)
    .replace("GREETING", greeting(PRESETS[FIRST_LOOK])).replace("COLUMNS", COLUMNS)
    .replace("SIDEBAR", str(SIDEBAR_WIDTH)).replace("HEIGHT", HEIGHT)
    .replace("NARROW", str(NARROW)).replace("CRAMPED", CRAMPED)
    .replace("LOW", str(LOW)).replace("LEAST", str(LEAST)).replace("IS_DARK", IS_DARK)
)  # fmt: skip


def portrait_of_a_fresh_page(results: Results) -> str:
    """Return the portrait of a fresh page as SVG."""
    scene = first_scene()
    pictures = results.pictures(PortraitInputs.of(scene))
    view = PortraitView(*[_unheard] * 5)
    starts = list(map(pictures.plane.place, scene.starts))
    view.show_orbits(scene.declaration, pictures, starts, scene.selected)
    view.fit()
    assert view.frame is not None  # noqa: S101  (it fits the orbits just shown)
    problem, levels = pictures.inputs.selected[0].problem, pictures.orbits[0].levels
    view.show_backdrop(results.backdrop(problem, view.frame.scaled(1.5).surroundings(), levels, pictures.plane))
    return still(view.figure, view.frame)


def _unheard(*_: Any) -> None:
    """Do nothing: nobody acts on a still picture."""
