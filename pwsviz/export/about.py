"""What a file shows, in words: the system, its parameters and how it was integrated; captions are made of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version

import numpy as np

import core
from pwsviz.geometry.projection import time_shown
from pwsviz.geometry.shades import region_name
from pwsviz.scene.equations import equations
from pwsviz.scene.names import met_at_surfaces, short_name
from pwsviz.scene.permalink import digest, query
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed
from pwsviz.text.words import at_surface, listed

__all__ = ["about", "named", "release"]

Told = Callable[[float], str]
"""Writes a number after a sign of equality: “= 0.5”."""


def exact(value: float) -> str:
    """Return a number with all of its digits: “= 0.5”."""
    return f"= {repr(float(value)).removesuffix('.0')}"


def named(scene: Scene, heading: str) -> str:
    """Return the beginning of a caption: “Phase portrait of the system “Elliptic curve””."""
    name = scene.declaration.name.translate(str.maketrans("“”", "‘’"))
    return f"{heading} of the system “{name}”"


def release() -> str:
    """Return the name and the version of this package."""
    try:
        return f"pwsviz {version('pwsviz')}"
    except PackageNotFoundError:  # not installed
        return "pwsviz from source"


def about(
    scene: Scene, address: str = "", how: str = "", *, every_start: bool = True, met: bool = True, slid: bool = True,
    endings: str = "", free: str = "", told: Told = exact,
) -> dict[str, str]:  # fmt: skip
    """Return what recomputes a scene, each part under its name: for the header of a file.

    Parameters
    ----------
    scene : Scene
        The settings.
    address : str
        Address of the page, without a query.
    how : str
        How a study was made; runs of the scene are described by its own settings.
    every_start : bool
        Whether it shows runs from all starts, or from the selected one alone.
    met, slid : bool
        Whether one of the runs meets a surface, and whether one slides; if none does, that is not mentioned.
    endings : str
        A sentence on runs that end before the end time, as of `endings.endings`; without its stop.
    free : str
        A parameter, or a variable at the start, that has many values in it; its present one is left out.
    told : callable
        Writes the numbers of the scene, as `exact` or `brief`.
    """
    try:
        link = f"{address}?{query(scene, typed=False)}"
    except ValueError:  # too large for a link; its parts follow
        link = "none, the scene is too large"
    parts = {"program": release(), "link": link, "scene": digest(scene)}
    parts |= {"system": scene.declaration.name, "equations": equations(scene.declaration)}
    return parts | {
        "variables": f"{_variables(scene)}; a column of such a name has its values",
        "parameters": _parameters(scene, told, free),
        "starts": _starts(scene, every_start, told, free),
        "integration": ". ".join(filter(None, (how or _integration(scene, met, slid, told), endings))),
    }


def _variables(scene: Scene) -> str:
    """Return the variables as columns are named, and in brackets as equations name them if that differs."""
    names = ((name, variable_name(name)) for name in scene.declaration.variables)
    return ", ".join(name if shown == name else f"{name} (in equations {shown})" for name, shown in names)


def _parameters(scene: Scene, told: Told, free: str) -> str:
    symbols = {q.name: short_name(q) for q in scene.declaration.parameters}
    return printed(", ".join(f"{symbols[name]} {told(value)}" for name, value in scene.values.items() if name != free))


def _starts(scene: Scene, every: bool, told: Told, free: str) -> str:
    """Return all starts, in the order of the numbers that mark them; or the selected one, with its number.

    Of a variable that has many values no value is told.
    """
    count, chosen = len(scene.starts), min(scene.selected, len(scene.starts) - 1)
    used = scene.starts if every else scene.starts[chosen : chosen + 1]
    variables = scene.declaration.variables
    if free in variables:
        pairs = zip(variables, used[0], strict=True)
        rest = ", ".join(f"{variable_name(name)} {told(x)}" for name, x in pairs if name != free)
        return printed(f"initial states ({', '.join(map(variable_name, variables))}){f' with {rest}' * bool(rest)}")
    numbers = [[told(x) for x in start] for start in used]
    points = "; ".join(f"({', '.join(text.split(' ')[1] for text in point)})" for point in numbers)
    sign = "≈" if any(text.startswith("≈") for point in numbers for text in point) else "="
    names = ", ".join(map(variable_name, variables))
    which = f", start {chosen + 1} of {count}" if len(used) < count else ""
    head = f"initial states 1 {'and' if count == 2 else 'to'} {count}:" if len(used) > 1 else "initial state"
    return printed(f"{head} ({names}) {sign} {points}{_begins(scene, used)}{which}")


def _begins(scene: Scene, starts: Sequence[Sequence[float]]) -> str:
    """Return in which regions runs begin whose region is not told by the signs of surfaces."""
    system = scene.build()
    if system.two_sided or system.laws.sides.shape[1]:
        return ""
    states, t = np.array(starts), time_shown(system)
    inside = [np.min(system.heights(k, t, states), axis=-1) > 0.0 for k in range(len(system.laws.regions))]
    of_start = [next((k for k, holds in enumerate(inside) if holds[n]), None) for n in range(len(states))]
    names = ["" if k is None else region_name(system.laws.regions[k]) for k in of_start]
    several = f"s {listed(names)}" if len({*names}) > 1 else f" {names[0]}"
    return f", in region{several}" if all(names) else ""


def _integration(scene: Scene, met: bool, slid: bool, told: Told) -> str:
    """Return the integrators, the step size and what happens at crossings."""
    adaptive = [name for name in scene.used if _adaptive(name)]
    others = [name for name in scene.used if name not in adaptive]
    by = [f"by {listed(others)} with step size τ {told(scene.tau)}"] if others else []
    longest = f"in steps of at most τ{'' if others else f' {told(scene.tau)}'}"
    by += [f"by {listed(adaptive)} with tolerance {scene.tolerance:.3g}, {longest}"] if adaptive else []
    what, slides = met_at_surfaces(scene.declaration), scene.slides and slid
    crossings = at_surface(what, scene.locate, slides, scene.perturbation_order, scene.perturbation_scale)
    end = told(scene.t_end).partition(" ")[2]
    return f"integrated {' and '.join(by)} for t ≤ {end}{f'; {crossings}' * met}"


def _adaptive(method: str) -> bool:
    return core.METHODS[method].adaptive
