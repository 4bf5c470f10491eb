"""The font of formulas: its MATH table lets roots and brackets grow with what they enclose.

It is a subset of STIX Math (licence: OFL.txt). The page serves it itself, so that formulas look the same everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

__all__ = ["FACE", "FORMULAS", "MathsFont"]


class MathsFont:
    """Names the file to Panel's server, which hands out only what the attributes of a class list."""

    _resources: ClassVar[Mapping[str, Mapping[str, str]]] = {"font": {"maths": "maths.woff2"}}


FACE = (
    '@font-face { font-family: "pwsviz maths"; font-display: swap; '
    f'src: url("components/{__name__}/{MathsFont.__name__}/_resources/font/maths.woff2") format("woff2"); }}'
)
"""Style of the document's head; within a component, browsers ignore the declaration of a font."""

FORMULAS = """
math { font-family: "pwsviz maths", math; font-weight: normal; font-size: 1.08em; }
mtd { padding: 0.9ex 0.4em; }
"""
"""Style of every component with formulas: Panel lets all elements inherit the font of the text, which has no roots."""
