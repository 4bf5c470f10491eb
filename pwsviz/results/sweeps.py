"""A bifurcation diagram, computed coarse to fine: whatever part of it is done covers the whole range."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from itertools import pairwise
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import core
from core import Status
from core.diagnostics import tells_of_growth
from pwsviz.geometry.point_counts import Portion
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.section_plane import in_first_turn
from pwsviz.results.requests import SweepInputs
from pwsviz.results.resting import ROUND_OFF
from pwsviz.scene.names import short_name
from pwsviz.scene.sweeping import USUAL_DISCARD
from pwsviz.scene.validation import MAX_STEPS
from pwsviz.tasks.cancellation import Cancel, Cancelled, Report
from pwsviz.text.advice import on_page
from pwsviz.text.words import listed_or_counted

__all__ = [
    "NO_CROSSING", "NO_START", "Diagram", "coarse_to_fine", "of_one_value", "sweep_arguments", "swept",
    "swept_values", "with_discard",
]  # fmt: skip

NO_START = -1
"""Outcome of a value at which no run can begin; the others are those of `core.Status`."""

NO_CROSSING = -2
"""Outcome of a value whose run reaches the end time and meets none of the system's surfaces, where those are asked."""

COARSE = 16
"""Part of the values that come first: every sixteenth one."""

FEWEST = 16
"""Least values of a portion: fewer would not occupy a processor for long enough."""

LOOKED_INTO = 4
"""Runs of a diagram, those in which rates change most, that are examined for what makes them doubtful in any case …"""

MOST_EXAMINED = 12
"""… and most runs that are, with others all over the range: to examine one takes as long as many a run …"""

MOST_BESIDE = 16
"""… and most runs between one in doubt and a clear one that are then examined, to tell how far the doubt reaches …"""

MOST_STEPS_EXAMINED = 400_000
"""… and most steps of either of those, of each of which the first `STEPS_OF_EACH` are examined."""

STEPS_OF_EACH = 50_000
"""As many are made again to be examined: see `core.Ensemble.warning`."""

TRIED = 16
"""Values, evenly spaced, whose runs tell whether a transient can be discarded."""

PORTION = 0.5
"""Seconds that a portion should take, after which it is drawn."""

FADED, LAST = 1e-3, 10
"""Part of the largest point of a run within which so many of its last ones show that it decays."""

_NUMBER = re.compile(r"-?\d[\d.,]*(e[+-]?\d+)?")


@dataclass(frozen=True)
class Diagram:
    """A bifurcation diagram, or the part of it that is done."""

    inputs: SweepInputs
    values: Floats
    """(v,) values of the parameter, in increasing order."""
    outcomes: NDArray[np.int64]
    """(v,) how the run of each ended, a `core.Status`, `NO_START` or `NO_CROSSING`; RUNNING where it is to come."""
    counts: NDArray[np.int64]
    """(v,) points of each."""
    portions: tuple[Portion, ...] = ()
    """Value and coordinate of the points, as they came; those of one value in the order of time.

    Of an angle, full turns are left out."""
    refusal: str = ""
    """Why the first of the values at which no run can begin has none."""
    sparse: bool = False
    """Whether nothing is discarded because most runs are all transient."""
    warnings: tuple[str, ...] = ()
    """What is said of the runs in doubt, once all are done: of those that differ in numbers alone, the first."""
    examined: Floats = field(default_factory=lambda: np.empty(0))
    """Values whose runs are examined for that, in increasing order."""
    warned: Floats = field(default_factory=lambda: np.empty(0))
    """Those of them whose runs are in doubt."""
    sensitive: Floats = field(default_factory=lambda: np.empty(0))
    """Those of them of whose runs no more is said than that small errors grow, as in chaos.

    Their points are not those of the exact solution, but it may leave others in the same places."""

    @property
    def done(self) -> NDArray[np.bool_]:
        """(v,) which values are done."""
        return np.asarray(self.outcomes != Status.RUNNING)

    @property
    def whole(self) -> NDArray[np.bool_]:
        """(v,) which values have all the points that were wanted."""
        return np.asarray(self.counts == self.inputs.points)

    @property
    def spacing(self) -> float:
        """Distance of one value from the next."""
        return (self.inputs.high - self.inputs.low) / (len(self.values) - 1)

    def told(self, value: float) -> str:
        """Return one of the values with the digits that tell it from the next, 8.701 for 8.70075."""
        digits = -math.floor(math.log10(self.spacing)) if len(self.values) > 1 else 6
        return f"{round(float(value), digits):.6g}"

    @property
    def round_off(self) -> float:
        """Difference of two points that is none, beside the start and the largest point."""
        points = (np.abs(part.y).max(initial=0.0) for part in self.portions)
        return ROUND_OFF * float(max([*map(abs, self.inputs.problem.x0), *points]))

    def doubtful_beside(self, value: float) -> Floats:
        """Return those of the values examined next to one, on either side, whose runs are in doubt."""
        return self._beside(value, self.warned)

    def is_sensitive(self, value: float) -> bool:
        """Whether small errors grow in the run at a value, or in those examined next to it on both sides."""
        return value in self.sensitive or len(self._beside(value, self.sensitive)) == 2

    def _beside(self, value: float, some: Floats) -> Floats:
        after = int(np.searchsorted(self.examined, value))
        beside = self.examined[max(after - 1, 0) : after + 1]
        return beside[np.isin(beside, some)]

    def points_at(self, value: float) -> Floats:
        """Return (n,) the coordinate at the points of one of the values, in the order of time."""
        return np.concatenate([np.empty(0), *(part.y[part.x == value] for part in self.portions)])

    def sorted_points(self) -> tuple[Floats, Floats]:
        """Return (c,) values and (c,) coordinates of all points, by value and then in the order of time."""
        x, y = (np.concatenate([np.empty(0), *(part[k] for part in self.portions)]) for k in (0, 1))
        order = np.argsort(x, kind="stable")
        return x[order], y[order]


def of_one_value(inputs: SweepInputs, value: float) -> SweepInputs:
    """Return inputs whose diagram has the points of one value of the parameter alone."""
    return replace(inputs, low=value, high=value, values=1)


def swept_values(inputs: SweepInputs) -> Floats:
    """Return (v,) values of the parameter, in increasing order."""
    return np.linspace(inputs.low, inputs.high, inputs.values)


def sweep_arguments(inputs: SweepInputs) -> dict[str, Any]:
    """Return the keywords of `core.sweep`, except x0."""
    of, tolerance = inputs.of or None, inputs.scheme.tolerance
    discard = USUAL_DISCARD if inputs.discard is None else inputs.discard
    return {
        "points": inputs.points, "discard": discard, "continuation": inputs.continuation, "of": of,
        "direction": inputs.direction, "tau": inputs.tau, "method": inputs.scheme.method, "tolerance": tolerance,
        "max_steps": MAX_STEPS, "sliding": inputs.scheme.sliding,
    }  # fmt: skip


def coarse_to_fine(count: int) -> NDArray[np.intp]:
    """Return the numbers from 0 to `count` − 1 in an order in which any first part of them covers the range evenly."""
    bits = max(count - 1, 1).bit_length()
    numbers = np.arange(2**bits)
    reverse = np.zeros_like(numbers)
    for bit in range(bits):
        reverse |= ((numbers >> bit) & 1) << (bits - 1 - bit)
    return reverse[reverse < count]


def swept(inputs: SweepInputs, pool: Executor, cancel: Cancel, report: Report) -> Diagram:
    """Compute a bifurcation diagram in portions, each of which is reported with those before.

    Raises
    ------
    ValueError
        If the system has no parameter, or no run can begin at any value.
    """
    if not inputs.parameter:
        raise ValueError(f"{inputs.problem.declaration.name} has no parameter, so there is nothing to sweep.")
    automatic, inputs = inputs.discard is None, with_discard(inputs, pool, cancel)
    values = swept_values(inputs)
    nothing = np.zeros(len(values), dtype=np.int64)
    found = Diagram(inputs, values, nothing + Status.RUNNING, nothing, sparse=automatic and not inputs.discard)
    runs = _Runs(inputs, pool, cancel, report)
    for numbers in _portions(inputs, len(values)):
        found = runs.extended(found, numbers)
        if cancel():
            raise Cancelled
        report(int(found.done.sum()), len(values), found)
    if (found.outcomes == NO_START).all():
        raise ValueError(found.refusal)
    return runs.examined(found)


def with_discard(inputs: SweepInputs, pool: Executor, cancel: Cancel) -> SweepInputs:
    """Return inputs with the number of points discarded first, where that is left open.

    It is `USUAL_DISCARD`, but none if most runs that meet the surface are all transient: they come to rest or cross
    rarely. Runs all over the range tell, whatever the present value: a click in the diagram sets that.
    """
    if inputs.discard is not None or not inputs.parameter:
        return inputs
    tried = replace(inputs, values=TRIED, points=USUAL_DISCARD + 1, discard=0, continuation="none")
    values, nothing = swept_values(tried), np.zeros(TRIED, dtype=np.int64)
    runs = _Runs(tried, pool, cancel, lambda *_: None)
    found = runs.extended(Diagram(tried, values, nothing + Status.RUNNING, nothing), np.arange(TRIED))
    transient = [_is_transient(found.points_at(float(value))) for value in values[found.counts > 0]]
    return replace(inputs, discard=0 if 2 * sum(transient) >= max(len(transient), 1) else USUAL_DISCARD)


def _is_transient(points: Floats) -> bool:
    """Whether a run has no more points than are discarded, or these have faded by then."""
    sizes = np.abs(points)
    return len(points) <= USUAL_DISCARD or bool(sizes[-LAST:].max() <= FADED * sizes.max())


def _portions(inputs: SweepInputs, count: int) -> Iterator[NDArray[np.intp]]:
    """Yield the numbers of the values of each portion, of about `PORTION` seconds, as the time of the last tells."""
    order = {"none": coarse_to_fine(count), "up": np.arange(count), "down": np.arange(count)[::-1]}
    left, size = order[inputs.continuation], -(-count // COARSE)
    while len(left):
        started = monotonic()
        yield left[:size]
        left = left[size:]
        least = FEWEST if inputs.continuation == "none" else 1
        size = max(round(size * min(2.0, PORTION / (monotonic() - started))), least)


class _Run(NamedTuple):
    """A run of a diagram."""

    value: float
    """Value of the parameter."""
    ensemble: core.Ensemble
    member: int

    @property
    def steps(self) -> int:
        """Number of its steps that are made again if it is examined."""
        return min(int(self.ensemble.steps[self.member]), STEPS_OF_EACH)

    @property
    def change(self) -> float:
        """Largest change of a rate from step to step, relative to the largest rate."""
        return float(np.nan_to_num(self.ensemble.unlike[self.member]))


class _Runs:
    """The runs of one diagram."""

    def __init__(self, inputs: SweepInputs, pool: Executor, cancel: Cancel, report: Report) -> None:
        self.inputs = inputs
        self._pool, self._cancel, self._report = pool, cancel, report
        self._system, self._arguments = inputs.problem.build(), sweep_arguments(inputs)
        self._parameter = next(q for q in self._system.parameters if q.name == inputs.parameter)
        self._after: core.Sweep | None = None  # of a continuation
        self._done: list[_Run] = []
        self._sweep(np.empty(0), lambda _part: None)  # refuses what makes no sense at any value

    def extended(self, found: Diagram, numbers: NDArray[np.intp]) -> Diagram:
        """Return a diagram with the points of further values, given by their numbers."""

        def tell(part: float) -> None:
            self._report(int(found.done.sum() + part * len(numbers)), len(found.values), found)

        try:
            return self._with(found, numbers, self._sweep(found.values[numbers], tell))
        except ValueError as reason:  # at one of the values no run can begin
            if len(numbers) == 1 and self._after is None:
                return _refused(found, int(numbers[0]), str(reason))
        if len(numbers) == 1:  # a continuation begins anew
            self._after = None
            return self.extended(found, numbers)
        for k in range(len(numbers)):
            found = self.extended(found, numbers[k : k + 1])
        return found

    def examined(self, found: Diagram) -> Diagram:
        """Return a diagram with what is said against the steps of some of its runs, the first of those with points."""
        shown = set(found.values[found.counts > 0].tolist())
        told: dict[float, str] = {}
        runs = sorted(self._to_examine(), key=lambda run: run.value not in shown)
        longest = max((run.steps for run in self._done), default=0)
        most = len(runs) + min(MOST_BESIDE, MOST_STEPS_EXAMINED // max(longest, 1))
        while runs:
            said = self._pool.map(lambda run: "" if self._cancel() else run.ensemble.warning(run.member), runs)
            told |= dict(zip((run.value for run in runs), said, strict=True))
            if self._cancel():
                raise Cancelled
            runs = self._beside_doubt(told)[: most - len(told)]
        sensitive = [value for value, words in told.items() if tells_of_growth(words)]
        warned = [value for value, words in told.items() if words and value not in sensitive]
        found = replace(found, examined=np.unique([*told]), warned=np.unique(warned), sensitive=np.unique(sensitive))
        kinds: dict[str, dict[float, str]] = {}  # by the words without their numbers
        for value in warned:
            words = told[value]
            kinds.setdefault(_NUMBER.sub("", words), {})[value] = on_page(words, self._system.variables)
        return replace(found, warnings=tuple(map(self._said, kinds.values())))

    def _said(self, words: dict[float, str]) -> str:
        """What is said against the run of the first of some values, and at which others, in other numbers."""
        first, *others = words
        values = [f"{value:.6g}" for value in sorted(others)]
        likewise = f" Likewise at {listed_or_counted(values, '{} other values')}." if values else ""
        return f"{short_name(self._parameter)} = {first:.6g}: {words[first]}{likewise}"

    def _to_examine(self) -> list[_Run]:
        """The runs in which rates change most from step to step, and others all over the range if they are short."""
        runs = {run.value: run for run in sorted(self._done, key=lambda run: -run.change)[:LOOKED_INTO]}
        others, left = sorted(self._done, key=lambda run: run.value), MOST_STEPS_EXAMINED
        for k in coarse_to_fine(len(others)).tolist():
            left -= others[k].steps
            if left < 0 or len(runs) == MOST_EXAMINED:
                break
            runs[others[k].value] = others[k]
        return list(runs.values())

    def _beside_doubt(self, told: dict[float, str]) -> list[_Run]:
        """The runs halfway between neighbours of those examined, of which something is said against one only."""
        runs = sorted(self._done, key=lambda run: run.value)
        known = [k for k, run in enumerate(runs) if run.value in told]
        differ = ((a, b) for a, b in pairwise(known) if bool(told[runs[a].value]) != bool(told[runs[b].value]))
        return [runs[(a + b) // 2] for a, b in differ if b > a + 1]

    def _keep(self, part: core.Sweep) -> None:
        """Keep the runs of further values."""
        values = iter(part.values.tolist())
        self._done += [_Run(next(values), one, member) for one in part.ensembles for member in range(len(one))]

    def _sweep(self, values: Floats, tell: Callable[[float], None]) -> core.Sweep:
        inputs = self.inputs
        done = core.sweep(
            self._system, (0.0, inputs.t_end), inputs.parameter, values, inputs.coordinate, inputs.problem.x0,
            after=self._after, executor=self._pool, cancel=self._cancel, progress=tell, **self._arguments,
        )  # fmt: skip
        if inputs.continuation != "none":
            self._after = done
        return done

    def _with(self, found: Diagram, numbers: NDArray[np.intp], part: core.Sweep) -> Diagram:
        outcomes, counts = found.outcomes.copy(), found.counts.copy()
        outcomes[numbers] = part.statuses
        if not self.inputs.of:
            crossings = np.concatenate([one.crossing_count for one in part.ensembles])
            outcomes[numbers[(outcomes[numbers] == Status.COMPLETED) & (crossings == 0)]] = NO_CROSSING
        self._keep(part)
        points = in_first_turn(self._system, self.inputs.column, part.points)
        at, each = np.unique(part.value, return_counts=True)
        counts[np.searchsorted(found.values, at)] = each
        portions = (*found.portions, Portion(part.value, points, 0))
        return replace(found, outcomes=outcomes, counts=counts, portions=portions)


def _refused(found: Diagram, number: int, reason: str) -> Diagram:
    outcomes = found.outcomes.copy()
    outcomes[number] = NO_START
    return replace(found, outcomes=outcomes, refusal=found.refusal or reason.removeprefix("member 0: "))
