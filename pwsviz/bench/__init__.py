"""python -m pwsviz bench: measure the numbers that the README states."""

from __future__ import annotations

from collections.abc import Iterator

from pwsviz.bench.accuracy import conservation, drift, orders
from pwsviz.bench.comparison import drawn, named
from pwsviz.bench.costs import call_costs, first_calls, moved_slider, step_costs
from pwsviz.bench.ensembles import ensembles
from pwsviz.bench.plan import LONG, QUICK, STANDARD, Plan
from pwsviz.bench.table import Table

__all__ = ["LONG", "QUICK", "STANDARD", "Plan", "Table", "sections"]

#: Functions that measure a section, in the order of the output.
_SECTIONS = (named, drawn, ensembles, step_costs, call_costs, first_calls, moved_slider, conservation, drift, orders)


def sections(plan: Plan = STANDARD) -> Iterator[Table]:
    """Measure one section after another, and yield its table.

    Parameters
    ----------
    plan
        STANDARD takes some minutes; QUICK has every section, with runs too short for numbers to state; LONG has runs of
        10⁸ steps and the whole catalogue.
    """
    for measure in _SECTIONS:
        yield measure(plan)
