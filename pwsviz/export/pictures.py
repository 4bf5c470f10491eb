"""Pictures of a figure for a paper or a lecture: SVG, PDF and PNG, made in the browser by `pictures.js`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from bokeh.plotting import figure

__all__ = ["CHOICES", "KINDS", "OTHER", "WIDTHS", "PictureFiles", "picture_callback", "pixels"]

KINDS = ("svg", "pdf", "png")
"""Formats; the first two are vectors."""

OTHER = "other"
"""The width that is typed."""

WIDTHS = (30, 500)
"""Least and greatest width in mm that may be."""

CHOICES: Mapping[str, tuple[str, tuple[str, ...], int]] = {
    "width": ("Width", ("85 mm", "175 mm", "250 mm", OTHER), 1),  # of a column, a page, a slide
    "height": (
        "Height at most (long captions add to it)",
        ("80 mm", "120 mm", "160 mm", "200 mm"),
        2,
    ),  # with the caption
    "points": ("Text", ("8 pt", "9 pt", "10 pt", "12 pt"), 1),
    "typeface": ("Typeface", ("sans serif", "serif"), 0),
    "dpi": ("PNG", ("150 dpi", "300 dpi", "600 dpi"), 1),  # of a screen, and what journals ask of images and of lines
    "look": ("Colours", ("for print", "as on the page"), 0),
    "caption": ("Caption", ("no caption", "short", "full"), 1),
}
"""Title, options and the number of the default option of each choice about pictures."""


def pixels(width: str, dpi: str) -> str:
    """Return the width in pixels of a PNG, in words, for a width in mm and one of `CHOICES`; empty without a width."""
    known = re.fullmatch(r"\s*(\d+(\.\d+)?)\s*(mm)?\s*", width)
    return f"{round(float(known[1]) / 25.4 * int(dpi.split()[0])):,} pixels wide" if known else ""


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
            "vendor/PwsvizSans-subset.ttf",
            "vendor/PwsvizSans-Italic-subset.ttf",
            "vendor/PwsvizSerif-subset.ttf",
            "vendor/PwsvizSerif-Italic-subset.ttf",
        )
    }


_SAVE = """
const files = new URL("components/MODULE/PictureFiles/_resources/files/", document.baseURI)
const wished = { ...wish }
for (const [name, choice] of Object.entries({ CHOICES })) wished[name] = choice.data.value
if (wished.width == "OTHER") wished.width = typed.data.value
const words = { short: "-short", full: "-full" }[wished.caption] ?? ""
wished.name = wish.name.replace(/\\.\\w+$/, ending => `-${parseFloat(wished.width)}mm${words}${ending}`)
const tell = words => trouble.data.setv({ object: words }, { sync: false })  // or the server would repeat it, late
tell("")
import(new URL("pictures.js", files)).then(({ save }) => save(IDS, wished)).then(tell).catch(reason => {
  const why = String(reason?.message ?? reason).replace(/[<>&*_`]/g, " ")
  const advice = reason?.told ? "" : "Is the page still connected? If so, try SVG, or another width."
  tell(`${wished.name} could not be saved: ${why}. ${advice}`.trim())
})
"""


def picture_callback(plots: Sequence[figure]) -> str:
    """Return JavaScript that saves figures as one file, one below the other.

    It takes from its arguments ``wish``, a mapping with ``kind`` (of `KINDS`), ``name`` of the file, ``title``,
    ``captions``, "short" and "full", ``widths``, which are `WIDTHS`, and ``shades``, the opacity in print of each
    colour of ground; a widget for each of `CHOICES`, and ``typed``, one for the width `OTHER`; and ``trouble``, a pane
    for the reason of a failure, of which the server does not learn.
    """
    code = _SAVE.replace("MODULE", __name__).replace("CHOICES", ", ".join(CHOICES)).replace("OTHER", OTHER)
    return code.replace("IDS", json.dumps([plot.id for plot in plots]))
