"""Names of parameters in plain text."""

from __future__ import annotations

import re

from sympy.printing.pretty.pretty_symbology import greek_unicode

import core

_CHARACTERS = {"{-}": "₋", "{+}": "₊", "^2": "²", "^3": "³", "_": ""}


def short_name(parameter: core.Parameter) -> str:
    """Return the symbol of a parameter in Unicode (a₋, ω²₊), or its name where Unicode cannot express the symbol."""
    text = re.sub(r"\\([A-Za-z]+)", lambda found: greek_unicode.get(found[1], found[0]), parameter.symbol)
    for latex, character in _CHARACTERS.items():
        text = text.replace(latex, character)
    return parameter.name if set(text) & set("\\{}^") else text
