"""A work-precision study in plain words, and its table of the cheapest integrators."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import numpy as np

import core
from core.interface import processor
from core.studies import CANCELLED, DONE, EXTERNAL_SOLVERS, WAITING, CostCurve
from pwsviz.figures.style import FAINT
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.numbers import printed
from pwsviz.text.tables import Numbers
from pwsviz.text.words import duration, listed, plural

Across = Literal["seconds", "evaluations"]
Up = Literal["state", "time", "invariant"]

ACROSS: Mapping[str, str] = {"seconds": "run time (s)", "evaluations": "evaluations of the field"}
UP: Mapping[str, str] = {
    "state": "state error at the end, ‖x − x*‖₂",
    "time": "error of the last crossing time, |t* − t̂|",
    "invariant": "largest |Δψ|",
}
"""Titles of the axes."""

MEANING: Mapping[str, str] = {
    "state": "‖x − x*‖₂ is the Euclidean distance between the states of the run and of the reference at the end.",
    "time": "t* and t̂ are the times of the last crossing of the reference and of the run.",
    "invariant": "|Δψ| is the change of ψ since the start.",
}
"""What the errors are, for captions."""

TARGETS = (1e-3, 1e-6, 1e-9)
"""Errors for which the table names the cheapest integrators."""

NONE = "–"
"""In place of an integrator where none reaches an error."""

TIE = 1.5
"""Ratio of run times up to which integrators are named together: the fastest of a few repeats of runs of a tenth of a
millisecond varies by as much where the processor has other work."""

_IN_MEMORY = 1e-3  #: seconds of preparing below which nothing was compiled or loaded


def cost_of(curve: CostCurve, across: Across) -> Floats:
    """Return (m,) run times, or numbers of evaluations."""
    return curve.seconds if across == "seconds" else curve.evaluations


def error_of(curve: CostCurve, up: Up) -> Floats:
    """Return (m,) errors of one kind."""
    return {"state": curve.state_error, "time": curve.time_error, "invariant": curve.invariant_error}[up]


def bottom_of(study: core.WorkPrecision, up: Up) -> float:
    """Return the lower end of a plot of errors, at which smaller ones are drawn."""
    return (study.floor[up] or MACHINE_EPSILON) / FAINT


def shows_round_off(study: core.WorkPrecision, up: Up) -> bool:
    """Whether errors come so near to round-off that its line is within the axes, or may be."""
    errors = np.concatenate([error_of(curve, up) for curve in study.curves])
    return bool((errors < 10 * (study.floor[up] or MACHINE_EPSILON)).any())


def setting_text(curve: CostCurve, k: int) -> str:
    """Return a setting as text: “τ = 0.01”."""
    name = "τ" if curve.setting_name == "tau" else curve.setting_name
    return f"{name} = {curve.setting[k]:.3g}"


def settings_text(study: core.WorkPrecision) -> str:
    """Return between which step sizes and tolerances the points lie: “step sizes from 0.001 to 0.2 (dmm2)”."""
    ranges = []
    for name, said in (("tau", "step sizes"), ("tolerance", "tolerances")):
        having = [c for c in study.curves if c.setting_name == name and np.isfinite(c.seconds).any()]
        whose: dict[str, list[str]] = {}
        for curve in having:
            found = curve.setting[np.isfinite(curve.seconds)]
            whose.setdefault(f"{found.min():.3g} to {found.max():.3g}", []).append(curve.title)
        if whose:
            ranges.append(f"{said} from " + ", ".join(f"{words} ({listed(titles)})" for words, titles in whose.items()))
    return "; ".join(ranges)


def missing_text(study: core.WorkPrecision) -> str:
    """Say which runs have no point, and why: “no point: rk2 with τ = 0.2 (…)”; empty if all have."""
    without = [
        f"{curve.title} with {setting_text(curve, int(k))} ({curve.status[k]})"
        for curve in study.curves
        for k in np.flatnonzero(~np.isfinite(curve.seconds))
        if curve.status[k] not in (WAITING, CANCELLED)
    ]
    return f"; no point: {listed(without)}" * bool(without)


def cost_words(cost: float, across: Across) -> str:
    """Return a cost with its unit."""
    return duration(cost) if across == "seconds" else plural(round(cost), "evaluation")


def cost_numbers(study: core.WorkPrecision, across: Across, up: Up) -> Numbers:
    """Return the cheapest run of ours and of an external solver for each of `TARGETS`; no rows if there is no error."""
    cost = "run time" if across == "seconds" else "evaluations"
    best = "fastest" if across == "seconds" else "cheapest"
    header = ("error at most", f"{best} integrator", cost, f"{best} external solver", cost)
    some = any(np.isfinite(error_of(curve, up)).any() for curve in study.curves)
    rows = tuple(_cheapest(study, target, across, up) for target in TARGETS) if some else ()
    what = "Shortest measured run time" if across == "seconds" else "Fewest evaluations measured"
    ties = f"; integrators up to {TIE:g} times slower are listed as well" * (across == "seconds")
    caption = f"{what} for each error. Only runs with the correct sequence of crossings are considered{ties}."
    return Numbers(header, rows, caption=caption)


def _cheapest(study: core.WorkPrecision, target: float, across: Across, up: Up) -> tuple[str, ...]:
    """Return the row of one target: the error, then integrators and cost, of ours and of external solvers."""
    cells = [printed(f"{target:.0e}")]
    for peer in (False, True):
        reached = [_reach(curve, target, across, up) for curve in study.curves if curve.peer is peer]
        found = sorted(filter(None, reached), key=lambda one: one[0])
        if not found:
            cells += [NONE, NONE]
            continue
        slack = TIE if across == "seconds" else 1.0
        best = [one for one in found if one[0] <= slack * found[0][0]]
        names = [f"{curve.title}, {setting_text(curve, k)}" for _, curve, k in best]
        if across == "seconds":  # a number stays with its unit
            told = [duration(cost).replace(" ", "\u00a0") for cost, *_ in best]
        else:
            told = [f"{round(cost):,}" for cost, *_ in best]
        cells += [" or ".join(names), " or ".join(told if len({*told}) > 1 else told[:1])]
    return tuple(cells)


def _reach(curve: CostCurve, target: float, across: Across, up: Up) -> tuple[float, CostCurve, int] | None:
    """Return the least cost of a right run with an error up to the target, its curve and index; None if none is."""
    good = (error_of(curve, up) <= target) & curve.correct_sequence
    cost = np.where(good, cost_of(curve, across), np.nan)
    if np.isnan(cost).all():
        return None
    k = int(np.nanargmin(cost))
    return float(cost[k]), curve, k


def cost_text(study: core.WorkPrecision, across: Across, up: Up) -> str:
    """Return in words what is missing or wrong in a study, and whose times tell little; empty if nothing is."""
    parts = [f"{words}."] if across == "seconds" and (words := _in_python(study)) else []
    if not any(np.isfinite(error_of(curve, up)).any() for curve in study.curves):
        parts.append(f"There is no {UP[up]} to show: {_why_none(study, up)}.")
    return " ".join([*parts, *_missing(study)])


def cost_details(study: core.WorkPrecision, across: Across, up: Up) -> str:
    """Return in words what a study measures, compile times, and which errors are too small to tell."""
    measured = _about_evaluations(study) if across == "evaluations" else f"{_timed(study)}."
    parts = (measured, _below(study, up), _compiling(study), _comparison(study, up))
    return " ".join(filter(None, parts))


def _why_none(study: core.WorkPrecision, up: Up) -> str:
    if not any(np.isfinite(curve.seconds).any() for curve in study.curves):
        return "no run has reached the end"
    return {
        "state": "no run has reached the end",
        "time": "no run has the crossings of the solution" if any(study.met) else "there is no crossing",
        "invariant": "no conserved quantity is known",
    }[up]


def _about_evaluations(study: core.WorkPrecision) -> str:
    notes = [
        f"{curve.title} does not count its evaluations."
        for curve in study.curves
        if np.isfinite(curve.seconds).any() and np.isnan(curve.evaluations).all()
    ]
    if any(curve.name == "taylor" for curve in study.curves):
        notes.append("One evaluation of taylor is a whole series.")
    return " ".join(notes)


def timed_how(study: core.WorkPrecision) -> str:
    """Return what a run time is, on which machine, and of which integrators the field is not compiled."""
    return "; ".join(filter(None, (_timed(study), _in_python(study))))


def _in_python(study: core.WorkPrecision) -> str:
    slow = [c.title for c in study.curves if c.peer and not EXTERNAL_SOLVERS[c.name].compiled]
    return f"{listed(slow)} evaluates the field in Python, whereas the others use compiled code" if slow else ""


def _timed(study: core.WorkPrecision) -> str:
    times = f"the shortest of {study.repeats} runs" if study.repeats > 1 else "one run"
    return f"Run time is the processor time of one thread, excluding compilation ({times}; {processor()})"


def _compiling(study: core.WorkPrecision) -> str:
    took = [(curve.title, curve.compile_seconds) for curve in study.curves if np.isfinite(curve.compile_seconds)]
    compiled = [f"{title} {duration(seconds)}" for title, seconds in took if seconds >= _IN_MEMORY]
    loaded = [title for title, seconds in took if seconds < _IN_MEMORY]
    rest = f"; {listed(loaded)} already loaded" * bool(loaded)
    return f"Compile/load time (not included): {listed(compiled)}{rest}." if compiled else ""


def _missing(study: core.WorkPrecision) -> Iterator[str]:
    """Yield a sentence on each missing or wrong result, once for each reason."""
    for word in (WAITING, CANCELLED):
        count = sum(curve.status.count(word) for curve in study.curves)
        if count:
            yield f"{plural(count, 'setting')} {word}."
    wrong = f"the sequence of crossings differs from that of the solution, which has {_met(study)} (open symbols)"
    told: dict[str, list[str]] = {}
    for curve in study.curves:
        places: dict[str, list[int]] = {}
        for k, status in enumerate(curve.status):
            if status not in (DONE, WAITING, CANCELLED):
                places.setdefault(wrong if np.isfinite(curve.seconds[k]) else status, []).append(k)
        for reason, found in places.items():
            told.setdefault(reason, []).append(f"{curve.title}{_where(curve, found)}")
    for reason, names in told.items():
        yield f"{'; '.join(names)}: {reason}."


def lies_below(study: core.WorkPrecision, up: Up) -> bool:
    """Whether errors are drawn at the lower end of the plot, which they lie below."""
    return any(found for _, found in _places_below(study, up))


def _places_below(study: core.WorkPrecision, up: Up) -> list[tuple[CostCurve, list[int]]]:
    """Return the curves, each with the numbers of the errors that lie below the plot."""
    bottom = bottom_of(study, up)
    return [
        (curve, np.flatnonzero((error_of(curve, up) < bottom) & np.isfinite(curve.seconds)).tolist())
        for curve in study.curves
    ]


def _below(study: core.WorkPrecision, up: Up) -> str:
    """Say which errors are drawn at the lower end of the plot, which they lie below; empty if none is."""
    told = [f"{curve.title}{_where(curve, found)}" for curve, found in _places_below(study, up) if found]
    return f"Errors of 0 or below the plot’s range, drawn as downward triangles: {'; '.join(told)}." if told else ""


def _where(curve: CostCurve, found: list[int]) -> str:
    if len(found) == len(curve.setting):
        return ""
    first = f", {setting_text(curve, found[0])}"
    return first if len(found) == 1 else f"{first} and {plural(len(found) - 1, 'other value')}"


def compared_with(study: core.WorkPrecision) -> str:
    """Return over which time the runs go, and what they are compared with."""
    return f"to t = {study.t_span[1]:.6g}, over {_met(study)}; reference: {study.reference}"


def _met(study: core.WorkPrecision) -> str:
    """Return what the solution meets: “21 crossings”, “3 crossings and 1 slide”."""
    return listed(str(study.met).split(", "))


def _comparison(study: core.WorkPrecision, up: Up) -> str:
    return (
        f"Run {compared_with(study)}. Errors below {study.floor[up]:.0e} may be round-off, or those of the reference. "
        "Round-off adds up along a run, so a curve may level off above that."
    )
