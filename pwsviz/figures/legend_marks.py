"""Marks in legends: over the line of a curve whose points are marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource
from bokeh.models.glyphs import Scatter
from bokeh.plotting import figure

__all__ = ["MARK_COLUMNS", "legend_marks", "mark_columns"]

MARK_COLUMNS = ("nowhere", "marker", "seen")
"""Columns that the source of the lines needs for their marks in the legend."""


def legend_marks(plot: figure, lines: ColumnDataSource) -> Any:
    """Return what a legend draws over its lines, of the source of these, as Bokeh asks for: nothing in the plot."""
    look: dict[str, Any] = {"fill_color": "colour", "line_color": "colour", "fill_alpha": "seen", "line_alpha": "seen"}
    return plot.add_glyph(lines, Scatter(x="nowhere", y="nowhere", marker="marker", **look))


def mark_columns(markers: Sequence[str], seen: bool) -> dict[str, Any]:
    """Return `MARK_COLUMNS` of lines.

    Parameters
    ----------
    markers : sequence of str
        The marker of each.
    seen : bool
        Whether there are marks; a legend draws a line without one only if its mark is transparent.
    """
    count = len(markers)
    return {"nowhere": [np.nan] * count, "marker": list(markers), "seen": [float(seen)] * count}
