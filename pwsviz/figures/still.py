"""A figure as SVG without a browser: its lines, areas and marks as they stand, without axes and texts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import singledispatch
from html import escape
from typing import Any

import numpy as np
from bokeh.core.property.vectorization import Field, Value
from bokeh.models import ColumnDataSource
from bokeh.models.glyph import Glyph
from bokeh.models.glyphs import Line, MultiLine, MultiPolygons, Scatter
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure
from numpy.typing import ArrayLike, NDArray

from pwsviz.geometry.window import Window

__all__ = ["still"]

UNITS = 2000.0
"""Units along the longer side of the window, to which places are rounded: about a pixel."""

Columns = dict[str, Any]
Place = tuple[float, float, float]  # of the left and upper end of the window, and units to a unit of the plane


def still(plot: figure, window: Window) -> str:
    """Return the SVG element that shows a window of a figure at equal scales, and around it as much as fits.

    Parameters
    ----------
    plot : figure
        Glyphs that are not lines, polygons or marks are left out; each mark is a disk of its size and colour, and a
        hollow one is white inside, and lies below all else, so that it hides no curve.
    window : Window
        Part of the plane; the element shows what lies around it as far as it has room.
    """
    scale = UNITS / max(window.width, window.height)
    place = window.x_low, window.y_high, scale
    parts = [part for renderer in sorted(plot.renderers, key=_covers) for part in _renderer_parts(renderer, place)]
    box = f"0 0 {window.width * scale:.0f} {window.height * scale:.0f}"
    return f'<svg viewBox="{box}" overflow="visible" aria-hidden="true">{"".join(parts)}</svg>'


def _covers(renderer: Any) -> bool:
    """Whether a renderer does not paint hollow marks."""
    glyph = renderer.glyph if isinstance(renderer, GlyphRenderer) else None
    return not (isinstance(glyph, Scatter) and glyph.fill_alpha == 0.0)


def _renderer_parts(renderer: Any, place: Place) -> Iterable[str]:
    if not isinstance(renderer, GlyphRenderer) or not renderer.visible:
        return ()
    source = renderer.data_source
    return _parts(renderer.glyph, dict(source.data), place) if isinstance(source, ColumnDataSource) else ()


@singledispatch
def _parts(_glyph: Glyph, _columns: Columns, _place: Place) -> list[str]:
    """Return the SVG elements of a glyph."""
    return []


@_parts.register
def _(glyph: Line, columns: Columns, place: Place) -> list[str]:
    return [_path(_track(columns["x"], columns["y"], place), _stroke(glyph, columns, 0))]


@_parts.register
def _(glyph: MultiLine, columns: Columns, place: Place) -> list[str]:
    lines = zip(columns["xs"], columns["ys"], strict=True)
    return [_path(_track(x, y, place), _stroke(glyph, columns, k)) for k, (x, y) in enumerate(lines)]


@_parts.register
def _(glyph: MultiPolygons, columns: Columns, place: Place) -> list[str]:
    elements = []
    for k, (xs, ys) in enumerate(zip(columns["xs"], columns["ys"], strict=True)):
        rings = [(x, y) for across, up in zip(xs, ys, strict=True) for x, y in zip(across, up, strict=True)]
        look = {
            "fill": _look(glyph, "fill_color", columns, k), "fill-opacity": _look(glyph, "fill_alpha", columns, k),
            "fill-rule": "evenodd",
        }  # fmt: skip
        elements.append(_path("".join(f"{_track(x, y, place)}Z" for x, y in rings), look))
    return elements


@_parts.register
def _(glyph: Scatter, columns: Columns, place: Place) -> list[str]:
    """Disks: lines without length, whose round ends keep their size at every scale, a filled one over its rim."""
    elements = []
    for k, (x, y) in enumerate(zip(columns["x"], columns["y"], strict=True)):
        dot, size = f"{_track([x], [y], place)}h0", _look(glyph, "size", columns, k)
        rim, room = _look(glyph, "line_color", columns, k), 2.0 * _look(glyph, "line_width", columns, k)
        seen = dot != "h0" and _look(glyph, "line_alpha", columns, k)
        fill = _look(glyph, "fill_color", columns, k) if _look(glyph, "fill_alpha", columns, k) else "white"
        for colour, width in ((rim, size), (fill, size - room)) if seen else ():
            elements.append(_path(dot, {**_line(colour, width), "stroke-linecap": "round"}))
    return elements


def _look(glyph: Glyph, name: str, columns: Columns, k: int) -> Any:
    """The value of a property of a glyph for its item k."""
    given = getattr(glyph, name)
    if isinstance(given, Field):
        return columns[given.field][k]
    if isinstance(given, str) and given in columns:
        return columns[given][k]
    return given.value if isinstance(given, Value) else given


def _stroke(glyph: Line | MultiLine, columns: Columns, k: int) -> dict[str, Any]:
    dash = _look(glyph, "line_dash", columns, k)
    look = _line(_look(glyph, "line_color", columns, k), _look(glyph, "line_width", columns, k))
    dashed = {"stroke-dasharray": " ".join(map(str, dash))} if isinstance(dash, Sequence) and len(dash) else {}
    return {**look, "stroke-opacity": _look(glyph, "line_alpha", columns, k), "stroke-linejoin": "round", **dashed}


def _line(colour: str, width: float) -> dict[str, Any]:
    return {"fill": "none", "stroke": colour, "stroke-width": width, "vector-effect": "non-scaling-stroke"}


def _path(track: str, look: dict[str, Any]) -> str:
    words = " ".join(f'{name}="{escape(str(value))}"' for name, value in look.items())
    return f'<path d="{track}" {words}/>' if track else ""


def _track(x: ArrayLike, y: ArrayLike, place: Place) -> str:
    """Commands that draw a line through points, broken where they are not finite; places are rounded to units."""
    left, top, scale = place
    points = np.column_stack([np.asarray(x, float) - left, top - np.asarray(y, float)]) * scale
    there = np.isfinite(points).all(axis=1)
    pieces = np.split(points, np.flatnonzero(~there))
    return "".join(_piece(piece[np.isfinite(piece).all(axis=1)]) for piece in pieces)


def _piece(points: NDArray[np.float64]) -> str:
    if not len(points):
        return ""
    whole = np.rint(points).astype(np.int64)
    steps = np.diff(whole, axis=0)
    steps = steps[steps.any(axis=1)]
    return f"M{whole[0, 0]} {whole[0, 1]}" + "".join(f"l{a} {b}" for a, b in steps.tolist())
