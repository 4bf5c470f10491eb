"""Numbers as users type them: read and checked, with messages that can be shown beside the field."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from core.symbolic import parse
from pwsviz.text.typed import Typed, as_python

LIMIT = 1e9
"""Largest |coordinate| of the ends of a window."""

NARROWEST = 1e-9
"""Least width and height of a window, relative to its largest |coordinate|: less is not resolved on a screen."""

MAX_STEPS = 2_000_000
"""Most steps of one run on the page, so that a mistyped step size cannot keep it busy."""


MAX_FUNCTION = 300
"""Characters of the function of a section, which a link can hold."""

_ENDS = ("left", "right", "bottom", "top")

MOST_NAMES = 200
"""Characters of a list of what may be chosen, up to which a complaint names all."""

_DECIMAL_COMMA = re.compile(r"\s*[-+−]?[0-9]+,[0-9]+\s*")
_LIMIT = re.compile(r"'[^']*': ((?:it contains|the exponent|the number|a number) .*)")  # of what is written as a number
_SUCH = "Type a number such as “0.01”, “1e-3”, “1/3” or “sqrt(2)”."


def value_of(text: str) -> float:
    """Return the number that a text stands for: a decimal, or a formula of the whitelist such as 1/3, 2pi or sqrt(2).

    Raises
    ------
    ValueError
        If it is neither.
    """
    try:
        return float(text.strip().replace("−", "-"))
    except ValueError:
        constant = parse(as_python(text.strip()), (), "the number")
    if constant.free_symbols:
        raise ValueError(f"“{text}” names a variable.")
    return float(constant)


def number(value: object, subject: str, low: float, high: float) -> float:
    """Read a number and check its range.

    Raises
    ------
    ValueError
        Naming the text or the subject, and what would do.
    """
    text = str(value)
    if not text.strip():
        raise ValueError(f"Nothing is typed here. {_SUCH}")
    try:
        result = value_of(text)
    except ValueError as refused:
        if (limit := _LIMIT.search(str(refused))) is not None:
            raise ValueError(f"“{text}” cannot be used: {limit[1]}. {_SUCH}") from None
        point = " The decimal point is written as “.”." * (_DECIMAL_COMMA.fullmatch(text) is not None)
        raise ValueError(f"“{text}” is not a number.{point} {_SUCH}") from None
    if not math.isfinite(result):
        why = "is too large" if re.search("[0-9]", text) else "is not a finite number"
        raise ValueError(f"“{text}” {why}. {_SUCH}")
    if not low <= result <= high:
        raise ValueError(f"{subject} must lie between {low:,g} and {high:,g}.")
    return result


def one_of(choices: Iterable[object], value: object, name: Callable[[object], str]) -> object:
    """Return a value that is one of the choices, of the same type: True is not 1.

    Raises
    ------
    ValueError
        Naming the value and, by `name`, the choices.
    """
    known = list(choices)
    if not any(value == one and type(value) is type(one) for one in known):
        names = ", ".join(map(name, known))
        offered = names if len(names) <= MOST_NAMES else "those that can be chosen here"
        raise ValueError(f"“{value}” is not one of {offered}.")
    return value


def window(value: object) -> tuple[float, float, float, float] | None:
    """Check the window of the portrait: None for one that suits the trajectories, or left, right, bottom and top end.

    Raises
    ------
    ValueError
        Naming the end that is refused, or what else is wrong.
    """
    if value is None:
        return None
    if not isinstance(value, tuple) or len(value) != len(_ENDS):
        raise ValueError(f"A window needs {len(_ENDS)} numbers: the {', '.join(_ENDS)} end.")
    left, right, bottom, top = (
        number(end, f"The {name} end", -LIMIT, LIMIT) for name, end in zip(_ENDS, value, strict=True)
    )
    if min(right - left, top - bottom) <= NARROWEST * max(map(abs, (left, right, bottom, top))):
        raise ValueError("The right end has to lie right of the left one, and the top end above the bottom one.")
    return left, right, bottom, top


def require_few_steps(t_end: float, tau: float) -> None:
    """Raise a ValueError that says what to change if a run needs more than `MAX_STEPS` steps."""
    steps = t_end / tau
    if steps > MAX_STEPS * (1 + 1e-9):
        raise ValueError(
            f"{steps:,.0f} steps are more than this page runs ({MAX_STEPS:,}): "
            f"take τ ≥ {_rounded_up(t_end / MAX_STEPS)} or an end time ≤ {tau * MAX_STEPS:g}."
        )


def require_known(names: list[Any], known: Mapping[str, Any], what: str) -> None:
    """Raise a ValueError that names the first unknown name, what it should be, and the known ones."""
    for name in names:
        if name not in known:
            raise ValueError(f"“{name}” is not {what}; known: {', '.join(known)}.")


def switch(value: object) -> bool:
    """Return whether something is on; ValueError if the value is neither True nor False."""
    if not isinstance(value, bool):
        raise ValueError(f"“{value}” is neither on nor off.")
    return value


def plane(value: object, count: int) -> tuple[int, int] | None:
    """Return two different numbers of variables below `count`, or None; ValueError if they are not."""
    if value is None:
        return None
    whole = isinstance(value, tuple) and len(value) == 2 and all(type(i) is int and 0 <= i < count for i in value)
    if not isinstance(value, tuple) or not whole or value[0] == value[1]:
        raise ValueError(
            f"“{value}” does not name two of the {count} variables: take two different numbers below {count}."
        )
    return value


def whole_number(value: object, subject: str, count: int) -> int:
    """Return a whole number from 0 to `count` − 1; ValueError, naming the subject, if it is none."""
    if type(value) is not int or not 0 <= value < count:
        raise ValueError(f"{subject} must lie between 0 and {count - 1}; it is “{value}”.")
    return value


def whole(value: object, subject: str, low: int, high: int) -> int:
    """Read a whole number and check its range; ValueError, as of `number`, if it is none."""
    result = number(value, subject, low, high)
    if result != int(result):
        raise ValueError(f"{subject} has to be a whole number from {low:,} to {high:,}.")
    return int(result)


def surface_function(value: object, names: Iterable[str]) -> str:
    """Return a function h(t, x) whose zeros are a section, as `core` reads it; empty for the switching surfaces.

    Raises
    ------
    ValueError
        If it cannot be read, or is constant; the message quotes what was typed.
    """
    typed = Typed()
    text = typed.read(str(value)).strip()
    if not text:
        return ""
    if len(text) > MAX_FUNCTION:
        raise ValueError(f"The function is {len(text):,} characters long; at most {MAX_FUNCTION} can be read.")
    try:
        function = parse(text, names, "h")
    except ValueError as reason:
        raise ValueError(typed.message(str(reason))) from None
    if not function.free_symbols:
        raise ValueError(f"“{value}” is constant: a section is where a function of the state vanishes.")
    return text


def _rounded_up(value: float) -> str:
    """Return `value` rounded up to two digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1 - 1e-12)) * power:.2g}"
