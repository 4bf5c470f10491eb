"""The entries of lists of names, parameters and numbers, as a user types them."""

from __future__ import annotations

import re
from dataclasses import replace

import core
from core.symbolic import parse, quoted
from pwsviz.editor.regions import Formula
from pwsviz.scene.checks import MAX_COORDINATE
from pwsviz.text.typed import split

__all__ = ["as_known", "is_decimal", "read_coordinate", "read_parameter", "read_variable"]


def read_variable(text: str) -> str:
    """Read the name of a variable; whether it can be one is checked with all else."""
    if names := text.split()[1:]:
        raise ValueError(
            f"{quoted(text)} is not one name: separate names by commas, as in {text.split()[0]}, {names[0]}"
        )
    return text


def read_parameter(text: str, formula: Formula) -> core.Parameter:
    """Read ``k = 3 in [0.1, 10]``."""
    name, equals, rest = (part.strip() for part in text.partition("="))
    value, within, bounds = (part.strip() for part in re.sub(r"\bin\b", "\0", rest, count=1).partition("\0"))
    ends = split(bounds[1:-1]) if bounds.startswith("[") and bounds.endswith("]") else []
    if text.isdecimal():
        raise ValueError(f"{quoted(text)} is not a parameter: write 0.{text} with a point if it is a part of a number")
    if not equals or (within and len(ends) != 2):
        raise ValueError(f"{quoted(text)} is not a parameter: write k = 3, or k = 3 in [0.1, 10]")
    if "=" in rest:
        raise ValueError(f"{quoted(text)} is more than one parameter: separate parameters by commas or new lines")
    numbers = [_number(part, f"Parameter {name}", formula) for part in (value, *ends)]
    return core.Parameter(name, numbers[0], (numbers[1], numbers[2]) if within else None)


def as_known(parameter: core.Parameter, known: core.Parameter | None) -> core.Parameter:
    """Return a parameter with the symbol and the description that it has in a known system."""
    return parameter if known is None else replace(parameter, latex=known.latex, doc=known.doc)


def read_coordinate(text: str, formula: Formula) -> float:
    """Read one coordinate of a start."""
    parts = text.split()
    if len(parts) > 1 and all(is_decimal(number) for part in parts for number in part.split("/")):
        raise ValueError(f"{quoted(text)} is not one number: separate numbers by commas, as in {', '.join(parts)}")
    number = _number(text, "Start x₀", formula)
    if abs(number) > MAX_COORDINATE:
        raise ValueError(f"{quoted(text)} is too large: take numbers between ±{MAX_COORDINATE:,.0f}")
    return number


def _number(text: str, what: str, formula: Formula) -> float:
    """Read a number, such as 0.1, 1/3 or sqrt(2)."""
    number = parse(formula(text), (), what)
    if number.free_symbols:
        raise ValueError(f"{what} = {quoted(text)} is not a number: write one such as 0.1, 1/3 or sqrt(2)")
    return float(number)


def is_decimal(text: str) -> bool:
    """Whether a text is a number in decimals, and no formula."""
    return re.fullmatch(r"[+-]?[0-9.]+([eE][+-]?[0-9]+)?", text) is not None
