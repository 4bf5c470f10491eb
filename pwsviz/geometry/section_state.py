"""The state that belongs to a point of a Poincaré section, of which only two coordinates are seen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import sympy

import core
from core.kernels import Floats
from core.symbolic import TIME
from pwsviz.geometry.section_plane import surface_functions

__all__ = ["StateAt", "on_section", "state_at"]

STEPS = 60
"""Most steps of Newton's method, damped ones included."""

CLOSE = 1e-13
"""Change of the state, relative to its size, below which Newton's method has arrived."""

FULFILLED = 1e-9
"""Largest |h|, and change of ψ, relative to its size, of a state that counts as found."""


class StateAt(NamedTuple):
    """A state on a section."""

    x: tuple[float, ...]
    taken: tuple[str, ...]
    """What the coordinates that are not shown were taken from: "h = 0" and "ψ = 0.125"."""


class _Condition(NamedTuple):
    """What a state has to fulfil."""

    function: sympy.Expr
    value: float
    words: str


def state_at(system: core.PiecewiseSystem, of: str, given: Mapping[int, float], near: Floats, mode: int) -> StateAt:
    """Return the state at t = 0 that has some coordinates and lies on a section.

    The other coordinates follow from h = 0 and, as far as that leaves them open, from the conserved quantities: these
    have the values of a state nearby. What is still open changes as little as possible from there. Where h depends on
    no other coordinate, the given ones change, as little as possible, until h = 0.

    Parameters
    ----------
    of
        h, or "" for the system's own surfaces.
    given
        Values of coordinates, by the number of the variable.
    near
        (d,) a state on the section.
    mode
        Number of the region whose conserved quantities count; of none, they do not.

    Raises
    ------
    ValueError
        If there is no such state nearby.
    """
    hidden = [k for k in range(system.dimension) if k not in given]
    start = np.array([given.get(k, value) for k, value in enumerate(near.tolist())])
    start = _on_surface(system, of, start, near, hidden)
    conditions = _conditions(system, of, near, mode, hidden)
    if not conditions:
        return StateAt(tuple(start.tolist()), ())
    found = _newton(system, start, hidden, conditions)
    words = tuple(one.words for one in conditions)
    if found is None:
        raise ValueError(f"No state here has {' and '.join(words)}: click where there are points, or near them.")
    return StateAt(tuple(found.tolist()), words)


def on_section(system: core.PiecewiseSystem, of: str, x: tuple[float, ...]) -> bool:
    """Whether a state is on a section at t = 0; on any of several surfaces."""
    functions = surface_functions(system, of)
    values = system.laws.evaluate(("h", of), functions, 0.0, np.array(x), system.parameter_array)
    return float(np.abs(values).min()) <= FULFILLED * (1.0 + float(np.abs(x).max()))


def _surface_at(system: core.PiecewiseSystem, of: str, near: Floats) -> sympy.Expr:
    """Return h at t = 0; of several surfaces that on which a state nearby lies."""
    functions = [h.subs(TIME, 0) for h in surface_functions(system, of)]
    values = system.laws.evaluate(("h at t = 0", of), functions, 0.0, near, system.parameter_array)
    return functions[int(np.argmin(np.abs(values)))]


def _on_surface(system: core.PiecewiseSystem, of: str, start: Floats, near: Floats, hidden: list[int]) -> Floats:
    """Move given coordinates to h = 0 where they alone decide it."""
    h, x = _surface_at(system, of, near), system.laws.x
    within = [k for k in range(system.dimension) if x[k] in h.free_symbols]
    if not within or set(within) & set(hidden):
        return start
    found = _newton(system, start, within, [_Condition(h, 0.0, "")])
    if found is None:
        raise ValueError(f"No state near here has {_vanishing(of)}: click where there are points, or near them.")
    return found


def _vanishing(of: str) -> str:
    """Return the equation of the surface in words."""
    return "h = 0" if of else "g = 0"


def _conditions(system: core.PiecewiseSystem, of: str, near: Floats, mode: int, hidden: list[int]) -> list[_Condition]:
    """Return what determines the hidden coordinates."""
    unknown, laws, p = {system.laws.x[k] for k in hidden}, system.laws, system.parameter_array
    h = _surface_at(system, of, near)
    found = [_Condition(h, 0.0, _vanishing(of))] if h.free_symbols & unknown else []
    conserved = laws.regions[mode].conserved if 0 <= mode < len(laws.regions) else ()
    for psi in conserved:
        if len(found) < len(hidden) and psi.free_symbols & unknown and TIME not in psi.free_symbols:
            level = float(laws.evaluate(("level of", psi), [psi], 0.0, near, p)[0])
            found.append(_Condition(psi, level, f"ψ = {level:.6g}"))
    return found


def _newton(
    system: core.PiecewiseSystem, start: Floats, hidden: list[int], conditions: list[_Condition]
) -> Floats | None:
    """Fulfil conditions by Newton steps of least norm, damped where they lead away; None if that fails."""
    laws, p, functions = system.laws, system.parameter_array, tuple(one.function for one in conditions)
    wanted = np.array([one.value for one in conditions])
    rows = [sympy.diff(one, laws.x[k]) for one in functions for k in hidden]

    def defect(x: Floats) -> Floats:
        value = laws.evaluate(("conditions", functions), functions, 0.0, x, p)
        return np.asarray((value - wanted) / (1.0 + np.abs(wanted)))

    x, error = start, defect(start)
    for _ in range(STEPS):
        slopes = laws.evaluate(("slopes", functions, tuple(hidden)), rows, 0.0, x, p).reshape(len(functions), -1)
        if not (np.isfinite(slopes).all() and np.isfinite(error).all()):
            return None
        step = np.linalg.lstsq(slopes / (1.0 + np.abs(wanted))[:, None], -error, rcond=1e-10)[0]
        part = 1.0
        while True:
            tried = x.copy()
            tried[hidden] += part * step
            after = defect(tried)
            if np.linalg.norm(after) < np.linalg.norm(error) or part < 1e-3:  # nan is no less
                break
            part /= 2
        if not np.linalg.norm(after) < np.linalg.norm(error):
            break
        x, error = tried, after
        if np.abs(part * step).max() <= CLOSE * (1.0 + np.abs(x).max()):
            break
    return x if np.abs(error).max() <= FULFILLED else None
