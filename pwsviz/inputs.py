"""Exactly what each result depends on, frozen and hashable: the keys of the cache."""

from __future__ import annotations

from dataclasses import dataclass

import core
from pwsviz.scene import Scene

Values = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Ground:
    """What a system is, and where it starts."""

    system: str
    values: Values
    x0: tuple[float, ...]

    @classmethod
    def of(cls, scene: Scene) -> Ground:
        """Read it from a scene."""
        return cls(scene.system, tuple(sorted(scene.values.items())), tuple(scene.x0))

    def build(self) -> core.PiecewiseSystem:
        """Return the system at these values."""
        return core.CATALOGUE[self.system].with_parameters(**dict(self.values))


@dataclass(frozen=True)
class Scheme:
    """How to integrate: a method, and what it does at crossings."""

    method: str
    locate: bool = True
    perturbation_order: int | None = None
    perturbation_scale: float = 1.0
    tolerance: float | None = None

    @classmethod
    def of(cls, scene: Scene, method: str) -> Scheme:
        """Read it from a scene, leaving out settings that have no effect on this method."""
        if core.METHODS[method].adaptive:  # crossing times are disturbed by a power of the step size; it has none
            return cls(method, scene.locate, tolerance=scene.tolerance)
        if not scene.locate or scene.perturbation_order is None:
            return cls(method, scene.locate)
        return cls(method, True, scene.perturbation_order, scene.perturbation_scale)

    @property
    def transition(self) -> str:
        """The name `core` has for it."""
        return "mannshardt" if self.locate else "none"


@dataclass(frozen=True)
class RunInputs:
    """Exactly what one trajectory depends on."""

    ground: Ground
    scheme: Scheme
    tau: float
    t_end: float


@dataclass(frozen=True)
class StudyInputs:
    """Exactly what one order study depends on: neither the step size nor the end time of the scene."""

    ground: Ground
    scheme: Scheme


def run_inputs(scene: Scene) -> tuple[RunInputs, ...]:
    """One set of inputs for each integrator of a scene."""
    ground = Ground.of(scene)
    return tuple(RunInputs(ground, Scheme.of(scene, name), scene.tau, scene.t_end) for name in scene.used)


def study_inputs(scene: Scene) -> StudyInputs:
    """Return the inputs of a scene's order study."""
    return StudyInputs(Ground.of(scene), Scheme.of(scene, scene.study_method))
