"""The inputs of each result, frozen and hashable: the keys of the cache."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import core
from pwsviz.geometry.section_crossings import chosen_direction
from pwsviz.scene.checks import Start
from pwsviz.scene.scene import Scene
from pwsviz.scene.sweeping import swept_coordinate, swept_direction, swept_parameter, swept_range
from pwsviz.scene.times import usual_times

STABILITY_END = 500.0
"""Largest end time of the hundreds of runs of a stability study, and of the solution they are compared with."""

USUAL_METHOD = "rk2"
"""Of the run that shows what a system looks like: explicit, so that it needs no ψ and compiles fastest."""

Values = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class InitialValueProblem:
    """A system at its parameter values, and a start."""

    declaration: core.PiecewiseSystem = field(hash=False)  # slow to hash, and keys are looked up often
    values: Values
    x0: Start

    @classmethod
    def of(cls, scene: Scene, start: Start | None = None) -> InitialValueProblem:
        """Read it from a scene, with the selected start or another one."""
        values = tuple(sorted(scene.values.items()))
        return cls(scene.declaration, values, scene.x0 if start is None else start)

    def build(self) -> core.PiecewiseSystem:
        """Return the system at these values."""
        return self.declaration.with_parameters(**dict(self.values))


def transition_of(locate: bool) -> str:
    """Return the argument ``transition`` of `core.integrate` that locates crossings, or steps over them."""
    return "mannshardt" if locate else "none"


def sliding_of(slide: bool) -> str:
    """Return the argument ``sliding`` of `core.integrate` that slides along the surface, or stops there."""
    return "continue" if slide else "stop"


@dataclass(frozen=True)
class Scheme:
    """How to integrate: a method, and what it does at crossings."""

    method: str
    locate: bool = True
    perturbation_order: int | None = None
    perturbation_scale: float = 1.0
    tolerance: float | None = None
    slide: bool = True

    @classmethod
    def of(cls, scene: Scene, method: str) -> Scheme:
        """Read it from a scene, leaving out settings that have no effect on this method."""
        if core.METHODS[method].adaptive:  # no fixed step size, of which a perturbation could be a power
            return cls(method, scene.locate, tolerance=scene.tolerance, slide=scene.slides)
        if not scene.locate or scene.perturbation_order is None:
            return cls(method, scene.locate, slide=scene.slides)
        return cls(method, True, scene.perturbation_order, scene.perturbation_scale, slide=scene.slides)

    @property
    def transition(self) -> str:
        """The argument ``transition`` of `core.integrate`."""
        return transition_of(self.locate)

    @property
    def sliding(self) -> str:
        """The argument ``sliding`` of `core.integrate`."""
        return sliding_of(self.slide)

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `core.integrate`, other than a tolerance, and of `core.order_study`."""
        return {
            "method": self.method,
            "transition": self.transition,
            "perturbation_order": self.perturbation_order,
            "perturbation_scale": self.perturbation_scale,
            "sliding": self.sliding,
        }


@dataclass(frozen=True)
class RunInputs:
    """Exactly what one trajectory depends on."""

    problem: InitialValueProblem
    scheme: Scheme
    tau: float
    t_end: float


@dataclass(frozen=True)
class ErrorInputs:
    """Exactly what one plot of the conserved quantity depends on."""

    runs: tuple[RunInputs, ...]
    """One for each integrator."""
    axes: tuple[int, int] | None
    """Of the portrait, in which the crossing under the pointer is marked, too."""


@dataclass(frozen=True)
class StudyInputs:
    """What one order study depends on: not the step size of the scene, and its end time only with few crossings."""

    problem: InitialValueProblem
    scheme: Scheme
    t_end: float
    """Time at which states are compared of a trajectory with less than two crossings."""


@dataclass(frozen=True)
class CostInputs:
    """Exactly what one comparison of run times depends on."""

    problem: InitialValueProblem
    t_end: float
    methods: tuple[str, ...]
    peers: tuple[str, ...]
    locate: bool = True
    slide: bool = True

    @classmethod
    def of(cls, scene: Scene) -> CostInputs:
        """Read it from a scene."""
        methods, peers, at_surface = tuple(scene.used), tuple(scene.peers), (scene.locate, scene.slides)
        return cls(InitialValueProblem.of(scene), scene.t_end, methods, peers, *at_surface)


@dataclass(frozen=True)
class StabilityInputs:
    """Exactly what one stability study depends on."""

    problem: InitialValueProblem
    t_end: float
    methods: tuple[str, ...]
    part: str
    coordinate: int
    tau: float | None = None
    """Step size of the scene; None for the map, which has many."""
    locate: bool = True
    slide: bool = True
    around: float | None = None
    """The coordinate of the start whose trajectory sets the range of starts of the map; None for that of `problem`."""

    @classmethod
    def of(cls, scene: Scene) -> StabilityInputs:
        """Read it from a scene, leaving out settings that have no effect on its part."""
        part = scene.stability_part
        coordinate = scene.stability_coordinate if part != "drift" else 0
        tau, end = scene.tau if part != "map" else None, min(scene.t_end, STABILITY_END)
        problem, at_surface = InitialValueProblem.of(scene), (scene.locate, scene.slides)
        around = scene.stability_around if part == "map" else None
        return cls(problem, end, tuple(scene.used), part, coordinate, tau, *at_surface, around)

    def of_limits(self) -> StabilityInputs:
        """Return what the largest step sizes beside a map depend on: the start itself."""
        return replace(self, part="largest_tau", around=None)

    def of_map(self) -> StabilityInputs:
        """Return what the map itself depends on: the start that it is drawn around, whichever start is selected."""
        if self.around is None:
            return self
        start = list(self.problem.x0)
        start[self.coordinate] = self.around
        return replace(self, problem=replace(self.problem, x0=tuple(start)), around=None)


@dataclass(frozen=True)
class SweepInputs:
    """Exactly what one bifurcation diagram depends on: not the current value of its parameter."""

    problem: InitialValueProblem
    """With the values of the other parameters."""
    scheme: Scheme
    tau: float
    parameter: str
    """Its name; empty if the system has none."""
    low: float
    high: float
    values: int
    coordinate: str
    of: str
    """h, or "" for the switching surfaces."""
    direction: int
    continuation: str
    points: int
    discard: int | None
    """None: see `pwsviz.results.sweeps.with_discard`."""
    t_end: float

    @property
    def column(self) -> int:
        """Number of the coordinate."""
        return self.problem.declaration.variables.index(self.coordinate)

    @classmethod
    def of_scene(cls, scene: Scene) -> SweepInputs:
        """Read it from a scene, leaving out settings that have no effect on a section."""
        parameter, (low, high) = swept_parameter(scene), swept_range(scene)
        name, method = parameter.name if parameter else "", scene.selected_method
        others = tuple(sorted((key, value) for key, value in scene.values.items() if key != name))
        scheme = Scheme(method, tolerance=Scheme.of(scene, method).tolerance, slide=scene.slides)
        return cls(
            InitialValueProblem(scene.declaration, others, scene.x0), scheme, scene.tau, name, low, high,
            scene.sweep_values, swept_coordinate(scene), scene.sweep_of, swept_direction(scene),
            scene.sweep_continuation, scene.sweep_points, scene.sweep_discard, scene.sweep_end,
        )  # fmt: skip


@dataclass(frozen=True)
class SectionInputs:
    """Exactly what the points of one Poincaré section depend on."""

    problem: InitialValueProblem
    """The system, without a start."""
    starts: tuple[Start, ...]
    scheme: Scheme
    tau: float
    of: str
    """h, or "" for the switching surfaces."""
    direction: int
    points: int
    discard: int

    @classmethod
    def of_scene(cls, scene: Scene) -> SectionInputs:
        """Read it from a scene. Crossings are located, and not perturbed, whatever the scene says."""
        method = scene.selected_method
        tolerance = scene.tolerance if core.METHODS[method].adaptive else None
        scheme = Scheme(method, tolerance=tolerance, slide=scene.slides)
        return cls(
            InitialValueProblem.of(scene, ()), scene.starts, scheme, scene.tau, scene.section_of,
            chosen_direction(scene.declaration, scene.section_of, scene.section_direction), scene.section_points,
            scene.section_discard,
        )  # fmt: skip


def run_inputs(scene: Scene) -> tuple[RunInputs, ...]:
    """Return the inputs of the run of each integrator from the selected start."""
    return tuple(_run_inputs(scene, name, scene.x0) for name in scene.used)


def other_inputs(scene: Scene) -> tuple[RunInputs, ...]:
    """Return the inputs of the run of each integrator from each of the other starts, start by start."""
    index = min(scene.selected, len(scene.starts) - 1)
    others = scene.starts[:index] + scene.starts[index + 1 :]
    return tuple(_run_inputs(scene, name, start) for start in others for name in scene.used)


def study_inputs(scene: Scene) -> tuple[StudyInputs, ...]:
    """Return the inputs of the order study of each integrator that the scene studies."""
    problem = InitialValueProblem.of(scene)
    return tuple(StudyInputs(problem, Scheme.of(scene, method), scene.t_end) for method in scene.order_methods)


def usual_inputs(system: core.PiecewiseSystem) -> RunInputs:
    """Return the inputs of a run of a system as it is declared, by a method that every system admits."""
    scheme = Scheme(USUAL_METHOD, slide=not system.laws.jumps)
    problem = InitialValueProblem(system, tuple(sorted(system.values.items())), system.x0)
    times = usual_times(system)
    return RunInputs(problem, scheme, times.tau, times.t_end)


def _run_inputs(scene: Scene, method: str, start: Start) -> RunInputs:
    return RunInputs(InitialValueProblem.of(scene, start), Scheme.of(scene, method), scene.tau, scene.t_end)
