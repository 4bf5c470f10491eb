"""python -m pwsviz bench: the figures that this project states, measured here, with the rivals in the same process."""

from __future__ import annotations

from typing import TextIO

from pwsviz.bench.catalogue import catalogue_orders, orders_in_digits
from pwsviz.bench.drawn import drawn
from pwsviz.bench.drift import drift
from pwsviz.bench.machine import machine_lines
from pwsviz.bench.plan import LONG, QUICK, STANDARD, Plan
from pwsviz.bench.quality import conservation, orders
from pwsviz.bench.rivals import comparison
from pwsviz.bench.sizes import larger_systems
from pwsviz.bench.slider import moved_slider
from pwsviz.bench.start import first_calls
from pwsviz.bench.steps import linearity, step_costs

__all__ = ["LONG", "QUICK", "STANDARD", "Plan", "report"]


# Memory first: the greatest that was ever held is no measure once the others have held more.
_SECTIONS = (
    linearity, comparison, drawn, step_costs, first_calls, larger_systems, moved_slider, conservation, drift, orders,
    catalogue_orders, orders_in_digits,
)  # fmt: skip


def report(out: TextIO, plan: Plan = STANDARD) -> None:
    """Measure everything and write it as text, line by line as it comes.

    Parameters
    ----------
    plan
        STANDARD takes some minutes; QUICK shows every section with figures too small to state; LONG has 10⁸ steps
        and the whole catalogue.
    """
    for line in machine_lines():
        print(line, file=out)
    for section in _SECTIONS:
        print(file=out)
        for line in section(plan):
            print(line, file=out, flush=True)
