"""Aligned text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

__all__ = ["aligned", "milliseconds"]


def aligned(header: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> Iterable[str]:
    """Lines of a table, indented; its first `left` columns start at the left, the others end at the right."""
    lines = [tuple(header), *(tuple(row) for row in rows)]
    widths = [max(len(cell) for cell in column) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = [c.ljust(w) if k < left else c.rjust(w) for k, (c, w) in enumerate(zip(line, widths, strict=True))]
        yield "  " + "   ".join(cells).rstrip()


def milliseconds(seconds: float | None) -> str:
    """Three digits of a time in ms; "-" for None."""
    if seconds is None:
        return "-"
    value = 1e3 * seconds
    return f"{value:.0f}" if value >= 99.5 else f"{value:.3g}" if value >= 1 else f"{value:.3f}"
