"""From a scene to arrays: only what the visible view needs, each computed once, and cancelled when outdated."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from threading import BoundedSemaphore

import core
from core.studies import STARTS_OF_MAP
from pwsviz.geometry.first_view import first_plane
from pwsviz.geometry.phase_plane import Backdrop, backdrop
from pwsviz.geometry.plane import XY, Axes, Plane, units_of
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import planes_alike
from pwsviz.geometry.window import Window
from pwsviz.results.animation import Frames, Landmarks, frames, landmarks
from pwsviz.results.cache import Cache, Value
from pwsviz.results.error_curve import ErrorCurve, error_curve
from pwsviz.results.orbits import Levels, Orbit, drawn_within, orbit_of, places_near
from pwsviz.results.parting import Parting, parting
from pwsviz.results.requests import (
    CostInputs,
    InitialValueProblem,
    RunInputs,
    SectionInputs,
    StabilityInputs,
    StudyInputs,
    SweepInputs,
    other_inputs,
    run_inputs,
    usual_inputs,
)
from pwsviz.results.run_summary import Summary, summary_of, warning_of
from pwsviz.results.sections import SectionPoints, studied_section
from pwsviz.results.states import StateCurves, state_curves
from pwsviz.results.studies import Compared, compared_crossings, studied_cost, studied_order, studied_stability
from pwsviz.results.sweeps import Diagram, swept
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import MAX_STEPS
from pwsviz.tasks.cancellation import Cancel, Cancelled, Report, never, silent

STUDIES_AT_ONCE = max(1, (os.cpu_count() or 1) - 1)
"""Long computations at the same time, over all sessions; one processor stays free for short ones, such as sliders."""

SHORT = 0.02
"""Seconds below which a first run is made again to be timed; of a longer one the first call is a small part."""

MOST_CALLED = 1000
"""Pairs of a system and a method of which it is known that they have been called."""

LONG = 200_000
"""Steps of a run from which the runs of one picture are computed in parallel; shorter ones lose more than they gain."""

ALL_FRAMES = 12_000
"""States that the player is sent, of all runs together."""

FEWEST_FRAMES = 300
"""Least of them of one run."""

MOST_FRAMES = 2000
"""Most of them of one run."""


@dataclass(frozen=True)
class PortraitInputs:
    """Exactly what the curves of one portrait depend on."""

    selected: tuple[RunInputs, ...]
    """One for each integrator."""
    others: tuple[RunInputs, ...] = ()
    """Those of the other starts, start by start."""
    axes: Axes | None = (0, 1)
    """The plane; None for the first plane of the system."""
    index: int = 0
    """Index of the selected start among all."""

    @classmethod
    def of(cls, scene: Scene) -> PortraitInputs:
        """Read it from a scene."""
        index = min(scene.selected, len(scene.starts) - 1)
        return cls(run_inputs(scene), other_inputs(scene), scene.axes, index)

    @property
    def declaration(self) -> core.PiecewiseSystem:
        """The system, at its declared parameter values."""
        return self.selected[0].problem.declaration

    @property
    def start_count(self) -> int:
        """Number of starts."""
        return 1 + len(self.others) // len(self.selected)


@dataclass(frozen=True)
class Pictures:
    """The curves of one portrait, and the figures of the selected runs."""

    inputs: PortraitInputs
    plane: Plane
    """In which they lie."""
    orbits: list[Orbit]
    others: list[Orbit]
    summaries: list[Summary]
    parting: Parting | None = None
    """From when on the selected runs cannot all follow the solution; None if they may."""
    alongside: Mapping[Plane, Sequence[Orbit]] = field(default_factory=dict)
    """In `planes_alike`, the orbits of the same runs: those of the selected start first, as `orbits` and `others`."""

    @property
    def system(self) -> core.PiecewiseSystem:
        """The system, at the values of its parameters."""
        return self.inputs.selected[0].problem.build()

    @property
    def thin(self) -> list[Orbit]:
        """The orbits that are drawn thin: from other starts, and alongside."""
        return [*self.others, *(orbit for orbits in self.alongside.values() for orbit in orbits)]

    @property
    def numbered(self) -> list[tuple[int, Orbit]]:
        """Every orbit with the number of its start, from 1; those of the selected start come first."""
        index, each = self.inputs.index, len(self.orbits)
        rest = [k for k in range(self.inputs.start_count) if k != index]
        numbers = [1 + k for k in (index, *rest) for _ in range(each)]
        return list(zip(numbers, (*self.orbits, *self.others), strict=True))


class Results:
    """Computes results on demand and caches them; shared by all sessions of a process.

    Attributes
    ----------
    computed : Counter
        How often each kind of result was computed, not found in the cache: ``"run"``, ``"orbit"``, ``"frames"``,
        ``"landmarks"``, ``"states"``, ``"error"``, ``"curve"``, ``"summary"``, ``"backdrop"``, ``"diagnosis"``,
        ``"warning"``, ``"study"``, ``"cost"``, ``"stability"``, ``"limits"``, ``"section"``, ``"sweep"``,
        ``"swept value"``, ``"compared"``, ``"plane"``.
    """

    def __init__(self, max_bytes: int = 256_000_000) -> None:
        self._cache = Cache(max_bytes)
        self.computed = self._cache.computed
        self._called: set[tuple[core.PiecewiseSystem, str]] = set()
        self._turns = BoundedSemaphore(STUDIES_AT_ONCE)
        self._pool = ThreadPoolExecutor(STUDIES_AT_ONCE, thread_name_prefix="pwsviz-study")
        self._runs = ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="pwsviz-run")

    def pictures(self, inputs: PortraitInputs, cancel: Cancel = never) -> Pictures:
        """Return the curves of the portrait and the figures of its selected runs."""
        plane = self.plane(inputs.declaration, inputs.axes, cancel)
        self._begin(inputs.selected, cancel)
        first = self.orbit(inputs.selected[0], None, plane, cancel)
        near = drawn_within(first)
        runs = (*inputs.selected, *inputs.others)
        return Pictures(
            inputs=inputs,
            plane=plane,
            orbits=[first, *(self.orbit(one, near, plane, cancel) for one in inputs.selected[1:])],
            others=[self.orbit(one, near, plane, cancel) for one in inputs.others],
            summaries=[self.summary(one, cancel) for one in inputs.selected],
            parting=parting({one.scheme.method: self.run(one, cancel) for one in inputs.selected}),
            alongside={
                alike: [self.orbit(one, near, alike, cancel) for one in runs]
                for alike in _alike(inputs.declaration, plane)
            },
        )

    def plane(self, system: core.PiecewiseSystem, chosen: Axes | None, cancel: Cancel = never) -> Plane:
        """Return the plane of two chosen variables; without such, that in which the system is looked at first.

        The units of both follow from the system as it is declared: neither parameters nor starts change them.
        """
        usual = usual_inputs(system)
        return self._get("plane", (usual, chosen), cancel, lambda: self._plane(usual, chosen, cancel))

    def _plane(self, usual: RunInputs, chosen: Axes | None, cancel: Cancel) -> Plane:
        run = self.run(usual, cancel)
        axes = chosen or first_plane(run.system, run.x)
        return Plane(axes, units_of(places_near(run, axes)))

    def error_curves(self, inputs: tuple[RunInputs, ...], cancel: Cancel = never) -> list[ErrorCurve]:
        """Return the curves of the plot of the conserved quantity."""
        self._begin(inputs, cancel)
        return [self.error_curve(one, cancel) for one in inputs]

    def _begin(self, inputs: tuple[RunInputs, ...], cancel: Cancel) -> None:
        """Start computing long runs and their errors in parallel: the compiled loops release the interpreter lock.

        This does not wait. Whoever requests one of these results later waits for it, and receives its exception.
        """
        long = [one for one in inputs if one.tau * LONG < one.t_end]
        if len(long) > 1:
            for one in long:
                self._runs.submit(self.error, one, cancel)

    def _get(self, kind: str, inputs: Hashable, cancel: Cancel, compute: Callable[[], Value]) -> Value:
        """Return a cached result, or compute it unless cancelled."""

        def stage() -> Value:
            if cancel():
                raise Cancelled
            return compute()

        return self._cache.get(kind, inputs, stage)

    def run(self, inputs: RunInputs, cancel: Cancel = never) -> core.Trajectory:
        """Return a run."""
        return self._get("run", inputs, cancel, lambda: self._timed_run(inputs, cancel))

    def has_run(self, inputs: RunInputs) -> bool:
        """Return whether a run is kept; nothing is computed."""
        return self._cache.found("run", inputs) is not None

    def _timed_run(self, inputs: RunInputs, cancel: Cancel) -> core.Trajectory:
        """Return a run; the first short one of a system and a method is made twice, as the first call is slow.

        It brings code and tables into memory, which takes several times as long as the run whose time is told.
        """
        run, called = _run(inputs, cancel), (inputs.problem.declaration, inputs.scheme.method)
        if called not in self._called and run.seconds < SHORT:
            run = _run(inputs, cancel)
        if len(self._called) >= MOST_CALLED:
            self._called.clear()
        self._called.add(called)
        return run

    def orbit(self, inputs: RunInputs, near: Window | None = None, plane: Plane = XY, cancel: Cancel = never) -> Orbit:
        """Return the trajectory for the portrait, as far as it stays within `near`.

        Without such a window the whole trajectory, but of one that may have run off only the part near its beginning.
        """
        return self._get(
            "orbit", (inputs, near, plane), cancel, lambda: orbit_of(inputs, self.run(inputs, cancel), near, plane)
        )

    def frames(self, inputs: tuple[RunInputs, ...], plane: Plane, cancel: Cancel = never) -> list[Frames]:
        """Return the states that the player shows of each run in the plane, then in those alike; of many fewer each."""
        first = self.orbit(inputs[0], None, plane, cancel)
        near = drawn_within(first)
        drawn = [plane, *_alike(inputs[0].problem.declaration, plane)]
        shown = [(one, each) for each in drawn for one in inputs]
        limit = min(MOST_FRAMES, max(FEWEST_FRAMES, ALL_FRAMES // len(shown)))
        windows = [near if first.runs_off else None, *(near for _ in shown[1:])]
        return [
            self._get(
                "frames", (one, each, limit, window), cancel, partial(self._frames, one, each, limit, window, cancel)
            )
            for (one, each), window in zip(shown, windows, strict=True)
        ]

    def _frames(self, inputs: RunInputs, plane: Plane, limit: int, near: Window | None, cancel: Cancel) -> Frames:
        return frames(self.run(inputs, cancel), plane, limit, near)

    def states(self, inputs: RunInputs, cancel: Cancel = never) -> StateCurves:
        """Return each coordinate of a run against time."""
        return self._get("states", inputs, cancel, lambda: state_curves(self.run(inputs, cancel)))

    def landmarks(self, inputs: RunInputs, plane: Plane, cancel: Cancel = never) -> Landmarks:
        """Return what the plot of the conserved quantity marks of a run."""
        return self._get("landmarks", (inputs, plane), cancel, lambda: landmarks(self.run(inputs, cancel), plane))

    def error(self, inputs: RunInputs, cancel: Cancel = never) -> Floats:
        """Return (n, m) the error of each ψ at each state of a run, accumulated since the start."""
        return self._get("error", inputs, cancel, lambda: self.run(inputs, cancel).accumulated_error())

    def error_curve(self, inputs: RunInputs, cancel: Cancel = never) -> ErrorCurve:
        """Return the error for the plot against time."""
        return self._get(
            "curve", inputs, cancel, lambda: error_curve(inputs, self.run(inputs, cancel), self.error(inputs, cancel))
        )

    def summary(self, inputs: RunInputs, cancel: Cancel = never) -> Summary:
        """Return the figures of a run."""
        return self._get(
            "summary", inputs, cancel, lambda: summary_of(inputs, self.run(inputs, cancel), self.error(inputs, cancel))
        )

    def warnings(self, inputs: tuple[RunInputs, ...], cancel: Cancel = never) -> tuple[str, ...]:
        """Return what is said against the step size of each run that reaches the end time; empty where nothing is.

        The message of a run that stops early has it already. It takes milliseconds, more than many a run.
        """
        return tuple(self._get("warning", one, cancel, partial(self._warning, one, cancel)) for one in inputs)

    def _warning(self, inputs: RunInputs, cancel: Cancel) -> str:
        return warning_of(self.run(inputs, cancel), inputs.scheme.locate)

    def backdrop(self, problem: InitialValueProblem, window: Window, levels: Levels, plane: Plane = XY) -> Backdrop:
        """Return the backdrop of the portrait on a window, with these level sets besides the usual ones."""
        key = _still(problem), window, levels, plane
        return self._cache.get("backdrop", key, lambda: backdrop(problem.build(), window, dict(levels), plane))

    def found_backdrop(
        self, problem: InitialValueProblem, window: Window, levels: Levels, plane: Plane = XY
    ) -> Backdrop | None:
        """Return the same if it is in the cache, else None."""
        found: Backdrop | None = self._cache.found("backdrop", (_still(problem), window, levels, plane))
        return found

    def diagnosis(self, inputs: RunInputs, cancel: Cancel = never) -> core.Diagnosis:
        """Return the constants of the theory along a run."""
        return self._get("diagnosis", inputs, cancel, lambda: core.diagnose(self.run(inputs, cancel)))

    def study(self, inputs: StudyInputs, cancel: Cancel = never, report: Report = silent) -> core.OrderStudy:
        """Return an order study."""
        compared = self.compared(inputs, cancel)
        key = (replace(inputs, t_end=0.0), compared)  # an end time that has no effect is no part of it
        return self._in_turn("study", key, cancel, partial(studied_order, inputs, compared, cancel, report))

    def compared(self, inputs: StudyInputs, cancel: Cancel = never) -> Compared:
        """Return which crossings an order study compares, and when it ends."""
        return self._cache.get("compared", inputs, lambda: compared_crossings(inputs, cancel))

    def studies(
        self, inputs: tuple[StudyInputs, ...], cancel: Cancel = never, report: Report = silent
    ) -> tuple[core.OrderStudy, ...]:
        """Return the order study of each integrator; those that cannot be studied are left out.

        `report` is told of the step sizes of all, with the studies so far.

        Raises
        ------
        ValueError
            If none can be studied: why the first cannot.
        """
        found: list[core.OrderStudy] = []
        reasons: list[ValueError] = []
        for k, one in enumerate(inputs):

            def tell(done: int, total: int, partial: core.OrderStudy, k: int = k) -> None:
                report(k * total + done, len(inputs) * total, (*found, partial))

            try:
                found.append(self.study(one, cancel, tell))
            except ValueError as why:
                reasons.append(why)
        if not found:
            raise reasons[0]
        return tuple(found)

    def cost(self, inputs: CostInputs, cancel: Cancel = never, report: Report = silent) -> core.WorkPrecision:
        """Return a study of run time against error."""
        return self._in_turn("cost", inputs, cancel, lambda: studied_cost(inputs, self._pool, cancel, report))

    def stability(
        self, inputs: StabilityInputs, cancel: Cancel = never, report: Report = silent
    ) -> core.StabilityStudy:
        """Return a part of a stability study; beside the map, the largest step sizes from the start."""
        if inputs.part != "map":
            return self._stability(inputs, cancel, report)
        count = len(inputs.methods)
        total = count * (1 + STARTS_OF_MAP)
        limits = self._stability(inputs.of_limits(), cancel, lambda done, _, partial: report(done, total, partial))

        def tell(done: int, _: int, partial: core.StabilityStudy) -> None:
            report(count + done, total, replace(limits, map=partial.map, complete=False))

        return replace(limits, map=self._stability(inputs.of_map(), cancel, tell).map)

    def _stability(self, inputs: StabilityInputs, cancel: Cancel, report: Report) -> core.StabilityStudy:
        kind = "limits" if inputs.part == "largest_tau" else "stability"
        return self._in_turn(kind, inputs, cancel, lambda: studied_stability(inputs, self._pool, cancel, report))

    def sweep(self, inputs: SweepInputs, cancel: Cancel = never, report: Report = silent) -> Diagram:
        """Return a bifurcation diagram, or the points of one value of its parameter."""
        kind = "sweep" if inputs.values > 1 else "swept value"
        return self._in_turn(kind, inputs, cancel, lambda: swept(inputs, self._pool, cancel, report))

    def section(self, inputs: SectionInputs, cancel: Cancel = never, report: Report = silent) -> SectionPoints:
        """Return the points of a Poincaré section."""
        return self._in_turn("section", inputs, cancel, lambda: studied_section(inputs, self._pool, cancel, report))

    def _in_turn(self, kind: str, inputs: Hashable, cancel: Cancel, compute: Callable[[], Value]) -> Value:
        """Run a long computation, at most `STUDIES_AT_ONCE` at the same time."""

        def study() -> Value:
            while not self._turns.acquire(timeout=0.05):
                if cancel():
                    raise Cancelled
            try:
                value = compute()
            finally:
                self._turns.release()
            if cancel():  # the result is incomplete
                raise Cancelled
            return value

        return self._cache.get(kind, inputs, study)


def _still(problem: InitialValueProblem) -> InitialValueProblem:
    """Return a problem without its start, on which no backdrop depends."""
    return replace(problem, x0=())


def _alike(system: core.PiecewiseSystem, plane: Plane) -> list[Plane]:
    """Return `planes_alike`, in the same units."""
    return [Plane(axes, plane.units) for axes in planes_alike(system, plane.axes)]


def _run(inputs: RunInputs, cancel: Cancel) -> core.Trajectory:
    run = core.integrate(
        inputs.problem.build(),
        (0.0, inputs.t_end),
        x0=inputs.problem.x0,
        tau=inputs.tau,
        cancel=cancel,
        max_steps=MAX_STEPS,
        tolerance=inputs.scheme.tolerance,
        **inputs.scheme.arguments(),
    )
    if cancel():
        raise Cancelled
    return run
