"""Time of a first call: in a fresh process, with and without what an earlier one compiled."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable

from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["first_calls"]

_START = """
import sys, time
start = time.perf_counter()
import core
imported = time.perf_counter()
core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 60.0), method=sys.argv[1], record="end")
print(imported - start, time.perf_counter() - imported)
"""


def first_calls(plan: Plan) -> Iterable[str]:
    """Lines on the first call of each method."""
    yield "First call, in seconds: integrate the elliptic curve to T = 60 in a fresh process, which compiles the"
    yield "method, and in another, which loads it. The cache folder is empty before the first method: it compiles the"
    yield "loops too, which all methods share."
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for method in plan.start_methods:
            (imported, compiles), (_, loads) = (_start(method, folder) for _ in range(2))
            rows.append([method, *(f"{seconds:.2f}" for seconds in (imported, compiles, loads))])
    yield from aligned(("method", "import", "compiles", "loads"), rows)


def _start(method: str, folder: str) -> tuple[float, float]:
    """Seconds to import core, and to call it for the first time, in a process of its own."""
    os.chmod(folder, 0o700)
    environment = {**os.environ, "PWSVIZ_CACHE": folder, "NUMBA_CACHE_DIR": folder}
    command = [sys.executable, "-c", _START, method]
    out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)  # noqa: S603 - our own text
    imported, called = map(float, out.stdout.split())
    return imported, called
