"""The phase portrait: orbits over the sides, the surface, the field and the level sets of ψ.

Stars mark the starts of the trajectories. The user places, selects, drags and removes them with mouse or finger; the
browser moves them (see `gestures`), and reports the new places to the server.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Event, PointEvent, Tap
from bokeh.models import ColumnDataSource, DataRange1d, HoverTool
from bokeh.plotting import figure

import core
from pwsviz.figures.gestures import attach_gestures
from pwsviz.figures.marks import crossing_columns, end_columns
from pwsviz.figures.style import (
    GREY,
    ORANGE,
    PURPLE,
    SIDES,
    VERMILION,
    assign,
    describe,
    fit_to_corners,
    legend_below,
    line_of,
    plain_figure,
    ranges,
    refit,
    unseen,
)
from pwsviz.geometry.phase_plane import Backdrop, Window
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import Axes, axis_labels, shows_surface, surface_name
from pwsviz.results.orbits import Orbit
from pwsviz.results.results import Pictures

PALE_STAR = "#F7DDA2"
"""Fill of the stars of other starts, on which a black number is legible."""

RIM = "#9A6700"
"""Outline of the stars; black would be lost on a dark page."""

NEAR = 1.2
"""Size, relative to the first orbit, of the window within which orbits of other integrators may widen the view."""

OTHERS = 3.0
"""The same for orbits from other starts."""

SUMMARY = "Phase portrait"

END_SIZE = 15
"""Diameter in pixels of the mark of an end: wide enough that two runs which end at one place do not look joined."""

STEP_SIZE = 3.5
"""Diameter in pixels of the dot at the end of a step."""

POINTED_SIZE = 19
"""Diameter in pixels of the ring around the crossing under the pointer: a mark, and some room."""


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
    on_remove, on_select : callable
        Called with the index of the start to remove or to select.

    Attributes
    ----------
    frame : Window or None
        The part of the plane to which the view is fitted, unless the user has zoomed.
    covered : Window or None
        The part of the plane the backdrop covers.
    dragging : bool
        Whether a star is being dragged; the view then stays as it is.
    """

    def __init__(
        self,
        on_window: Callable[[Window], None],
        on_place: Callable[[float, float], None],
        on_move: Callable[[int, float, float], None],
        on_remove: Callable[[int], None],
        on_select: Callable[[int], None],
    ) -> None:
        self.figure = self._plot()
        self.frame: Window | None = None
        self.covered: Window | None = None
        self.dragging = False
        self._fitted_to: Hashable = None
        self._box: Window | None = None
        self._backdrop: Backdrop | None = None
        self._visible: Window | None = None
        self._heard = 0
        self._acts: dict[str, Callable[[int, float, float], None]] = {
            "drag": on_move,
            "drop": on_move,
            "remove": lambda index, _x, _y: on_remove(index),
            "select": lambda index, _x, _y: on_select(index),
        }
        self._backdrop_glyphs()
        self._orbit_glyphs()
        self._crossing_glyphs()
        self._start_glyphs()
        self._add_legend()
        self._watch_window(on_window)
        self._watch_gestures(on_place)

    @staticmethod
    def _plot() -> figure:
        plot = plain_figure(
            SUMMARY,
            match_aspect=True,
            x_range=DataRange1d(range_padding=0.08),
            y_range=DataRange1d(range_padding=0.08),
            active_drag="pan",
            active_scroll="wheel_zoom",
        )
        plot.grid.visible = False
        return plot

    def _backdrop_glyphs(self) -> None:
        plot = self.figure
        self.side = ColumnDataSource({"xs": [], "ys": []})
        self.tint = plot.multi_polygons("xs", "ys", source=self.side, color=SIDES[-1], alpha=0.13, line_width=0)
        self.levels, self.orbit_levels, self.arrows = {}, {}, {}
        for side, colour in SIDES.items():
            self.levels[side], self.orbit_levels[side], self.arrows[side] = (_line_source() for _ in range(3))
            plot.line("x", "y", source=self.levels[side], color=colour, alpha=0.45, line_width=1)
            plot.line("x", "y", source=self.orbit_levels[side], color=colour, alpha=0.9, line_width=1.5)
            plot.line("x", "y", source=self.arrows[side], color=GREY, alpha=0.75, line_width=1)
        self.surface = _line_source()
        self.surface_line = plot.line("x", "y", source=self.surface, color=PURPLE, line_width=2.5)

    def _orbit_glyphs(self) -> None:
        plot = self.figure
        columns = ("xs", "ys", "method", "colour", "dash", "width")
        looks: dict[str, Any] = {"color": "colour", "line_dash": "dash", "line_width": "width", "line_join": "round"}
        self.others = ColumnDataSource({name: [] for name in columns})
        plot.multi_line("xs", "ys", source=self.others, alpha=0.55, **looks)
        self.orbits = ColumnDataSource({name: [] for name in columns})
        self.curves = plot.multi_line("xs", "ys", source=self.orbits, **looks)
        self.steps = ColumnDataSource({name: [] for name in ("x", "y", "colour")})
        plot.scatter("x", "y", source=self.steps, size=STEP_SIZE, color="colour")
        self.jumps = _line_source()
        self.jump_lines = plot.line("x", "y", source=self.jumps, color=ORANGE, line_dash=[2, 4], line_width=2)

    def _crossing_glyphs(self) -> None:
        plot = self.figure
        self.crossings = unseen(
            ("x", "y", "label", "kind", "marker", "colour", "method", "number", "time", "start", "chosen", "size")
        )
        self.marks = plot.scatter(
            "x", "y", source=self.crossings, marker="marker", size="size", fill_color="white", line_color="colour",
            line_width=2,
        )  # fmt: skip
        reach = plot.scatter("x", "y", source=self.crossings, size=16, alpha=0.0)  # easier to hit than the mark
        self.hover = HoverTool(
            renderers=[reach],
            tooltips=[
                ("crossing", "@number"), ("time", "@time{%.9g}"), ("kind", "@kind"), ("integrator", "@method"),
                ("start", "@start"),
            ],
            formatters={"@time": "printf"}, attachment="above", visible=False, limit=3,
        )  # fmt: skip
        plot.add_tools(self.hover)
        self._end_glyphs()
        self.pointed = ColumnDataSource({"x": [], "y": []})
        self.pointed_time = ColumnDataSource({"t": []})  # for figures whose horizontal axis is time
        ring: dict[str, Any] = {"size": POINTED_SIZE, "fill_alpha": 0.0, "line_color": VERMILION, "line_width": 3}
        plot.scatter("x", "y", source=self.pointed, **ring)

    def _end_glyphs(self) -> None:
        plot = self.figure
        self.ends = unseen(("x", "y", "label", "marker", "colour", "method", "time", "why", "start"))
        self.stops = plot.scatter(
            "x", "y", source=self.ends, marker="marker", size=END_SIZE, fill_color="white", line_color="colour",
            line_width=2,
        )  # fmt: skip
        plot.add_tools(
            HoverTool(
                renderers=[self.stops], attachment="above", visible=False, limit=3, formatters={"@time": "printf"},
                tooltips=[
                    ("stops at time", "@time{%.9g}"), ("as", "@why"), ("integrator", "@method"), ("start", "@start"),
                ],
            )
        )  # fmt: skip

    def _start_glyphs(self) -> None:
        plot = self.figure
        columns = ("x", "y", "number", "size", "fill", "chosen", "heard")
        self.starts = unseen(columns)
        self.stars = plot.scatter(
            "x", "y", source=self.starts, marker="star", size="size", fill_color="fill", line_color=RIM,
            line_width=1.2,
        )  # fmt: skip
        plot.text(
            "x", "y", "number", source=self.starts, text_align="center", text_baseline="middle", text_color="black",
            text_font_size="10px", text_font_style="bold", y_offset=1,
        )  # fmt: skip
        self.moving = ColumnDataSource({name: [] for name in ("x", "y", "colour", "marker", "size")})
        plot.scatter(
            "x", "y", source=self.moving, marker="marker", size="size", fill_color="colour", line_color="white",
            line_width=1.5,
        )  # fmt: skip
        self.corners = fit_to_corners(plot, [-1.0, 1.0], [-1.0, 1.0])

    def _add_legend(self) -> None:
        *_, self.surface_entry, self.tint_entry = legend_below(
            self.figure,
            3,
            [
                ({"field": "method"}, self.curves),
                ("start", self.stars),
                ({"field": "label"}, self.marks),
                ({"field": "label"}, self.stops),
                ("S: g = 0", self.surface_line),
                ("g < 0", self.tint),
            ],
        )

    def _watch_window(self, on_window: Callable[[Window], None]) -> None:
        across, up = ranges(self.figure)

        def tell(_attribute: str, _old: object, _new: object) -> None:
            bounds = np.array([across.start, across.end, up.start, up.end], dtype=float)
            if np.isfinite(bounds).all():
                self._visible = Window(*bounds.tolist())
                on_window(self._visible)

        for axis in (across, up):
            axis.on_change("start", tell)
            axis.on_change("end", tell)

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
        self.hand.on_change("data", lambda _attribute, _old, new: self._handle_gesture(new))

    def _handle_gesture(self, said: dict[str, Sequence[Any]]) -> None:
        """Pass on a gesture that the browser reports."""
        act, index, x, y, self._heard = (said[name][0] for name in ("act", "index", "x", "y", "count"))
        self.dragging = act == "drag"
        if act in self._acts and 0 <= index < len(self.starts.data["x"]) and math.isfinite(x) and math.isfinite(y):
            self._acts[act](int(index), float(x), float(y))
        if act == "drop" and self._box is not None:
            self._fit(self._fitted_to, self._box)

    # What is drawn ---------------------------------------------------------------------------------------------------

    def show_orbits(
        self, system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
    ) -> Window:
        """Draw the trajectories, fit the view if it no longer suits them, and return the part it is fitted to.

        Parameters
        ----------
        system : core.PiecewiseSystem
            The system.
        pictures : Pictures
            The curves, in the plane of ``pictures.inputs.axes``.
        starts : sequence of (float, float)
            The present starts in that plane; the user may have moved them since the curves were submitted.
        selected : int
            Index of the selected start.
        """
        axes = pictures.inputs.axes
        self._name(system, axes)
        self.orbits.data = _curves(pictures.orbits)
        self.others.data = _curves(pictures.others, thinner=0.5)
        assign(self.crossings, **crossing_columns(pictures.numbered, pictures.inputs.index + 1))
        self.ends.data = end_columns(pictures.numbered)
        self.steps.data = _step_columns([*pictures.orbits, *pictures.others])
        self.jumps.data = _columns(np.concatenate([orbit.jumps for orbit in (*pictures.orbits, *pictures.others)]))
        self.show_starts(starts, selected)
        describe(self.figure, portrait_text(system, pictures, starts, selected))
        self._box = extent(pictures.orbits, pictures.others)
        return self._fit((pictures.inputs.selected[0].problem.declaration, axes), self._box)

    def show_starts(self, starts: Sequence[tuple[float, float]], selected: int) -> None:
        """Put the stars at the starts; after a refused move this puts its star back."""
        chosen = [k == selected for k in range(len(starts))]
        self.starts.data = {  # sent after each gesture, as `heard` differs: the browser may have moved them by itself
            "x": [float(x) for x, _ in starts],
            "y": [float(y) for _, y in starts],
            "number": [str(k + 1) for k in range(len(starts))],
            "size": [26 if it else 21 for it in chosen],
            "fill": [ORANGE if it else PALE_STAR for it in chosen],
            "chosen": chosen,
            "heard": [self._heard] * len(starts),
        }

    def _name(self, system: core.PiecewiseSystem, axes: Axes) -> None:
        """Label the axes, and show only what is drawn in the legend."""
        self.figure.xaxis.axis_label, self.figure.yaxis.axis_label = axis_labels(system, axes)
        self.surface_entry.label = value(surface_name(system))
        self.surface_entry.visible = self.tint_entry.visible = shows_surface(system, axes)

    def _fit(self, what: Hashable, box: Window) -> Window:
        """Fit the view to `box`, unless a star is being dragged or the present view shows the box large enough.

        Another system, or another plane, always gets a new view.
        """
        news = what != self._fitted_to
        if self.frame is None or news or not (self.dragging or _holds(self.frame, box)):
            self.frame, self._fitted_to = box, what
            assign(self.corners, x=[box.x_low, box.x_high], y=[box.y_low, box.y_high])
            for axis in ranges(self.figure):  # zoom in as far as floats resolve, and out as far as is useful
                axis.min_interval = 1e-9 * _power_of_ten(max(map(abs, box)))
                axis.max_interval = 1e4 * _power_of_ten(max(box.width, box.height))
        if news:
            refit(self.figure)
        return self.frame

    def show_backdrop(self, backdrop: Backdrop) -> None:
        """Draw the backdrop of the orbits."""
        if backdrop is self._backdrop:
            return
        self._backdrop, self.covered = backdrop, backdrop.window
        self.side.data = {
            "xs": [[[ring[:, 0] for ring in (outer, *holes)]] for outer, holes in _polygons(backdrop)],
            "ys": [[[ring[:, 1] for ring in (outer, *holes)]] for outer, holes in _polygons(backdrop)],
        }
        self.surface.data = _columns(backdrop.surface)
        for side in SIDES:
            self.levels[side].data = _columns(backdrop.levels[side])
            self.orbit_levels[side].data = _columns(backdrop.orbit_levels[side])
            self.arrows[side].data = _columns(backdrop.arrows[side])


def portrait_text(
    system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
) -> str:
    """Return what the portrait shows, in sentences for screen readers."""
    across, up = (system.variables[k] for k in pictures.inputs.axes)
    x, y = starts[selected]
    count = len(starts)
    which = "one trajectory, which starts" if count == 1 else f"{count} trajectories; number {selected + 1} starts"
    crossed = "; ".join(
        f"{one.method} crosses the surface {one.crossings} time{'s' * (one.crossings != 1)}"
        for one in pictures.summaries
    )
    return f"{SUMMARY} of {system.name}, {up} against {across}: {which} at ({x:.4g}, {y:.4g}). {crossed}."


def extent(orbits: Sequence[Orbit], others: Sequence[Orbit] = ()) -> Window:
    """Return the box of the first orbit, closed surfaces of comparable size, and the orbits near it.

    Parameters
    ----------
    orbits : sequence of Orbit
        One for each integrator, from the selected start.
    others : sequence of Orbit
        The same from the other starts, start by start. Those of the first integrator count, farther out (`OTHERS`)
        than the orbits of other integrators (`NEAR`).
    """
    first = Window.around(np.concatenate([orbits[0].path, orbits[0].surface]))
    points = np.concatenate([*(orbit.path for orbit in orbits), orbits[0].surface])
    there = np.concatenate([np.empty((0, 2)), *(orbit.path for orbit in others[:: len(orbits)])])
    near, far = first.scaled(NEAR).holds(points), first.scaled(OTHERS).holds(there)
    return Window.around(np.concatenate([points[near], there[far]]))


def _curves(orbits: Sequence[Orbit], thinner: float = 1.0) -> dict[str, list[Any]]:
    lines = [line_of(orbit.method) for orbit in orbits]
    return {
        "xs": [orbit.path[:, 0] for orbit in orbits],
        "ys": [orbit.path[:, 1] for orbit in orbits],
        "method": [orbit.method for orbit in orbits],
        "colour": [line.colour for line in lines],
        "dash": [list(line.dash) for line in lines],
        "width": [thinner * line.width for line in lines],
    }


def _step_columns(orbits: Sequence[Orbit]) -> dict[str, Any]:
    dots = np.concatenate([orbit.steps for orbit in orbits])
    colours = [line_of(orbit.method).colour for orbit in orbits for _ in orbit.steps]
    return {"x": dots[:, 0], "y": dots[:, 1], "colour": colours}


def _holds(frame: Window, box: Window) -> bool:
    """Whether the box lies in the frame, enlarged by 6 %, and has at least 40 % of its width and height."""
    room = frame.scaled(1.06)
    return room.covers(box) and min(box.width / frame.width, box.height / frame.height) >= 0.4


def _power_of_ten(size: float) -> float:
    """Return the power of ten below a size: bounds of a range should change seldom, as each change refits the view."""
    return 10.0 ** math.floor(math.log10(size))


def _polygons(backdrop: Backdrop) -> list[tuple[Floats, list[Floats]]]:
    return list(zip(backdrop.minus_outer, backdrop.minus_holes, strict=True))


def _line_source() -> ColumnDataSource:
    return ColumnDataSource({"x": [], "y": []})


def _columns(points: Floats) -> dict[str, Floats]:
    return {"x": points[:, 0], "y": points[:, 1]}
