"""Keep the stretches of a run in which the mean rates of change differ most, for `diagnostics.resolution`.

A step that leaps over something narrow takes the state farther, or less far, than its neighbours do. The loop looks at
the state once in a number of steps only, which costs a hundredth of a step.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the arguments.

from __future__ import annotations

from core.kernels.jit import internal

__all__ = ["STEPS_BETWEEN", "begun_rows", "kept_rows", "look", "rows_of_looks"]

#: Steps between two looks, a power of two.
STEPS_BETWEEN = 64
#: Number of equal parts of a run, at most, of each of which the largest change of each coordinate's rate is kept.
_PARTS = 32
#: Rows of a table of looks, of 3 + d columns: the last look and the one before, as (t, -, mode, x); the mean rates
#: between them, and the largest so far; then, by part and coordinate, (t, change, mode, x) of the change kept.
_LAST, _BEFORE, _RATES, _LARGEST, _KEPT = range(5)


def rows_of_looks(d: int) -> int:
    """Number of rows that a table of looks has."""
    return _KEPT + _PARTS * d


def begun_rows(run_looks: int) -> list[int]:
    """Rows of the last looks of a segment, between which and the end of the run no change of rates has been seen."""
    return [_BEFORE] if run_looks > 1 else [_LAST] if run_looks else []


def kept_rows(changes: int, part: int, d: int) -> range:
    """Rows of the changes kept."""
    return range(_KEPT, _KEPT + -(-changes // part) * d if changes else _KEPT)


@internal
def look(run, x, looks):
    """Look at the state at the end of a step, and keep the change of each coordinate's rate if it is large."""
    if run.look_segment != run.crossings:
        run.looks = 0
    if run.looks > 0:
        if run.looks > 1:
            begin_change(run, x.size, looks)
        for i in range(x.size):
            rate = (x[i] - looks[_LAST, 3 + i]) / (run.t - looks[_LAST, 0])
            largest = max(abs(rate), looks[_LARGEST, 3 + i] if run.changes + run.looks > 1 else 0.0)
            looks[_LARGEST, 3 + i] = largest
            if run.looks > 1:
                keep_change(run, i, abs(rate - looks[_RATES, 3 + i]), x.size, looks)
            looks[_RATES, 3 + i] = rate
        for i in range(3 + x.size):
            looks[_BEFORE, i] = looks[_LAST, i]
        run.looks = 2
    else:
        run.looks = 1
    looks[_LAST, 0], looks[_LAST, 2] = run.t, run.mode
    for i in range(x.size):
        looks[_LAST, 3 + i] = x[i]
    run.look_segment = run.crossings


@internal
def begin_change(run, d, looks):
    """Make room for another change; if all parts are used, join every two."""
    if run.changes == _PARTS * run.part:
        run.part *= 2
        for k in range(_PARTS // 2 * d):
            one = _KEPT + 2 * d * (k // d) + k % d
            if not looks[one, 1] >= looks[one + d, 1]:
                one += d
            for i in range(3 + d):
                looks[_KEPT + k, i] = looks[one, i]
    if run.changes % run.part == 0:
        for i in range(d):
            looks[_KEPT + run.changes // run.part * d + i, 1] = -1.0
    run.changes += 1


@internal
def keep_change(run, i, change, d, looks):
    """Keep the change of a coordinate's rate, if it is the largest of its part of the run."""
    kept = looks[_KEPT + (run.changes - 1) // run.part * d + i]
    if change > kept[1]:
        kept[1], kept[0], kept[2] = change, looks[_BEFORE, 0], looks[_BEFORE, 2]
        for k in range(d):
            kept[3 + k] = looks[_BEFORE, 3 + k]
        run.unlike = max(run.unlike, change / looks[_LARGEST, 3 + i])
