"""Search steps for features of a height that are narrower than the distances of the places at which it is sampled.

Where bounds on the height over a box around the way between two places do not tell that it is positive, the piece is
cut into shorter ones, in smaller boxes. If the height is negative throughout a box, it has two zeros there: a pair of
crossings that no place has shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.diagnostics.boxes import CUTS, PARTS, Bounds, Cubics, Way
from core.kernels.arrays import Floats

__all__ = ["Dips", "dips_between", "doubts"]

#: Most pieces that are cut at a time, those with the lowest bounds.
_MOST = 512


class Dips(NamedTuple):
    """What bounds tell of a height in k steps, between the places of each."""

    found: NDArray[np.bool_]
    """(k,): it is negative somewhere between places at which it is positive."""
    none: NDArray[np.bool_]
    """(k, n - 1): it is positive throughout, from one place to the next."""


def dips_between(
    height: Expr, symbols: Sequence[Symbol], way: Way, parameters: Floats, wanted: NDArray[np.bool_]
) -> Dips:
    """Search steps for pairs of zeros of a height between places at which it is positive.

    Parameters
    ----------
    height : expression
        In the symbols.
    symbols : sequence of symbols
        Time, the d variables, and the parameters.
    way : Way
        The places.
    parameters : (m,) array
        Values of the parameters.
    wanted : (k, n - 1) array of bool
        Between which places to look.

    Returns
    -------
    Dips
    """
    found, none = np.zeros(len(wanted), dtype=bool), wanted.ravel().copy()
    with np.errstate(all="ignore"):
        cubics, bounds = Cubics.of(way), Bounds([height], symbols, parameters)
        none &= cubics.known
        number, row = np.flatnonzero(none), np.repeat(np.arange(len(wanted)), wanted.shape[1])
        begin, width = np.zeros(len(number)), 1.0
        for _ in range(CUTS + 1):
            low, high = (end[:, 0] for end in bounds.over(cubics.boxes(number, begin, width)))
            found[row[number[high < 0.0]]] = True
            undecided = np.flatnonzero(~(low > 0.0) & ~found[row[number]])
            if len(undecided) > _MOST:
                lowest = np.argpartition(np.nan_to_num(low[undecided], nan=-np.inf), _MOST)
                none[number[undecided[lowest[_MOST:]]]] = False
                undecided = undecided[lowest[:_MOST]]
            width /= PARTS
            begin = (begin[undecided, None] + width * np.arange(PARTS)).ravel()
            number = np.repeat(number[undecided], PARTS)
            if not len(number):
                break
        none[number] = False
    return Dips(found, none.reshape(wanted.shape) & ~found[:, None])


def doubts(height: Expr, symbols: Sequence[Symbol], way: Way, parameters: Floats, values: Floats) -> Floats:
    """How much bounds on a height leave in doubt that it is positive throughout steps at whose ends it is.

    Parameters
    ----------
    height, symbols, parameters
        As for `dips_between`.
    way : Way
        The two ends of each of k steps.
    values : (k, 2) array
        The height there.

    Returns
    -------
    (k,) array
        0 where it is positive throughout, or not at both ends; else up to 1: the lesser value at an end as part of its
        distance from the lower bound. Near a zero that a step ends at, there is little.
    """
    with np.errstate(all="ignore"):
        low, _ = Bounds([height], symbols, parameters).over(Cubics.of(way).boxes_of_all())
        low, least = low[:, 0], values.min(axis=1)
        return np.nan_to_num(np.where((least > 0.0) & (low <= 0.0), least / (least - low), 0.0))
