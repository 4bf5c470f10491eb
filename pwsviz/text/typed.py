"""Formulas and lists of them as people type them, written as `core` reads them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from core.symbolic import quoted

__all__ = ["Typed", "as_python", "as_typed", "rates", "split"]

#: Signs that people type or paste, and what Python writes for them.
_SIGNS = {"−": "-", "·": "*", "×": "*", "^": "**"}
#: An exponent as it is printed, in raised digits.
_RAISED = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
#: A number as it is printed: 2×10⁻⁶ or 10⁻⁶.
_PRINTED = re.compile(rf"(?:([0-9]+(?:\.[0-9]+)?)×)?(?<![\w.])10({_RAISED.pattern})")
_LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
#: Digits of an index, as names are printed: x₁ for x1.
_INDEX = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
#: A number that is no part of a name, with its exponent if it has one: of 2e only 2, of 2e3x all but x. It is taken
#: whole: possessive quantifiers (++) give nothing back. (That of a group does in Python before 3.11.5.)
_NUMBER = r"(?<![\w.])(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?[0-9]++|(?![eE][+-]?[0-9]))"
#: A number, or a closing bracket, before what it multiplies: a name or a bracket; after a bracket also a number.
_PRODUCT = re.compile(rf"({_NUMBER}) *(?=[^\W\d]|\()|(\)) *(?=[\w(])")

#: What stands before the field of a variable where it is typed as an equation: x' = or dx/dt =.
_RATE = re.compile(r"(?:^|(?<=[,;\n]))\s*(?:([^\W\d]\w*)\s*['′’]|d\s*([^\W\d]\w*)\s*/\s*dt)\s*=(?!=)")


def as_python(text: str) -> str:
    """Write a formula with ``**`` for ``^`` and with the signs of products: ``2q^2`` and ``2q²`` become ``2*q**2``.

    A name before a bracket stays as it is, as it may be that of a function.
    """
    text = _PRINTED.sub(lambda found: f"{found[1] or 1}e{found[2].translate(_LOWERED)}", text)
    for sign, plain in _SIGNS.items():
        text = text.replace(sign, plain)
    text = _RAISED.sub(lambda found: f"**{found[0].translate(_LOWERED)}", text)
    return _PRODUCT.sub(lambda found: f"{found[1] or found[2]}*", text.translate(_INDEX))


def as_typed(text: str) -> str:
    """Write a formula of `core` as people type it: with ``^`` for ``**``."""
    return text.replace("**", "^")


class Typed:
    """Formulas as they were typed, by what `core` reads for them, so that its messages can quote the former."""

    def __init__(self) -> None:
        self._typed: dict[str, str] = {}

    def read(self, text: str) -> str:
        """Return what `core` reads for a formula, and remember the formula."""
        written = as_python(text)
        self._typed[written.strip()] = text.strip()
        return written

    def message(self, words: str) -> str:
        """Return a message of `core` with formulas as they were typed, and ``^`` for ``**`` elsewhere."""
        words = as_typed(words)
        for written, text in self._typed.items():
            words = words.replace(as_typed(quoted(written)), quoted(text))
        return words


def rates(text: str, variables: Sequence[str]) -> list[str]:
    """Split the text of a field, an expression for each variable; in any order where each is typed as an equation."""
    pieces = _RATE.split(text)
    names = [a or b for a, b in zip(pieces[1::3], pieces[2::3], strict=True)]
    if pieces[0].strip() or sorted(names) != sorted(variables):
        return split(text)
    laws = dict(zip(names, (split(piece) for piece in pieces[3::3]), strict=True))
    return [law for name in variables for law in laws[name]]


def split(text: str) -> list[str]:
    """Split a list at commas, semicolons and new lines outside brackets, and drop empty entries."""
    items, depth = [""], 0
    for character in re.sub(r"\r\n?|\n", "\n", text):
        depth = max(0, depth + (character in "([") - (character in ")]"))
        if depth == 0 and character in ",;\n":
            items.append("")
        else:
            items[-1] += character
    return [item.strip().replace("\n", " ") for item in items if item.strip()]
