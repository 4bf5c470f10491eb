"""Check arguments that must be numbers; raise a ValueError that names the argument and its value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["checked_sliding", "choice", "count", "listed", "number", "numbers", "plain_numbers"]

#: Types that Python would convert to numbers, but that are refused.
_NO_NUMBERS = (str, bytes, bytearray, bool, np.bool_, np.complexfloating, np.datetime64, np.timedelta64)
#: Types of numbers that need no closer look.
_PLAIN = frozenset((float, int, np.float64))
#: Types that Python would convert to sequences, but that are refused: "12", b"12", {2, 1} in any order.
_UNORDERED = (str, bytes, bytearray, Set, Mapping)


def number(value: Any, what: str) -> float:
    """Return a finite float, else raise ValueError; text and truth values are refused."""
    try:
        if type(value) not in (float, int) and (isinstance(value, _NO_NUMBERS) or np.ndim(value)):
            raise TypeError
        found = float(value)
    except OverflowError:
        found = math.inf
    except (TypeError, ValueError):
        raise ValueError(f"{what} = {value!r} is not a number") from None
    if not math.isfinite(found):
        raise ValueError(f"{what} = {value!r}: a finite number is needed")
    return found


def count(value: Any, what: str, most: float = math.inf) -> int:
    """Return an integer from 1 to `most`, else raise ValueError."""
    found = number(value, what)
    if found < 1 or found != int(found) or found > most:
        span = "of at least 1" if most == math.inf else f"from 1 to {most:,}"
        raise ValueError(f"{what} = {value!r}: a whole number {span} is needed")
    return int(found)


def listed(values: Any, what: str, wanted: str, alone: type | tuple[type, ...] = ()) -> tuple[Any, ...]:
    """Return the elements of a sequence, else raise ValueError; text and unordered collections are refused.

    A value of one of the types `alone` counts as a sequence of one element.
    """
    if isinstance(values, alone):
        return (values,)
    try:
        if isinstance(values, _UNORDERED):
            raise TypeError
        return tuple(values)
    except TypeError:
        raise ValueError(f"{what} = {values!r}: {wanted}") from None


def plain_numbers(values: Any, count: int) -> tuple[float, ...] | None:
    """Return the finite floats that a tuple, a list or an array plainly holds; None where a closer look is needed."""
    if type(values) is np.ndarray:
        values = values.tolist()
    if type(values) not in (tuple, list) or len(values) != count or not _PLAIN.issuperset(map(type, values)):
        return None
    try:
        found = tuple(map(float, values))
    except OverflowError:
        return None
    return found if math.isfinite(sum(found)) else None


def choice(value: Any, what: str, options: tuple[str, ...]) -> str:
    """Return one of some words, else raise ValueError."""
    if not isinstance(value, str) or value not in options:
        raise ValueError(f"{what} = {value!r}: choose from {', '.join(options)}")
    return value


def checked_sliding(value: Any) -> bool:
    """Return whether a run slides, from "stop" or "continue"."""
    return choice(value, "sliding", ("stop", "continue")) == "continue"


def numbers(values: Any, what: str) -> NDArray[np.float64]:
    """Return an array of finite floats of the same shape, else raise ValueError."""
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        raise ValueError(f"{what} = {values!r}: an array of numbers is needed") from None
    if array.dtype.kind not in "fiu":
        if array.dtype.kind != "O":
            raise ValueError(f"{what} = {values!r}: numbers are needed")
        array = np.array([number(v, what) for v in array.ravel()]).reshape(array.shape)
    array = array.astype(np.float64)
    finite = np.isfinite(array)
    if not finite.all():
        raise ValueError(f"{what} holds {array[~finite][0]!r}: finite numbers are needed")
    return array
