"""Names of parameters in plain text."""

from __future__ import annotations

import core

_CHARACTERS = {"{-}": "₋", "{+}": "₊", "^2": "²", "^3": "³", r"\omega": "ω", r"\gamma": "γ", r"\mu": "μ", "_": ""}


def short_name(parameter: core.Parameter) -> str:
    """Return the symbol of a parameter in Unicode (a₋, ω²₊), or its name where Unicode cannot express the symbol."""
    text = parameter.symbol
    for latex, character in _CHARACTERS.items():
        text = text.replace(latex, character)
    return parameter.name if set(text) & set("\\{}^") or len(text) == 1 else text
