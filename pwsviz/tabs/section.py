"""The tab of the Poincaré section and its return map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import panel as pn
import panel_material_ui as pmui
from bokeh.plotting import figure

from pwsviz.export.files import Table
from pwsviz.export.script import section_program
from pwsviz.figures.section import SectionView
from pwsviz.figures.section_prospects import prospects
from pwsviz.figures.section_text import section_how, section_rows, section_text, section_warnings
from pwsviz.geometry.projection import surface_texts
from pwsviz.geometry.section_crossings import is_one_way
from pwsviz.geometry.section_plane import (
    angles,
    coordinate_names,
    names_time,
    seen_as_curves,
    usual_plane,
)
from pwsviz.geometry.section_state import on_section, state_at
from pwsviz.results.requests import SectionInputs
from pwsviz.results.sections import SectionPoints, SectionPortion
from pwsviz.scene.names import LABELS, SECTION_DIRECTIONS, readable
from pwsviz.scene.presets import shown_example
from pwsviz.tabs.base import LongTab, about_crossings
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.math_names import variable_name
from pwsviz.text.typed import as_typed
from pwsviz.text.words import as_text, complaint, listed
from pwsviz.widgets.disclosure import Disclosure
from pwsviz.widgets.dropdown import Dropdown
from pwsviz.widgets.number_field import NumberField
from pwsviz.widgets.panes import text_pane
from pwsviz.widgets.setting_buttons import choice

OTHER = "…"
"""Option of the surfaces that stands for any other function."""

NOT_AT = (
    "All runs start at t = 0, and the laws or the surface change with time: choose two variables as coordinates to "
    "start by a click."
)
"""Why a click on a section over time starts nothing."""

FIRST_POINTS = "A number marks the first point of each start."
"""What the discs in the figure are."""

KINDS = {"Section": False, "Return map": True}


class SectionTab(LongTab):
    """Where the runs of all starts meet a surface."""

    settings = ("section_axes", "section_map", "axes")
    every_start = True

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view: SectionView | None = None
        self._before: dict[str, Any] = {}  # the starts before the last click
        self._placed: tuple[Any, ...] = ()  # those after it

    def inputs(self) -> SectionInputs:
        """Return all starts and one integrator."""
        return SectionInputs.of_scene(self.scene)

    def compute(self, inputs: SectionInputs, cancel: Cancel, report: Report) -> SectionPoints:
        """Compute the points."""
        return self.results.section(inputs, cancel, report)

    @property
    def plane(self) -> tuple[int, int]:
        """The numbers of the coordinates shown."""
        scene = self.scene
        return scene.section_axes or usual_plane(scene.declaration, scene.section_of)

    @property
    def _alike(self) -> bool:
        """Whether it shows a plane that the portrait shows, at equal scales: the only one, or the one chosen there."""
        scene = self.scene
        drawn = (0, 1) if scene.declaration.dimension == 2 else scene.axes or ()
        return not scene.section_map and {*self.plane} == {*drawn}

    def build(self) -> list[Any]:
        """Make the choices, and the plot."""
        scene = self.scene
        self.view = SectionView(self._place, self._fit)
        self._of = Dropdown("Surface", description="Where the points lie.", options={"": ""}, value="")
        self._of.param.watch(self._take_surface, "value")
        self._other = pmui.TextInput(
            label="h(t, x), which vanishes there", size="small", width=210, margin=(8, 10, 4, 0), visible=False
        )
        self._other.param.watch(self._take_function, "value")
        self._across, self._up = (Dropdown(words, options={"": 0}, value=0) for words in ("Horizontal", "Vertical"))
        self._across.param.watch(lambda event: self._take_axis(0, event.new), "value")
        self._up.param.watch(lambda event: self._take_axis(1, event.new), "value")
        self._up_place, kind = _wide(self._up, 88), choice(scene, "section_map", lambda: KINDS, name="Shown")
        self.note = text_pane("", "about")
        self._more = pn.FlexBox(*self._rarely_needed(), visible=False, margin=0, sizing_mode="stretch_width")
        more = pmui.IconButton(icon="tune", description="More choices", size="small", margin=(10, 0, 0, 0))
        more.on_click(self._toggle)
        scene.param.watch(self._offer, ["system", "own", "section_of", "section_axes", "section_map"])
        self._offer()
        controls = pn.FlexBox(
            kind, _wide(self._of, 120), self._other, _wide(self._across, 88), self._up_place, more,
            Disclosure(more, self._more),
            margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        return [controls, self._more, self.progress, self.plot(self.view.figure), self.note]

    def _rarely_needed(self) -> list[Any]:
        scene = self.scene
        ways = choice(scene, "section_direction", lambda: {words: way for way, words in SECTION_DIRECTIONS.items()})
        methods = choice(
            scene, "study_method", lambda: {name: name for name in scene.used}, ("system", "own", "methods")
        )
        names = ("section_points", "section_discard")
        fields = [NumberField(LABELS[n], partial(getattr, scene, n), partial(scene.accept, n)) for n in names]

        def sync(*_: Any) -> None:
            ways.visible = not is_one_way(scene.declaration, scene.section_of)
            for field in fields:
                field.sync()

        sync()
        scene.param.watch(sync, ["system", "own", "section_of", *names])
        return [ways, methods, *(_wide(field, 170) for field in fields)]

    def _toggle(self, _event: Any) -> None:
        self._more.visible = not self._more.visible

    # The choices -----------------------------------------------------------------------------------------------------

    def _offer(self, *_: Any) -> None:
        """Offer the surfaces and the coordinates of the system."""
        scene, system = self.scene, self.scene.declaration
        own = surface_texts(system)
        if system.two_sided:
            options = {"S: g = 0": ""}
        else:
            options = {"all surfaces": "", **{f"{readable(g, system)} = 0": g for g in own}}
        chosen = scene.section_of if scene.section_of in options.values() else OTHER
        self._of.offer({**options, "another …": OTHER}, chosen)
        self._other.param.update(
            value=as_typed(scene.section_of) if chosen == OTHER else "", visible=chosen == OTHER,
            error_state=False, helper_text="",
        )  # fmt: skip
        names = {name: k for k, name in enumerate(coordinate_names(system))}
        for dropdown, k in zip((self._across, self._up), self.plane, strict=True):
            dropdown.offer(names, k)
        self._up_place.visible = not scene.section_map

    def _take_surface(self, event: Any) -> None:
        """Take one of the own surfaces, or let another be typed."""
        self._other.visible = event.new == OTHER
        if event.new != OTHER and event.new != self.scene.section_of:
            self._accept("section_of", event.new)

    def _take_function(self, event: Any) -> None:
        if not self._other.visible or event.new == as_typed(self.scene.section_of):
            return
        try:
            self.scene.accept("section_of", event.new)
        except ValueError as reason:
            self._other.param.update(error_state=True, helper_text=str(reason))

    def _take_axis(self, place: int, k: int) -> None:
        axes = list(self.plane)
        if k is None or axes[place] == k or k > self.scene.declaration.dimension:
            return
        if axes[1 - place] == k:  # exchange them
            axes[1 - place] = axes[place]
        axes[place] = k
        self._accept("section_axes", tuple(axes))

    def _accept(self, name: str, value: object) -> None:
        try:
            self.scene.accept(name, value)
        except ValueError as reason:
            self.note.object = complaint(reason)

    # What is shown ---------------------------------------------------------------------------------------------------

    def draw(self, outcome: SectionPoints) -> str:
        """Draw the points and return how many there are in words."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        self.view.show(outcome, self.plane, self.scene.section_map, self._alike)
        if outcome.inputs.starts != self._placed:
            self.note.object = as_text(self._hint(), "about")
        return section_text(outcome)

    def warnings(self, outcome: SectionPoints) -> Sequence[str]:
        """Return what is said against the step size."""
        return section_warnings(outcome)

    def remark(self, outcome: SectionPoints) -> str:
        """Return what may be expected of the points, and what the runs do at crossings if that is unusual."""
        inputs = outcome.inputs
        hope = prospects(inputs.problem.declaration, "section", shown_example(self.scene), inputs.of)
        return f"{hope} {about_crossings(self.scene, locates=True)}".strip()

    def _hint(self) -> str:
        system, scene = self.scene.declaration, self.scene
        if scene.section_map:
            return ""
        over_time = system.dimension in self.plane
        if over_time and names_time(system, scene.section_of):
            return NOT_AT
        turns = [coordinate_names(system)[k] for k in self.plane if k in angles(system)]
        several = len(surface_texts(system)) > 1 and not scene.section_of
        curved = bool(seen_as_curves(system, scene.section_of, self.plane))
        of = "the surface of the nearest point" if several else "the surface"
        on = f" nearby, on {of}" if curved else f" there{f', on {of}' * several}"
        note = f" {listed(turns)} {'is' if len(turns) == 1 else 'are'} shown modulo 2π." if turns else ""
        at = ", at t = 0" if over_time else ""
        starts = "sets a state at t = 0" if self._at_instants() else f"starts a trajectory{on}{at}"
        return f"A click {starts}. {FIRST_POINTS}{note}"

    def table(self) -> Table | None:
        """Return a row for each point."""
        return section_rows(self.outcome) if self.outcome is not None else None

    def heading(self, outcome: SectionPoints) -> str:
        """Return whether it is the section, or its return map."""
        return "Return map" if self.scene.section_map else "Poincaré section"

    def meaning(self, outcome: SectionPoints) -> str:
        """Return what the numbers in the figure are, for captions."""
        one = "The encircled number marks the first point."
        return "" if self.scene.section_map else FIRST_POINTS if len(outcome.statuses) > 1 else one

    def how(self, outcome: SectionPoints) -> str:
        """Return the surface and the integrator."""
        return section_how(outcome)

    def pictures(self) -> list[figure]:
        """Return the figure, painted finely enough for print."""
        if self.view is None or self.outcome is None or not any(self.outcome.counts):
            return []
        self.view.cloud.sharpen()
        return super().pictures()

    def program(self) -> str:
        """Return the lines that find the same points."""
        return section_program(self.scene, self.inputs(), self.outcome)

    # A click ---------------------------------------------------------------------------------------------------------

    def _place(self, x: float, y: float) -> None:
        """Add the start that belongs to a point of the section."""
        scene, system, axes = self.scene, self.scene.declaration, self.plane
        if scene.section_map or self.outcome is None:
            return
        try:
            if system.dimension in axes and names_time(system, scene.section_of):
                raise ValueError(NOT_AT)
            places = {axes[0]: self._rounded(x, 0), axes[1]: self._rounded(y, 1)}
            given = {k: value for k, value in places.items() if k < system.dimension}
            near, mode = self._nearest(given)
            found = state_at(scene.build(), scene.section_of, given, near, mode)
            before = {"starts": scene.starts, "selected": scene.selected}
            scene.place(found.x)
        except ValueError as reason:
            self.note.object = complaint(reason)
            return
        self._before, self._placed = before, scene.starts
        names = list(map(variable_name, system.variables))
        state = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, found.x, strict=True))
        hidden = [name for k, name in enumerate(names) if k not in given]
        taken = f"; {listed(hidden)} from {listed(found.taken)}" if hidden and found.taken else ""
        on = on_section(scene.build(), scene.section_of, found.x) or self._at_instants()
        elsewhere = "" if on else f" There {'h' if scene.section_of else 'g'} ≠ 0 at t = 0: its points lie elsewhere."
        self.note.object = as_text(f"Start {len(scene.starts)} at {state}{taken}.{elsewhere}", "about")

    def _at_instants(self) -> bool:
        """Whether points are the states at some instants, and no places are met by surfaces."""
        laws = self.scene.declaration.laws
        return not self.scene.section_of and len(laws.instants) == len(laws.surfaces)

    def _rounded(self, value: float, place: int) -> float:
        """Round a coordinate to about a pixel."""
        assert self.view is not None  # noqa: S101  (clicked after it was built)
        window = self.view.cloud.window
        if window is None:
            return value
        return round(value, 3 - math.floor(math.log10((window.width, window.height)[place])))

    def _nearest(self, given: dict[int, float]) -> tuple[Any, int]:
        """Return the state of the point nearest on the screen, of the selected start if it has any; and its mode."""
        assert isinstance(self.outcome, SectionPoints)  # noqa: S101  (clicked on what was drawn)
        scene, found = self.scene, self.outcome
        own = [one for one in found.portions if one.start == min(scene.selected, len(scene.starts) - 1)]
        portions = own or list(found.portions)
        if not portions:
            return np.array(scene.x0), -1
        return min((_closest(one, given) for one in portions), key=lambda one: one[0])[1:]

    def _fit(self) -> None:
        """Show all points, and take back what the first of two clicks has placed."""
        assert self.view is not None  # noqa: S101  (clicked after it was built)
        if self._placed and self.scene.starts == self._placed:
            self.scene.param.update(**self._before)
            self._placed = ()
        self.view.cloud.fit()


def _wide(widget: Any, width: int) -> pn.Column:
    """Return a widget in a place of some width in pixels, and wider where type is larger."""
    return pn.Column(widget, styles={"width": f"{width / 16:g}rem"}, margin=(0, 8, 0, 0))


def _closest(portion: SectionPortion, given: dict[int, float]) -> tuple[float, Any, int]:
    """Return the distance of the nearest point, its state and its mode."""
    away = sum((portion.x[:, k] - value) ** 2 for k, value in given.items())
    best = int(np.argmin(away))
    return float(np.asarray(away)[best]), portion.x[best], int(portion.mode[best])
