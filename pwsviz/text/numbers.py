"""Numbers as they are printed on the page, with true minus signs and powers of ten; programs and links have others."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from fractions import Fraction

__all__ = ["PRINTED", "RAISED", "brief", "printed", "shortest"]

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+")
"""Characters of an exponent, raised; a plus sign is left out."""

PLAIN = 2
"""Powers of ten up to which, and down to whose inverse, a number is printed without one."""

MANY_DIGITS = 10
"""Characters of a number from which a ratio of the same value is easier to read."""

LARGEST_DENOMINATOR = 999
"""Of such a ratio: a number that is none of these is closer to one of them than 1e-16 only by a rare chance."""

FEW_DIGITS, ROUNDED = 6, 5
"""Significant digits up to which a caption has a number as it is, and those to which it rounds others."""

_QUOTED = r"“[^”]*”|(?<!\w)'[^']*'(?!\w)"
"""What a message quotes, and so has to stay as it was typed."""
_POWER = r"(?P<factor>(?<![\w.])[0-9]+(?:\.[0-9]+)?)e(?P<power>[+-]?[0-9]+)(?!\w)"
_SMALL = r"(?P<small>(?<![\w.])0\.000[0-9]*[1-9][0-9]*)(?!\w|\.[0-9])"
_MINUS = r"(?<![\w)\]])-(?=\.?[0-9])"
_WRITTEN = re.compile(rf"{_QUOTED}|{_POWER}|{_SMALL}|{_MINUS}")

PRINTED = """
const printed = text => {  // a single number, as `printed` in Python
  const [factor, power] = (/^-?0\\.000[0-9]*[1-9]/.test(text) ? Number(text).toExponential() : text).split("e")
  const raised = power?.replace("+", "").replace(/./g, sign => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)])
  const times = power == null ? factor : `${/^-?1$/.test(factor) ? factor.slice(0, -1) : factor + "×"}10${raised}`
  return times.replace("-", "\\u2212")
}
"""
"""JavaScript of the same, for numbers that only the browser knows."""


def shortest(value: float) -> str:
    """Return the shortest text that determines a number: its digits, or a ratio as 100/7 where these are many."""
    digits = re.sub(r"e(-?)\+?0*", r"e\1", repr(value).removesuffix(".0"))
    if len(digits) <= MANY_DIGITS or not math.isfinite(value):
        return digits
    ratio = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    text = f"{ratio.numerator}/{ratio.denominator}"
    return text if ratio.numerator / ratio.denominator == value and len(text) <= MANY_DIGITS else digits


def brief(value: float) -> str:
    """Return a number as a field shows it, “= 100/7”; rounded, “≈ 0.70711”, where that has many digits."""
    text = shortest(float(value))
    digits = re.sub(r"e.*|\D", "", text).strip("0")
    return f"= {text}" if "/" in text or len(digits) <= FEW_DIGITS else f"≈ {value:.{ROUNDED}g}"


def printed(text: str) -> str:
    """Return a text with its numbers as they are printed: 2e-06 as 2×10⁻⁶, 3e+01 as 30, -3 as −3; quotations stay.

    0.000122, too, is printed as 1.22×10⁻⁴, as a smaller one is.
    """
    return _WRITTEN.sub(_print, text)


def _print(found: re.Match[str]) -> str:
    small = f"{Decimal(found['small']):e}".split("e") if found["small"] else None
    factor, power = small or (found["factor"], found["power"])
    if power is None:
        return "−" if found[0] == "-" else found[0]
    if abs(int(power)) <= PLAIN:
        return f"{Decimal(found[0]):f}"
    return f"{'' if factor == '1' else f'{factor}×'}10{str(int(power)).translate(RAISED)}"
