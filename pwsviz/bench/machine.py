"""The machine and the versions of packages with which was measured."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__all__ = ["machine_lines"]

#: Packages whose versions are listed.
_PACKAGES = ("numpy", "numba", "scipy", "heyoka")


def machine_lines() -> Iterable[str]:
    """Lines of text on versions and on the processor."""
    packages = ", ".join(f"{name} {_version(name)}" for name in _PACKAGES)
    yield f"Python {platform.python_version()}, {packages}"
    yield f"{_processor()}, {os.cpu_count()} cores, {platform.machine()} {platform.system()}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    """Name of the processor: from a file on Linux, from `platform` elsewhere."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"
