"""Messages of `core`, which speak to programs, in the words of the page: its controls and symbols."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from pwsviz.text.math_names import variable_name

__all__ = ["locating", "on_page", "without_advice"]


def _state(found: re.Match[str]) -> str:
    """Return a state in Python, x0 = (0.5, 0.0), as the page writes it: (0.5, 0)."""
    return re.sub(r"\.0(?=[,)])|,(?=\))", "", found[0].removeprefix("x0 = "))


def _time(found: re.Match[str]) -> str:
    """Return a time in six digits."""
    return f"{float(found[0]):.6g}"


#: What `core` writes for programs, as a pattern, and what the page says instead.
_SAID: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (r'let it slide \(sliding="continue"\)', "choose “Slide along the surface”"),
    (r"Raise the limit \(max_crossings\) to continue", "Take an earlier end time"),
    (r"Raise the limit \(max_events\) to continue", "Take an earlier end time"),
    (r"in one field for all regions \(PiecewiseSystem\.from_field\)", "in the box “Field f, with sign, abs, max, min”"),
    (r" \(terminal=False\)", ""),
    (r"(?<=solution ends at t = )[\d.e+-]*\d", _time),
    (
        r"crossings = \([^()]*\): crossing (\d+) and the one after it are needed, but (.*?) known",
        r"the order is studied up to crossing \1 of the reference and the one after it, but \2 known",
    ),
    (r", or raise the limit \(max_steps\)", ""),
    (r"Declare the law of that region \(regions\)", "Declare a law for that region in the editor"),
    (r"give a tau, which no step is longer than", "take a smaller τ, which no step is longer than"),
    (r"\bx0 = \([^()]*\)", _state),
    (r"\bf_minus\b", "f₋"),
    (r"\bf_plus\b", "f₊"),
    (r"alpha_hat\^2/M_hat", "α̂²/M̂"),
    (r"alpha\^2/M", "α²/M"),
    (r"\btau_-\^\*", "τ₋*"),
    (r"\btau_\+\^\*", "τ₊*"),
    (r"\btau\b", "τ"),
    (r"\bpsi\b", "ψ"),
    (r"\(x - a\)\*\*3", "(x − a)³"),
    (r"(?<=[\w)])\*\*(?=[\w(])", "^"),
)

#: What follows the name of a variable in a message.
_FOLLOWED = r"(?= = |' | after a reset | is about |: write the system )"


#: What a message advises, which has no place under a printed figure.
_ADVICE = (
    r"\. If it touches it, no step size helps: change [^.;]*\. Otherwise take [^.;]*",
    r"[;,:] (?:take|give) [^.;]*(?:\.\d[^.;]*)*",
    r" First switch on “Locate crossings”\.",
)


def without_advice(message: str) -> str:
    """Return a warning without what it advises, for captions."""
    for pattern in _ADVICE:
        message = re.sub(pattern, "", message)
    return message


def locating(warning: str) -> str:
    """Return a warning of a run that steps over a surface: what it advises is to locate crossings, before all else."""
    return f"{without_advice(warning)} First switch on “Locate crossings”." if warning else ""


def on_page(message: str, variables: Iterable[str] = ()) -> str:
    """Return a message of `core` as the page says it: controls for arguments of Python, and mathematical symbols.

    Parameters
    ----------
    message : str
        What `core` says.
    variables : iterable of str
        Names of variables whose values it may tell.
    """
    for pattern, words in _SAID:
        message = re.sub(pattern, words, message)
    for name in variables:
        message = re.sub(rf"\b{re.escape(name)}{_FOLLOWED}", variable_name(name), message)
    return message
