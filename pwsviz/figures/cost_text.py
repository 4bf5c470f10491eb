"""A work-precision study in plain words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import numpy as np

import core
from core.studies import CANCELLED, DONE, WAITING, CostCurve
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.words import duration, listed, plural

Across = Literal["seconds", "evaluations"]
Up = Literal["state", "time", "invariant"]

ACROSS: Mapping[str, str] = {"seconds": "run time (s)", "evaluations": "evaluations of the field"}
UP: Mapping[str, str] = {
    "state": "error of the state at the end",
    "time": "error of the time of the last crossing",
    "invariant": "greatest |Δψ| between crossings",
}
"""Titles of the axes."""

TARGETS = (1e-3, 1e-6, 1e-9)
"""Errors for which the text names the cheapest integrator."""

_IN_MEMORY = 1e-3  #: seconds of preparing below which nothing was compiled or loaded


def cost_of(curve: CostCurve, across: Across) -> Floats:
    """Return (m,) run times, or numbers of evaluations."""
    return curve.seconds if across == "seconds" else curve.evaluations


def error_of(curve: CostCurve, up: Up) -> Floats:
    """Return (m,) errors of one kind."""
    return {"state": curve.state_error, "time": curve.time_error, "invariant": curve.invariant_error}[up]


def setting_text(curve: CostCurve, k: int) -> str:
    """Return a setting as text: “τ = 0.01”."""
    name = "τ" if curve.setting_name == "tau" else curve.setting_name
    return f"{name} = {curve.setting[k]:.3g}"


def cost_words(cost: float, across: Across) -> str:
    """Return a cost with its unit."""
    return duration(cost) if across == "seconds" else plural(round(cost), "evaluation")


def cost_text(study: core.WorkPrecision, across: Across, up: Up) -> str:
    """Return a study in words: which integrator is cheapest for an error, compile times, and what is missing."""
    if not any(np.isfinite(error_of(curve, up)).any() for curve in study.curves):
        start = f"There is no {UP[up]} to show: {_why_none(study, up)}."
    else:
        start = " ".join(_cheapest(study, target, across, up) for target in TARGETS)
    parts = [start, _compiling(study), *_missing(study), _measured_against(study, up)]
    if across == "evaluations":
        parts.insert(1, _about_evaluations(study))
    return " ".join(filter(None, parts))


def _why_none(study: core.WorkPrecision, up: Up) -> str:
    if not any(np.isfinite(curve.seconds).any() for curve in study.curves):
        return "no run has reached the end"
    return {
        "state": "no run has reached the end",
        "time": "no run has as many crossings as the solution" if study.crossings else "there is no crossing",
        "invariant": "no conserved quantity is known",
    }[up]


def _cheapest(study: core.WorkPrecision, target: float, across: Across, up: Up) -> str:
    """Return the cheapest integrator for an error, and how the best of the other kind (ours or external) compares."""
    best = sorted(filter(None, (_reach(curve, target, across, up) for curve in study.curves)), key=lambda one: one[0])
    if not best:
        return f"None reaches an error of {target:.0e}."
    cost, curve, k = best[0]
    word = "Fastest" if across == "seconds" else "Fewest evaluations"
    text = f"{word} to an error of {target:.0e}: {curve.title} ({setting_text(curve, k)}), {cost_words(cost, across)}"
    others = [one for one in best[1:] if one[1].peer != curve.peer]
    if others:
        other = others[0]
        whose = "of ours" if curve.peer else "of others"
        text += f"; the best {whose}, {other[1].title}, takes {other[0] / cost:.3g} times as much"
    return text + "."


def _reach(curve: CostCurve, target: float, across: Across, up: Up) -> tuple[float, CostCurve, int] | None:
    """Return the least cost of a setting with an error up to the target, with its curve and index; None if none is."""
    cost = np.where(error_of(curve, up) <= target, cost_of(curve, across), np.nan)
    if np.isnan(cost).all():
        return None
    k = int(np.nanargmin(cost))
    return float(cost[k]), curve, k


def _about_evaluations(study: core.WorkPrecision) -> str:
    notes = [
        f"{curve.title} does not count its evaluations."
        for curve in study.curves
        if np.isfinite(curve.seconds).any() and np.isnan(curve.evaluations).all()
    ]
    if any(curve.name == "taylor" for curve in study.curves):
        notes.append("An evaluation of taylor is a whole series.")
    return " ".join(notes)


def _compiling(study: core.WorkPrecision) -> str:
    took = [(curve.title, curve.compile_seconds) for curve in study.curves if np.isfinite(curve.compile_seconds)]
    compiled = [f"{title} {duration(seconds)}" for title, seconds in took if seconds >= _IN_MEMORY]
    return f"Compile/load time (not included): {listed(compiled)}." if compiled else ""


def _missing(study: core.WorkPrecision) -> Iterator[str]:
    """Yield a sentence on each missing or wrong result, once for each integrator and reason."""
    for word in (WAITING, CANCELLED):
        count = sum(curve.status.count(word) for curve in study.curves)
        if count:
            yield f"{plural(count, 'setting')} {word}."
    for curve in study.curves:
        places: dict[str, list[int]] = {}
        for k, status in enumerate(curve.status):
            if status not in (DONE, WAITING, CANCELLED):
                wrong = f"not the {plural(study.crossings, 'crossing')} that the solution has"
                places.setdefault(wrong if np.isfinite(curve.seconds[k]) else status, []).append(k)
        for reason, found in places.items():
            yield f"{curve.title}{_where(curve, found)}: {reason}."


def _where(curve: CostCurve, found: list[int]) -> str:
    if len(found) == len(curve.setting):
        return ""
    first = f", {setting_text(curve, found[0])}"
    return first if len(found) == 1 else f"{first} and {plural(len(found) - 1, 'other setting')}"


def _measured_against(study: core.WorkPrecision, up: Up) -> str:
    text = f"Run to t = {study.t_span[1]:.6g}, over {plural(study.crossings, 'crossing')}."
    if up == "invariant":
        return text
    return f"{text} Measured against: {study.reference}; errors below {study.floor[up]:.0e} are round-off, or its own."
