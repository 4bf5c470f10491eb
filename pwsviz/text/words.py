"""Texts on the page; what a user or a system provides is escaped, never taken for markup."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from html import escape

from pwsviz.text.advice import on_page
from pwsviz.text.numbers import RAISED, printed

_SIZE = re.compile(r"\|[^|<>]{1,24}\|")
"""An absolute value, at whose bars a browser would break the line."""

_ENDS_SENTENCE = re.compile(r"(?<=\.) (?=[A-Z])")

_UNFOLD = """\
const root = this.getRootNode(), buttons = () => [...root.querySelectorAll('.more')], opens = one => one.ariaExpanded;\
const tell = (one, open) => { one.ariaExpanded = open; one.ariaLabel = open == 'true' ? 'less' : 'more' };\
tell(this, opens(this) == 'true' ? 'false' : 'true');\
root.unfolded = buttons().map(opens);\
root.keeping ??= new MutationObserver(() => buttons().forEach((one, k) => tell(one, root.unfolded[k] ?? 'false')));\
root.keeping.observe(root, { childList: true, subtree: true })\
"""
"""JavaScript of a button that unfolds: what a user has unfolded stays so when other words take its place."""

_MORE = f'<button class="more" aria-label="more" aria-expanded="false" onclick="{escape(_UNFOLD)}"></button>'
"""Before what it unfolds; seen on narrow screens only, with its label as its text."""

_SHORT = 24
"""Characters of a sentence that does not stand alone, as “Start 1 of 3.”"""


def as_text(words: str, kind: str = "") -> str:
    """Return a paragraph with these words, escaped, and with their numbers as they are printed."""
    if not words:
        return ""
    role = ' role="alert"' if kind == "error" else ""
    markup = _SIZE.sub(r'<span style="white-space: nowrap">\g<0></span>', escape(printed(words)))
    markup = f"<span>{_folded(markup)}</span>" if kind == "stopped" else markup  # in a lecture over what follows
    return f'<p class="{kind}"{role}>{markup}</p>'


def sentences(words: str) -> list[str]:
    """Return the sentences of a paragraph."""
    return _ENDS_SENTENCE.split(words)


def _folded(markup: str) -> str:
    """Return a warning whose sentences after the first are unfolded on narrow screens by a button."""
    first, *others = sentences(markup)
    if others and len(first) < _SHORT:
        first = f"{first} {others.pop(0)}"
    return f'{first} {_MORE}<span class="others">{" ".join(others)}</span>' if others else first


def listed(names: Sequence[str]) -> str:
    """Return names as a list in words: “a, b and c”."""
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1] if names else "")))


def at_surface(met: str, locate: bool, slide: bool, order: int | None = None, scale: float = 1.0) -> str:
    """Return what integrators do at a surface: whether they locate what is `met` there, perturb and slide.

    Where nothing but jumps is met, the law is the same on both sides of them: no transition scheme is needed.
    """
    how = "a shortened step that ends on the surface" if met == "jumps" else "Mannshardt’s transition scheme"
    words = f"{met} {f'located by {how}' if locate else 'not located'}"
    if locate and order is not None:
        words += f", their times perturbed by {perturbation(order, scale)}"
    return words + "; on attracting parts of the surface, Filippov’s sliding solution is followed" * slide


def perturbation(order: int, scale: float) -> str:
    """Return the perturbation c·τᵖ of crossing times: “2·τ³”, or “τ” for c = p = 1."""
    factor = "" if scale == 1.0 else f"{scale:g}·"
    return printed(f"{factor}τ{str(order).translate(RAISED) if order != 1 else ''}")


FEW = 4
"""Values that a sentence lists."""

STEPS_MARKED = "Small dots are the ends of steps, between which the integrators interpolate."
"""What captions say of curves on which steps are marked."""


JUMPS_MARKED = "Jumps are marked at the state before each."
"""What captions say of marks where the state jumps."""


def whose_marks(methods: Sequence[str], crossings: int) -> str:
    """Say of several integrators whose crossings or jumps are marked, if any, and whose sides are shaded, if any."""
    shown = "Marks at surfaces and any shading refer" if crossings else "Any shading refers"
    return f"{shown} to {methods[0]}." if len(methods) > 1 else ""


def listed_or_counted(values: Sequence[str], counted: str) -> str:
    """Return up to `FEW` values as a list; of more of them only how many, in these words: “{} of them”."""
    return listed(values) if len(values) <= FEW else counted.format(len(values))


def plural(count: int, noun: str) -> str:
    """Return count and noun: “1 step”, “2,000 steps”."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def duration(seconds: float) -> str:
    """Return a time in seconds, or in milliseconds below one second: two digits, which is what a clock repeats."""
    value, unit = (seconds, "s") if seconds >= 1 else (seconds * 1e3, "ms")
    return f"{float(f'{value:.2g}'):g} {unit}"


def upper_bound(value: float) -> float:
    """Return a value that is not negative, rounded up to one digit."""
    if value == 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(f"{math.ceil(value / power * (1 - 1e-12)) * power:.0e}")


def rounded_up(value: float) -> str:
    """Return the same as it is printed."""
    bound = upper_bound(value)
    return printed(f"{bound:g}" if bound == 0 or 0.01 <= bound < 1000 else f"{bound:.0e}")


def rounded(value: float) -> str:
    """Return a value that is not negative, rounded to two digits, as it is printed."""
    return printed(f"{value:.2g}" if value == 0 or 0.01 <= value < 1000 else f"{value:.1e}".replace(".0e", "e"))


def complaint(reason: Exception) -> str:
    """Return an exception as a paragraph for the user: the message of a ValueError; else that the program failed."""
    return as_text(failure(reason), "error")


def failure(reason: Exception) -> str:
    """Return the words of `complaint`."""
    if isinstance(reason, ValueError):
        return on_page(str(reason))
    return f"The program failed here ({type(reason).__name__}: {reason}). The server’s log has the details."
