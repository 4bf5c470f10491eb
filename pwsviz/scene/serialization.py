"""A user's own system as JSON, and back; a text that is no such description is refused with a ValueError."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any, NoReturn

import core
from pwsviz.geometry.projection import PLANE

__all__ = ["packed", "shown", "unpacked", "visible"]

_LAWS = (
    "f", "psi", "f_minus", "f_plus", "g", "psi_minus", "psi_plus", "jump", "surfaces", "regions", "jumps",
    "transitions",
)  # fmt: skip
"""The fields of a system that `law_arguments` gives."""

SHOWN = 40
"""Characters of a refused text that a message quotes."""


def packed(system: core.PiecewiseSystem) -> str:
    """Return a declaration as JSON, without the fields that have their defaults."""
    given = {name: part for name, part in _differing(system).items() if name not in _LAWS}
    given |= {name: _plain(part) for name, part in system.law_arguments().items()}
    values = system.values
    given["parameters"] = [_differing(parameter) for parameter in system.parameters]
    given["values"] = {  # compared as text: -0.0 is not 0.0
        q.name: values[q.name] for q in system.parameters if repr(values[q.name]) != repr(q.default)
    }
    return json.dumps({name: value for name, value in given.items() if value not in ({}, [])}, separators=(",", ":"))


def _plain(part: Any) -> Any:
    """Return regions and transitions as JSON has them."""
    if isinstance(part, dict):
        return {str(name): _plain(one) for name, one in part.items()}
    if isinstance(part, core.Region | core.Transition):
        return _differing(part)
    return [_plain(one) for one in part] if isinstance(part, tuple) else part


def _differing(record: Any) -> dict[str, Any]:
    return {f.name: getattr(record, f.name) for f in fields(record) if getattr(record, f.name) != f.default}


def unpacked(text: str) -> core.PiecewiseSystem:
    """Return the system that a description declares.

    Raises
    ------
    ValueError
        If the text describes no system, or the system is refused; escape the message before it goes into a page.
    """
    try:
        given = json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise ValueError(f"“{shown(text)}” does not describe a system.") from None
    parts = _checked(given, _SYSTEM, "system", ("name", "variables"))
    system = core.PiecewiseSystem(**parts)
    if system.dimension < PLANE:
        raise ValueError(f"{system.variables[0]} alone is not enough: a portrait needs two variables")
    return system


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a finite number")


def _checked(given: Any, parts: dict[str, Callable[[Any], Any]], what: str, needed: Iterable[str]) -> dict[str, Any]:
    """Return the fields of a JSON object, each read by its entry of `parts`."""
    if not isinstance(given, dict):
        raise ValueError(f"{_quoted(given)} is not a {what}.")
    if missing := [name for name in needed if name not in given]:
        raise ValueError(f"The {what} lacks its {missing[0]}.")
    if unknown := [name for name in given if name not in parts]:
        raise ValueError(f"“{shown(unknown[0])}” is not part of a {what}.")
    return {name: parts[name](value) for name, value in given.items()}


def _word(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{_quoted(value)} is not a text.")
    return value


def _float(value: Any) -> float:
    if type(value) not in (int, float):
        raise ValueError(f"{_quoted(value)} is not a number.")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{_quoted(value)} is too large.") from None


def _list_of(kind: Callable[[Any], Any]) -> Callable[[Any], tuple[Any, ...]]:
    def checked(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise ValueError(f"{_quoted(value)} is not a list.")
        return tuple(map(kind, value))

    return checked


def _parameter(value: Any) -> core.Parameter:
    parts = {"name": _word, "default": _float, "bounds": _list_of(_float), "doc": _word, "latex": _word}
    return core.Parameter(**_checked(value, parts, "parameter", ("name", "default")))


def _values(value: Any) -> dict[str, float]:
    if not isinstance(value, dict):
        raise ValueError(f"{_quoted(value)} is not a list of values of parameters.")
    return {name: _float(number) for name, number in value.items()}


def _mapping_of(key: Callable[[str], Any], kind: Callable[[Any], Any]) -> Callable[[Any], dict[Any, Any]]:
    def checked(value: Any) -> dict[Any, Any]:
        if not isinstance(value, dict):
            raise ValueError(f"{_quoted(value)} is not a list of regions or surfaces by name.")
        return {key(name): kind(one) for name, one in value.items()}

    return checked


def _region(value: Any) -> core.Region:
    return core.Region(**_checked(value, {"f": _list_of(_word), "psi": _list_of(_word)}, "region", ("f",)))


def _transition(value: Any) -> core.Transition:
    parts = {"mode": _word, "guard": _word, "to": _word, "jump": _list_of(_word)}
    return core.Transition(**_checked(value, parts, "transition", ("mode", "guard", "to")))


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 3):
        raise ValueError(f"{_quoted(text)} is not the number of a surface.")
    return int(text)


_SYSTEM: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys(("name", "g", "doc"), _word),
    **dict.fromkeys(("variables", "f", "psi", "f_minus", "f_plus", "psi_minus", "psi_plus", "jump"), _list_of(_word)),
    "surfaces": _list_of(_word),
    "regions": _mapping_of(str, _region),
    "jumps": _mapping_of(_number, _list_of(_word)),
    "transitions": _list_of(_transition),
    "parameters": _list_of(_parameter),
    "x0": _list_of(_float),
    "values": _values,
}


# Refused text in messages --------------------------------------------------------------------------------------------


def shown(text: str, most: int = SHOWN) -> str:
    """Return a text cut to `most` characters and made `visible`."""
    return visible(text if len(text) <= most else text[: most - 1] + "…")


def _quoted(value: object) -> str:
    """Return a wrong value as a message quotes it; of a container only its type, as nested lists may be deep."""
    return f"“{shown(str(value))}”" if isinstance(value, str | int | float) else f"a {type(value).__name__}"


def visible(text: str) -> str:
    """Return a text with U+FFFD in place of unprintable characters and of those that reverse the text direction."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
