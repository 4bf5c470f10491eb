"""The greatest memory that was ever held."""

from __future__ import annotations

import sys

__all__ = ["peak_memory"]


def peak_memory() -> float:
    """Greatest resident memory of this process so far, in bytes; nan where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows has no such module
        return float("nan")
    unit = 1 if sys.platform == "darwin" else 1024
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit)
