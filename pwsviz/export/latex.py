"""The equations of a system as LaTeX, to be read by a paper with the package amsmath."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import sympy
from sympy import Expr, Symbol

import core
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import default_name
from pwsviz.text.mathml import Names, latex, ordered

__all__ = ["equations_latex", "latex_file"]

LONGEST = 100
"""Characters of LaTeX on a line, about; a longer sum is broken between its terms."""

_SPECIAL = {
    **{one: rf"\{one}" for one in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
}  # fmt: skip

_BREAK = "\\\\\n&\\quad {}"
"""Between two lines of one expression; the empty group makes a sign at its beginning one between two terms."""


def latex_file(scene: Scene, about: Mapping[str, str]) -> bytes:
    """Return a file that a paper can read: the equations, the values of the parameters and, as comments, `about`.

    Parameters
    ----------
    scene : Scene
        The settings.
    about : mapping of name to str
        Origin of the file.
    """
    comments = "".join(f"% {name}: {' '.join(words.split())}\n" for name, words in about.items())
    return f"% Needs \\usepackage{{amsmath}}.\n{comments}{equations_latex(scene.declaration, scene.values)}".encode()


def equations_latex(system: core.PiecewiseSystem, values: Mapping[str, float]) -> str:
    """Return the laws of all regions, the surfaces, resets and transitions, and the parameters, as one ``align*``."""
    names = {Symbol(p.name): f"{{{p.symbol}}}" if "^" in p.symbol else p.symbol for p in system.parameters}
    names |= {symbol: default_name(symbol.name) for symbol in system.laws.x}
    blocks = [*_laws(system, names), *_surfaces(system, names), *_resets(system, names), *_ways(system, names)]
    if values:
        told = [f"{names[Symbol(name)]} &= {sympy.latex(_number(value))}" for name, value in values.items()]
        blocks.append(_block("parameters", told))
    return "\\begin{align*}\n" + "\\\\[1ex]\n".join(blocks) + "\n\\end{align*}\n"


def _block(head: str, lines: Iterable[str]) -> str:
    return "\\\\\n".join([f"&\\text{{{head}:}}", *lines])


def _laws(system: core.PiecewiseSystem, names: Names) -> list[str]:
    sides = {"-": "$g < 0$", "+": "$g > 0$"} if system.two_sided else {}
    blocks, regions = list[str](), system.laws.regions
    if system.two_sided and len(set(system.regions.values())) == 1:
        sides, regions = {regions[0].name: "law"}, regions[:1]
    for mode in regions:
        lines = [f"{names[x]}' &= {_broken(rate, names)}" for x, rate in zip(system.laws.x, mode.field, strict=True)]
        side = [mode.name] if len(regions) == len(sides) == 2 else []
        for k, one in enumerate(mode.conserved, 1):
            below = ", ".join([*side, *([str(k)] if len(mode.conserved) > 1 else [])])
            lines.append(f"\\psi{f'_{{{below}}}' if below else ''} &= {_broken(one, names)}")
        blocks.append(_block(sides.get(mode.name, f"region {_text(mode.name)}"), lines))
    return blocks


def _surfaces(system: core.PiecewiseSystem, names: Names) -> list[str]:
    if system.transitions:
        return []
    surfaces = system.laws.surfaces
    labels = ["g"] if system.two_sided else [f"g_{{{k + 1}}}" for k in range(len(surfaces))]
    lines = [f"{label} &= {_broken(g, names)}" for label, g in zip(labels, surfaces, strict=True)]
    return [_block("switching", lines)]


def _resets(system: core.PiecewiseSystem, names: Names) -> list[str]:
    blocks = []
    for surface in system.jumps:
        way = next(one for ways in system.laws.ways for one in ways if one.surface == surface and one.jump is not None)
        label = "g" if system.two_sided else f"g_{{{surface + 1}}}"
        blocks.append(_block(f"reset at ${label} = 0$", _reset(system, way, names)))
    return blocks


def _ways(system: core.PiecewiseSystem, names: Names) -> list[str]:
    """Return the transitions between regions that have names."""
    if not system.transitions:
        return []
    laws, blocks = system.laws, []
    for mode, ways in zip(laws.regions, laws.ways, strict=False):
        for way in ways:
            head = f"{_text(mode.name)} to {_text(laws.mode(way.to).name)}" if way.to is not None else _text(mode.name)
            lines = [f"{_broken(laws.surfaces[way.surface], names)} &= 0", *_reset(system, way, names)]
            blocks.append(_block(head, lines))
    return blocks


def _reset(system: core.PiecewiseSystem, way: Any, names: Names) -> list[str]:
    """Return what changes in a reset."""
    pairs = zip(system.laws.x, way.jump or system.laws.x, strict=True)
    return [f"{names[x]} &\\mapsto {_broken(after, names)}" for x, after in pairs if after != x]


def _broken(expression: Expr, names: Names) -> str:
    """Return an expression in LaTeX, in lines if it is a long sum."""
    terms = ordered(expression)
    if len(terms) == 1:
        return latex(expression, names)
    lines = [""]
    for term in terms:
        shown = latex(term, names)
        shown = shown if shown.startswith("-") or lines == [""] else f"+ {shown}"
        if lines[-1] and len(lines[-1]) + len(shown) > LONGEST:
            lines.append(shown)
        else:
            lines[-1] = f"{lines[-1]} {shown}".lstrip()
    return _BREAK.join(lines)


def _number(value: float) -> sympy.Expr:
    return sympy.Integer(int(value)) if value.is_integer() else sympy.Float(f"{value:.15g}")


def _text(words: str) -> str:
    """Return a name that a user chose, for text mode; the signs of a region in mathematics."""
    if re.fullmatch("[-+]+", words):
        return f"${words}$"
    return "".join(_SPECIAL.get(one, one) for one in words)
