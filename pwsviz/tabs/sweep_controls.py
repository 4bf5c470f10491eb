"""The controls of the bifurcation diagram; those that few need stand behind “more”."""

from __future__ import annotations

from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.geometry.projection import surface_texts
from pwsviz.geometry.section_crossings import is_one_way
from pwsviz.scene.names import LABELS, SWEEP_CONTINUATIONS, SWEEP_DIRECTIONS, readable, short_name
from pwsviz.scene.scene import Scene
from pwsviz.scene.sweeping import USUAL_DISCARD, swept_coordinate, swept_parameter, swept_range
from pwsviz.scene.views import SWEEP_SETTINGS
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed
from pwsviz.text.typed import as_typed
from pwsviz.widgets.disclosure import Disclosure
from pwsviz.widgets.dropdown import Dropdown
from pwsviz.widgets.number_field import NumberField
from pwsviz.widgets.panes import PLAIN_SX
from pwsviz.widgets.setting_buttons import choice

__all__ = ["SweepControls"]

AUTOMATIC = "auto"
"""Stands for a number that is chosen from the runs."""

OTHER = "other"
"""Stands for a surface whose function is typed."""

ROW_CSS = ":host { flex-wrap: wrap; gap: 0 8px; } :host > * { flex: 1 1 110px !important; min-width: 100px; }"
"""Side by side where at least 100 px remain for each."""

ABOUT = {
    "sweep_values": "How many values of the parameter, evenly spaced.",
    "sweep_points": "How many points are kept for each value.",
    "sweep_discard": "How many points are discarded first: the transient. “auto” stands "
    f"for {USUAL_DISCARD}, or for none if most runs end or fade within them.",
    "sweep_end": "A run that has not all its points by this time ends there.",
}
"""Tooltips of the numbers behind “more”."""


class SweepControls(pn.viewable.Viewer):
    """Which parameter, range and coordinate; behind “more” which surface, and how many points."""

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.scene = scene
        self.parameter = Dropdown(LABELS["sweep_parameter"], options={"": ""}, value="")
        self.parameter.param.watch(partial(self._take, "sweep_parameter"), "value")
        self.ends = [
            NumberField(label, partial(self._end, k), partial(scene.accept, f"sweep_range.{k}"))
            for k, label in enumerate(("from", "to"))
        ]
        system = ("system", "own")
        self._coordinate = Dropdown(LABELS["sweep_coordinate"], options={"": ""}, value="")
        self._coordinate.param.watch(partial(self._take, "sweep_coordinate"), "value")
        self._method = choice(scene, "study_method", lambda: {n: n for n in scene.used}, (*system, "methods"))
        self._more = pmui.Button(label="more", icon="tune", size="small", variant="text", margin=(2, 0), sx=PLAIN_SX)
        self._more.on_click(lambda _: self._open())
        self._first = pn.Row(
            self.parameter, *self.ends, self._coordinate, margin=0, sizing_mode="stretch_width", stylesheets=[ROW_CSS]
        )
        self.box = pn.Column(margin=0, sizing_mode="stretch_width", visible=False)
        self.numbers: dict[str, NumberField] = {}
        self._discarded = USUAL_DISCARD  # in the diagram shown
        self._asked = False  # for another function, of which nothing is known yet
        scene.param.watch(self._sync, [*SWEEP_SETTINGS, *system, "methods"])
        self._sync()

    def _end(self, k: int) -> float:
        return swept_range(self.scene)[k]

    def _take(self, setting: str, event: Any) -> None:
        """Take what was chosen from a list, unless it is what is shown of the scene."""
        if event.new and event.new != self._shown(setting):
            self.scene.accept(setting, event.new)

    def _shown(self, setting: str) -> str:
        if setting == "sweep_coordinate":
            return swept_coordinate(self.scene)
        parameter = swept_parameter(self.scene)
        return parameter.name if parameter else ""

    # Behind “more” ---------------------------------------------------------------------------------------------------

    def _open(self) -> None:
        """Show what stands behind “more”, made the first time, or hide it."""
        if not self.numbers:
            self._make_more()
        self.box.visible = not self.box.visible

    def _make_more(self) -> None:
        scene = self.scene
        self.surface = Dropdown(
            "Surface", description="Where the points of the section lie.", options={"": ""}, value=""
        )
        self.surface.param.watch(self._take_surface, "value")
        self.function = pmui.TextInput(
            label="h(t, x), zero on the surface", size="small", sizing_mode="stretch_width", margin=(8, 0, 6, 0)
        )
        self.function.param.watch(self._take_function, "value")
        self.numbers = {
            key: NumberField(
                LABELS[key],
                partial(self._count, key),
                partial(scene.accept, key),
                description=about,
                written=partial(self._written, key),
            )
            for key, about in ABOUT.items()
        }
        self._direction = choice(
            scene, "sweep_direction", lambda: {words: key for key, words in SWEEP_DIRECTIONS.items()}
        )
        continuation = choice(
            scene, "sweep_continuation", lambda: {words: key for key, words in SWEEP_CONTINUATIONS.items()}
        )
        row = {"margin": 0, "sizing_mode": "stretch_width", "stylesheets": [ROW_CSS]}
        self.box.objects = [
            pn.Row(self.surface, self.function, **row),
            pn.FlexBox(self._direction, continuation, margin=0, sizing_mode="stretch_width"),
            pn.Row(*self.numbers.values(), **row),
        ]
        self._sync()

    def _count(self, key: str) -> float:
        """Return one of the numbers; where it is automatic, that of the diagram shown."""
        value = getattr(self.scene, key)
        return float(self._discarded if value is None else value)

    def _written(self, key: str) -> str:
        return AUTOMATIC if getattr(self.scene, key) is None else ""

    def tell_discarded(self, number: int | None) -> None:
        """Show how many points are discarded in a diagram, if that is automatic."""
        if number is not None:
            self._discarded = number
            self._sync()

    def _surfaces(self) -> dict[str, str]:
        """Return the surfaces offered: their functions by what the list says."""
        system = self.scene.declaration
        texts = {f"{readable(g, system)} = 0": g for g in surface_texts(system)}
        if len(texts) == 1:
            return {f"S: {next(iter(texts))}": "", "another function …": OTHER}
        return {"all surfaces": "", **texts, "another function …": OTHER}

    def _take_surface(self, event: Any) -> None:
        """Take one of the system's surfaces, or ask for another function."""
        offered = set(self.surface.options.values()) - {OTHER}
        self._asked = self.function.visible = event.new == OTHER
        if event.new in offered and event.new != self.scene.sweep_of:
            self.scene.accept("sweep_of", event.new)

    def _take_function(self, event: Any) -> None:
        """Take a function that was typed, or say why not."""
        if not event.new.strip() or event.new == as_typed(self.scene.sweep_of):
            return
        try:
            self.scene.accept("sweep_of", event.new)
        except ValueError as reason:
            self.function.param.update(error_state=True, helper_text=printed(str(reason)))
        else:
            self._asked = False
            self.function.param.update(error_state=False, helper_text="")

    # What the scene says ---------------------------------------------------------------------------------------------

    def _sync(self, *_: Any) -> None:
        """Show the settings of the scene."""
        scene, system = self.scene, self.scene.declaration
        swept = self._shown("sweep_parameter")
        self.parameter.offer({short_name(q): q.name for q in system.parameters} or {"none": ""}, swept)
        self._coordinate.offer({variable_name(name): name for name in system.variables}, swept_coordinate(scene))
        self._first.visible = self._more.visible = bool(swept)
        self._method.visible = len(scene.used) > 1 and bool(swept)
        for field in (*self.ends, *self.numbers.values()):
            field.sync()
        if self.numbers:
            self._sync_surface()

    def _sync_surface(self) -> None:
        of, offered = self.scene.sweep_of, self._surfaces()
        own = of in offered.values()
        other = self._asked or not own
        self.surface.offer(offered, OTHER if other else of)
        self._direction.visible = not is_one_way(self.scene.declaration, of)
        self.function.visible = other
        if not own:
            self.function.param.update(value=as_typed(of), error_state=False, helper_text="")

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the controls."""
        line = pn.FlexBox(
            self._method, self._more, Disclosure(self._more, self.box), margin=0, sizing_mode="stretch_width"
        )
        return pn.Column(self._first, line, self.box, margin=0, sizing_mode="stretch_width")
