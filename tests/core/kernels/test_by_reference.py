"""Named tuples passed to jitted functions as one pointer."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from core.kernels.by_reference import by_reference


class Pair(NamedTuple):
    """Two arrays and a number."""

    x: Any
    matrix: Any
    scale: Any


@njit
def scaled(pair, k):
    pair.x[k] *= pair.scale
    return pair.matrix.shape[0]


@njit
def scale_all(x, matrix, scale):
    pair = by_reference(Pair(x, matrix, scale))
    rows = 0
    for k in range(x.size):
        rows += scaled(pair, k)
    return rows


def test_fields_are_those_of_the_tuple_and_arrays_are_written_through():
    x, matrix = np.array([1.0, 2.0, 3.0]), np.zeros((5, 2))[::2]
    assert scale_all(x, matrix, 2.0) == 9
    np.testing.assert_array_equal(x, [2.0, 4.0, 6.0])
    assert scale_all(x.astype(np.float32), np.zeros((1, 1), dtype=np.int64), 3) == 3


def test_each_call_has_a_reference_of_its_own():
    @njit
    def sum_of_both(x, y):
        first, second = by_reference(Pair(x, y, 1.0)), by_reference(Pair(y, x, 2.0))
        return first.x[0] * first.scale, second.x[0] * second.scale

    assert sum_of_both(np.array([1.0]), np.array([10.0])) == (1.0, 20.0)


def test_a_field_that_the_tuple_has_not_is_refused():
    @njit
    def wrong(x):
        return by_reference(Pair(x, x, 1.0)).y

    with pytest.raises(TypingError, match="Unknown attribute 'y'"):
        wrong(np.ones(1))
