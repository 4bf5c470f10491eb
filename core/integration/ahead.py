"""What lies beside a run that could not go on: where g jumps, where g = 0 crosses itself, an unbounded field."""

from __future__ import annotations

import numpy as np
from sympy import Expr

from core.integration.explained import Explained
from core.integration.recorded import Point
from core.kernels.arrays import Floats
from core.symbolic.singularities import BESIDE
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["Ahead", "what_is_ahead"]

#: Steps from a run that are looked at along its field, ahead and behind, and places on them.
_STEPS, _PLACES = 4.0, 513
#: By how much these are moved: a pole may be a whole number of steps away.
_UNEVEN = 1e-3 / np.pi
#: How many times as far a slide is looked at: a method that chooses its steps may have made short ones only.
_ALONG = 16.0
#: Most changes of the sign of g that are looked at, halvings of the interval of each, …
_CHANGES, _HALVINGS = 8, 50
#: … and the part of g at its ends that is left of a jump, but not of a zero.
_JUMPS = 0.1
#: Part of its size to which the gradient of g decreases where the surface crosses itself.
_VANISHES = 0.02
#: Ratio of distances from a surface at which an unbounded field is compared, and least ratio of its sizes there: that
#: of a logarithm is 1.1, and that of a bounded field 1 to 11 digits.
_FARTHER, _GROWS = 16.0, 1.02


class Ahead(Explained):
    """Why no step leads on; each with what to do about it."""

    JUMP_OF_G = (
        "g changes its sign next to this place, but not by a zero, as at a pole, and only zeros of g are met",
        "Switch by functions that vanish where the law is to change: numerator and denominator, each as a surface of "
        "its own.",
    )
    DOUBLE_POINT = (
        "the surface g = 0 crosses itself ahead, where the rates of both sides vanish, so that the laws do not tell "
        "where sliding leads",
        "Declare each branch as a surface of its own, as x and y in place of x*y, or end the run before.",
    )
    UNBOUNDED_FIELD = (
        "the field is not bounded at the surface where this step begins",
        "No step can begin there, however small: take variables in which the field is bounded, or end the run before.",
    )


def what_is_ahead(system: PiecewiseSystem, last: Point, step: float) -> Ahead | None:
    """Why a run cannot go on from a place by a step of some signed length; None if nothing of this kind is found."""
    if last.mode == NO_MODE or not np.isfinite(step):
        return None
    mode = system.laws.mode(last.mode).written
    here = np.array([(last.t, *last.x)])
    with np.errstate(all="ignore"):
        if not mode.slides and _is_unbounded(system, here, mode.field, mode.heights):
            return Ahead.UNBOUNDED_FIELD
        field = _values(system, mode.field, here)[0]
        if not np.isfinite(field).all():
            return None
        parts, way = np.linspace(-1.0, 1.0, _PLACES)[:, None] + _UNEVEN, step * _STEPS * np.array([1.0, *field])
        if mode.surface is not None:
            turns = _turns(system, here + _ALONG * parts[parts[:, 0] > 0.0] * way, mode.surface)
            return Ahead.DOUBLE_POINT if turns else None
        along = here + parts * way
        jumps = any(_jumps(system, along, height) for height in mode.heights)
    return Ahead.JUMP_OF_G if jumps else None


def _values(system: PiecewiseSystem, expressions: tuple[Expr, ...], places: Floats) -> Floats:
    """Values of expressions, a column each, at times and states, a row each."""
    return system.laws.evaluate(
        ("ahead", expressions), expressions, places[:, 0], places[:, 1:], system.parameter_array
    )


def _gradient(system: PiecewiseSystem, g: Expr, places: Floats) -> Floats:
    return _values(system, tuple(g.diff(v) for v in system.laws.x), places)


def _is_unbounded(system: PiecewiseSystem, here: Floats, field: tuple[Expr, ...], heights: tuple[Expr, ...]) -> bool:
    """Whether the field grows without bound towards the surface next to a place, if that is on it."""
    if not heights:
        return False
    met = heights[int(np.argmin(np.abs(_values(system, heights, here)[0])))]
    inward = _gradient(system, met, here)[0]
    unit = BESIDE * max(1.0, float(np.abs(here[0, 1:]).max()))
    if not 0.0 < float(np.linalg.norm(inward)) < np.inf:
        return False
    near = here.repeat(3, axis=0)
    near[:, 1:] += unit * _FARTHER ** np.arange(3.0)[:, None] * inward / np.linalg.norm(inward)
    high = _values(system, (met,), np.concatenate([here, near[:1]]))[:, 0]
    sizes = np.abs(_values(system, field, near)).max(axis=1)
    return bool(abs(high[0]) < high[1] and (sizes[:-1] >= _GROWS * sizes[1:]).all())


def _turns(system: PiecewiseSystem, along: Floats, surface: Expr) -> bool:
    """Whether the gradient of g vanishes, or turns back, along some places."""
    gradients = _gradient(system, surface, along)
    part = gradients @ gradients[0] / (gradients[0] @ gradients[0])
    return bool((part < _VANISHES).any())


def _jumps(system: PiecewiseSystem, along: Floats, height: Expr) -> bool:
    """Whether a function changes its sign along some places, but not by a zero."""
    values = _values(system, (height,), along)[:, 0]
    changes = np.flatnonzero(values[1:] * values[:-1] < 0.0)[:_CHANGES]
    return any(_jumps_between(system, along[k : k + 2], values[k : k + 2], height) for k in changes)


def _jumps_between(system: PiecewiseSystem, ends: Floats, values: Floats, height: Expr) -> bool:
    """Whether the change of sign between two places is none by a zero."""
    low, high = ends
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = _values(system, (height,), middle[None])[0, 0] * values[0] > 0.0
        low, high = (middle, high) if below else (low, middle)
    left = np.abs(_values(system, (height,), np.array([low, high]))[:, 0]).max()
    return bool(not np.isfinite(left) or left > _JUMPS * np.abs(values).max())
