"""The controls: every setting of the scene, and nothing that the scene does not know."""

from __future__ import annotations

from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.fields import NumberField
from pwsviz.names import short_name
from pwsviz.panes import heading, text_pane
from pwsviz.scene import PERTURBATION_ORDERS, TOLERANCES, Scene
from pwsviz.text import as_text, method_notes

TAU_SLIDER = (1e-4, 0.3)
COORDINATES_CSS = ":host { flex-wrap: wrap; gap: 0 8px; } :host > * { flex: 1 1 80px !important; min-width: 80px; }"
"""Side by side as far as their names can be read."""

WIDE: dict[str, Any] = {"sizing_mode": "stretch_width", "size": "small", "margin": (6, 0)}


class Sidebar(pn.viewable.Viewer):
    """Controls of one scene."""

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.scene = scene
        self.tau = self._number("tau", "Step size τ", bounds=TAU_SLIDER, logarithmic=True)
        self.tolerance = self._number(
            "tolerance",
            "Tolerance of taylor",
            bounds=TOLERANCES,
            logarithmic=True,
            description="Error of one step, relative to the state. No step is longer than τ.",
        )
        self.t_end = self._number("t_end", "End time")
        self.scale = self._number("perturbation_scale", "Factor c")
        self.methods = pmui.CheckBoxGroup(
            label="", value=scene.used, options=scene.offered, inline=True, margin=0, size="small"
        )
        self.methods_note = text_pane("", "about")
        self.methods_message = text_pane("", "error")
        self.system = pmui.Select.from_param(
            scene.param.system,
            label="System",
            options={s.name: key for key, s in core.CATALOGUE.items()},
            description="",
            **WIDE,
        )
        self.locate = pmui.Switch.from_param(
            scene.param.locate, label="Land on the surface", description="", margin=(4, 0)
        )
        self.order = pmui.Select(
            label="Disturb crossing times by c·τᵖ, p =",
            options={str(p or "none"): p or 0 for p in PERTURBATION_ORDERS},  # a Select cannot show the value None
            value=scene.perturbation_order or 0,
            **WIDE,
        )
        self.order.param.watch(lambda event: scene.param.update(perturbation_order=event.new or None), "value")
        self.about = text_pane("", "about")
        self.parameters = pn.Column(margin=0, sizing_mode="stretch_width")
        self.coordinates = pn.Row(margin=0, sizing_mode="stretch_width", stylesheets=[COORDINATES_CSS])
        self.fields: dict[str, NumberField] = {}  # those of the system: its parameters and coordinates
        self._built_for = ""
        self.methods.param.watch(self._take_methods, "value")
        scene.param.watch(self._sync, ["system", "tau", "tolerance", "t_end", "perturbation_scale", "x0", "values"])
        scene.param.watch(self._dim, ["system", "methods", "locate", "perturbation_order"])
        self._sync()
        self._dim()

    def _number(self, field: str, label: str, **options: Any) -> NumberField:
        return NumberField(label, partial(self._read, field), partial(self.scene.accept, field), **options)

    def _read(self, field: str) -> float:
        name, _, part = field.partition(".")
        value = getattr(self.scene, name)
        if name == "x0":
            return float(value[int(part)])
        return float(value[part] if name == "values" else value)

    def _rebuild(self) -> None:
        """Make the fields of another system's parameters and coordinates."""
        system = core.CATALOGUE[self.scene.system]
        parameters = {
            f"values.{p.name}": {"label": short_name(p), "bounds": p.bounds, "description": f"{p.name}: {p.doc}"}
            for p in system.parameters
        }
        coordinates = {f"x0.{i}": {"label": f"{name} at start"} for i, name in enumerate(system.variables)}
        self.fields = {key: self._number(key, **options) for key, options in (parameters | coordinates).items()}
        self._built_for = self.scene.system
        self.about.object = as_text(system.doc, "about")
        self.parameters.objects = [self.fields[key] for key in parameters]
        self.coordinates.objects = [self.fields[key] for key in coordinates]

    def _sync(self, *_: Any) -> None:
        if self._built_for != self.scene.system:
            self._rebuild()
        for field in (self.tau, self.tolerance, self.t_end, self.scale, *self.fields.values()):
            field.sync()

    def _dim(self, *_: Any) -> None:
        """Offer what has an effect, and say what has none."""
        self.methods.param.update(options=self.scene.offered, value=self.scene.used)
        self.methods_note.object = method_notes(self.scene)
        self.tolerance.show_if(any(core.METHODS[name].adaptive for name in self.scene.used))
        self.order.disabled = not self.scene.locate
        self.scale.text.disabled = not self.scene.locate or self.scene.perturbation_order is None

    def _take_methods(self, event: Any) -> None:
        if event.new == self.scene.used:
            return
        try:
            self.scene.accept("methods", list(event.new))
            self.methods_message.object = ""
        except ValueError as reason:
            self.methods_message.object = as_text(str(reason), "error")

    def __panel__(self) -> pn.viewable.Viewable:
        """Top to bottom in the order one sets things up."""
        return pn.Column(
            heading("System"), self.system, self.about, self.parameters,
            heading("Start"), self.coordinates,
            heading("Integrators"), self.methods, self.methods_message, self.methods_note,
            self.tau, self.tolerance, self.t_end,
            heading("Crossings"), self.locate, self.order, self.scale,
            margin=(4, 12), sizing_mode="stretch_width",
        )  # fmt: skip
