"""What can be seen on a section of a system at all, told by its declaration: in words."""

from __future__ import annotations

import sympy

import core
from core.symbolic import TIME, Way, keeps
from pwsviz.geometry.section_crossings import has_reset
from pwsviz.geometry.section_plane import surface_functions
from pwsviz.scene.presets import PRESETS
from pwsviz.text.words import listed

__all__ = ["examples_of", "prospects", "reset_words"]


def reset_words(system: core.PiecewiseSystem, of: str) -> str:
    """Return that the points are states after a reset map, if one acts at the surface; else nothing."""
    return ", just after the reset map" if has_reset(system, of) else ""


def prospects(system: core.PiecewiseSystem, view: str, shown: str = "", of: str = "") -> str:
    """Return why a view can show little, or what it depends on, and which examples show more; else nothing.

    Parameters
    ----------
    view
        Its key.
    shown
        Title of the example that is shown, which is not recommended.
    of
        What the points are zeros of; empty for the system's own surfaces.
    """
    words = []
    stroboscopic = any(TIME in h.free_symbols for h in surface_functions(system, of))
    if _is_flow_in_the_plane(system) and not stroboscopic:
        words.append(
            "Few distinct points are to be expected, perhaps after a transient. In the plane, where the law does not "
            "depend on time, bounded orbits generally are closed, or end in an equilibrium or a closed orbit."
        )
    if _conserves(system):
        words.append(
            "The points depend on the initial value of the conserved quantity; other starts may give a different "
            "section."
        )
    return " ".join(filter(None, [*words, examples_of(view, shown)])) if words else ""


def examples_of(view: str, shown: str = "") -> str:
    """Return which examples show more in a view, other than one that is shown."""
    others = [f"“{one.title}”" for one in PRESETS.values() if one.settings["view"] == view and one.title != shown]
    return f"See also the example{'s' * (len(others) > 1)} {listed(others)}." if others else ""


def _is_flow_in_the_plane(system: core.PiecewiseSystem) -> bool:
    """Whether the state, a point of the plane, determines all that follows, and moves without jumps."""
    laws = system.laws
    return system.dimension == 2 and not system.transitions and not laws.jumps and not laws.names_time


def _conserves(system: core.PiecewiseSystem) -> bool:
    """Whether all regions have one conserved quantity in common that does not contain time and that resets keep."""
    laws, values = system.laws, {symbol: sympy.Float(system.values[symbol.name]) for symbol in system.laws.p}

    def kept(psi: sympy.Expr, way: Way) -> bool:
        if way.jump is None:
            return True
        after = [u.subs(values) for u in way.jump]
        return keeps(psi.subs(values), laws.surfaces[way.surface].subs(values), laws.x, after)

    common = set.intersection(*(set(mode.conserved) for mode in laws.regions))
    return any(
        TIME not in psi.free_symbols and all(kept(psi, way) for ways in laws.ways for way in ways) for psi in common
    )
