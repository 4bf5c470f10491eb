"""Legends: below a figure, in which they take no room from the picture, with marks as large as in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.annotations import Legend, LegendItem
from bokeh.models.glyphs import Scatter
from bokeh.plotting import figure

__all__ = ["LEGEND_GLYPH", "MARK_COLUMNS", "legend_below", "legend_marks", "mark_columns"]

LEGEND_GLYPH = 28
"""Pixels of line in a legend: a little more than one period of the longest dash pattern."""

LEGEND_ROW = 18
"""Pixels of a row of a legend, and so of the largest mark in it."""

LEGEND_GAP = 2
"""Pixels between two of its rows."""

LEGEND_CSS = f"""
:host(.bk-Legend) {{ font-size: 13px; left: calc(50% + var(--legend-aside, 0px));
                    width: max-content; max-width: var(--legend-width, 100%); grid-template-columns: minmax(0, auto); }}
.bk-grid.bk-grid {{ display: flex; flex-wrap: wrap; justify-content: center; gap: {LEGEND_GAP}px 12px; width: auto; }}
.bk-item.bk-item {{ gap: 5px; min-height: {LEGEND_ROW}px; }}
"""
"""Its entries, in small type, in as many rows as they need."""

FOLD_CSS = """
.bk-item.folded { display: none; }
button { all: unset; cursor: pointer; pointer-events: auto; font: inherit; min-height: ROWpx;
         line-height: max(ROWpx, 1.2em);
         padding: 3px 8px; margin: -3px -8px;
         color: var(--mui-palette-primary-main, #1565c0); }
button:focus-visible { outline: 2px solid; }
""".replace("ROW", str(LEGEND_ROW))
"""The entries that are folded, and the button that unfolds them."""

FOLD = """
const folded = folding + (innerWidth < NARROW ? ON_PHONES : 0)
const rest = new Set(own.model.items.slice(own.model.items.length - folded))
const own_entries = () => own.entries.filter(({ item }) => item.visible && rest.has(item))
const button = grid.button ??= document.createElement("button")
const fold = () => {
  const count = own_entries().length, folds = count >= FEWEST, open = button.ariaExpanded == "true"
  for (const { el, item } of own.entries) { el.classList.toggle("folded", folds && !open && rest.has(item)) }
  const size = own.model.label_text_font_size  // larger in a lecture
  button.style.fontSize = size.value ?? size
  const words = open ? "fewer" : `${count} more`
  if (button.textContent != words) { button.textContent = words }
  button.ariaLabel = `${words} entries of the legend`
  if (folds && grid.lastElementChild != button) { grid.append(button) } else if (!folds) { button.remove() }
}
if (button.onclick == null) {
  button.type = "button"
  button.ariaExpanded = "false"
  button.onclick = () => {
    button.ariaExpanded = String(button.ariaExpanded != "true")
    fold()
    own.request_paint()
  }
  for (const kind of ["pointerdown", "mousedown", "touchstart"]) {
    button.addEventListener(kind, event => event.stopPropagation())  // no gesture of the figure
  }
  const make = own._render_items  // Bokeh measures the entries as soon as it has made them
  own._render_items = () => {
    make.call(own)
    fold()
  }
  fold()
}
"""
"""JavaScript that folds the last entries of a legend on the page, where there are some: a picture for print has all."""

FEWEST = 2
"""Fewest entries that are folded; a single one takes as much room as the button."""

ON_PHONES = 2
"""Entries that are folded besides on a narrow screen, where the legend would take a third row."""

NARROW = 600
"""Pixels below which a screen is that narrow."""

KEEP_PLACE = (
    """
const found = id => cb_context.index.query_one(view => view.model.id == id)
const own = found(legend), grid = own?.grid_el, { el, frame } = found(plot) ?? {}
if (grid != null && el != null) {
  const set = (name, pixels) => el.style.setProperty(`--legend${name}`, `${pixels}px`)
  set("-width", cb_obj.outer_width)
  set("-aside", cb_obj.outer_width / 2 - frame.bbox.hcenter)  // from below the frame to below the figure
  if (grid.watcher == null) {
    grid.watcher = new ResizeObserver(() => {
      if (grid.offsetHeight > 0) { set("", grid.offsetHeight - usual) }
      own.update_position()  // measures it: the layout that follows would take the size it had at the layout before
    })
    grid.watcher.observe(grid)
    new MutationObserver(() => own.request_paint()).observe(grid, { childList: true })
  }
  if (folding > 0) { FOLD }
}
""".replace("FOLD", FOLD)
    .replace("FEWEST", str(FEWEST))
    .replace("ON_PHONES", str(ON_PHONES))
    .replace("NARROW", str(NARROW))
)
"""JavaScript that gives a legend the width of its figure, and makes the figure as much taller as the legend is taller
than usual, and has its entries painted when it makes them anew.

It knows plot and legend by their ids, not as models: in the browser a legend makes its entries anew at each change of
any model that can be reached from them. Bokeh itself leaves them unpainted until the figure is painted next.
"""

MARKS_AS_DRAWN = """
const { prototype } = Bokeh.loader["models/glyphs/marker"].MarkerView, small = prototype._get_legend_args
if (prototype.marks_as_drawn == null) {
  prototype.marks_as_drawn = true
  prototype._get_legend_args = function (box, index) {
    const place = small.call(this, box, index), room = Math.abs(box.y1 - box.y0) - 1
    const size = { get: () => Math.min(this.size.get(index), room) || place.size.get(index) }
    return { ...place, size, angle: { get: () => this.angle.get(index) } }
  }
}
"""
"""JavaScript that gives the marks in all legends the angle that they have in the figure, and the size as far as there
is room: Bokeh makes them alike, upright, and so small that a star looks like a speck."""

MARK_COLUMNS = ("nowhere", "marker")
"""Columns that the source of the lines needs for their marks in the legend."""


def legend_marks(plot: figure, lines: ColumnDataSource, size: float, **fill: Any) -> Any:
    """Return what a legend draws over its lines, of the source of these, as Bokeh asks for: nothing in the plot.

    Parameters
    ----------
    plot : figure
        The figure.
    lines : ColumnDataSource
        Its curves, with the columns `MARK_COLUMNS`.
    size : float
        Diameter in pixels of the marks on the curves.
    **fill
        Their filling, of the colour of the curve unless this names another one.
    """
    look: dict[str, Any] = {"fill_color": "colour", "line_color": "colour", **fill}
    return plot.add_glyph(lines, Scatter(x="nowhere", y="nowhere", marker="marker", size=size, **look))


def mark_columns(markers: Sequence[str]) -> dict[str, Any]:
    """Return `MARK_COLUMNS` of lines, of the marker of each."""
    return {"nowhere": [np.nan] * len(markers), "marker": list(markers)}


def legend_below(
    plot: figure, entries: Sequence[tuple[Any, Any]], usual: int = 1, folding: int = 0
) -> list[LegendItem]:
    """Put a legend below the plot, where it covers nothing, and return its entries.

    Parameters
    ----------
    plot : figure
        The figure.
    entries : list of (label, renderer)
        A label is a text, or ``{"field": name}`` for one entry per distinct value in that column. In place of a
        renderer, several that are painted one over the other.
    usual : int
        Rows for which the figure has room: more of them make it taller, so that the plot itself keeps its place.
    folding : int
        How many of the last entries are seen on the page only once they are unfolded.
    """
    items = [LegendItem(label=label, renderers=one if isinstance(one, list) else [one]) for label, one in entries]
    look: dict[str, Any] = {
        "orientation": "horizontal",
        "margin": 0,
        "padding": 4,
        "stylesheets": [LEGEND_CSS, FOLD_CSS],
    }
    size: dict[str, Any] = {"glyph_width": LEGEND_GLYPH, "glyph_height": LEGEND_ROW}
    legend = Legend(items=items, location="center", **size, **look)
    for name, pixels in size.items():  # the theme of the page would make glyphs so small that dashes look alike
        legend.js_on_change(name, CustomJS(code=f"cb_obj.{name} = {pixels}"))
    room = usual * LEGEND_ROW + (usual - 1) * LEGEND_GAP
    keep = CustomJS(args={"plot": plot.id, "legend": legend.id, "usual": room, "folding": folding}, code=KEEP_PLACE)
    for width in ("outer_width", "inner_width"):
        plot.js_on_change(width, CustomJS(code=MARKS_AS_DRAWN), keep)
    plot.add_layout(legend, "below")
    return items
