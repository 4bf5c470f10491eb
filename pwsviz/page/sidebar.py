"""The controls of the settings of a scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.figures.summaries import method_notes
from pwsviz.geometry.plane import Axes
from pwsviz.geometry.projection import PLANE, planes
from pwsviz.page.help import FIRST, note_of
from pwsviz.page.initial_states import Trajectories
from pwsviz.page.shown_example import ShownExample
from pwsviz.scene.checks import OWN
from pwsviz.scene.names import LABELS, short_name
from pwsviz.scene.presets import PRESETS, Preset
from pwsviz.scene.scene import PERTURBATION_ORDERS, TOLERANCES, Scene
from pwsviz.text.math_names import variable_name
from pwsviz.text.words import as_text
from pwsviz.widgets.choices import Choices
from pwsviz.widgets.dropdown import CHOOSER, Dropdown
from pwsviz.widgets.number_field import Later, NumberField, at_once
from pwsviz.widgets.panes import PLAIN_SX, heading, heading_with, text_pane

TAU_SLIDER = (1e-4, 0.3)
"""Ends of the slider of the step size; the field beside it takes the whole range of the scene."""

COORDINATES_CSS = """
:host { flex-wrap: wrap; gap: 0 8px; }
:host > * { flex: 1 1 80px !important; min-width: 80px; }
:host > div:first-of-type:nth-last-child(4), :host > div:first-of-type:nth-last-child(4) ~ div
    { flex-basis: 100px !important; }
"""
"""Side by side where at least 80 px remain for each, so that the names can be read."""

METHOD_NOTES = {name: method.doc for name, method in core.METHODS.items()}
FAMILIES = {name: method.family for name, method in core.METHODS.items()}
"""What each integrator is, for its tooltip, and the family under whose name it stands."""

AT_SURFACE = {
    LABELS["locate"]: "Split a step at the surface and complete it with the field of the other "
    "side (Mannshardt), which preserves the order. Otherwise a step across the surface is completed with the field of "
    "the side on which it began.",
    LABELS[
        "slide"
    ]: "Where both fields point towards the surface, follow Filippov’s sliding solution along it, and leave "
    "where one field ceases to point towards it. Otherwise the run ends there: the theory of Hirani et al. covers "
    "transversal crossings only.",
}
"""The boxes of the group of crossings, and what they do."""

NO_SLIDE_AT_INSTANTS = "There is no surface to slide along: this law changes at instants, wherever the state is."
NO_SLIDE_AT_JUMPS = "Where the state jumps at a surface, as in this system, runs do not slide along it."
"""Why the box of sliding has no effect."""

START = "Coordinate of the selected start. A start can also be dragged in the portrait."
"""Tooltip of a coordinate."""

AUTOMATIC = ()
"""The plane that suits the system, as a value of its list: a Select cannot show the value None."""

NUMBERS = ("tau", "tolerance", "t_end", "perturbation_scale")


class Sidebar(pn.viewable.Viewer):
    """The controls of one scene.

    Parameters
    ----------
    scene : Scene
        The settings.
    on_edit : callable
        Called when the user wants to write a system.
    later : callable, optional
        Takes a function that shows changed numbers, and calls it; at once, unless it is better to wait for others.
    on_preset : callable
        Called with an example that has been loaded.
    example : ShownExample, optional
        The example that the scene is, if any.
    """

    def __init__(
        self, scene: Scene, on_edit: Callable[[], None], later: Later = at_once,
        on_preset: Callable[[Preset], None] = lambda _: None, example: ShownExample | None = None,
    ) -> None:  # fmt: skip
        super().__init__()
        self.scene, self._later, self._on_preset = scene, later, on_preset
        self.example = example or ShownExample(scene)
        self._make_examples()
        self._make_system(on_edit)
        self._make_numbers()
        self._make_methods()
        self._make_crossings()
        self.about = text_pane("", "about")
        self.parameters = pn.Column(margin=0, sizing_mode="stretch_width")
        self.trajectories = Trajectories(scene)
        self.coordinates = pn.Row(margin=0, sizing_mode="stretch_width", stylesheets=[COORDINATES_CSS])
        self.fields: dict[str, NumberField] = {}  # of the parameters and coordinates of the system
        self._made: dict[str, list[NumberField]] = {}
        self._placed: dict[str, list[NumberField]] = {}
        self._built_for: core.PiecewiseSystem | None = None
        scene.param.watch(self._sync, [*NUMBERS, "system", "own", "starts", "selected", "values"])
        scene.param.watch(self._choose, ["system", "own", "axes"])
        scene.param.watch(self._enable, ["system", "own", "methods", "locate", "slide", "perturbation_order"])
        self.example.param.watch(self._name_example, ["preset", "changed"])
        self._sync()
        self._choose()
        self._enable()
        if self.example.preset is not None:
            self._name_example()

    def _make_examples(self) -> None:
        self.presets = Dropdown(
            "Examples",
            description="Scenes to start from: the figures of the paper, and others.",
            value="",
            groups=_titles(),
            css_classes=[CHOOSER],
        )
        self.presets.param.watch(self._load, "value")
        self._naming = False  # not choosing
        self.preset_note = text_pane(FIRST, "about")

    def _make_system(self, on_edit: Callable[[], None]) -> None:
        self.system = Dropdown(
            LABELS["system"],
            description="The fields, and the surfaces between them.",
            value=self.scene.system,
            options=self._systems(),
            css_classes=[CHOOSER],
        )
        self.system.param.watch(self._take_system, "value")
        self.write = pmui.Button(
            label="Write your own …", icon="edit", variant="text", size="small", margin=0, sx=PLAIN_SX
        )
        self.write.on_click(lambda _: on_edit())
        self.plane = Dropdown(
            LABELS["axes"],
            description="The two variables on the axes; “automatic” takes those in which the trajectory is not flat.",
            options={"automatic": AUTOMATIC},
            value=AUTOMATIC,
        )
        self.plane.param.watch(self._take_plane, "value")

    def _make_numbers(self) -> None:
        self.tau = self._number(
            "tau", bounds=TAU_SLIDER, logarithmic=True,
            description="Length of a step in time. Numbers and formulas can be typed, such as “1e-3” or “1/300”.",
        )  # fmt: skip
        self.tolerance = self._number(
            "tolerance",
            bounds=TOLERANCES,
            logarithmic=True,
            description="Error allowed in one step, relative to the state. No step is longer than τ.",
        )
        self.t_end = self._number("t_end", description="The run starts at t = 0 and ends here.")
        self.scale = self._number("perturbation_scale", description="Crossing times are perturbed by c·τᵖ.")

    def _make_methods(self) -> None:
        self.methods = Choices(
            label=LABELS["methods"], value=self.scene.used, options=self.scene.offered, about=METHOD_NOTES,
            groups=FAMILIES, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self.methods_note = text_pane("", "about")
        self.methods_message = text_pane("", "error")
        self.methods.param.watch(self._take_methods, "value")

    def _make_crossings(self) -> None:
        self.at_surface = Choices(
            label="Crossings", options=list(AT_SURFACE), about=AT_SURFACE, margin=(4, 0), sizing_mode="stretch_width"
        )
        self.at_surface.param.watch(self._take_at_surface, "value")
        self.order = Dropdown(
            LABELS["perturbation_order"],
            description="Perturb every crossing time on purpose, to see which p preserves the order of the method.",
            options={str(p or "none"): p or 0 for p in PERTURBATION_ORDERS},  # a Select cannot show the value None
            value=self.scene.perturbation_order or 0,
        )
        self.order.param.watch(lambda event: self.scene.param.update(perturbation_order=event.new or None), "value")
        self.scene.param.watch(lambda event: self.order.param.update(value=event.new or 0), "perturbation_order")

    def _number(self, field: str, label: str = "", **options: Any) -> NumberField:
        return NumberField(
            label or LABELS[field], partial(self._read, field), partial(self.scene.accept, field), later=self._later,
            **options,
        )  # fmt: skip

    def _read(self, field: str) -> float:
        name, _, part = field.partition(".")
        value = getattr(self.scene, name)
        if name == "x0":
            return float(value[int(part)])
        return float(value[part] if name == "values" else value)

    def _rebuild(self) -> None:
        """Make the fields of another system's parameters and coordinates, reusing those there are."""
        system = self.scene.declaration
        parameters = {
            f"values.{p.name}": {"label": short_name(p), "bounds": p.bounds, "description": p.doc}
            for p in system.parameters
        }
        coordinates = {
            f"x0.{i}": {"label": f"initial {variable_name(name)}", "description": START}
            for i, name in enumerate(system.variables)
        }
        spare = {key: list(fields) for key, fields in self._made.items()}
        self.fields = {key: self._field(spare, key, **options) for key, options in (parameters | coordinates).items()}
        self._built_for = system
        offered = {_plane_name(system, axes): axes for axes in planes(system)}
        self.plane.offer({"automatic": AUTOMATIC, **offered}, self.scene.axes or AUTOMATIC)
        self.plane.visible = system.dimension > PLANE
        self.about.object = as_text(system.doc, "about")
        self._place(self.parameters, [self.fields[key] for key in parameters])
        self._place(self.coordinates, [self.fields[key] for key in coordinates])

    def _field(self, spare: dict[str, list[NumberField]], key: str, **options: Any) -> NumberField:
        """Return an unused field of the same kind (parameter or coordinate), or a new one."""
        kind = key.partition(".")[0]
        if spare.get(kind):
            field = spare[kind].pop(0)
            field.rebind(read=partial(self._read, key), accept=partial(self.scene.accept, key), **options)
            return field
        field = self._number(key, **options)
        self._made.setdefault(kind, []).append(field)
        return field

    def _place(self, box: Any, fields: list[NumberField]) -> None:
        """Show exactly these fields in a box; its models are made anew only if the fields differ."""
        if self._placed.get(box.name) != fields:
            self._placed[box.name] = fields
            box.objects = fields

    def _sync(self, *_: Any) -> None:
        """Show the numbers of the scene, after making the fields of its system if need be."""
        if self._built_for is not self.scene.declaration:
            self._rebuild()
        self._later(self._show_numbers)

    def _show_numbers(self) -> None:
        for field in (self.tau, self.tolerance, self.t_end, self.scale, *self.fields.values()):
            field.sync()

    def _choose(self, *_: Any) -> None:
        """Show the chosen system and plane."""
        self.system.offer(self._systems(), self.scene.system)
        if (plane := self.scene.axes or AUTOMATIC) in self.plane.options.values():
            self.plane.value = plane

    def _enable(self, *_: Any) -> None:
        """Enable the controls that have an effect, and say which methods are left out."""
        self.methods.param.update(options=self.scene.offered, value=self.scene.used)
        self.at_surface.value = [LABELS[key] for key in ("locate", "slide") if getattr(self.scene, key)]
        why = _why_no_sliding(self.scene.declaration)
        self.at_surface.barred = {LABELS["slide"]: why} if why else {}
        self.methods_note.object = method_notes(self.scene)
        self.tolerance.show_if(any(core.METHODS[name].adaptive for name in self.scene.used))
        self.order.disabled = not self.scene.locate
        self.scale.entry.disabled = not self.scene.locate or self.scene.perturbation_order is None

    def _systems(self) -> dict[str, str]:
        names = {system.name: key for key, system in core.CATALOGUE.items()}
        return {**names, f"Yours: {self.scene.own.name}": OWN} if self.scene.own is not None else names

    def _take_system(self, event: Any) -> None:
        if event.new is not None and event.new != self.scene.system:
            self.scene.accept("system", event.new)

    def _take_plane(self, event: Any) -> None:
        chosen = event.new or None
        if event.new is not None and chosen != self.scene.axes and self._built_for == self.scene.declaration:
            self.scene.accept("axes", chosen)

    def _load(self, event: Any) -> None:
        """Load a preset, and say what to look at and what to try."""
        if event.new and not self._naming:
            preset = PRESETS[event.new]
            self.example.load(preset)
            self._on_preset(preset)

    def _name_example(self, *_: Any) -> None:
        """Name the example, and say what to look at and to try; say if it is changed; of another system say nothing."""
        preset, changed = self.example.preset, self.example.changed
        self._naming = True
        self.presets.value = "" if preset is None or changed else preset.key
        self._naming = False
        self.preset_note.object = "" if preset is None else note_of(preset, changed)

    def _take_at_surface(self, event: Any) -> None:
        self.scene.param.update(**{key: LABELS[key] in event.new for key in ("locate", "slide")})

    def _take_methods(self, event: Any) -> None:
        if event.new == self.scene.used:
            return
        try:
            self.scene.accept("methods", list(event.new))
            self.methods_message.object = ""
        except ValueError as reason:
            self.methods_message.object = as_text(str(reason), "error")
            self.methods.value = self.scene.used

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the controls in a column, in the order in which one sets things up."""
        return pn.Column(
            self.presets, self.preset_note,
            heading_with("System", self.write), self.system, self.about, self.parameters, self.plane,
            self.trajectories, self.coordinates,
            heading("Time"), self.tau, self.t_end,
            heading("Integrators"), self.methods, self.methods_message, self.methods_note, self.tolerance,
            heading("Crossings"), self.at_surface, self.order, self.scale,
            margin=(4, 12), sizing_mode="stretch_width",
        )  # fmt: skip


def _titles() -> dict[str, dict[str, str]]:
    """Return the examples by title: those beyond the paper, and its figures for whoever looks for these."""
    listed: dict[str, dict[str, str]] = {"To explore": {"choose …": ""}, "Figures of the paper": {}}
    for key, preset in PRESETS.items():
        listed["Figures of the paper" if preset.figure else "To explore"][preset.title] = key
    return listed


def _why_no_sliding(system: core.PiecewiseSystem) -> str:
    """Return why no run slides along a surface, whatever the scene says; empty if one may."""
    laws = system.laws
    if 0 < len(laws.surfaces) == len(laws.instants):
        return NO_SLIDE_AT_INSTANTS
    return NO_SLIDE_AT_JUMPS if laws.jumps else ""


def _plane_name(system: core.PiecewiseSystem, axes: Axes) -> str:
    return ", ".join(variable_name(system.variables[k]) for k in axes)
