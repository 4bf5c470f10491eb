"""Formulas as people type them, written as `core` reads them."""

from __future__ import annotations

import re

__all__ = ["as_python"]

#: Signs that people type or paste, and what Python writes for them.
_SIGNS = {"−": "-", "·": "*", "×": "*", "^": "**"}
#: A number that is no part of a name, with its exponent if it has one: of 2e only 2, of 2e3x all but x. It is taken
#: whole: possessive quantifiers (++) give nothing back.
_NUMBER = r"(?<![\w.])(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?[0-9]++)?+"
#: A number, or a closing bracket, before what it multiplies: a name or a bracket; after a bracket also a number.
_PRODUCT = re.compile(rf"({_NUMBER}) *(?=[^\W\d]|\()|(\)) *(?=[\w(])")


def as_python(text: str) -> str:
    """Write a formula with ``**`` for ``^`` and with the signs of products: ``2q^2`` becomes ``2*q**2``.

    A name before a bracket stays as it is, as it may be that of a function.
    """
    for sign, plain in _SIGNS.items():
        text = text.replace(sign, plain)
    return _PRODUCT.sub(lambda found: f"{found[1] or found[2]}*", text)
