"""Numbers as users type them: read and checked, with messages that can be shown beside the field."""

from __future__ import annotations

import math
from collections.abc import Iterable

from core.symbolic import parse
from pwsviz.text.typed import as_python

MAX_STEPS = 2_000_000
"""Most steps of one run on the page, so that a mistyped step size cannot keep it busy."""


_SUCH = "Type one such as 0.01, 1e-3, 1/3 or sqrt(2)."


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
    try:
        result = value_of(str(value))
    except ValueError:
        raise ValueError(f"“{value}” is not a number. {_SUCH}") from None
    if not math.isfinite(result):
        raise ValueError(f"“{value}” is not a finite number. {_SUCH}")
    if not low <= result <= high:
        raise ValueError(f"{subject} has to lie between {low:g} and {high:g}.")
    return result


def one_of(choices: Iterable[object], value: object) -> object:
    """Return a value that is one of the choices, of the same type: True is not 1.

    Raises
    ------
    ValueError
        Naming the value and the choices.
    """
    known = list(choices)
    if not any(value == one and type(value) is type(one) for one in known):
        raise ValueError(f"“{value}” is none of {', '.join(str(one or 'none') for one in known)}.")
    return value


def require_few_steps(t_end: float, tau: float) -> None:
    """Raise a ValueError that says what to change if a run needs more than `MAX_STEPS` steps."""
    steps = t_end / tau
    if steps > MAX_STEPS * (1 + 1e-9):
        raise ValueError(
            f"{steps:,.0f} steps are more than this page runs ({MAX_STEPS:,}): "
            f"take τ ≥ {_rounded_up(t_end / MAX_STEPS)} or an end time ≤ {tau * MAX_STEPS:g}."
        )


def _rounded_up(value: float) -> str:
    """Return `value` rounded up to two digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1 - 1e-12)) * power:.2g}"
