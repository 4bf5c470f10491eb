"""What each setting of a scene accepts: its value, or what a user typed for it, checked against the other settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import param

import core
from core.integrate import checked_start
from pwsviz.scene.names import EXTERNAL_SOLVERS, choice_name, short_name
from pwsviz.scene.sweeping import checked as checked_of_sweep
from pwsviz.scene.validation import (
    number,
    one_of,
    plane,
    require_few_steps,
    require_known,
    surface_function,
    switch,
    whole,
    whole_number,
    window,
)
from pwsviz.scene.views import SWEEP_SETTINGS, VIEWS
from pwsviz.text.math_names import variable_name

if TYPE_CHECKING:
    from pwsviz.scene.scene import Scene

__all__ = ["MAX_COORDINATE", "MAX_STARTS", "OWN", "Start", "accepted_start", "checked", "checked_number"]

MAX_COORDINATE = 1e6
"""Largest |coordinate| of a start, and largest |value| of a parameter without bounds of its own."""

MAX_STARTS = 12
"""Trajectories in one portrait; each is integrated and drawn once for every integrator."""

OWN = "own"
"""Key of the system that the user typed."""

Start: TypeAlias = "tuple[float, ...]"

_SUBJECTS = {
    "tau": "The step size", "t_end": "The end time", "tolerance": "The tolerance", "perturbation_scale": "The factor",
    "section_points": "The number of points", "section_discard": "The number discarded",
}  # fmt: skip
"""What a message calls the settings that are numbers."""


def checked(scene: Scene, name: str, part: str, value: object) -> object:
    """Return a setting as it is applied.

    Parameters
    ----------
    scene : Scene
        The settings so far.
    name : str
        Of a setting.
    part : str
        Of a setting with several values the one meant; else empty.
    value : object
        The value, or the text of a number.

    Raises
    ------
    ValueError
        If the value is refused, with a text for the user.
    """
    if name in _CHECKS:
        return _CHECKS[name](scene, name, part, value)
    if name not in scene.param or not isinstance(scene.param[name], param.Selector):
        raise ValueError(f"“{name}” is not a setting of this page.")
    return _choice(scene, name, part, value)


def checked_number(scene: Scene, name: str, _: str, value: object) -> float:
    """Return a setting that is a number, checked against its bounds alone; ValueError if it is refused."""
    return number(value, _SUBJECTS[name], *scene.param[name].bounds)


def accepted_start(scene: Scene, value: object) -> Start:
    """Return an initial state; ValueError if no trajectory can start there."""
    wanted = value if isinstance(value, tuple) else ()
    names = list(map(variable_name, scene.declaration.variables))
    if len(wanted) != len(names):
        raise ValueError(f"A start needs {len(names)} numbers: {', '.join(names)}.")
    start = tuple(number(x, name, -MAX_COORDINATE, MAX_COORDINATE) for name, x in zip(names, wanted, strict=True))
    return checked_start(scene.build(), 0.0, start)


def _whole(scene: Scene, name: str, _: str, value: object) -> int:
    return whole(value, _SUBJECTS[name], *scene.param[name].bounds)


def _switch(_scene: Scene, _name: str, _: str, value: object) -> bool:
    return switch(value)


def _choice(scene: Scene, name: str, _: str, value: object) -> object:
    return one_of(scene.param[name].objects, value, partial(choice_name, name))


def _tau(scene: Scene, name: str, _: str, value: object) -> float:
    tau = checked_number(scene, name, "", value)
    require_few_steps(scene.t_end, tau)
    return tau


def _end(scene: Scene, name: str, _: str, value: object) -> float:
    t_end = checked_number(scene, name, "", value)
    require_few_steps(t_end, scene.tau)
    return t_end


def _methods(scene: Scene, _name: str, _: str, value: object) -> list[str]:
    if not isinstance(value, list) or not value:
        raise ValueError("Choose at least one integrator.")
    require_known(value, core.METHODS, "an integrator")
    resting = set(scene.methods) - set(scene.offered)
    return [name for name in core.METHODS if name in value or name in resting]


def _peers(_scene: Scene, _name: str, _: str, value: object) -> list[str]:
    if not isinstance(value, list):
        raise ValueError(f"“{value}” is not a list of integrators.")
    require_known(value, EXTERNAL_SOLVERS, "an integrator to compare with")
    return [name for name in EXTERNAL_SOLVERS if name in value]


def _system(scene: Scene, name: str, _: str, value: object) -> object:
    if value == OWN and scene.own is None:
        raise ValueError("There is no system of your own yet: write one first.")
    return _choice(scene, name, "", value)


def _starts(scene: Scene, _name: str, _: str, value: object) -> tuple[Start, ...]:
    if not isinstance(value, tuple) or not 1 <= len(value) <= MAX_STARTS:
        raise ValueError(f"From 1 to {MAX_STARTS} trajectories are possible.")
    return tuple(accepted_start(scene, start) for start in value)


def _selected(scene: Scene, _name: str, _: str, value: object) -> int:
    return whole_number(value, "The number of the selected start", len(scene.starts))


def _variable(scene: Scene, _name: str, _: str, value: object) -> int:
    return whole_number(value, "The number of a variable", len(scene.declaration.variables))


def _around(_scene: Scene, _name: str, _: str, value: object) -> float | None:
    return None if value is None else number(value, "The coordinate", -MAX_COORDINATE, MAX_COORDINATE)


def _axes(scene: Scene, _name: str, _: str, value: object) -> object:
    return plane(value, scene.declaration.dimension)


def _section_axes(scene: Scene, _name: str, _: str, value: object) -> object:
    return None if value is None else plane(value, 1 + scene.declaration.dimension)  # time is the last


def _window(_scene: Scene, _name: str, _: str, value: object) -> object:
    return window(value)


def _view(_scene: Scene, name: str, _: str, value: object) -> object:
    return one_of(VIEWS, value, partial(choice_name, name))


def _surface(scene: Scene, _name: str, _: str, value: object) -> str:
    return surface_function(value, (*scene.declaration.variables, *scene.declaration.values))


def _values(scene: Scene, _: str, name: str, value: object) -> dict[str, float]:
    parameters = {p.name: p for p in scene.declaration.parameters}
    if name not in parameters:
        raise ValueError(f"“{name}” is not a parameter of this system; it has {', '.join(parameters) or 'none'}.")
    low, high = parameters[name].bounds or (-MAX_COORDINATE, MAX_COORDINATE)
    return {**scene.values, name: number(value, short_name(parameters[name]), low, high)}


_CHECKS: Mapping[str, Callable[[Scene, str, str, object], Any]] = {
    **dict.fromkeys(SWEEP_SETTINGS, checked_of_sweep),
    **dict.fromkeys(("tolerance", "perturbation_scale"), checked_number),
    **dict.fromkeys(("locate", "slide", "order_all", "section_map"), _switch),
    **dict.fromkeys(("section_points", "section_discard"), _whole),
    **dict.fromkeys(("section_of", "sweep_of"), _surface),
    "tau": _tau, "t_end": _end, "methods": _methods, "peers": _peers, "system": _system, "values": _values,
    "starts": _starts, "selected": _selected, "axes": _axes, "window": _window, "view": _view,
    "stability_coordinate": _variable, "stability_around": _around, "section_axes": _section_axes,
}  # fmt: skip
"""Setting -> its check; one that is missing here is one of some choices."""
