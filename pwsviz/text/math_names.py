"""Names and signs of formulas, given as LaTeX: as presentation MathML, and in plain characters."""

from __future__ import annotations

import re
from html import escape

import sympy
from sympy import Symbol
from sympy.printing.pretty.pretty_symbology import greek_unicode

__all__ = [
    "default_name",
    "name_markup",
    "numbered",
    "operator",
    "plain_text",
    "quantity_name",
    "said_name",
    "unicode_name",
    "variable_name",
]

_ACCENTS = {"hat": "^", "bar": "‾", "tilde": "~", "vec": "→", "dot": "˙", "ddot": "¨"}
_SIGNS = {"-": "−", "'": "′"}
_COMMANDS = {
    "pm": "±", "sum": "∑", "cdots": "⋯", "ldots": "…", "leftarrow": "←", "circ": "∘", "top": "⊤",
}  # fmt: skip
_UNICODE = {"^2": "²", "^3": "³"}
_LOWERED = str.maketrans("0123456789-+aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉₋₊ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ")
_LOW = "[-+0-9aehijklmnoprstuvx]"
_ACCENTED = "|".join(_ACCENTS)
#: A base with at most two scripts, each a character, a command or a group in braces. Each part of a base has one way to
#: match, so that no text takes long.
_SCRIPT = r"(?:[_^](?:\{[^{}]*\}|\\[A-Za-z]++|[^\\{}\s]))"
_BASE = rf"(?:\\(?:{_ACCENTED})\{{[^{{}}]*\}}|\\[A-Za-z]++|[^\\_^{{}}])+"
_NAME = re.compile(rf"(?P<base>{_BASE})(?P<scripts>{_SCRIPT}{{0,2}})")
_ENDS_IN_SUBSCRIPT = re.compile(r"_\{[^{}]*\}$")
_PIECE = re.compile(rf"\\({_ACCENTED})\{{([^{{}}]*)\}}|\\([A-Za-z]+)|([^\W\d_]+)|(\d+(?:\.\d+)?)|(\S)")


def name_markup(text: str) -> str:
    r"""Typeset the LaTeX of a name, such as ``\omega^2_{-}`` or ``\hat{t}``; any other text is shown as it is."""
    name = _NAME.fullmatch(text.strip())
    found = re.findall(_SCRIPT, name["scripts"]) if name else []
    if name is None or len({script[0] for script in found}) < len(found):  # two subscripts or two superscripts
        return f"<mtext>{plain_text(text)}</mtext>"
    scripts = {script[0]: _pieces(script[1:].strip("{}")) for script in found if script[1:] != "{}"}
    base = _pieces(name["base"])
    match sorted(scripts):
        case ["^", "_"]:
            return f"<msubsup>{base}{scripts['_']}{scripts['^']}</msubsup>"
        case ["_"]:
            return f"<msub>{base}{scripts['_']}</msub>"
        case ["^"]:
            return f"<msup>{base}{scripts['^']}</msup>"
    return base


def _pieces(text: str) -> str:
    """Typeset a sequence of letters, digits and signs as one element."""
    row = []
    for accent, accented, command, word, number, sign in _PIECE.findall(text):
        if accent:
            row.append(f'<mover accent="true">{_pieces(accented)}<mo>{_ACCENTS[accent]}</mo></mover>')
        elif number:
            row.append(f"<mn>{number}</mn>")
        elif sign or command in _COMMANDS:
            row.append(operator(_COMMANDS.get(command) or _SIGNS.get(sign, sign)))
        else:
            row.append(f"<mi>{plain_text(greek_unicode.get(command, command) or word)}</mi>")
    return row[0] if len(row) == 1 else f"<mrow>{''.join(row)}</mrow>"


def operator(sign: str) -> str:
    """Typeset a sign."""
    low = ' stretchy="false"' * (sign in "()")  # no higher than a line of text
    return f"<mo{low}>{plain_text(sign)}</mo>"


def plain_text(text: str) -> str:
    """Escape text; control characters, which are not allowed in HTML, become U+FFFD."""
    return escape("".join(c if c.isprintable() else "\ufffd" for c in text))


def default_name(name: str) -> str:
    """Return the LaTeX of a symbol's name; the endings _minus and _plus become a sign in its subscript."""
    for word, sign in (("_minus", "-"), ("_plus", "+")):
        if name.endswith(word):
            stem = str(sympy.latex(Symbol(name.removesuffix(word))))
            return f"{stem[:-1]}{sign}}}" if _ENDS_IN_SUBSCRIPT.search(stem) else f"{stem}_{{{sign}}}"
    return str(sympy.latex(Symbol(name)))


def unicode_name(latex: str, otherwise: str) -> str:
    """Return the LaTeX of a symbol in Unicode (a₋, ω₊², x₁), or another name where Unicode cannot express it."""
    text = re.sub(r"\\([A-Za-z]+)", lambda found: greek_unicode.get(found[1], found[0]), latex)
    low = rf"_(?:\{{({_LOW}+(?:,{_LOW}+)*)\}}|({_LOW})(?!\w))"
    text = re.sub(low, lambda found: (found[1] or found[2]).translate(_LOWERED), text)
    text = re.sub(r"_\{(\w+)\}", r"_\1", text)  # not all letters can be lowered
    for part, character in _UNICODE.items():
        text = text.replace(part, character)
    text = re.sub(
        f"([²³])([{''.join(map(chr, set(_LOWERED.values())))}]+)", r"\2\1", text
    )  # as where one is below the other
    return otherwise if set(text) & set("\\{}^") else text


def numbered(name: str, number: int) -> str:
    """Return a name with an index: g₁."""
    return f"{name}{str(number).translate(_LOWERED)}"


def quantity_name(where: str, k: int, count: int) -> str:
    r"""Return the LaTeX of the k-th of some conserved quantities: ``\psi_{-}``, or ``\psi_{-,1}`` if there are several.

    Parameters
    ----------
    where
        "-" or "+" for a side; "" where the region is told beside it.
    """
    index = ",".join(filter(None, (where, str(k + 1) if count > 1 else "")))
    return rf"\psi_{{{index}}}" if index else r"\psi"


def variable_name(name: str) -> str:
    """Return the name of a variable as formulas show it, φ for ``phi``, as far as Unicode can express it."""
    return unicode_name(default_name(name), name)


def said_name(text: str) -> str:
    """Return the LaTeX of a name or a formula in plain characters."""
    plain = re.sub(rf"\\({_ACCENTED})\{{([^{{}}]*)\}}", r"\2-\1", text)
    plain = re.sub(r"\\([A-Za-z]+)", lambda found: _COMMANDS.get(found[1], found[1]), plain)
    return re.sub(r"[\\{}]", "", plain)
