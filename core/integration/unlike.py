"""Keep the stretches of a run in which the mean rates of change differ most, for `diagnostics.resolution`.

A step that leaps over something narrow takes the state farther, or less far, than its neighbours do. The loop looks at
the state once in a number of steps only, which costs a hundredth of a step of order 4.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the arguments.

from __future__ import annotations

from core.kernels.jit import internal

__all__ = ["STEPS_BETWEEN", "begun_rows", "kept_rows", "look", "rows_of_looks"]

#: Steps between two looks, a power of two: a look costs as much as a step of order 4.
STEPS_BETWEEN = 128
#: Number of equal parts of a run, at most, of each of which the largest change of each coordinate's rate is kept.
_PARTS = 32
#: Rows of a table of looks, of 3 + d columns: the last two looks, one after the other, as (t, -, mode, x); the mean
#: rates between them, and the largest so far; then, by part and coordinate, (t, change, mode, x) of the change kept.
_RATES, _LARGEST, _KEPT = 2, 3, 4


def rows_of_looks(d: int) -> int:
    """Number of rows that a table of looks has."""
    return _KEPT + _PARTS * d


def begun_rows(looks: int) -> list[int]:
    """Rows of the last looks of a segment, between which and the end of the run no change of rates has been seen."""
    return [looks & 1] if looks > 1 else [0] if looks else []


def kept_rows(changes: int, doublings: int, d: int) -> range:
    """Rows of the changes kept."""
    return range(_KEPT, _KEPT + (1 + ((changes - 1) >> doublings)) * d if changes else _KEPT)


@internal
def look(run, x, looks):
    """Look at the state at the end of a step, and keep the change of each coordinate's rate if it is large."""
    if run.look_segment != run.crossings:
        run.look_segment, run.looks = run.crossings, 0
    row, before, last = -1, run.looks & 1, (run.looks + 1) & 1
    if run.looks > 1:
        row = row_of_change(run, x.size, looks)
    elif run.changes + run.looks == 0:
        for i in range(x.size):
            looks[_LARGEST, 3 + i] = 0.0
    if run.looks > 0:
        per = 1.0 / (run.t - looks[last, 0])
        for i in range(x.size):
            rate = (x[i] - looks[last, 3 + i]) * per
            looks[_LARGEST, 3 + i] = max(looks[_LARGEST, 3 + i], abs(rate))
            change = abs(rate - looks[_RATES, 3 + i])
            looks[_RATES, 3 + i] = rate
            if row >= 0 and change > looks[row + i, 1]:
                keep(looks[before], change, looks[row + i])
                run.unlike = max(run.unlike, change / looks[_LARGEST, 3 + i])
    looks[before, 0], looks[before, 2] = run.t, run.mode
    for i in range(x.size):
        looks[before, 3 + i] = x[i]
    run.looks += 1


@internal
def row_of_change(run, d, looks):
    """Row for another change, of the first coordinate; if all parts are used, every two are joined."""
    if run.changes == _PARTS << run.doublings:
        run.doublings += 1
        for k in range(_PARTS // 2 * d):
            one = _KEPT + 2 * d * (k // d) + k % d
            if not looks[one, 1] >= looks[one + d, 1]:
                one += d
            for i in range(3 + d):
                looks[_KEPT + k, i] = looks[one, i]
    row = _KEPT + (run.changes >> run.doublings) * d
    if run.changes & ((1 << run.doublings) - 1) == 0:
        for i in range(d):
            looks[row + i, 1] = -1.0
    run.changes += 1
    return row


@internal
def keep(begun, change, kept):
    """Keep the change between two stretches, with where the first of them began."""
    for i in range(kept.size):
        kept[i] = begun[i]
    kept[1] = change
