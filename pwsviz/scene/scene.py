"""The settings a user has chosen: no widgets, no arrays.

Every setting is checked (`checks`): `Scene.accept` either applies a value or raises a ValueError whose text can be
shown beside the field. A scene is therefore valid at all times.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any

import param

import core
from core.integrate import checked_method, checked_start
from pwsviz.geometry.projection import PLANE
from pwsviz.scene.checks import MAX_STARTS, OWN, Start, accepted_start, checked, checked_number
from pwsviz.scene.names import (
    COST_ACROSS,
    COST_UP,
    EXTERNAL_SOLVERS,
    SECTION_DIRECTIONS,
    STABILITY_PARTS,
    STABILITY_SHOWN,
    SWEEP_CONTINUATIONS,
    SWEEP_DIRECTIONS,
    choice_name,
)
from pwsviz.scene.sweeping import AFRESH, COUNTS
from pwsviz.scene.times import END_TIME, STEP_SIZE, Times, are_alike, times_of
from pwsviz.scene.validation import MAX_STEPS, one_of, require_few_steps
from pwsviz.scene.views import VIEWS

TOLERANCES = (1e-15, 1e-3)
"""Least and greatest tolerance (error of a step relative to the state) of an integrator that chooses its own steps."""

PERTURBATION_ORDERS = (None, 1, 2, 3, 4, 6, 8, 15)
"""Offered orders p of the perturbation c·τᵖ of crossing times; None for no perturbation."""

_PLAIN_STUDIES: Mapping[str, Any] = {
    "stability_coordinate": 0, "stability_around": None, "section_of": "", "section_axes": None, **AFRESH,
}  # fmt: skip
"""What another system resets of the views: it has other variables."""


class _ViewKey(param.Parameter):  # type: ignore[type-arg]
    """A key of `VIEWS`, read when a value is set: a `Selector` would keep the keys that there were at import."""

    def _validate_value(self, val: object, allow_None: bool) -> None:  # noqa: N803  (param's name)
        one_of(VIEWS, val, partial(choice_name, "view"))


class Scene(param.Parameterized):
    """The settings of one page: a system, where it starts, and how it is integrated.

    Attributes
    ----------
    loads : int
        How often a whole scene was loaded into this one, which then brings a window of its own.
    """

    system: Any = param.Selector(
        default="elliptic_curve", objects=[*core.CATALOGUE, OWN], doc="Key in `core.CATALOGUE`, or `OWN`."
    )
    own: Any = param.ClassSelector(default=None, class_=core.PiecewiseSystem, doc="The system the user typed.")
    values = param.Dict(default={}, doc="Value of each parameter of the system.")
    starts: Any = param.ClassSelector(default=(), class_=tuple, doc="Initial states, one for each trajectory.")
    selected: Any = param.Integer(default=0, bounds=(0, MAX_STARTS - 1), doc="Index of the start that is selected.")
    axes: Any = param.ClassSelector(
        default=None, class_=tuple, doc="The two variables that span the portrait; None: as suits what it shows."
    )
    window: Any = param.ClassSelector(
        default=None, class_=tuple, doc="Ends (left, right, bottom, top) of the portrait; None: as suits what it shows."
    )
    methods = param.ListSelector(default=["dmm2", "rk2"], objects=list(core.METHODS), doc="Integrators side by side.")
    tau = param.Number(default=STEP_SIZE, bounds=(1e-6, 1.0), doc="Step size.")
    tolerance = param.Number(default=1e-12, bounds=TOLERANCES, doc="Of integrators that choose their own steps.")
    t_end = param.Number(default=END_TIME, bounds=(1e-3, 1e5), doc="End time; the run starts at 0.")
    locate = param.Boolean(default=True, doc="Land on the surface at crossings (Mannshardt), or step over it.")
    slide = param.Boolean(default=True, doc="Slide along the surface where both fields point to it, or stop there.")
    perturbation_order: Any = param.Selector(
        default=None, objects=list(PERTURBATION_ORDERS), doc="Order p of the perturbation c·τᵖ of crossing times."
    )
    perturbation_scale = param.Number(default=1.0, bounds=(-10.0, 10.0), doc="Factor c of the perturbation c·τᵖ.")
    view: Any = _ViewKey(default="conserved", doc="The view beside the portrait: a key of `VIEWS`.")
    study_method: Any = param.Selector(
        default="dmm2", objects=list(core.METHODS), doc="The integrator that a view of one integrator shows."
    )
    order_all = param.Boolean(default=False, doc="Whether Order and Crossing time show all chosen integrators.")
    peers = param.ListSelector(default=["scipy"], objects=list(EXTERNAL_SOLVERS), doc="External solvers in Cost.")
    cost_across: Any = param.Selector(default="seconds", objects=list(COST_ACROSS))
    cost_up: Any = param.Selector(default="state", objects=list(COST_UP))
    stability_part: Any = param.Selector(default="map", objects=list(STABILITY_PARTS))
    stability_shown: Any = param.Selector(default="outcome", objects=list(STABILITY_SHOWN), doc="Colours of the map.")
    stability_coordinate = param.Integer(default=0, bounds=(0, None), doc="The variable along the map's other axis.")
    stability_around: Any = param.Number(
        default=None, doc="Its value at the start around which the map is drawn; None: at the selected start."
    )
    section_of = param.String(default="", doc="h of the section, as `core` reads it; empty: the switching surfaces.")
    section_direction: Any = param.Selector(
        default=0, objects=list(SECTION_DIRECTIONS), doc="1: crossings where h rises, −1: where it falls, 0: both."
    )
    section_axes: Any = param.ClassSelector(
        default=None, class_=tuple, doc="The two coordinates shown, time being the last; None: those that show most."
    )
    section_points = param.Integer(default=2000, bounds=(1, 1_000_000), doc="Points of each start.")
    section_discard = param.Integer(default=0, bounds=(0, 1_000_000), doc="Points of each start discarded first.")
    section_map = param.Boolean(default=False, doc="Whether the return map is shown, not the section itself.")
    sweep_parameter = param.String(
        default="", doc="The parameter of the diagram; empty: that which the system suggests."
    )
    sweep_range: Any = param.ClassSelector(
        default=None, class_=tuple, doc="Its first and last value; None: its bounds."
    )
    sweep_coordinate = param.String(default="", doc="The variable shown; empty: the first that varies on the surface.")
    sweep_of = param.String(default="", doc="h(t, x), whose zeros are the section; empty: the switching surface.")
    sweep_direction: Any = param.Selector(
        default="auto", objects=list(SWEEP_DIRECTIONS), doc="As of the section; auto: as a closed curve has one point."
    )
    sweep_continuation: Any = param.Selector(default="none", objects=list(SWEEP_CONTINUATIONS))
    sweep_values = param.Integer(default=400, bounds=COUNTS["sweep_values"][1:], doc="Values of the parameter.")
    sweep_points = param.Integer(default=100, bounds=COUNTS["sweep_points"][1:], doc="Points kept for each.")
    sweep_discard = param.Integer(
        default=None, allow_None=True, bounds=COUNTS["sweep_discard"][1:],
        doc="Points of each value discarded first; None: those of a transient, unless most runs have no more.",
    )  # fmt: skip
    sweep_end = param.Number(default=2000.0, bounds=(1e-3, 1e5), doc="Time at which a run ends that lacks points.")

    def __init__(self, **params: Any) -> None:
        self._no_defaults = False
        self._times = times_of("")  # of the system shown: what differs from them was chosen by the person
        self._stands_in = False  # whether the state is shown in place of a ψ that the system lacks
        self.loads = 0
        super().__init__(**params)
        chosen = self.declaration
        missing = {"values": dict(chosen.values), "starts": (chosen.x0,), **self._taken_times(self._usual_times())}
        self.param.update(**{name: value for name, value in missing.items() if name not in params})

    # Reading it ------------------------------------------------------------------------------------------------------

    @property
    def declaration(self) -> core.PiecewiseSystem:
        """The chosen system, at its declared parameter values."""
        return self.own if self.system == OWN and self.own is not None else core.CATALOGUE[self.system]

    @property
    def x0(self) -> Start:
        """The selected start."""
        return tuple(self.starts[min(self.selected, len(self.starts) - 1)])

    @property
    def offered(self) -> list[str]:
        """Integrators that can be used with the system."""
        system = self.declaration
        return [name for name in core.METHODS if can_use(system, name)]

    @property
    def used(self) -> list[str]:
        """The chosen integrators that can be used with the system; if there are none, the first one offered.

        Those that cannot be used stay in `methods`, and return with a system that admits them.
        """
        offered = self.offered
        return [name for name in self.methods if name in offered] or offered[:1]

    @property
    def fixed_step(self) -> list[str]:
        """Those of `used` with a fixed step size, and so an order; if there are none, the first such of `offered`."""
        fixed_step = [name for name in self.used if not core.METHODS[name].adaptive]
        return fixed_step or [name for name in self.offered if not core.METHODS[name].adaptive][:1]

    @property
    def selected_method(self) -> str:
        """The integrator that a view of one integrator shows: `study_method`, or the first of `used`."""
        return self.study_method if self.study_method in self.used else self.used[0]

    @property
    def order_methods(self) -> list[str]:
        """The integrators whose order is studied: all of `fixed_step`, or one of them."""
        names = self.fixed_step
        return names if self.order_all else [self.study_method if self.study_method in names else names[0]]

    @property
    def slides(self) -> bool:
        """Whether runs slide along the surface: those of a system with a jump do not."""
        return bool(self.slide) and not self.declaration.laws.jumps

    def build(self) -> core.PiecewiseSystem:
        """Return the chosen system at the chosen parameter values."""
        return self.declaration.with_parameters(**self.values)

    def settings(self) -> dict[str, Any]:
        """Return all settings, for `restore`."""
        return {name: getattr(self, name) for name in self.param if name != "name"}

    # Changing it -----------------------------------------------------------------------------------------------------

    def restore(self, settings: Mapping[str, Any]) -> None:
        """Set all settings at once to those of a scene, as `settings` returned them."""
        with self._without_defaults():
            self.param.update(**settings)
        self._times, self._stands_in = self._usual_times(), False

    def load(self, settings: Mapping[str, Any]) -> None:
        """Set some settings, and all others to their defaults; the user's own system is kept.

        Step size and end time then count as those of the system shown: another one comes with its own.

        Raises
        ------
        ValueError
            As `accept`; the scene is then unchanged.
        """
        fresh = Scene(own=self.own)
        given = dict(settings)
        fresh.accept("methods", given.pop("methods", fresh.methods))  # a system that lacks some would keep the others
        fresh.accept("system", given.pop("system", fresh.system))
        for name, value in given.pop("values", {}).items():
            fresh.accept(f"values.{name}", value)
        fresh.accept_times(given.pop("tau", fresh.tau), given.pop("t_end", fresh.t_end))
        fresh.accept("starts", given.pop("starts", fresh.starts))  # before the settings that refer to one of them
        for name, value in given.items():
            fresh.accept(name, value)
        self.loads += 1
        self.restore(fresh.settings())
        self._times = self._times._replace(tau=self.tau, t_end=self.t_end)

    @contextmanager
    def _without_defaults(self) -> Iterator[None]:
        """Within this context, a change of `system` does not reset the starts and the parameter values."""
        self._no_defaults = True
        try:
            yield
        finally:
            self._no_defaults = False

    def use(self, system: core.PiecewiseSystem) -> None:
        """Choose a system that the user declared, with its own start and parameter values.

        Step size and end time stay if it is much like the system shown: of the same variables, and about as fast.

        Raises
        ------
        ValueError
            If it has fewer than two variables, or cannot start at its initial state.
        """
        if system.dimension < PLANE:
            raise ValueError("A portrait needs at least two variables.")
        changes = {"values": dict(system.values), "starts": (system.x0,), "selected": 0, "axes": None, "window": None}
        checked_start(system, 0.0, system.x0)
        kept = {"tau": self.tau, "t_end": self.t_end} if are_alike(self.declaration, system) else {}
        with self._without_defaults():
            times = self._taken_times(times_of(OWN, system)) | kept
            self._show(system, own=system, system=OWN, **changes, **times)

    @param.depends("system", watch=True)
    def _start_afresh(self) -> None:
        if self._no_defaults:
            return
        if self.system == OWN and self.own is None:
            raise ValueError("There is no system of your own yet: write one first.")
        chosen = self.declaration
        self._show(
            chosen, values=dict(chosen.values), starts=(chosen.x0,), selected=0, axes=None, window=None,
            **self._taken_times(self._usual_times()),
        )  # fmt: skip

    @param.depends("axes", watch=True)
    def _look_afresh(self) -> None:
        if not self._no_defaults:
            self.window = None

    @param.depends("starts", "selected", "stability_coordinate", watch=True)
    def _map_afresh(self) -> None:
        if not self._no_defaults:
            self.stability_around = None

    @param.depends("sweep_parameter", watch=True)
    def _sweep_afresh(self) -> None:
        if not self._no_defaults:
            self.sweep_range = None

    def _show(self, system: core.PiecewiseSystem, /, **settings: Any) -> None:
        """Set what comes with a system; the state stands in for the view of ψ until a system has one again."""
        wanted = "conserved" if self._stands_in else str(self.view)
        stands_in = wanted == "conserved" and not system.laws.most_conserved
        self.param.update(view="state" if stands_in else wanted, **settings, **_PLAIN_STUDIES)
        self._stands_in = stands_in

    @param.depends("view", watch=True)
    def _choose_view(self) -> None:
        self._stands_in = False

    def _usual_times(self) -> Times:
        return times_of(str(self.system), self.own if self.system == OWN else None)

    def _taken_times(self, now: Times) -> dict[str, float]:
        """Return step size and end time for a system of which those of its own are given.

        What the person chose instead of those of the system before stays, but not from the catalogue to a system of
        the user's own, or back: they may differ by powers of ten. The end time is reached in at most `MAX_STEPS` steps.
        """
        before, self._times = self._times, now
        chosen = Times(self.tau, self.t_end, now.own) if before.own == now.own else before
        tau = now.tau if chosen.tau == before.tau else chosen.tau
        t_end = min(now.t_end, tau * MAX_STEPS) if chosen.t_end == before.t_end else chosen.t_end
        return {"tau": float(tau), "t_end": float(t_end)}

    def place(self, start: Start) -> None:
        """Add a trajectory, and select it.

        Raises
        ------
        ValueError
            If no trajectory can start there, or there are `MAX_STARTS` already.
        """
        if len(self.starts) >= MAX_STARTS:
            raise ValueError(f"There are {MAX_STARTS} trajectories already: remove one first.")
        added = accepted_start(self, start)
        self.param.update(starts=(*self.starts, added), selected=len(self.starts))

    def move(self, index: int, start: object) -> None:
        """Let one trajectory start elsewhere, and select it; ValueError where it cannot."""
        starts = list(self.starts)
        starts[index] = accepted_start(self, start)
        self.param.update(starts=tuple(starts), selected=index)

    def choose_on_map(self, tau: float, value: float) -> None:
        """Take a step size and a coordinate of the start from the stability map, which stays as it is.

        Raises
        ------
        ValueError
            As `accept`; the step size is taken first.
        """
        coordinate, around = self.stability_coordinate, self.stability_around
        drawn_around = self.x0[coordinate] if around is None else around
        self.accept("tau", tau)
        self.accept(f"x0.{coordinate}", value)
        self.stability_around = drawn_around

    def remove(self, index: int) -> None:
        """Remove one trajectory; ValueError if it is the last one."""
        if len(self.starts) == 1:
            raise ValueError("One trajectory has to stay.")
        starts = self.starts[:index] + self.starts[index + 1 :]
        selected = self.selected - (self.selected > index)
        self.param.update(selected=min(selected, len(starts) - 1), starts=starts)

    # Applying what a user typed, or what a link says -----------------------------------------------------------------

    def accept(self, field: str, value: object) -> None:
        """Check and apply one setting.

        Parameters
        ----------
        field : str
            Name of a setting; ``"x0"`` or ``"x0.<index>"`` for the selected start or one coordinate of it,
            ``"values.<name>"`` for one parameter.
        value : object
            The value, or the text of a number; for ``"methods"`` and ``"peers"`` a list of names.

        Raises
        ------
        ValueError
            If the value is refused, with a text for the user; the scene is then unchanged.
        """
        name, _, part = field.partition(".")
        if name == "x0":
            self.move(self.selected, self._with_coordinate(int(part), value) if part else value)
            return
        self.param.update(**{name: checked(self, name, part, value)})

    def accept_times(self, tau: object, t_end: object) -> None:
        """Apply step size and end time together: either one with the old value of the other may need too many steps.

        Raises
        ------
        ValueError
            As `accept`; the scene is then unchanged.
        """
        step, end = self.checked_time("tau", tau), self.checked_time("t_end", t_end)
        require_few_steps(end, step)
        self.param.update(tau=step, t_end=end)

    def checked_time(self, field: str, value: object) -> float:
        """Return ``"tau"`` or ``"t_end"`` checked by itself, not against the limit of steps; ValueError if refused."""
        return checked_number(self, field, "", value)

    def _with_coordinate(self, index: int, value: object) -> tuple[object, ...]:
        """Return the selected start with another coordinate, which need not be checked yet."""
        return (*self.x0[:index], value, *self.x0[index + 1 :])


def can_use(system: core.PiecewiseSystem, method: str) -> bool:
    """Return whether a method, a key of `core.METHODS`, can be used on a system."""
    try:
        checked_method(system, method)
    except ValueError:
        return False
    return True
