"""What a file or a picture shows, in words: the system, its parameters and how it was integrated."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

import core
from pwsviz.geometry.shades import region_name
from pwsviz.scene.names import readable, short_name
from pwsviz.scene.permalink import digest, query
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import numbered
from pwsviz.text.numbers import printed
from pwsviz.text.words import at_surface, listed

__all__ = ["about", "caption", "release"]


LONGEST = 400
"""Characters of equations in a caption, about five lines of a page; longer ones are left out."""

OMITTED = "its equations are in the CSV and NPZ files"
"""What a caption says in place of longer equations."""

LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def release() -> str:
    """Return the name and the version of this package."""
    try:
        return f"pwsviz {version('pwsviz')}"
    except PackageNotFoundError:  # not installed
        return "pwsviz from source"


def about(scene: Scene, address: str = "", how: str = "") -> dict[str, str]:
    """Return what recomputes a scene, each part under its name: for the header of a file.

    Parameters
    ----------
    scene : Scene
        The settings.
    address : str
        Address of the page, without a query.
    how : str
        How a study was made; runs of the scene are described by its own settings.
    """
    try:
        link = f"{address}?{query(scene)}"
    except ValueError:  # too large for a link; its parts follow
        link = "none, the scene is too large"
    parts = {"program": release(), "link": link, "scene": digest(scene)}
    parts |= {"system": scene.declaration.name, "equations": _equations(scene)}
    return parts | {
        "variables": f"{', '.join(scene.declaration.variables)}; a column of such a name has its values",
        "parameters": _parameters(scene),
        "starts": _starts(scene),
        "integration": how or _integration(scene),
    }


def caption(scene: Scene, title: str, how: str = "") -> str:
    """Return the caption of a picture: its title, the equations, the parameters and the method.

    Parameters
    ----------
    scene, how
        As in `about`.
    title : str
        What the picture shows.
    """
    parts = about(scene, how=how)
    values = f"; {parts['parameters']}" if parts["parameters"] else ""
    how = " ".join(f"{parts[name][0].upper()}{parts[name][1:]}." for name in ("starts", "integration"))
    laws = parts["equations"] if len(parts["equations"]) <= LONGEST else OMITTED
    return printed(_indexed(f"{title}, {parts['system']}: {laws}{values}. {how}"))


def _indexed(text: str) -> str:
    """Return a text with lowered indices, as x₁ for x1, and with √ for the root; the files have columns named x1."""
    indexed = re.sub(r"(?<!\w)([^\W\d_])(\d)(?![A-Za-z0-9_.])", lambda name: name[1] + name[2].translate(LOWERED), text)
    return indexed.replace("sqrt(", "√(")


def _equations(scene: Scene) -> str:
    """Return the laws of all regions, as “g < 0: x′ = 2·y, ψ₋ = …; g > 0: …; g = …”; of equal sides once."""
    system = scene.declaration
    words = {"-": ("g < 0", "ψ₋"), "+": ("g > 0", "ψ₊")} if system.two_sided else {}
    regions = list(zip(system.laws.regions, system.regions.values(), strict=True))
    if system.two_sided and regions[0][1] == regions[1][1]:
        words, regions = {regions[0][0].name: ("on both sides", "ψ")}, regions[:1]
    laws = []
    for mode, region in regions:
        where, psi = words.get(mode.name, (f"region {region_name(mode)}", "ψ"))
        rates = [
            f"{variable}′ = {readable(rate, system)}" for variable, rate in zip(system.variables, region.f, strict=True)
        ]
        laws.append(f"{where}: " + ", ".join([*rates, *(f"{psi} = {readable(one, system)}" for one in region.psi)]))
    names = ["g"] if system.two_sided else [numbered("g", k + 1) for k in range(len(system.surfaces))]
    laws += [f"{name} = {readable(g, system)}" for name, g in zip(names, system.surfaces, strict=True)]
    laws += [f"reset map at {names[k]} = 0: {_map(jump, system)}" for k, jump in system.jumps.items()]
    for way in system.transitions:
        jump = f", reset map {_map(way.jump, system)}" if way.jump else ""
        laws.append(f"{way.mode} to {way.to} where {readable(way.guard, system)} = 0{jump}")
    return "; ".join(laws)


def _map(jump: Iterable[str], system: core.PiecewiseSystem) -> str:
    """Return the state after a jump, as “(x, −ε·v)”."""
    return f"({', '.join(readable(part, system) for part in jump)})"


def _parameters(scene: Scene) -> str:
    symbols = {q.name: short_name(q) for q in scene.declaration.parameters}
    return printed(", ".join(f"{symbols[name]} = {value:.15g}" for name, value in scene.values.items()))


def _starts(scene: Scene) -> str:
    points = "; ".join(f"({', '.join(f'{x:.15g}' for x in start)})" for start in scene.starts)
    names = ", ".join(scene.declaration.variables)
    return printed(f"started at ({names}) = {points}")


def _integration(scene: Scene) -> str:
    """Return the integrators, the step size and what happens at crossings."""
    used = scene.used
    steps = [f"step size τ = {scene.tau:.15g}"] if not all(map(_adaptive, used)) else []
    steps += [f"tolerance {scene.tolerance:.3g} (taylor)"] if any(map(_adaptive, used)) else []
    crossings = at_surface(scene.locate, scene.slides, scene.perturbation_order, scene.perturbation_scale)
    return f"integrated by {listed(used)} with {' and '.join(steps)} to t = {scene.t_end:.15g}; {crossings}"


def _adaptive(method: str) -> bool:
    return core.METHODS[method].adaptive
