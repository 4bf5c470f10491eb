"""The phase portrait: orbits over the sides, the surface, the field and the level sets of ψ.

Stars stand where the trajectories start. They are placed, chosen, dragged and removed by hand, with mouse or finger;
the browser moves them (`gestures`), and tells the server where to.
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
from pwsviz.figures.style import (
    GREEN,
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
from pwsviz.results.results import Orbit, Pictures

KIND_MARKERS = {
    "transversal": "circle", "grazing": "diamond", "sliding": "square", "repelling": "triangle", "jump": "hex",
}  # fmt: skip
KIND_COLOURS = {
    "transversal": PURPLE, "grazing": VERMILION, "sliding": GREEN, "repelling": GREEN, "jump": ORANGE,
}  # fmt: skip
"""Besides the markers; those of one colour never meet at one crossing."""

PALE_STAR = "#F7DDA2"
"""Of the other starts than the selected one; a black number is legible on it as on the other."""

RIM = "#9A6700"
"""Around the stars; black would be lost on a dark page."""

NEAR = 1.2
"""How far out, in sizes of the first orbit, another integrator's may still widen the view."""

OTHERS = 3.0
"""How far out trajectories from other starts may."""

SUMMARY = "Phase portrait"

POINTED_SIZE = 19
"""Pixels across the ring around the crossing pointed at: a mark, and some room."""


class PortraitView:
    """One fixed figure; `show_orbits` and `show_backdrop` only change its data.

    Parameters
    ----------
    on_window : callable
        Told the part of the plane on the screen whenever that changes.
    on_place : callable
        Told where (x, y) the person clicked on empty ground.
    on_move : callable
        Told which start (from 0) was dragged where (x, y): some twenty times a second on the way, and at the end.
        Who refuses a move calls `show_starts`, or the star stays where it was dropped.
    on_remove, on_select : callable
        Told which start is to go, or to be selected.

    Attributes
    ----------
    frame : Window or None
        What the view is fitted to, unless the person has zoomed.
    covered : Window or None
        The part of the plane the backdrop covers.
    dragging : bool
        Whether a star is under the person's hand; the view then stays as it is.
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
        self._ground: Backdrop | None = None
        self._visible: Window | None = None
        self._heard = 0
        self._acts: dict[str, Callable[[int, float, float], None]] = {
            "drag": on_move,
            "drop": on_move,
            "remove": lambda index, _x, _y: on_remove(index),
            "select": lambda index, _x, _y: on_select(index),
        }
        self._ground_glyphs()
        self._orbit_glyphs()
        self._crossing_glyphs()
        self._start_glyphs()
        self._add_legend()
        self._watch_window(on_window)
        self._watch_hand(on_place)

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

    def _ground_glyphs(self) -> None:
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
        self.jumps = _line_source()
        self.jump_lines = plot.line("x", "y", source=self.jumps, color=ORANGE, line_dash=[2, 4], line_width=2)

    def _crossing_glyphs(self) -> None:
        plot = self.figure
        columns = ("x", "y", "label", "kind", "marker", "colour", "method", "number", "time")
        self.crossings = unseen(columns)
        self.marks = plot.scatter(
            "x", "y", source=self.crossings, marker="marker", size=7, fill_color="white", line_color="colour",
            line_width=2,
        )  # fmt: skip
        reach = plot.scatter("x", "y", source=self.crossings, size=16, alpha=0.0)  # a mark is small to hit
        self.hover = HoverTool(
            renderers=[reach],
            tooltips=[
                ("crossing", "@number"), ("time", "@time{%.9g}"), ("kind", "@kind"), ("integrator", "@method"),
            ],
            formatters={"@time": "printf"}, attachment="above", visible=False, limit=3,
        )  # fmt: skip
        plot.add_tools(self.hover)
        self.pointed = ColumnDataSource({"x": [], "y": []})
        ring: dict[str, Any] = {"size": POINTED_SIZE, "fill_alpha": 0.0, "line_color": VERMILION, "line_width": 3}
        plot.scatter("x", "y", source=self.pointed, **ring)

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

    # The hand --------------------------------------------------------------------------------------------------------

    def _watch_hand(self, on_place: Callable[[float, float], None]) -> None:
        def place(event: Event) -> None:
            if not isinstance(event, PointEvent) or event.x is None or event.y is None:
                return
            x, y = float(event.x), float(event.y)
            if self._visible is None or self._visible.holds(np.array([[x, y]])).all():  # else on an axis
                on_place(x, y)

        self.figure.on_event(Tap, place)
        self.hand = attach_gestures(self.figure, self.starts)
        self.hand.on_change("data", lambda _attribute, _old, new: self._obey(new))

    def _obey(self, said: dict[str, Sequence[Any]]) -> None:
        """Pass on what the browser says the hand has done."""
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
        """Draw the trajectories, fit the view if it no longer suits them, and return the part of the plane to cover.

        Parameters
        ----------
        system : core.PiecewiseSystem
            Whose they are.
        pictures : Pictures
            Their curves, in the plane of ``pictures.inputs.axes``.
        starts : sequence of (float, float)
            Where in that plane all trajectories start by now; the person may have gone on meanwhile.
        selected : int
            Which of them is selected.
        """
        axes = pictures.inputs.axes
        self._name(system, axes)
        self.orbits.data = _curves(pictures.orbits)
        self.others.data = _curves(pictures.others, thinner=0.5)
        self._show_crossings(pictures.orbits)
        self.jumps.data = _columns(np.concatenate([orbit.jumps for orbit in (*pictures.orbits, *pictures.others)]))
        self.show_starts(starts, selected)
        describe(self.figure, portrait_text(system, pictures, starts, selected))
        self._box = extent(pictures.orbits, pictures.others)
        return self._fit((pictures.inputs.selected[0].ground.declaration, axes), self._box)

    def _show_crossings(self, orbits: Sequence[Orbit]) -> None:
        kinds = [kind for orbit in orbits for kind in orbit.kinds]
        marks = np.concatenate([orbit.crossings for orbit in orbits])
        assign(
            self.crossings,
            x=marks[:, 0],
            y=marks[:, 1],
            **kind_columns(kinds),
            method=[orbit.method for orbit in orbits for _ in orbit.kinds],
            number=np.concatenate([orbit.numbers for orbit in orbits]),
            time=np.concatenate([orbit.times for orbit in orbits]),
        )

    def show_starts(self, starts: Sequence[tuple[float, float]], selected: int) -> None:
        """Put the stars where the trajectories start: also where a move was refused, to bring its star back."""
        chosen = [k == selected for k in range(len(starts))]
        self.starts.data = {  # sent if the hand said anything since: it may have moved them in the browser alone
            "x": [float(x) for x, _ in starts],
            "y": [float(y) for _, y in starts],
            "number": [str(k + 1) for k in range(len(starts))],
            "size": [26 if it else 21 for it in chosen],
            "fill": [ORANGE if it else PALE_STAR for it in chosen],
            "chosen": chosen,
            "heard": [self._heard] * len(starts),
        }

    def _name(self, system: core.PiecewiseSystem, axes: Axes) -> None:
        """Say what is on the axes, and name in the legend only what is there."""
        self.figure.xaxis.axis_label, self.figure.yaxis.axis_label = axis_labels(system, axes)
        self.surface_entry.label = value(surface_name(system))
        self.surface_entry.visible = self.tint_entry.visible = shows_surface(system, axes)

    def _fit(self, what: Hashable, box: Window) -> Window:
        """Keep a view that holds the orbits at a fair size, or is held itself; else take a new one.

        A new system, or another plane, always gets its own.
        """
        news = what != self._fitted_to
        if self.frame is None or news or not (self.dragging or _holds(self.frame, box)):
            self.frame, self._fitted_to = box, what
            assign(self.corners, x=[box.x_low, box.x_high], y=[box.y_low, box.y_high])
            for axis in ranges(self.figure):  # as far as digits tell points apart, and no farther out than is of use
                axis.min_interval = 1e-9 * _power_of_ten(max(map(abs, box)))
                axis.max_interval = 1e4 * _power_of_ten(max(box.width, box.height))
        if news:
            refit(self.figure)
        return self.frame

    def show_backdrop(self, ground: Backdrop) -> None:
        """Draw what lies under the orbits."""
        if ground is self._ground:
            return
        self._ground, self.covered = ground, ground.window
        self.side.data = {
            "xs": [[[ring[:, 0] for ring in (outer, *holes)]] for outer, holes in _polygons(ground)],
            "ys": [[[ring[:, 1] for ring in (outer, *holes)]] for outer, holes in _polygons(ground)],
        }
        self.surface.data = _columns(ground.surface)
        for side in SIDES:
            self.levels[side].data = _columns(ground.levels[side])
            self.orbit_levels[side].data = _columns(ground.orbit_levels[side])
            self.arrows[side].data = _columns(ground.arrows[side])


def kind_columns(kinds: Sequence[str]) -> dict[str, Sequence[str]]:
    """Return the columns of crossings of these kinds that say how each is marked; "crossing" is any kind, unsaid."""
    return {
        "label": ["crossing" if kind == "transversal" else kind for kind in kinds],
        "kind": kinds,
        "marker": [KIND_MARKERS.get(kind, "circle") for kind in kinds],
        "colour": [KIND_COLOURS.get(kind, PURPLE) for kind in kinds],
    }


def portrait_text(
    system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
) -> str:
    """Return what the portrait shows, in a sentence for those who cannot see it."""
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
    """Return the box that shows the first orbit whole, closed surfaces of its size, and the others near it.

    Parameters
    ----------
    orbits : sequence of Orbit
        One for each integrator, from the selected start.
    others : sequence of Orbit
        The same from the other starts, start by start. Another start counts farther out than another integrator.
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


def _holds(frame: Window, box: Window) -> bool:
    """Whether the box is inside the frame, to a hair, and not much smaller in either direction."""
    room = frame.scaled(1.06)
    return room.covers(box) and min(box.width / frame.width, box.height / frame.height) >= 0.4


def _power_of_ten(size: float) -> float:
    """The size's order of magnitude: bounds on a range that change seldom, as every change refits the view."""
    return 10.0 ** math.floor(math.log10(size))


def _polygons(ground: Backdrop) -> list[tuple[Floats, list[Floats]]]:
    return list(zip(ground.minus_outer, ground.minus_holes, strict=True))


def _line_source() -> ColumnDataSource:
    return ColumnDataSource({"x": [], "y": []})


def _columns(points: Floats) -> dict[str, Floats]:
    return {"x": points[:, 0], "y": points[:, 1]}
