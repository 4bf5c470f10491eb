"""The small tables of measured numbers below each figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import core
from pwsviz.figures.order import Studied, limits
from pwsviz.results.requests import RunInputs
from pwsviz.results.run_summary import Summary
from pwsviz.text.tables import Numbers
from pwsviz.text.words import duration, rounded_up

__all__ = ["run_numbers", "slope_numbers"]


def run_numbers(summaries: Mapping[RunInputs, Summary]) -> Numbers:
    """Return a row for each run, and a note with the reasons of those that did not reach the end time."""
    rows = tuple(
        (
            summary.method,
            f"({', '.join(f'{x:g}' for x in inputs.problem.x0)})",
            f"{summary.steps:,}",
            summary.course,
            rounded_up(summary.worst_error) if math.isfinite(summary.worst_error) else "no ψ known",
            duration(summary.seconds),
            summary.status.name.lower().replace("_", " "),
        )
        for inputs, summary in summaries.items()
    )
    stopped = {one.status: one.message for one in reversed(list(summaries.values()))}
    stopped.pop(core.Status.COMPLETED, None)
    first = next(iter(summaries))
    words = [_step(first), "Run times are those of the compiled loop, once, with what it records.", *stopped.values()]
    return Numbers(
        ("integrator", "from", "steps", "at the surface", "largest |Δψ|", "run time", "how it ended"),
        rows,
        " ".join(words),
    )


def _step(inputs: RunInputs) -> str:
    if inputs.scheme.tolerance is not None:
        return f"Tolerance {inputs.scheme.tolerance:g}."
    return f"Step size τ = {inputs.tau:g}."


def slope_numbers(shown: Sequence[Studied]) -> Numbers:
    """Return a row for each curve of an order plot."""
    cells = tuple(
        (
            row.name if len(shown) == 1 else f"{one.method}, {row.name}",
            _digits(row.slope, ".3f"),
            _window(row.window),
            *(_digits(float(row.error[k]), ".1e") for k in (one.taus.argmax(), one.taus.argmin())),
        )
        for one in shown
        for row in one.rows
    )
    found = limits(shown)
    above = " to ".join(dict.fromkeys(f"{row.fit_above:.2g}" for row in found)) if found else "round-off"
    first, methods = shown[0], ", ".join(one.method for one in shown)
    sizes = f"{len(first.taus)} step sizes from {first.taus.max():.3g} to {first.taus.min():.2g}"
    return Numbers(
        ("curve", "fitted slope", "fitted where τ is", "error at the largest τ", "at the smallest"),
        cells,
        f"{methods}, {sizes}; reference: {first.reference}; fits use errors above {above}.",
    )


def _window(window: tuple[float, float]) -> str:
    low, high = (_digits(tau, ".1e") for tau in window)
    return f"{low} … {high}" if math.isfinite(window[0]) else "–"


def _digits(value: float, spec: str) -> str:
    return format(value, spec) if math.isfinite(value) else "–"
