"""What lies under the trajectories of a portrait: sides, surface, field and level sets, also as time moves them."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.events import MouseLeave, MouseMove, Pan, RangesUpdate
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.annotations import Label, LegendItem
from bokeh.models.glyphs import Line, MultiPolygons, Scatter
from bokeh.models.renderers import GlyphRenderer
from bokeh.models.widgets import Div
from bokeh.plotting import figure

import core
from pwsviz.figures.colours import GREEN, GREY, SHADES, SIDES, SURFACE, TINT
from pwsviz.figures.labels import PLACE_LABELS, label_glyph, surface_labels
from pwsviz.figures.legends import LEGEND_GLYPH
from pwsviz.figures.moving import AWAIT, ELSEWHEN, REPAINT, TELL_PLACE
from pwsviz.figures.style import assign, ranges, tips, unseen
from pwsviz.geometry.hiding import any_seen, unhidden
from pwsviz.geometry.phase_plane import Backdrop
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import surface_name
from pwsviz.geometry.shades import shade_names
from pwsviz.geometry.walls import NO_LAW
from pwsviz.geometry.window import Window
from pwsviz.results.orbits import PIECES_WITH_LEVELS

__all__ = ["Ground"]

LEVEL_SET: dict[str, Any] = {"line_alpha": 0.85, "line_width": 0.8}
DOTS = (2, 3)
OWN_LEVEL_SET: dict[str, Any] = {"line_width": 2.0, "line_dash": DOTS}
"""Looks of the level sets of ψ, and of those on which the run is: the palest that WCAG admits (3:1), on every shade."""

HEAD: dict[str, Any] = {"fill_color": GREY, "line_color": GREY}
"""Look of the head of an arrow, where the legend names the field."""

READOUT_STYLES: dict[str, str | None] = {
    "font-size": "0.8125rem",
    "font-variant-numeric": "tabular-nums",
    "line-height": "1.2",
    "min-width": "0",
    "flex": "1 1 0",
    "align-self": "center",
}
"""CSS of the line that tells what is under the pointer."""

GESTURES = "Click or tap: new start · drag a star"
"""What that line says while the pointer is elsewhere."""


OWN_LEVEL, ATTRACTS, REPELS = "ψ = ψ(trajectory)", "S attracts", "S repels"

MEANINGS = {
    OWN_LEVEL: f"“{OWN_LEVEL}”: level sets of ψ through the first points of up to {PIECES_WITH_LEVELS} arcs of "
    "{trajectory}",
    ATTRACTS: f"“{ATTRACTS}”: both fields point towards S",
    REPELS: f"“{REPELS}”: both fields point away from S",
}
"""What entries of the legend mean, for captions."""


ADDITIONAL = ("f/|f|", "ψ = const.", OWN_LEVEL)
"""Entries of the legend that a first look can do without: on the page they are to be unfolded.

Whether a surface attracts or repels decides what runs do there, and is rare: only a phone folds that, too.
"""


class Ground:
    """The glyphs of a backdrop in a figure, made once; `show` changes their data.

    Attributes
    ----------
    legend : list of (label, renderer)
        What a legend says of it, for `legend_below`; its entries go to `follow`.
    clock : ColumnDataSource
        One row: the time t that is shown, and whether it is running; changed in the browser.
    readout : Div
        Tells what is under the pointer.
    waiting : Label
        Says that the backdrop has not come yet for all that is seen.
    """

    def __init__(self, plot: figure) -> None:
        self.figure = plot
        self._shown: Backdrop | None = None
        self._own: dict[int, Floats] = {}  # points of the level sets of the trajectories that these do not hide
        self.side = ColumnDataSource({"xs": [], "ys": []})
        tint = plot.add_glyph(self.side, MultiPolygons(fill_color=SHADES[-1], fill_alpha=TINT, line_width=0))
        self.bare = ColumnDataSource({"xs": [], "ys": []})
        hatched: dict[str, Any] = {"hatch_pattern": "/", "hatch_color": GREY, "hatch_alpha": 0.35, "hatch_scale": 12}
        bare = plot.add_glyph(self.bare, MultiPolygons(fill_color=GREY, fill_alpha=0.08, line_width=0, **hatched))
        self.levels, self.orbit_levels, self.arrows = ({side: _line_source() for side in SIDES} for _ in range(3))
        usual, own, field = (list[Any]() for _ in range(3))
        for side, colour in SIDES.items():
            usual.append(plot.add_glyph(self.levels[side], Line(line_color=colour, **LEVEL_SET)))
            own.append(plot.add_glyph(self.orbit_levels[side], Line(line_color=colour, **OWN_LEVEL_SET)))
            field.append(plot.add_glyph(self.arrows[side], Line(line_color=GREY, line_alpha=0.8)))
        plot.add_tools(tips([("ψ on this level set", "@psi{5}")], renderers=[*usual, *own], visible=False, limit=1))
        self.attracting, self.repelling, self.surface = _line_source(), _line_source(), _line_source()
        look: dict[str, Any] = {"line_color": GREEN, "line_width": 9}
        attracting = plot.add_glyph(self.attracting, Line(**look))
        repelling = plot.add_glyph(self.repelling, Line(line_dash=[4, 4], **look))
        line = plot.add_glyph(self.surface, Line(line_width=2.5, **SURFACE))
        self._names = label_glyph(plot)
        self.labels = self._names.data_source
        self._surface_labels: list[str] = []
        self._tint = ""  # name of the regions that are tinted
        self._arrow_lines = field
        head = plot.add_glyph(unseen(("x", "y")), Scatter(marker="triangle", angle=-math.pi / 2, size=7, **HEAD))
        self._level_keys = {3: _keys(plot, **LEVEL_SET), 4: _keys(plot, **OWN_LEVEL_SET)}  # by entry
        usual_keys, own_keys = (list(keys.values()) for keys in self._level_keys.values())
        self.legend: list[tuple[str, Any]] = [
            ("S: g = 0", line), ("g < 0", tint), ("no law", bare),
            (ATTRACTS, [attracting, line]), (REPELS, [repelling, line]),
            ("f/|f|", [*field, head]), ("ψ = const.", usual_keys), (OWN_LEVEL, own_keys),
        ]  # fmt: skip
        self.additional = sum(name in ADDITIONAL for name, _ in self.legend)  # they are the last ones
        self.formulas = ColumnDataSource({"text": ["null"], "across": ["x"], "up": ["y"]})
        self.clock = ColumnDataSource({"t": [0.0], "running": [False]})
        self._marked = ColumnDataSource({"count": [0]})
        self.waiting = Label(
            x=8, y=8, x_units="screen", y_units="screen", text="", text_font_size="12px", text_color=GREY,
            tags=["drawing"],
        )  # fmt: skip
        plot.add_layout(self.waiting)
        self.readout = Div(text=GESTURES, render_as_text=True, styles=READOUT_STYLES, margin=0)

    def meaning(self, trajectory: str) -> str:
        """Return what those lines mean that are in the legend now, for captions.

        Parameters
        ----------
        trajectory : str
            Name of the selected one.
        """
        names = [name for name, _ in self.legend[-len(self._line_entries) :]]
        entries = zip(names, self._line_entries, strict=True)
        shown = [MEANINGS[name] for name, entry in entries if entry.visible and name in MEANINGS]
        if self._bare_entry.visible and NO_LAW in str(self._bare_entry.label):
            shown.append(f"“{NO_LAW}”: a region in which the system is not defined")
        return f"{'; '.join(shown)}.".format(trajectory=trajectory) if shown else ""

    def follow(self, entries: list[LegendItem], marks: list[ColumnDataSource], curves: list[ColumnDataSource]) -> None:
        """Let the browser paint what depends on time, and tell what is under the pointer.

        Parameters
        ----------
        entries : list of LegendItem
            Those of `legend`.
        marks, curves : list of ColumnDataSource
            The marks on the trajectories, and these themselves, under which no label is to stand.
        """
        self._surface_entry, self._tint_entry, self._bare_entry, *self._line_entries = entries
        plane = {"formulas": self.formulas, "clock": self.clock, "ranges": list(ranges(self.figure))}
        painted = {
            "side": self.side,
            "bare": self.bare,
            "surface": self.surface,
            "entry": entries[0],
            "tint_entry": entries[1],
            "arrows": self._arrow_lines,
        }
        lines = {"lines_below": self._lines(-1), "lines_above": self._lines(1)}
        repaint = CustomJS(args=plane | painted | lines, code=REPAINT)
        there = {"labels": self.labels, "glyph": self._names.glyph, "marks": marks, "curves": curves}
        there["lines"] = [source for side in SIDES for source in self._lines(side)]
        there |= {"plot": self.figure.id, "size": None}
        there["again"] = self._marked  # the code does not read it, but what nothing names is not sent
        label = CustomJS(args=plane | there, code=PLACE_LABELS)
        self._names.tags = [label]  # for pictures, in whose frames there is room elsewhere
        for source in (self.formulas, self.clock):
            source.js_on_change("data", repaint, label)
        self._marked.js_on_change("data", label)  # not the marks themselves: from these a legend would reach all this
        rest = f"readout.setv({{ text: '{GESTURES}' }}, {{ sync: false }})"
        forget = CustomJS(args={"readout": self.readout}, code=rest)
        self.formulas.js_on_change("data", forget)
        self.figure.js_on_event(RangesUpdate, repaint)
        wait = CustomJS(args=plane | {"waiting": self.waiting}, code=AWAIT)
        self.formulas.js_on_change("data", wait)
        for axis in ranges(self.figure):
            axis.js_on_change("start", label, wait)
            axis.js_on_change("end", label, wait)
        tell = CustomJS(args=plane | {"readout": self.readout}, code=TELL_PLACE.replace("GESTURES", GESTURES))
        self.figure.js_on_event(MouseMove, tell)
        self.figure.js_on_event(Pan, tell)  # as a start is dragged
        self.figure.js_on_event(MouseLeave, tell)

    def _lines(self, side: int) -> list[ColumnDataSource]:
        return [self.levels[side], self.orbit_levels[side], self.arrows[side]]

    def name(self, system: core.PiecewiseSystem) -> None:
        """Name the surface in the legend, if it is drawn; several of them in the figure, too."""
        self._surface_entry.label = value(surface_name(system))
        self._surface_labels = surface_labels(system)
        self._tint = shade_names(system).get(-1, "")

    def _show_entries(self, backdrop: Backdrop, seen: Window) -> None:
        """Let a key stand in the legend for what is seen alone; of what moves, for what may be at another time."""
        moving = bool(backdrop.formulas["moving"] and backdrop.formulas["regions"])
        self._surface_entry.visible = (moving and backdrop.formulas["drawn"]) or any_seen(backdrop.surface, seen)
        tinted = _any_seen(backdrop.minus_outer, seen)
        self._tint_entry.visible = moving or tinted
        self._tint_entry.label = value(self._tint if tinted else f"{self._tint}{ELSEWHEN}")
        name = backdrop.formulas["bare"]
        self._bare_entry.visible = bool(name) and (moving or _any_seen(backdrop.bare_outer, seen))
        self._bare_entry.label = value(name)
        sliding = ({0: backdrop.attracting}, {0: backdrop.repelling})
        for k, (entry, part) in enumerate(
            zip(self._line_entries, (*sliding, backdrop.arrows, backdrop.levels, self._own), strict=True)
        ):
            if backdrop.formulas["moving"]:
                there = [side for side, line in part.items() if np.isfinite(line).any()]
            elif part is self._own:
                there = [side for side, points in part.items() if seen.holds(points).any()]
            else:
                there = [side for side, line in part.items() if any_seen(line, seen)]
            entry.visible = bool(there)
            if there and k in self._level_keys:
                _colour(self._level_keys[k], there, DOTS if part is self._own else ())

    def keep_clear(self) -> None:
        """Let the browser place the labels anew: there are other marks."""
        self._marked.data = {"count": [self._marked.data["count"][0] + 1]}

    def show(
        self, backdrop: Backdrop, names: tuple[str, str], seen: Window, curves: Sequence[Floats] = ()
    ) -> None:  # fmt: skip
        """Draw a backdrop.

        Parameters
        ----------
        backdrop : Backdrop
            What to draw.
        names : (str, str)
            Of the two variables that span the plane.
        seen : Window
            The part of the plane that is seen.
        curves : sequence of (n, 2) arrays
            The trajectories: level sets that these hide are not drawn.
        """
        new = backdrop is not self._shown
        if new:
            self._own = backdrop.orbit_levels
            if not backdrop.formulas["moving"]:
                window = backdrop.window
                self._own = {side: unhidden(line, curves, window, seen) for side, line in self._own.items()}
        self._show_entries(backdrop, seen)
        if new:
            self._paint(backdrop, names)

    def _paint(self, backdrop: Backdrop, names: tuple[str, str]) -> None:
        """Send the data of a backdrop."""
        moved = self._shown is not None and self._shown.formulas["moving"]
        self._shown = backdrop
        for source, columns in (
            (self.side, _polygons(backdrop.minus_outer, backdrop.minus_holes)),
            (self.bare, _polygons(backdrop.bare_outer, backdrop.bare_holes)),
            (self.surface, _columns(backdrop.surface)),
        ):
            if moved:  # by the browser itself, so that it shows other data than were sent
                source.data = columns
            else:
                assign(source, **columns)
        hidden = not any(map(len, self._own.values()))  # not drawn then: in print, the curves’ dashes would show them
        own = {side: line[: 0 if hidden else len(line)] for side, line in backdrop.orbit_levels.items()}
        for side in SIDES:
            cut = [_columns(part[side]) for part in (backdrop.levels, own, backdrop.arrows)]
            for source, columns in zip(self._lines(side), backdrop.whole.get(side, cut), strict=True):
                assign(source, **columns)
        assign(self.attracting, **_columns(backdrop.attracting))
        assign(self.repelling, **_columns(backdrop.repelling))
        text = json.dumps(
            {**backdrop.formulas, "surfaces": self._surface_labels, "window": backdrop.window, "tint": self._tint}
        )
        # Sent last: the browser then paints what moves as it is at the time of the player.
        self.formulas.data = {"text": [text], "across": [names[0]], "up": [names[1]]}


def _any_seen(outlines: list[Floats], seen: Window) -> bool:
    """Whether a region is seen, of outlines with a vertex in each cell of the grid: a border of it, or nothing else."""
    within = [(outline, seen.holds(outline)) for outline in outlines]
    return any(holds.any() or _surrounds(outline, seen) for outline, holds in within)


def _surrounds(outline: Floats, seen: Window) -> bool:
    """Whether an outline with no vertex in a window surrounds it."""
    x, y = 0.5 * (seen.x_low + seen.x_high), 0.5 * (seen.y_low + seen.y_high)
    (ax, ay), (bx, by) = outline[:-1].T, outline[1:].T
    rises = (ay > y) != (by > y)
    right = x < ax[rises] + (y - ay[rises]) / (by[rises] - ay[rises]) * (bx[rises] - ax[rises])
    return bool(np.count_nonzero(right) % 2)


def _polygons(outer: list[Floats], holes: list[list[Floats]]) -> dict[str, Any]:
    """Return outlines, and those of their holes, as columns."""
    regions = [[ring, *inner] for ring, inner in zip(outer, holes, strict=True)]
    return {name: [[[ring[:, k] for ring in rings]] for rings in regions] for k, name in enumerate(("xs", "ys"))}


def _keys(plot: figure, **look: Any) -> dict[int, GlyphRenderer[Any]]:
    """Return what a legend paints of the lines on each side: nothing in the figure."""
    nowhere = ColumnDataSource({"x": [np.nan], "y": [np.nan]})
    return {side: plot.add_glyph(nowhere, Line(line_color=colour, **look)) for side, colour in SIDES.items()}


def _colour(keys: dict[int, GlyphRenderer[Any]], there: list[int], dash: tuple[int, ...]) -> None:
    """Give the key of lines, with their dash, the colour of the side on which they are; if on both, half of it each.

    The entry keeps its renderers: of others, Bokeh would go through all models of the page.
    """
    half = LEGEND_GLYPH // 2
    halved = [*dash] * ((half + dash[-1]) // sum(dash)) if dash else [half, 0]
    halved[-1] += LEGEND_GLYPH - sum(halved)
    for side, key in keys.items():
        alone = [*dash] if side in there else [0, LEGEND_GLYPH]
        key.glyph.line_dash = halved if len(there) == len(keys) else alone
        key.glyph.line_dash_offset = half if side > 0 else 0


def _line_source() -> ColumnDataSource:
    return ColumnDataSource({"x": [], "y": []})


def _columns(points: Floats) -> dict[str, Floats]:
    """Return points as columns: x, y, and ψ where it is given."""
    return dict(zip(("x", "y", "psi"), points.T, strict=False))
