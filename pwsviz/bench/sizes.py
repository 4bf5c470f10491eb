"""What a larger system costs: its first call in a fresh process, the memory that takes, and its steps."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable

from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["larger_systems"]

_FIRST = """
import json, sys, time
import numpy as np
import core
from core.integration import compiled_march
from pwsviz.bench.larger import FAMILIES
from pwsviz.bench.memory import peak_memory

family, d, method = sys.argv[1], int(sys.argv[2]), sys.argv[3]
compiled_march()
before = peak_memory()
started = time.perf_counter(), time.process_time()
system = FAMILIES[family](np.random.default_rng(1), d)
declared = time.process_time()
settings = {} if core.METHODS[method].adaptive else {"tau": 1e-3}
core.integrate(system, (0.0, 0.01), method=method, record="end", **settings)
first = time.perf_counter() - started[0], time.process_time() - declared
grown = peak_memory() - before
runs = [core.integrate(system, (0.0, 0.5), method=method, record="end", **settings) for _ in range(7)]
step = min(run.seconds / run.steps for run in runs)
print(json.dumps([declared - started[1], first[1], first[0], grown / 2**20, 1e6 * step]))
"""


def larger_systems(plan: Plan) -> Iterable[str]:
    """Lines on the first call of each method against the dimension."""
    yield "Larger systems: declaring one, and its first call, in a fresh process with an empty cache folder; the time"
    yield "loop is compiled already. Seconds of the processor, and by the clock on the wall for both; by how much they"
    yield "raise the greatest memory ever held; microseconds a step (tau = 0.001; taylor: tolerance = 1e-12)."
    rows = []
    for family, d in plan.larger:
        for method in plan.start_methods:
            declared, first, wall, memory, step = _measured(family, d, method)
            cells = (f"{declared:.2f}", f"{first:.2f}", f"{wall:.2f}", f"{memory:.0f}", f"{step:.3g}")
            rows.append([family, str(d), method, *cells])
    header = ("family", "d", "method", "declared (s)", "first call (s)", "wall (s)", "memory (MiB)", "us a step")
    yield from aligned(header, rows, left=1)


def _measured(family: str, d: int, method: str) -> list[float]:
    """What the program prints, run in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o700)
        command = [sys.executable, "-c", _FIRST, family, str(d), method]
        environment = {**os.environ, "PWSVIZ_CACHE": folder}
        out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)  # noqa: S603 - our own text
    numbers: list[float] = json.loads(out.stdout)
    return numbers
