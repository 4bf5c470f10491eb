"""The runs that a figure draws, as tables: a row for each step, for each crossing, and for each vertex drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.export.columns import by_name
from pwsviz.export.files import Tables
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.section_plane import angles
from pwsviz.results.orbits import Orbit
from pwsviz.results.requests import RunInputs
from pwsviz.results.results import Pictures, PortraitInputs
from pwsviz.results.sweeps import NO_CROSSING, NO_START, Diagram

__all__ = ["MOST_ROWS", "DrawnRun", "conserved_tables", "drawn_runs", "drawn_table", "portrait_tables", "sweep_tables"]

MOST_ROWS = 2_000_000
"""Rows of a table, about; of runs that have more steps together, every k-th step of each is kept, and the last."""

Columns = dict[str, NDArray[Any]]


class DrawnRun(NamedTuple):
    """A run in a figure."""

    start: int
    """Number of its start, from 1."""
    run: core.Trajectory


Drawn = Callable[[], Sequence[DrawnRun]]
"""Returns the runs in a figure; it may have to compute them."""


def drawn_runs(inputs: PortraitInputs, selected: int, run: Callable[[RunInputs], core.Trajectory]) -> Drawn:
    """Return the runs in a portrait, start by start.

    Parameters
    ----------
    inputs : PortraitInputs
        What the portrait draws.
    selected : int
        Index of the selected start.
    run : callable
        Returns a run.
    """
    each = len(inputs.selected)
    before = selected * each
    ordered = (*inputs.others[:before], *inputs.selected, *inputs.others[before:])
    return lambda: [DrawnRun(1 + k // each, run(one)) for k, one in enumerate(ordered)]


def portrait_tables(runs: Drawn) -> Tables:
    """Return the states of all runs at the integrators' own steps, and their crossings with the place on the surface.

    Columns
    -------
    curves: start, integrator, step, t, the variables by name, side; of several surfaces the region in its place;
    crossings: start, integrator, number, t, the variables by name, side_entered (or region_entered), kind.
    """
    return {
        "curves": lambda: _stacked(drawn := runs(), map(_states, drawn, _kept(drawn))),
        "crossings": lambda: _stacked(drawn := runs(), [_crossings(one, places=True) for one in drawn]),
    }


def drawn_table(pictures: Pictures) -> Tables:
    """Return the curves of a portrait as drawn: between long steps the solution, elsewhere no more than a screen shows.

    Columns
    -------
    drawn: start, integrator, the two variables of the plane by name; a row of NaN is a gap in the curve. A plane alike
    has a table of its own, with its variables in the name.
    """
    variables = pictures.inputs.selected[0].problem.declaration.variables
    starts = [number for number, _ in pictures.numbered]

    def drawn(plane: Plane, orbits: Sequence[Orbit]) -> Columns:
        numbered = sorted(zip(starts, orbits, strict=True), key=lambda one: one[0])
        lengths = [len(orbit.path) for _, orbit in numbered]
        return {
            "start": np.repeat([number for number, _ in numbered], lengths),
            "integrator": np.repeat([orbit.method for _, orbit in numbered], lengths),
            **by_name(
                [variables[k] for k in plane.axes], plane.values(np.concatenate([o.path for _, o in numbered])).T
            ),
        }

    alongside = {
        f"drawn {' '.join(variables[k] for k in one.axes)}": (one, orbits) for one, orbits in pictures.alongside.items()
    }
    whole = {"drawn": (pictures.plane, [*pictures.orbits, *pictures.others])} | alongside
    return {name: partial(drawn, *given) for name, given in whole.items()}


def conserved_tables(runs: Drawn) -> Tables:
    """Return the error of ψ of all runs at their own steps, and the times of their crossings.

    Columns
    -------
    curves: start, integrator, step, t, side, change_of_psi (|Δψ| since the start);
    crossings: start, integrator, number, t, side_entered, kind.
    """
    return {
        "curves": lambda: _stacked(drawn := runs(), map(_changes, drawn, _kept(drawn))),
        "crossings": lambda: _stacked(drawn := runs(), [_crossings(one, places=False) for one in drawn]),
    }


def sweep_tables(found: Diagram, present: float = math.nan, alone: Diagram | None = None) -> Tables:
    """Return the points of a bifurcation diagram, value by value and in the order of time, and how each run ended.

    `present` is the chosen value of the parameter, and `alone` the points of this value if the diagram has none of it.

    Columns
    -------
    points: value, the coordinate by name (of an angle, without full turns), chosen;
    values: value, points (how many), ended, doubt (“examined”, “small errors grow”, “in doubt”, or empty where a run is
        not examined);
    chosen: value, points (how many), if it is within the range.
    """
    marked = np.empty(0) if alone is None else alone.points_at(present)

    def points() -> Columns:
        x, y = found.sorted_points()
        row = int(np.searchsorted(x, present))
        value = np.insert(x, np.full(len(marked), row), present)
        coordinate = np.insert(y, np.full(len(marked), row), marked)
        inputs = found.inputs
        turns = " mod 2*pi" if inputs.column in angles(inputs.problem.declaration) else ""
        named = by_name([inputs.coordinate + turns], [coordinate])
        return {"value": value, **named, "chosen": (value == present).astype(int)}

    def chosen() -> Columns:
        count = np.count_nonzero(points()["chosen"])
        return {"value": np.array([present]), "points": np.array([count])}

    def values() -> Columns:
        there = found.done
        ended = [_ended(*one) for one in zip(found.outcomes[there].tolist(), found.whole[there], strict=True)]
        value = found.values[there]
        examined = np.where(np.isin(value, found.examined), "examined", "")
        growing = np.where(np.isin(value, found.sensitive), "small errors grow", examined)
        doubt = np.where(np.isin(value, found.warned), "in doubt", growing)
        return {"value": value, "points": found.counts[there], "ended": np.array(ended), "doubt": doubt}

    there = found.inputs.low <= present <= found.inputs.high
    return {"points": points, "values": values, **({"chosen": chosen} if there else {})}


def _ended(code: int, whole: bool) -> str:
    """Return in words how the run of a value ended."""
    if whole:
        return "all points found"
    known = {NO_START: "no run begins here", NO_CROSSING: "no crossing up to the end time"}
    return known.get(code) or core.Status(code).reason


def _kept(runs: Sequence[DrawnRun]) -> list[NDArray[np.intp]]:
    """Return the rows of each run that go into a table."""
    every = -(-sum(len(one.run.t) for one in runs) // MOST_ROWS)
    kept = [np.arange(0, len(one.run.t), max(every, 1)) for one in runs]
    return [np.union1d(rows, [len(one.run.t) - 1]) for one, rows in zip(runs, kept, strict=True)]


def _states(drawn: DrawnRun, rows: NDArray[np.intp]) -> Columns:
    run = drawn.run
    return {
        "step": rows,
        "t": run.t[rows],
        **by_name(run.system.variables, run.x[rows].T),
        **_where("side", run.system, run.mode[rows]),
    }


def _changes(drawn: DrawnRun, rows: NDArray[np.intp]) -> Columns:
    run = drawn.run
    return {
        "step": rows,
        "t": run.t[rows],
        **_where("side", run.system, run.mode[rows]),
        "change_of_psi": run.change_of_psi()[rows],
    }


def _crossings(drawn: DrawnRun, places: bool) -> Columns:
    met = drawn.run.crossings
    at = by_name(drawn.run.system.variables, met.x.T) if places else {}
    entered = _where("side_entered", drawn.run.system, met.mode)
    return {"number": np.arange(1, 1 + len(met)), "t": met.t, **at, **entered, "kind": met.kind}


def _where(name: str, system: core.PiecewiseSystem, mode: NDArray[np.int64]) -> Columns:
    """Return the column of the modes: their sides of one surface, else the names of the regions."""
    laws = system.laws
    if laws.two_sided:
        return {name: laws.sides[mode, 0]}
    return {name.replace("side", "region"): np.array([*map(laws.name, range(laws.count)), ""])[mode]}


def _stacked(runs: Sequence[DrawnRun], given: Iterable[Columns]) -> Columns:
    """Return one long table of the parts of all runs, with start and integrator of its run in each row."""
    parts = list(given)
    lengths = [len(part["t"]) for part in parts]
    labels = {"start": [one.start for one in runs], "integrator": [one.run.method for one in runs]}
    columns = {name: np.repeat(np.array(label), lengths) for name, label in labels.items()}
    return columns | {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
