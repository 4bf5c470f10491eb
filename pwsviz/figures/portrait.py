"""The phase portrait: orbits over the sides, the surface, the field and the level sets of ψ.

Stars mark the starts of the trajectories. The user places, selects, drags and removes them with mouse or finger; the
browser moves them (see `gestures`), and reports the new places to the server.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Event, PointEvent, RangesUpdate, Reset, Tap
from bokeh.models import ColumnDataSource, CustomJS, DataRange1d, ResetTool
from bokeh.models.glyphs import Line, MultiLine, Scatter, Text
from bokeh.plotting import figure

import core
from pwsviz.figures.colours import AMBER, GREY, GROUND, VERMILION
from pwsviz.figures.crowding import Marks
from pwsviz.figures.framing import extent, power_of_ten
from pwsviz.figures.gestures import MOVING_KEYS, attach_gestures
from pwsviz.figures.ground import Ground
from pwsviz.figures.legends import legend_below
from pwsviz.figures.lines import LEGEND_WIDTH, LOOK_COLUMNS
from pwsviz.figures.marks import crossing_columns, end_columns, star_labels
from pwsviz.figures.orbit_lines import (
    alongside_columns,
    curve_columns,
    fitted,
    selected_shares,
    starts_of_thin,
    step_columns,
    thin_shares,
)
from pwsviz.figures.portrait_text import SUMMARY, portrait_text
from pwsviz.figures.style import (
    assign,
    crossing_tips,
    describe,
    fit_to_corners,
    invisible,
    legend_lines,
    plain_figure,
    ranges,
    refit,
    show_methods,
    tips,
    unseen,
)
from pwsviz.figures.touch import attach_touch
from pwsviz.geometry.first_view import with_room
from pwsviz.geometry.phase_plane import Backdrop
from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.projection import axis_labels
from pwsviz.geometry.window import Window
from pwsviz.results.results import Pictures
from pwsviz.text.math_names import variable_name

STAR_SIZE = {True: 26, False: 21}
"""Diameter in pixels of the star of the selected start, and of others."""

CROWDED_STAR_SIZE = {True: 15, False: 11}
"""The same of stars that would cover one another: small, they lie side by side."""

STAR, PALE_STAR = "#E69F00", "#F7DDA2"
"""Fill of the star of the selected start, and of others: a black number is legible on either."""

OTHERS_ALPHA = 0.9
"""Opacity of the curves from other starts, which are thin, too."""

ROOM = 1.08
"""Size of the view relative to the box of the trajectories that it is fitted to."""

FOLLOW = """
const [across, up] = ranges
corners.data = { x: [across.start, across.end], y: [up.start, up.end] }
for (const range of ranges) { range.have_updated_interactively = false }
"""
"""JavaScript run when the user has panned or zoomed: what is seen then is kept, at equal scales, at any size."""

END_SIZE = 15
"""Diameter in pixels of the mark of an end: wide enough that two runs which end at one place do not look joined."""

POINTED_WIDTH = 4.0
"""Width in pixels of a curve of another start while the pointer is on it."""

STEP_SIZE = 4.5
"""Diameter in pixels of the dot at the end of a step."""

POINTED_SIZE = 19
"""Diameter in pixels of the ring around the crossing under the pointer: a mark, and some room."""


def _star_sizes(numbers: Sequence[str], chosen: Sequence[bool]) -> list[int]:
    """Return the sizes of stars, of which those that would cover one another have no number inside."""
    return [(STAR_SIZE if number else CROWDED_STAR_SIZE)[it] for number, it in zip(numbers, chosen, strict=True)]


def _ignore(*_: Any) -> None:
    """Do nothing, where nobody listens."""


class PortraitView:
    """One fixed figure; `show_orbits` and `show_backdrop` only change its data.

    Parameters
    ----------
    on_window : callable
        Called with the visible part of the plane whenever that changes.
    on_place : callable
        Called with (x, y) when the user clicks on the plane, beside all stars.
    on_move : callable
        Called with (index, x, y) when the user drags a start: some twenty times a second, and at the end. To refuse a
        move, call `show_starts`; otherwise the star stays where it was dropped.
    on_drop : callable
        Called after the last move.
    on_remove, on_select : callable
        Called with the index of the start to remove or to select.
    on_zoom : callable, optional
        Called with the visible part of the plane when the user has panned or zoomed.
    on_fit : callable, optional
        Called when the user wants to see the trajectories again.
    on_double_click : callable, optional
        Called after a double click beside all stars, of which the first click has called `on_place`.

    Attributes
    ----------
    frame : Window or None
        The part of the plane that the view was last told to show.
    ground : Ground
        What lies under the trajectories.
    """

    def __init__(
        self,
        on_window: Callable[[Window], None],
        on_place: Callable[[float, float], None],
        on_move: Callable[[int, float, float], None],
        on_remove: Callable[[int], None],
        on_select: Callable[[int], None],
        on_drop: Callable[[], None] = _ignore,
        on_zoom: Callable[[Window], None] = _ignore,
        on_fit: Callable[[], None] = _ignore,
        on_double_click: Callable[[], None] = _ignore,
    ) -> None:
        self.figure = self._plot()
        self.frame: Window | None = None
        self._pictures: Pictures | None = None
        self._names = ("x", "y")
        self._named: tuple[core.PiecewiseSystem, Plane] | None = None
        self._visible: Window | None = None
        self._heard = 0

        def drop(index: int, x: float, y: float) -> None:
            on_move(index, x, y)
            on_drop()

        self._acts: dict[str, Callable[[int, float, float], None]] = {
            "drag": on_move,
            "drop": drop,
            "remove": lambda index, _x, _y: on_remove(index),
            "select": lambda index, _x, _y: on_select(index),
            "fit": lambda _index, _x, _y: on_double_click(),
        }
        self.ground = Ground(self.figure)
        self._orbit_glyphs()
        self._crossing_glyphs()
        self._start_glyphs()
        self._add_legend()
        self._watch_window(on_window, on_zoom, on_fit)
        self._watch_gestures(on_place)

    @staticmethod
    def _plot() -> figure:
        plot = plain_figure(
            SUMMARY,
            match_aspect=True,
            x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.0),
            min_border_left=76,  # wider than the usual numbers, whose width would move the range, and the range them
            active_drag="pan",
            active_scroll="wheel_zoom",
        )
        plot.grid.visible = False
        keys = f"{plot.html_attributes['aria-keyshortcuts']} {MOVING_KEYS}"
        plot.html_attributes = {**plot.html_attributes, "aria-keyshortcuts": keys}
        for reset in (tool for tool in plot.tools if isinstance(tool, ResetTool)):
            reset.description = "Fit to the trajectories (double-click)"
        return plot

    def _orbit_glyphs(self) -> None:
        plot = self.figure
        columns = ("xs", "ys", *LOOK_COLUMNS, "width", "stroke")
        looks: dict[str, Any] = {"line_color": "colour", "line_width": "width", "line_join": "round"}
        self.others = ColumnDataSource({name: [] for name in (*columns, "start")})
        pointed = MultiLine(**{**looks, "line_width": POINTED_WIDTH})
        thin = MultiLine(line_alpha=OTHERS_ALPHA, line_dash="stroke", **looks)
        self.beside = plot.add_glyph(self.others, thin, hover_glyph=pointed)
        where: dict[str, Any] = {"attachment": "horizontal", "point_policy": "follow_mouse", "limit": 1}
        plot.add_tools(tips([("@method", "start @start")], renderers=[self.beside], visible=False, **where))
        self.orbits = ColumnDataSource({name: [] for name in columns})
        self.curves = plot.add_glyph(self.orbits, MultiLine(line_dash="stroke", **looks))
        self.steps = ColumnDataSource({name: [] for name in ("x", "y", "colour")})
        plot.add_glyph(self.steps, Scatter(size=STEP_SIZE, fill_color="colour", line_color="white"))
        a_dot = Scatter(size=STEP_SIZE, fill_color=GREY, line_color="white")
        # In the legend, a dot on a curve as in the figure, but grey: those of each integrator have its colour.
        under = plot.line([np.nan], [np.nan], line_color=GREY, line_width=LEGEND_WIDTH)
        self.dots = [under, plot.add_glyph(unseen(("x", "y")), a_dot)]
        self.methods, self.keys = legend_lines(plot)
        self.jumps = ColumnDataSource({"x": [], "y": []})
        self.jump_lines = plot.add_glyph(self.jumps, Line(line_color=AMBER, line_dash=[8, 3, 2, 3], line_width=1.5))
        self.trails = ColumnDataSource({name: [] for name in ("xs", "ys", "colour", "dash", "width", "alpha")})
        looks |= {"line_alpha": "alpha", "line_dash": "dash"}
        plot.add_glyph(self.trails, MultiLine(**looks))  # under all marks and numbers

    def _crossing_glyphs(self) -> None:
        plot = self.figure
        self.crossings = unseen(
            ("x", "y", "label", "kind", "marker", "colour", "method", "number", "time", "start", "chosen", "size")
        )
        self.marks = Marks(plot, self.crossings)
        reach = plot.add_glyph(self.crossings, invisible(size=16))  # easier to hit than the mark
        self.hover = crossing_tips(reach, "time", "@method, start @start")
        plot.add_tools(self.hover)
        self._end_glyphs()
        self.pointed = ColumnDataSource({"x": [], "y": []})
        self.pointed_time = ColumnDataSource({"t": []})  # for figures whose horizontal axis is time
        self.played_time = ColumnDataSource({"t": []})  # likewise: where the player stands
        ring: dict[str, Any] = {"size": POINTED_SIZE, "fill_alpha": 0.0, "line_color": VERMILION, "line_width": 3}
        plot.add_glyph(self.pointed, Scatter(**ring))

    def _end_glyphs(self) -> None:
        plot = self.figure
        self.ends = unseen(("x", "y", "label", "marker", "colour", "method", "time", "kind", "start"))
        # White inside: through a hollow mark, runs that end there from both sides would look joined.
        look: dict[str, Any] = {"marker": "marker", "fill_color": "white", "line_color": "colour", "line_width": 2}
        self.stops = plot.add_glyph(self.ends, Scatter(size=END_SIZE, **look))
        rows = [("@kind", "t = @time{9}"), ("of", "@method, start @start")]
        plot.add_tools(tips(rows, renderers=[self.stops], attachment="horizontal", visible=False, limit=2))

    def _start_glyphs(self) -> None:
        plot = self.figure
        columns = ("x", "y", "number", "crowd", "size", "fill", "chosen", "heard")
        self.starts = unseen(columns)
        look: dict[str, Any] = {"size": "size", "fill_color": "fill", "line_color": AMBER, "line_width": 1.2}
        self.stars = plot.add_glyph(self.starts, Scatter(marker="star", **look))
        letters: dict[str, Any] = {"text_color": "black", "text_font_size": "10px", "text_font_style": "bold"}
        centred: dict[str, Any] = {"text_align": "center", "text_baseline": "middle", "y_offset": 1}
        plot.add_glyph(self.starts, Text(text="number", **letters, **centred))
        above: dict[str, Any] = {"text_align": "center", "text_baseline": "bottom", "y_offset": -9}
        ground: dict[str, Any] = {"background_fill_color": GROUND, "background_fill_alpha": 0.8, "padding": 1}
        named: dict[str, Any] = {"text_font_size": "12px", "text_color": AMBER}
        plot.add_glyph(self.starts, Text(text="crowd", **{**letters, **named}, **above, **ground))
        self.alongside = unseen(("x", "y", "size", "label", "align", "baseline", "dx", "dy"))
        look = {"size": "size", "fill_color": PALE_STAR, "line_color": AMBER, "line_width": 1.2}
        plot.add_glyph(self.alongside, Scatter(marker="circle", **look))
        place: dict[str, Any] = {"text_align": "align", "text_baseline": "baseline", "x_offset": "dx", "y_offset": "dy"}
        plot.add_glyph(self.alongside, Text(text="label", **{**letters, **named}, **place, **ground))
        self.moving = ColumnDataSource({name: [] for name in ("x", "y", "colour", "marker", "size", "alpha")})
        look = {"size": "size", "fill_color": "colour", "fill_alpha": "alpha", "line_color": "white", "line_width": 1.5}
        plot.add_glyph(self.moving, Scatter(marker="marker", **look))
        self.corners = fit_to_corners(plot, [-1.0, 1.0], [-1.0, 1.0])

    def _add_legend(self) -> None:
        entries = legend_below(
            self.figure,
            [
                ({"field": "method"}, self.keys),
                ("step", self.dots),
                ("start", self.stars),
                ({"field": "label"}, self.marks.key),
                ({"field": "label"}, self.stops),
                ("reset", self.jump_lines),
                *self.ground.legend,
            ],
            usual=2,
            folding=self.ground.additional,
        )
        self._step_entry, self._reset_entry = entries[1], entries[5]
        self._step_entry.visible = self._reset_entry.visible = False
        marks = [self.starts, self.alongside, self.crossings, self.ends]
        self.ground.follow(entries[-len(self.ground.legend) :], marks, [self.orbits, self.others])

    def _watch_window(
        self, on_window: Callable[[Window], None], on_zoom: Callable[[Window], None], on_fit: Callable[[], None]
    ) -> None:
        across, up = ranges(self.figure)

        def tell(_attribute: str, _old: object, _new: object) -> None:
            bounds = np.array([across.start, across.end, up.start, up.end], dtype=float)
            if np.isfinite(bounds).all():
                self._visible = Window(*bounds.tolist())
                self._label_marks()
                on_window(self._visible)

        for axis in (across, up):
            axis.on_change("start", tell)
            axis.on_change("end", tell)

        def zoom(event: Event) -> None:
            ends = np.array([event.x0, event.x1, event.y0, event.y1] if isinstance(event, RangesUpdate) else [], float)
            if len(ends) and np.isfinite(ends).all():
                on_zoom(Window(*ends.tolist()))

        follow = CustomJS(args={"corners": self.corners, "ranges": [across, up]}, code=FOLLOW)
        self.figure.js_on_event(RangesUpdate, follow)
        self.figure.on_event(RangesUpdate, zoom)
        self.figure.on_event(Reset, lambda _event: on_fit())

    # Gestures --------------------------------------------------------------------------------------------------------

    def _watch_gestures(self, on_place: Callable[[float, float], None]) -> None:
        def place(event: Event) -> None:
            if not isinstance(event, PointEvent) or event.x is None or event.y is None:
                return
            x, y = float(event.x), float(event.y)
            if self._visible is None or self._visible.holds(np.array([[x, y]])).all():  # else the click was on an axis
                on_place(x, y)

        self.figure.on_event(Tap, place)
        self.hand = attach_gestures(self.figure, self.starts)
        attach_touch(self.figure)
        self.hand.on_change("data", lambda _attribute, _old, new: self._handle_gesture(new))

    def _handle_gesture(self, said: dict[str, Sequence[Any]]) -> None:
        """Pass on a gesture that the browser reports."""
        act, index, x, y, self._heard = (said[name][0] for name in ("act", "index", "x", "y", "count"))
        if act in self._acts and 0 <= index < len(self.starts.data["x"]) and math.isfinite(x) and math.isfinite(y):
            self._acts[act](int(index), float(x), float(y))

    # What is drawn ---------------------------------------------------------------------------------------------------

    def show_orbits(
        self, system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
    ) -> None:
        """Draw the trajectories; the view stays as it is.

        Parameters
        ----------
        system : core.PiecewiseSystem
            The system.
        pictures : Pictures
            The curves, in their plane.
        starts : sequence of (float, float)
            The present starts in that plane; the user may have moved them since the curves were submitted.
        selected : int
            Index of the selected start.
        """
        self._name(system, pictures.plane)
        view = self._visible or self.frame
        self.orbits.data = curve_columns(pictures.orbits, view, selected_shares(pictures))
        self._show_methods()
        thin = curve_columns(pictures.thin, view, thin_shares(pictures))
        assign(self.others, **thin, start=starts_of_thin(pictures))
        marked = crossing_columns(pictures.numbered, pictures.inputs.index + 1)
        self.marks.name(marked)
        assign(self.crossings, **marked)
        assign(self.ends, **end_columns(pictures.numbered, self._visible or self.frame))
        steps = step_columns([*pictures.orbits, *pictures.thin])
        assign(self.steps, **steps)
        omitted = any(orbit.more_steps for orbit in (*pictures.orbits, *pictures.thin))
        self._step_entry.update(visible=len(steps["x"]) > 0, label=value("step (first ones)" if omitted else "step"))
        jumps = np.concatenate([orbit.jumps for orbit in (*pictures.orbits, *pictures.thin)])
        assign(self.jumps, x=jumps[:, 0], y=jumps[:, 1])
        self._reset_entry.visible = self.joins_jumps
        assign(self.alongside, **alongside_columns(system, pictures, view))
        self.show_starts(starts, selected)
        describe(self.figure, portrait_text(system, pictures, starts, selected))
        self._pictures = pictures

    @property
    def joins_jumps(self) -> bool:
        """Whether lines join states before and after jumps: not where jumps leave the drawn coordinates alone."""
        x, y = (np.asarray(self.jumps.data[name], dtype=float) for name in "xy")
        return bool((np.hypot(np.diff(x), np.diff(y)) > 0).any())

    @property
    def marks_steps(self) -> bool:
        """Whether steps are marked, between which curves are interpolated: only where they are long."""
        return len(self.steps.data["x"]) > 0

    def show_ground(
        self, system: core.PiecewiseSystem, backdrop: Backdrop, window: Window, starts: Sequence[tuple[float, float]]
    ) -> None:
        """Draw what is known of a system of two variables before any trajectory is: field, surface and starts."""
        self._name(system, XY)
        marked = crossing_columns([], 1)
        self.marks.name(marked)
        assign(self.crossings, **marked)
        assign(self.ends, **end_columns([]))
        self.look_at(window)
        self.show_starts(starts, 0)
        self.show_backdrop(backdrop)

    def show_starts(self, starts: Sequence[tuple[float, float]], selected: int) -> None:
        """Put the stars at the starts; after a refused move this puts its star back."""
        chosen = [k == selected for k in range(len(starts))]
        numbers, crowds = star_labels(starts, self._visible or self.frame)
        assign(
            self.starts,
            x=[float(x) for x, _ in starts],
            y=[float(y) for _, y in starts],
            number=numbers,
            crowd=crowds,
            size=_star_sizes(numbers, chosen),
            fill=[STAR if it else PALE_STAR for it in chosen],
            chosen=chosen,
            heard=[self._heard] * len(starts),  # sent after each gesture: the browser may have moved them by itself
        )
        self.ground.keep_clear()

    def _label_marks(self) -> None:
        """Fit numbers of stars, names of ends and looks of curves to what the view tells apart."""
        if self._pictures is not None:
            self._fit_curves(self._pictures)
            ends = end_columns(self._pictures.numbered, self._visible or self.frame)
            if ends["label"] and ends["label"] != list(self.ends.data["label"]):
                assign(self.ends, **ends)
        x, y = self.starts.data["x"], self.starts.data["y"]
        numbers, crowds = star_labels(list(zip(x, y, strict=True)), self._visible or self.frame)
        if self._pictures is not None and crowds != list(self.starts.data["crowd"]):
            sizes = _star_sizes(numbers, list(self.starts.data["chosen"]))
            self.starts.data = {**self.starts.data, "number": numbers, "crowd": crowds, "size": sizes}

    def _fit_curves(self, pictures: Pictures) -> None:
        """Give the curves the widths and strokes that suit the view, without sending the curves."""
        view = self._visible or self.frame
        strong, thin = selected_shares(pictures), thin_shares(pictures)
        for source, orbits, shares in ((self.orbits, pictures.orbits, strong), (self.others, pictures.thin, thin)):
            for name, column in fitted(orbits, view, shares).items():
                if len(column) == len(source.data[name]) and column != list(source.data[name]):
                    source.patch({name: list(enumerate(column))})
        self._show_methods()

    def _show_methods(self) -> None:
        """Name the integrators in the legend, each with the stroke of its curve."""
        methods = self.orbits.data["method"]
        show_methods(self.methods, methods, dict(zip(methods, map(list, self.orbits.data["stroke"]), strict=True)))

    def _name(self, system: core.PiecewiseSystem, plane: Plane) -> None:
        """Label the axes, and show only what is drawn in the legend; each change rebuilds parts of the figure."""
        if self._named == (system, plane):
            return
        self._named = system, plane
        self.figure.xaxis.axis_label, self.figure.yaxis.axis_label = axis_labels(system, plane)
        a, b = plane.axes
        self._names = variable_name(system.variables[a]), variable_name(system.variables[b])
        self.ground.name(system)

    def fit(self) -> None:
        """Let the view show the trajectories drawn last."""
        if self._pictures is not None:
            self.look_at(with_room(self._pictures.system, extent(self._pictures).scaled(ROOM)))

    def look_at(self, window: Window) -> None:
        """Let the view show at least this part of the plane, as large as the screen and equal scales allow."""
        self.frame, self._visible = window, None
        assign(self.corners, x=[window.x_low, window.x_high], y=[window.y_low, window.y_high])
        for axis in ranges(self.figure):  # zoom in as far as floats resolve, and out as far as is useful
            axis.min_interval = 1e-9 * power_of_ten(max(map(abs, window)))
            axis.max_interval = 1e4 * power_of_ten(max(window.width, window.height))
        refit(self.figure)
        self._label_marks()

    def show_backdrop(self, backdrop: Backdrop) -> None:
        """Draw the backdrop of the orbits."""
        curves = [] if self._pictures is None else [orbit.path for orbit in self._pictures.orbits]
        self.ground.show(backdrop, self._names, self._visible or self.frame or backdrop.window, curves)
