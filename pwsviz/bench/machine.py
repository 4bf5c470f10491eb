"""The machine and the versions of packages with which was measured."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

from core.interface import processor

__all__ = ["machine_lines"]

#: Packages whose versions are listed.
_PACKAGES = ("numpy", "numba", "scipy", "heyoka")


def machine_lines() -> Iterable[str]:
    """Lines of text on versions and on the processor."""
    packages = ", ".join(f"{name} {_version(name)}" for name in _PACKAGES)
    yield f"Python {platform.python_version()}, {packages}"
    yield f"{processor()}, {os.cpu_count()} cores, {platform.machine()} {platform.system()}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
