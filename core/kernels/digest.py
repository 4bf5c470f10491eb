"""One digest of the sources that compiled code is made of, for every cache that keeps machine code."""

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
    """Digest of the sources of modules, and of all they import from this package.

    numba looks for changes in a function's own file only. What it inlines from others has to be part of the key under
    which the machine code is kept: a closed-over variable of a cached function is.

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
    """Names of the modules of this package that a source imports, in the form ``from … import …``."""
    for match in _IMPORT.finditer(source):
        for name in re.findall(r"\w+", match[2]):
            inner = f"{match[1]}.{name}"
            yield inner if inner in sys.modules else match[1]
