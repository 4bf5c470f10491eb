"""The table of a section of the benchmark, and its text."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNKNOWN", "Table", "milliseconds"]

#: A cell without a value.
UNKNOWN = "-"
#: Characters to a line of text.
_WIDTH = 110


@dataclass(frozen=True)
class Table:
    """Measured numbers, and how they were measured."""

    title: str
    about: str
    """What was measured, how, and in what unit."""
    header: Sequence[str]
    """k names of columns."""
    rows: Sequence[Sequence[str]]
    """Rows of k cells each."""

    @property
    def columns(self) -> dict[str, NDArray[np.str_]]:
        """Name of a column -> its cells as text; empty where there is no value."""
        cells = [["" if cell == UNKNOWN else cell for cell in row] for row in self.rows]
        return {name: np.array([row[k] for row in cells]) for k, name in enumerate(self.header)}

    @property
    def text(self) -> str:
        """The table as aligned text, words to the left and numbers to the right."""
        columns = list(zip(self.header, *self.rows, strict=True))
        aligned = [_aligned(column) for column in columns]
        lines = ["  " + "   ".join(cells).rstrip() for cells in zip(*aligned, strict=True)]
        return "\n".join([*textwrap.wrap(f"{self.title}: {self.about}", _WIDTH), *lines])


def _aligned(column: Sequence[str]) -> list[str]:
    width = max(map(len, column))
    if any(_is_number(cell) for cell in column[1:]):
        return [cell.rjust(width) for cell in column]
    return [cell.ljust(width) for cell in column]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def milliseconds(seconds: float) -> str:
    """A time (s) in ms, with three digits; `UNKNOWN` for nan."""
    value = 1e3 * seconds
    if value != value:
        return UNKNOWN
    return f"{value:.0f}" if value >= 99.5 else f"{value:.3g}" if value >= 1 else f"{value:.3f}"
