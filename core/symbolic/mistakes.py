"""What is wrong with the syntax of an expression, in words that name the place."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

from core.symbolic.operations import FUNCTIONS

__all__ = ["meant", "mistake", "usual_name"]

_TOKENS = re.compile(
    r"(?P<number>(?<!\w)(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<open>[(\[{])|(?P<close>[)\]}])|(?P<sign>\*\*|//|[<>=!]=|[-+*/^%@<>=&|~,])|(?P<other>\S)"
)
#: Signs that may begin an expression.
_PREFIXES = {"+", "-", "~"}
#: Names that combine conditions, which stand between operands.
_WORDS = {"and", "or", "not", "if", "else", "in", "is", "lambda"}
#: Kinds of tokens with which an operand ends, and with which one begins.
_ENDS, _BEGINS = ("number", "name", "close"), ("number", "name", "open")
_PAIRS = {"(": ")", "[": "]", "{": "}"}
#: What functions are called elsewhere, and here.
_ELSEWHERE = {"ln": "log", "sgn": "sign", "signum": "sign", "fabs": "abs", "tg": "tan", "sh": "sinh", "ch": "cosh"}
#: Likeness of two names, from 0 to 1, from which one may be meant by the other.
_LIKE = 0.7


def meant(name: str, known: Iterable[str]) -> str:
    """Return a question for what an unknown name stands for, in brackets after a space; or nothing.

    It stands for a product of known names (kx for k*x), for a function of one (sinx), or for a known name it is like.
    """
    known = [*known]
    if found := _product(name, known) or _application(name, known):
        return f" (did you mean {found}?)"
    names = {one.lower(): one for one in known}
    like = get_close_matches(usual_name(name.lower()), names, n=1, cutoff=_LIKE)
    return f" (did you mean {names[like[0]]}?)" if like else ""


def usual_name(function: str) -> str:
    """Return the name that a function has here."""
    return _ELSEWHERE.get(function, function)


def _product(name: str, known: Sequence[str]) -> str:
    """Return the product of the fewest known names that make up a name, of functions none; empty if there is none."""
    factors = [one for one in known if one not in FUNCTIONS]
    products: dict[int, tuple[str, ...]] = {0: ()}  # by the number of characters that they make up
    for end in range(1, len(name) + 1):
        ways = [
            (*products[end - len(one)], one)
            for one in factors
            if end - len(one) in products and name.endswith(one, 0, end)
        ]
        if ways:
            products[end] = min(ways, key=len)
    return "*".join(products.get(len(name), ()))


def _application(name: str, known: Sequence[str]) -> str:
    """Return the function of a known name, or of a product, that was written without brackets, or nothing."""
    for function in FUNCTIONS:
        argument = _product(name.removeprefix(function), known) if name.startswith(function) else ""
        if argument:
            return f"{function}({argument})"
    return ""


def mistake(source: str) -> str:
    """Return what keeps a text from being an expression, or how expressions are written where that is not found."""
    tokens = [(str(found.lastgroup), found[0]) for found in _TOKENS.finditer(source)]
    tokens = [("sign", text) if text in _WORDS else (kind, text) for kind, text in tokens]
    if ("sign", "=") in tokens:
        return "of a law write what stands right of = alone, of g or psi the difference of both sides"
    if ("sign", "^") in tokens:
        return _unpaired(tokens) or "write powers as **"
    if ("sign", "|") in tokens:
        return "write the absolute value |x| as abs(x)"
    return _strange(tokens) or _unpaired(tokens) or _between(tokens) or "write products with *, powers with **"


def _strange(tokens: list[tuple[str, str]]) -> str:
    return next((f"{text!r} has no meaning here" for kind, text in tokens if kind == "other"), "")


def _unpaired(tokens: list[tuple[str, str]]) -> str:
    """Say which bracket has no counterpart."""
    awaited: list[str] = []
    for kind, text in tokens:
        if kind == "open":
            awaited.append(_PAIRS[text])
        elif kind == "close" and (not awaited or awaited.pop() != text):
            return f"a bracket is missing before one of the {text}"
    return f"a closing bracket {awaited[-1]} is missing" if awaited else ""


def _between(tokens: list[tuple[str, str]]) -> str:
    """Say what is missing between two neighbours, or at an end."""
    ends = [("sign", ""), *tokens, ("sign", "")]
    for (kind, text), (other, following) in itertools.pairwise(ends):
        if kind in _ENDS and other in _BEGINS and (kind, other) != ("name", "open"):
            if text in FUNCTIONS:
                return f"the argument of {text} needs brackets, as in {text}({following if other != 'open' else '…'})"
            missing = f"a multiplication sign is missing between {text} and {following}"
            return f"{missing}: write a product as {text}*{following}"
        if kind in ("sign", "open") and other in ("sign", "close") and following not in _PREFIXES | {"not"}:
            if text in _PAIRS and following == _PAIRS[text]:
                return f"there is nothing between {text} and {following}"
            return f"a number or a name is missing {f'before {following}' if following else f'after {text}'}"
    return ""
