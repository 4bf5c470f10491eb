"""Warn of runs backward in time in which something happens that is not undone: a jump, or a transition one way."""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from core.integration.trajectory import Trajectory
from core.symbolic.impacts import keeps
from core.symbolic.laws import Way
from core.symbolic.source_text import to_text
from core.symbolic.zero_testing import is_zero
from core.system import PiecewiseSystem

__all__ = ["not_undone"]


def not_undone(run: Trajectory) -> Iterator[str]:
    """Say that a run backward in time does not lead to where a solution forward in time comes from.

    Jumps and transitions are made as they are forward in time. That undoes a jump which is its own inverse on the
    surface, as of an elastic impact.

    Yields
    ------
    str
        A sentence without the last full stop; none where all that may have happened is undone.
    """
    if not run.t[-1] < run.t[0]:
        return
    laws = run.system.laws
    for way in (way for ways in laws.ways for way in ways):
        surface = laws.surfaces[way.surface]
        if way.jump is None:
            lost = way.to is not None and way.back is None
        else:
            lost = _leaves(run.system, way) or (run.crossing_count > 0 and not _is_own_inverse(run.system, way))
        if lost:
            what = "transition" if way.jump is None else "jump"
            yield (
                f"Backward in time the {what} at {to_text(surface)} = 0 is made as it is forward in time, not undone: "
                "states beyond it are not those from which a solution comes here"
            )
            return


def _leaves(system: PiecewiseSystem, way: Way) -> bool:
    """Whether a jump leads off its surface: backward in time it is never met."""
    g, after = _in_numbers(system, way)
    return not keeps(g, g, system.laws.x, after)


def _is_own_inverse(system: PiecewiseSystem, way: Way) -> bool:
    _, after = _in_numbers(system, way)
    x = system.laws.x
    twice = (u.xreplace(dict(zip(x, after, strict=True))) for u in after)
    return all(is_zero(u - v) for u, v in zip(twice, x, strict=True))


def _in_numbers(system: PiecewiseSystem, way: Way) -> tuple[sympy.Expr, list[sympy.Expr]]:
    """The switching function of a way, and the state after its jump, with the present values of the parameters."""
    values = {p: sympy.Rational(system.values[p.name]) for p in system.laws.p}
    return system.laws.surfaces[way.surface].xreplace(values), [u.xreplace(values) for u in way.jump or ()]
