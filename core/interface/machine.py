"""The processor on which the program runs."""

from __future__ import annotations

import platform
import re
from pathlib import Path

__all__ = ["processor"]


def processor() -> str:
    """Return the name of the processor, without marks of its maker: from a file on Linux, from `platform` elsewhere."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or "unknown processor"
    return " ".join(re.sub(r"\((R|TM|C)\)|\bCPU\b|@.*", "", name).split())
