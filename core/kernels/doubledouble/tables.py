"""Constants of the double-double elementary functions, evaluated once, on import."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import accumulate
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

_mp = mpmath.mp.clone()
_mp.dps = 80
_ONE = 2**240  #: numbers are split as integer multiples of its inverse

Table = tuple[NDArray[np.float64], NDArray[np.float64]]


def _parts(value: Any, count: int = 2) -> tuple[float, ...]:
    """Split a number into `count` doubles, each the nearest to the remainder of those before it."""
    rest, parts = int(_mp.nint(value * _ONE)), []
    for _ in range(count):
        parts.append(rest / _ONE)  # the quotient of Python integers is correctly rounded
        rest -= int(parts[-1] * _ONE)
    return tuple(parts)


def _powers(base: Any, first: int, end: int) -> Iterator[Any]:
    """base^n for first ≤ n < end, each from the power before it."""
    return accumulate(range(first + 1, end), lambda power, _: power * base, initial=base**first)


def _table(values: Iterable[Any]) -> Table:
    """High parts and low parts of numbers."""
    pairs = np.array([_parts(value) for value in values])
    return pairs[:, 0].copy(), pairs[:, 1].copy()


#: log(2)/128.
EXP_STEP = _parts(_mp.log(2) / 128)
#: 128/log(2).
EXP_STEPS_PER_UNIT = float(128 / _mp.log(2))
#: 2^(j/128) − 1 for −64 ≤ j < 64.
EXP_HIGH, EXP_LOW = _table(power - 1 for power in _powers(_mp.mpf(2) ** (_mp.mpf(1) / 128), -64, 64))

#: log 2.
LOG_2 = _parts(_mp.log(2))
#: The first integer i of the table: i/128 runs from 1/√2 to √2.
LOG_FIRST = 90
#: c = 128/i in double precision.
LOG_C = np.array([128.0 / i for i in range(LOG_FIRST, 182)])
#: −log c.
LOG_HIGH, LOG_LOW = _table(-_mp.log(c) for c in LOG_C.tolist())

#: π/512 in three parts.
SIN_STEP = _parts(_mp.pi / 512, 3)
#: 512/π.
SIN_STEPS_PER_UNIT = float(512 / _mp.pi)
#: sin(n π/512) over a whole turn, 0 ≤ n < 1024.
SIN_HIGH, SIN_LOW = (
    np.concatenate((q[:-1], q[:0:-1], -q[:-1], -q[:0:-1]))
    for q in _table(turned.imag for turned in _powers(_mp.expjpi(_mp.mpf(1) / 512), 0, 257))
)
