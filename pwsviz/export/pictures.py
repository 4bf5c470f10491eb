"""Pictures of a figure for a paper or a lecture: SVG, PDF and PNG, made in the browser by `pictures.js`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import ClassVar

from bokeh.plotting import figure

__all__ = ["CHOICES", "KINDS", "PictureFiles", "picture_callback", "pixels"]

KINDS = ("svg", "pdf", "png")
"""Formats; the first two are vectors."""

CHOICES: Mapping[str, tuple[str, tuple[str, ...], int]] = {
    "width": ("Width", ("85 mm", "175 mm", "250 mm"), 1),  # of a column, a page, a slide
    "height": (
        "Height at most (long captions add to it)",
        ("80 mm", "120 mm", "160 mm", "200 mm"),
        2,
    ),  # with the caption
    "points": ("Text", ("8 pt", "9 pt", "10 pt", "12 pt"), 1),
    "dpi": ("PNG", ("150 dpi", "300 dpi", "600 dpi"), 1),  # of a screen, and what journals ask of images and of lines
    "look": ("Colours", ("for print", "as on the page"), 0),
    "caption": ("Caption", ("no caption", "short", "full"), 1),
}
"""Title, options and the number of the default option of each choice about pictures."""


def pixels(width: str, dpi: str) -> str:
    """Return the width in pixels of a PNG, in words, for these two of `CHOICES`."""
    return f"{round(int(width.split()[0]) / 25.4 * int(dpi.split()[0])):,} pixels wide"


class PictureFiles:
    """What the browser fetches to make a picture, and only then; the server of Panel finds it by these attributes."""

    _resources: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "files": (
            "pictures.js",
            "picture_clip.js",
            "picture_layout.js",
            "picture_letters.js",
            "picture_markers.js",
            "picture_names.js",
            "vendor/jspdf.umd.min.js",
            "vendor/svg2pdf.umd.min.js",
            "vendor/DejaVuSans-subset.ttf",
            "vendor/DejaVuSans-Oblique-subset.ttf",
        )
    }


_SAVE = """
const files = new URL("components/MODULE/PictureFiles/_resources/files/", document.baseURI)
const wished = { ...wish }
for (const [name, choice] of Object.entries({ CHOICES })) wished[name] = choice.data.value
wished.name = wish.name.replace(/\\.\\w+$/, ending => `-${parseInt(wished.width)}mm${ending}`)
const tell = words => trouble.data.setv({ object: words }, { sync: false })  // or the server would repeat it, late
tell("")
import(new URL("pictures.js", files)).then(({ save }) => save(IDS, wished)).then(tell).catch(reason => {
  const why = String(reason?.message ?? reason).replace(/[<>&*_`]/g, " ")
  const advice = "Is the page still connected? If so, try SVG, or another width."
  tell(`${wished.name} could not be saved: ${why}. ${advice}`)
})
"""


def picture_callback(plots: Sequence[figure]) -> str:
    """Return JavaScript that saves figures as one file, one below the other.

    It takes from its arguments ``wish``, a mapping with ``kind`` (of `KINDS`), ``name`` of the file, ``title``,
    ``captions``, "short" and "full", and ``shades``, the opacity in print of each colour of ground; a widget for each
    of `CHOICES`; and ``trouble``, a pane for the reason of a failure, of which the server does not learn.
    """
    code = _SAVE.replace("MODULE", __name__).replace("CHOICES", ", ".join(CHOICES))
    return code.replace("IDS", json.dumps([plot.id for plot in plots]))
