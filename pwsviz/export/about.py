"""What a file or a picture shows, in words: the system, its parameters and how it was integrated."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import core
from pwsviz.scene.equations import equations, indexed
from pwsviz.scene.names import met_at_surfaces, short_name
from pwsviz.scene.permalink import digest, query
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed
from pwsviz.text.words import at_surface, listed

__all__ = ["about", "caption", "release"]


LONGEST = 400
"""Characters of equations in a caption, about five lines of a page; longer ones are left out."""

OMITTED = "its equations are in the TEX, CSV and NPZ files"
"""What a caption says in place of longer equations."""


def release() -> str:
    """Return the name and the version of this package."""
    try:
        return f"pwsviz {version('pwsviz')}"
    except PackageNotFoundError:  # not installed
        return "pwsviz from source"


def about(
    scene: Scene, address: str = "", how: str = "", *, every_start: bool = True, slid: bool = True, endings: str = ""
) -> dict[str, str]:
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
    slid : bool
        Whether one of the runs slides; if none does, sliding is not mentioned.
    endings : str
        Which runs ended before the end time, if any did.
    """
    try:
        link = f"{address}?{query(scene)}"
    except ValueError:  # too large for a link; its parts follow
        link = "none, the scene is too large"
    parts = {"program": release(), "link": link, "scene": digest(scene)}
    parts |= {"system": scene.declaration.name, "equations": equations(scene.declaration)}
    return parts | {
        "variables": f"{_variables(scene)}; a column of such a name has its values",
        "parameters": _parameters(scene),
        "starts": _starts(scene, every_start),
        "integration": "; ".join(filter(None, (how or _integration(scene, slid), endings))),
    }


def caption(
    scene: Scene, title: str, how: str = "", free: str = "", *, every_start: bool = True, slid: bool = True,
    endings: str = "",
) -> str:  # fmt: skip
    """Return the caption of a picture: its title, the equations, the parameters and the method.

    Parameters
    ----------
    scene, how, every_start, slid, endings
        As in `about`.
    title : str
        What the picture shows.
    free : str
        A parameter that has many values in it, whose present one is left out.
    """
    parts = about(scene, how=how, every_start=every_start, slid=slid, endings=endings)
    values = f"; {values}" if (values := _parameters(scene, free)) else ""
    how = " ".join(f"{parts[name][0].upper()}{parts[name][1:]}." for name in ("starts", "integration"))
    laws = parts["equations"] if len(parts["equations"]) <= LONGEST else OMITTED
    return printed(indexed(f"{title}, {parts['system']}: {laws}{values}. {how}"))


def _variables(scene: Scene) -> str:
    """Return the variables as columns are named, and in brackets as equations name them if that differs."""
    names = ((name, variable_name(name)) for name in scene.declaration.variables)
    return ", ".join(name if shown == name else f"{name} (in equations {shown})" for name, shown in names)


def _parameters(scene: Scene, free: str = "") -> str:
    symbols = {q.name: short_name(q) for q in scene.declaration.parameters}
    return printed(", ".join(f"{symbols[name]} = {value:.15g}" for name, value in scene.values.items() if name != free))


def _starts(scene: Scene, every: bool) -> str:
    """Return all starts; or the selected one, with its number among them."""
    count, chosen = len(scene.starts), min(scene.selected, len(scene.starts) - 1)
    used = scene.starts if every else scene.starts[chosen : chosen + 1]
    points = "; ".join(f"({', '.join(f'{x:.15g}' for x in start)})" for start in used)
    names = ", ".join(map(variable_name, scene.declaration.variables))
    which = f", start {chosen + 1} of {count}" if len(used) < count else ""
    return printed(f"started at ({names}) = {points}{which}")


def _integration(scene: Scene, slid: bool) -> str:
    """Return the integrators, the step size and what happens at crossings."""
    used = scene.used
    steps = [f"step size τ = {scene.tau:.15g}"] if not all(map(_adaptive, used)) else []
    steps += [f"tolerance {scene.tolerance:.3g} (taylor)"] if any(map(_adaptive, used)) else []
    met = met_at_surfaces(scene.declaration)
    crossings = at_surface(met, scene.locate, scene.slides and slid, scene.perturbation_order, scene.perturbation_scale)
    return f"integrated by {listed(used)} with {' and '.join(steps)} to t = {scene.t_end:.15g}; {crossings}"


def _adaptive(method: str) -> bool:
    return core.METHODS[method].adaptive
