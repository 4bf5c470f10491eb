"""How columns are written into messages to the browser."""

from __future__ import annotations

import gzip
import sys
from base64 import b64encode
from typing import Any

import numpy as np
from bokeh.core.serialization import Serializer

__all__ = ["InlineArray", "sent"]

FEW = 40
"""Entries up to which a column of numbers is sent as text."""

MOST = 8192
"""Numbers up to which an array is sent as base64 within the message, which makes it a third longer.

Bokeh sends an array in two messages of its own, and a picture has two dozen: writing them takes longer than all else
about the message.
"""


class InlineArray(np.ndarray):
    """An array of floats that is sent within the message."""


def _written(array: InlineArray, _: Serializer) -> dict[str, Any]:
    """Return the array as Bokeh writes it where messages cannot have parts, as in a file."""
    packed = gzip.compress(array.tobytes(), compresslevel=0)  # the browser unpacks it; to make it smaller takes longer
    data = {"type": "bytes", "data": b64encode(packed).decode("ascii")}
    return {
        "type": "ndarray", "array": data, "shape": list(array.shape), "dtype": array.dtype.name, "order": sys.byteorder,
    }  # fmt: skip


Serializer.register(InlineArray, _written)


def sent(column: Any) -> Any:
    """Return a column, or each cell of one that holds lines, in the form in which it takes the least time to send."""
    if isinstance(column, list) and column and isinstance(column[0], list | np.ndarray):
        return [_inline(cell) if isinstance(cell, np.ndarray) else sent(cell) for cell in column]
    if isinstance(column, np.ndarray) and column.dtype.kind in "if" and len(column) <= FEW:
        return column.tolist()
    return _inline(column) if isinstance(column, np.ndarray) else column


def _inline(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    fits = array.dtype == np.float64 and array.size <= MOST
    return array.view(InlineArray) if fits else array
