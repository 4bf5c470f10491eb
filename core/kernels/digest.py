"""Digest of the sources from which machine code is compiled: the key of every cache that keeps it."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

__all__ = ["imported_modules", "source_digest"]

_PACKAGE = __name__.partition(".")[0]
_IMPORT = re.compile(rf"^from ({_PACKAGE}(?:\.\w+)*) import (\([^)]*\)|[^\n(]*)", re.MULTILINE)


@cache
def source_digest(*names: str) -> str:
    """Digest of the sources of modules, and of all modules of this package that they import, directly or not.

    numba recompiles a cached function only when its own file changes. Functions inlined from other files have to enter
    the key by another way: the value of a variable that the function closes over is part of the key.

    Parameters
    ----------
    names
        Names of the modules.
    """
    sources: dict[str, str] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in sources:
            sources[name] = Path(str(import_module(name).__file__)).read_text(encoding="utf-8")
            waiting += imported_modules(sources[name])
    return hashlib.sha256("\0".join(sources[name] for name in sorted(sources)).encode()).hexdigest()


def imported_modules(source: str) -> Iterator[str]:
    """Names of the modules of this package that a source imports by ``from … import …``."""
    for match in _IMPORT.finditer(source):
        for name in re.findall(r"\w+", match[2]):
            inner = f"{match[1]}.{name}"
            yield inner if inner in sys.modules else match[1]
