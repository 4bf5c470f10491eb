"""The phase portrait: orbits over the sides, the surface, the field and the level sets of ψ."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Tap
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.plotting import figure

import core
from pwsviz.curves import Floats
from pwsviz.plane import Backdrop, Window
from pwsviz.projection import axis_labels, shows_surface, surface_name
from pwsviz.results import Orbit
from pwsviz.style import GREY, ORANGE, PURPLE, SIDES, assign, fit_to, legend_below, line_of, plain_figure, ranges, refit

KIND_MARKERS = {
    "transversal": "circle", "grazing": "diamond", "sliding": "square", "repelling": "triangle", "jump": "hex",
}  # fmt: skip
NEAR = 1.2
"""How far out, in sizes of the first orbit, another may still widen the view."""


class PortraitView:
    """One fixed figure; `show_orbits` and `show_backdrop` only change its data.

    Parameters
    ----------
    on_window : callable
        Told the part of the plane on the screen whenever that changes.
    on_tap : callable
        Told where the person clicked.

    Attributes
    ----------
    frame : Window or None
        What the view is fitted to, unless the person has zoomed.
    covered : Window or None
        The part of the plane the backdrop covers.
    """

    def __init__(self, on_window: Callable[[Window], None], on_tap: Callable[[float, float], None]) -> None:
        self.figure = self._plot()
        self.frame: Window | None = None
        self.covered: Window | None = None
        self._system = ""
        self._ground: Backdrop | None = None
        self._ground_glyphs()
        self._orbit_glyphs()
        self._add_legend()
        self.figure.on_event(Tap, lambda event: on_tap(event.x, event.y))
        self._watch_window(on_window)

    @staticmethod
    def _plot() -> figure:
        plot = plain_figure(
            "Phase portrait: trajectories, the switching surface, directions of the field and level sets",
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
        self.orbits = ColumnDataSource({name: [] for name in columns})
        self.curves = plot.multi_line(
            "xs", "ys", source=self.orbits, color="colour", line_dash="dash", line_width="width", line_join="round"
        )
        self.jumps = _line_source()
        self.jump_lines = plot.line("x", "y", source=self.jumps, color=ORANGE, line_dash=[2, 4], line_width=2)
        self.crossings = ColumnDataSource({name: [] for name in ("x", "y", "kind", "marker")})
        self.marks = plot.scatter(
            "x",
            "y",
            source=self.crossings,
            marker="marker",
            size=7,
            fill_color="white",
            line_color=PURPLE,
            line_width=2,
        )
        self.starts = ColumnDataSource({"x": [], "y": []})
        self.start = plot.scatter(
            "x", "y", source=self.starts, marker="star", size=15, color=ORANGE, line_color="black", line_width=0.7
        )
        self.corners = ColumnDataSource({"x": [-1.0, 1.0], "y": [-1.0, 1.0]})
        frame = plot.scatter("x", "y", source=self.corners, alpha=0.0, size=1)
        fit_to(plot, frame)

    def _add_legend(self) -> None:
        *_, self.surface_entry, self.tint_entry = legend_below(
            self.figure,
            3,
            [
                ({"field": "method"}, self.curves),
                ("start", self.start),
                ({"field": "kind"}, self.marks),
                ("S: g = 0", self.surface_line),
                ("g < 0", self.tint),
            ],
        )

    def _watch_window(self, on_window: Callable[[Window], None]) -> None:
        across, up = ranges(self.figure)

        def tell(_attribute: str, _old: object, _new: object) -> None:
            bounds = np.array([across.start, across.end, up.start, up.end], dtype=float)
            if np.isfinite(bounds).all():
                on_window(Window(*bounds.tolist()))

        for axis in (across, up):
            axis.on_change("start", tell)
            axis.on_change("end", tell)

    def show_orbits(self, system: core.PiecewiseSystem, orbits: Sequence[Orbit]) -> Window:
        """Draw the trajectories, fit the view if it no longer suits them, and return the part of the plane to cover."""
        self._name(system)
        lines = [line_of(orbit.method) for orbit in orbits]
        self.orbits.data = {
            "xs": [orbit.path[:, 0] for orbit in orbits],
            "ys": [orbit.path[:, 1] for orbit in orbits],
            "method": [orbit.method for orbit in orbits],
            "colour": [line.colour for line in lines],
            "dash": [list(line.dash) for line in lines],
            "width": [line.width for line in lines],
        }
        marks = np.concatenate([orbit.crossings for orbit in orbits])
        kinds = [kind for orbit in orbits for kind in orbit.kinds]
        assign(
            self.crossings,
            x=marks[:, 0],
            y=marks[:, 1],
            kind=["crossing" if kind == "transversal" else kind for kind in kinds],
            marker=[KIND_MARKERS.get(kind, "cross") for kind in kinds],
        )
        assign(self.starts, x=[orbits[0].x0[0]], y=[orbits[0].x0[1]])
        jumps = np.concatenate([orbit.jumps for orbit in orbits])
        self.jumps.data = _columns(jumps)
        return self._fit(system.name, extent(orbits))

    def _name(self, system: core.PiecewiseSystem) -> None:
        """Say what is on the axes, and name in the legend only what is there."""
        self.figure.xaxis.axis_label, self.figure.yaxis.axis_label = axis_labels(system)
        self.surface_entry.label = value(surface_name(system))
        self.surface_entry.visible = self.tint_entry.visible = shows_surface(system)

    def _fit(self, system: str, box: Window) -> Window:
        """Keep a view that holds the orbits at a fair size; else take a new one. A new system always gets its own."""
        new_system = system != self._system
        if self.frame is None or new_system or not _holds(self.frame, box):
            self.frame, self._system = box, system
            assign(self.corners, x=[box.x_low, box.x_high], y=[box.y_low, box.y_high])
            for axis in ranges(self.figure):  # as far as digits tell points apart, and no farther out than is of use
                axis.min_interval = 1e-9 * _power_of_ten(max(map(abs, box)))
                axis.max_interval = 1e4 * _power_of_ten(max(box.width, box.height))
        if new_system:
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


def extent(orbits: Sequence[Orbit]) -> Window:
    """Return the box that shows the first orbit whole, closed surfaces of its size, and the others near it."""
    first = Window.around(np.concatenate([orbits[0].path, orbits[0].surface]))
    points = np.concatenate([*(orbit.path for orbit in orbits), orbits[0].surface])
    return Window.around(points[first.scaled(NEAR).holds(points)])


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
