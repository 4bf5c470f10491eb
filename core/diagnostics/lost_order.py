"""Test whether shorter steps converge as the order of the method says: beside a singularity of the field they do not.

The error of a way of given length falls as the power p of the step, the order of the method, where the field is smooth
along the way. Where a derivative is far larger within a step than beside it, as of a root or a logarithm next to the
border of where they are real, it falls as a lower power, and this one step limits the accuracy of the run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.departures import noise
from core.diagnostics.examined_steps import NEAR, Steps
from core.diagnostics.kept_at_zero import with_units_of_others
from core.kernels.arrays import Floats

__all__ = ["too_long_for_the_order"]

#: Least error that is reported, as part of the longest way of a step, and the part of its order that a method keeps.
_LEAST, _KEPT = 1e-5, 0.5
#: Error, as part of the longest way, from which on the order may be lower by one at the most, and higher by so much:
#: the error of a step that does not resolve a peak falls faster than that of one that does.
_LARGE, _HIGHER = 1e-3, 1.5
#: Part of the sum of the usual errors of all steps, which are taken for the median error, that is reported.
_OF_ALL = 0.2
#: Error of a step by rounding of the state, relative to it.
_ROUNDING = 2.0**-48
#: Part of a step that is left out before a surface on which the field has no value.
_BEFORE = 2.0**-16
#: Most steps, those with the largest errors, of which the order is estimated.
_MOST = 64


class _Largest(NamedTuple):
    """Of some steps."""

    errors: Floats
    """(k, 3) distances between the ends of a step and of two halves, of these and of four quarters, of these and of
    eight parts, in units of the longest way."""
    of_rounding: Floats
    """(k,) bounds on what rounding adds to each."""


def too_long_for_the_order(groups: Sequence[Steps]) -> Iterator[str]:
    """Warn of the step with the largest error that does not fall with the step as the order of the method says."""
    steps = reduce(Steps.with_others, groups)
    p = steps.method.order
    if p is None or not len(steps):
        return
    rows, found = _largest(steps)
    with np.errstate(all="ignore"):
        halved = np.log2(found.errors[:, :-1] / found.errors[:, 1:])
        told = found.errors[:, :1] > found.of_rounding[:, None] * 2.0 ** (p * np.arange(1, 3))
        large = found.errors[:, 0] > _LARGE
        order = np.where(told, halved, np.inf).min(axis=1)
        lost = order < np.where(large, max(p - 1.0, _KEPT * p), _KEPT * p)
        higher = large & told[:, 0] & (halved[:, 0] > p + _HIGHER) & ~lost
        order = np.where(higher, halved[:, 0], order)
        lost |= higher
    if lost.any():
        worst = int(np.argmax(np.where(lost, found.errors[:, 0], 0.0)))
        power, far = max(float(order[worst]), 0.0), "far " if order[worst] < p else ""
        falls = f"falls as tau^{power:.2g}" if np.isfinite(power) else "vanishes with half of it"
        yield (
            f"{steps.named(rows[worst])} is too long for {steps.method.name} to keep its order: the field changes too "
            f"fast in it, so that the error, {found.errors[worst, 0]:.1g} of the longest step, {falls}, "
            f"not as tau^{p}; take a {far}smaller tau, or the method taylor, which chooses its steps"
        )


def _largest(steps: Steps) -> tuple[NDArray[np.intp], _Largest]:
    """Rows of the steps with the largest errors, none of them usual, and what is known of these steps."""
    steps = _before_the_surface(steps)
    whole, halves = _end(steps, 1), _end(steps, 2)
    with np.errstate(all="ignore"):
        unit = np.nanmax(np.abs(halves - steps.x), axis=0, initial=0.0)
        unit = with_units_of_others(steps.run, np.where(unit > 0.0, unit, np.inf))
        error = np.nan_to_num((np.abs(whole - halves) / unit).max(axis=1), nan=0.0, posinf=0.0)
    rows = np.argsort(-error, kind="stable")[:_MOST]
    rows = rows[error[rows] > max(_OF_ALL * steps.run.steps * float(np.median(error)), _LEAST)]
    some = steps.some(rows)
    quarters, eighths = _end(some, 4), _end(some, 8)
    with np.errstate(all="ignore"):
        later = [(np.abs(a - b) / unit).max(axis=1) for a, b in ((halves[rows], quarters), (quarters, eighths))]
        clock = np.abs(np.spacing(some.t) / some.h)[:, None] * np.abs(halves[rows] - some.x)  # of how long a step is
        rounding = ((noise(some) + _ROUNDING * np.abs(some.x) + clock) / unit).max(axis=1)
    return rows, _Largest(np.column_stack([error[rows], *later]), rounding)


def _before_the_surface(steps: Steps) -> Steps:
    """The steps, of which those end just before the surface that have no value on it, as of a field 1/sqrt(g)."""
    whole = np.abs(steps.h) >= (1.0 - NEAR) * steps.run.tau
    cut = np.flatnonzero(~whole)
    ends = [_end(steps.some(cut), count) for count in (1, 2, 4, 8)] if len(cut) else []
    bare = cut[~np.isfinite(ends).all(axis=(0, 2))] if ends else cut
    h = steps.h.copy()
    h[bare] *= 1.0 - _BEFORE
    return Steps(steps.run, steps.t, steps.x, steps.mode, h) if len(bare) else steps


def _end(steps: Steps, count: int) -> Floats:
    """States (k, d) to which a number of equal parts of each step lead, one after another; nan where one has none."""
    t, x, h = steps.t, steps.x, steps.h / count
    for _ in range(count):
        x = steps.states(t, x, steps.mode, (t + h)[:, None])[:, 0]
        t = t + h
    return x
