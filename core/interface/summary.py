"""Results whose `repr` is one line."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

__all__ = ["Brief"]

_LONGEST = 60  #: most characters displayed of a value; of a longer tuple, its length is


class Brief:
    """A dataclass whose `repr` is one line; arrays are displayed as their shapes."""

    def __repr__(self) -> str:
        facts = ", ".join(f"{f.name} {_fact(getattr(self, f.name))}" for f in fields(self))  # type: ignore[arg-type]
        return f"<{type(self).__name__}: {facts}>"


def _fact(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return str(value.shape)
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Brief):
        return f"<{type(value).__name__}>"
    text = repr(value)
    if len(text) <= _LONGEST:
        return text
    return f"({len(value)})" if isinstance(value, tuple) else f"{text[:_LONGEST]}…"
