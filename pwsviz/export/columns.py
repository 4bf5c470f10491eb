"""Meaning and unit of the columns of exported tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

__all__ = ["MEANINGS", "by_name", "is_count", "meanings"]

_TIME = "in the system’s unit of time"

MEANINGS: Mapping[str, str] = {
    "start": "number of the start, from 1",
    "integrator": "its name",
    "step": "number of the step, from 0; of very long runs every k-th step is kept",
    "t": f"time, {_TIME}",
    "side": "sign of g on the side occupied; 0 while sliding along g = 0",
    "region": "region occupied: its name, or one sign for each surface, 0 for one along which it slides; to be read "
    "as text",
    "region_entered": "region entered, likewise; empty where the run stopped",
    "side_entered": "sign of g on the side entered; 0 where it slides or stops",
    "change_of_psi": "|Δψ|, the error of ψ since the start, the largest over several ψ; "
    "while a run slides, |Δg| and what else sliding keeps",
    "number": "number of the crossing in its run, from 1",
    "point": "number of the point of its start, from 1; discarded points do not count",
    "kind": "what happens; sliding: it begins, leaving: it ends, jump: the state is the one before it",
    "curve": "where the error is taken: before the first crossing, after or at the crossing numbered, or at a time",
    "tau": f"step size τ, {_TIME}",
    "tolerance": "error of a step relative to the state",
    "error": "error of the quantity that the figure shows",
    "slope": "fitted order",
    "slope_error": "standard error of the slope, from the residuals of the fit",
    "reference": "solution with which the runs are compared",
    "setting": "step size τ or tolerance, as setting_name says",
    "setting_name": "what setting is",
    "outcome": "how the run ended, or what is wrong with it",
    "reason": "why the smallest step size that fails does",
    "fit_from": f"smallest τ of the fit, {_TIME}",
    "fit_to": f"largest τ of the fit, {_TIME}",
    "fit_above": "errors above this may enter the fit",
    "fit_below": "errors below this may enter the fit",
    "seconds": "processor time of a run, in s",
    "compile_seconds": "processor time to compile or load, not included in seconds, in s",
    "evaluations": "number of evaluations of the (discrete) field",
    "state_error": "‖x − x*‖₂ at the end, x* the solution",
    "time_error": f"|t̂ − t*| of the last crossing, {_TIME}",
    "invariant_error": "largest |Δψ| of the run, the error of ψ since the start",
    "crossings": "number of crossings and jumps",
    "expected_crossings": "number of crossings and jumps of the solution",
    "slides": "how often sliding begins",
    "expected_slides": "how often sliding begins in the solution",
    "value": "value of the parameter",
    "chosen": "1 at the chosen value of the parameter, which the figure marks; 0 at others",
    "ended": "how the run of a value ended",
    "doubt": "whether the run of a value was examined for errors and is in doubt; empty if it was not examined",
    "points": "number of its points",
    "correct_sequence": "whether the run has the crossings of the solution, in order",
    "as_the_solution": "whether the run ends as the solution does, with the same sequence of crossings",
    "largest_tau": f"largest step size that works, {_TIME}",
    "first_that_fails": f"smallest step size that fails, {_TIME}",
    "delta": "distance of the start from the tangency",
}
"""Meaning of each column by its name; the variables of a system need none."""


def is_count(name: str) -> bool:
    """Whether a column counts something: its numbers are whole, or nan."""
    return MEANINGS.get(name, "").startswith("number of ")


def by_name(names: Sequence[str], columns: Iterable[NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return columns of variables or parameters by name, with a prefix where a column of ours has the same name."""
    return {
        f"variable_{name}" if name in MEANINGS or name == "about" else name: column
        for name, column in zip(names, columns, strict=True)
    }


def meanings(names: Iterable[str]) -> str:
    """Return the meaning of the columns named, those that need one, on one line."""
    return "; ".join(f"{name}: {MEANINGS[name]}" for name in names if name in MEANINGS)
