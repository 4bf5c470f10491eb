"""Run time against error: the cost of accuracy with the methods of this package and with external solvers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.integrate import checked_method, checked_settings, checked_start
from core.integration.tally import Tally, crossed
from core.interface.arguments import count, listed, number
from core.interface.cancelling import Cancel, Cancelled
from core.interface.summary import Brief
from core.interface.tasks import GivenUp, as_completed, check_hooks
from core.kernels.arrays import Floats
from core.methods import METHODS, Method
from core.reference import reference_solution
from core.studies.external_solvers import EXTERNAL_SOLVERS
from core.studies.measure import Measured, Problem, measure
from core.studies.target import Target, target_of
from core.system import PiecewiseSystem, Start
from core.systems import System, system_of

__all__ = ["CANCELLED", "DONE", "WAITING", "CostCurve", "WorkPrecision", "work_precision"]

#: Methods that are measured where none are given, if the system admits them.
_METHODS = ("dmm2", "dmm4", "rk4", "prk8", "taylor")
#: Tolerances of a variable-step method where none are given.
_TOLERANCES = tuple(10.0**-k for k in (3, 5, 7, 9, 11, 13, 15))
#: Coarsest default step size, as part of the mean time between crossings.
_COARSEST = 0.25
#: Digits of error expected from one default step size to the next.
_DIGITS = 1.5
#: Digits of error expected from the coarsest default step size to the finest.
_ALL_DIGITS = 12.0
#: Steps per second of the budget: a bound on the number of steps at the finest default step size.
_STEPS_A_SECOND = 5e5
#: End of a message about settings that are not a sequence of numbers.
_NUMBERS = "a tuple is needed, as in (0.1, 0.05)"
#: Most settings of one integrator.
_MAX_SETTINGS = 64
#: Most timed runs at one setting.
_MAX_REPEATS = 1000

#: `CostCurve.status` of a setting that is still to be measured.
WAITING = "not measured yet"
#: `CostCurve.status` of a setting that is not measured because the study was cancelled.
CANCELLED = "cancelled"
#: `CostCurve.status` of a setting that has been measured.
DONE = "completed"


@dataclass(frozen=True, eq=False, repr=False)
class CostCurve(Brief):
    """One integrator at m settings; nan where there is no result, and `status` says why."""

    name: str
    """A key of METHODS, or of core.studies.external_solvers.EXTERNAL_SOLVERS."""
    title: str
    """Name for display."""
    peer: bool
    """Whether it is an external solver."""
    setting_name: str
    """"tau" or "tolerance"."""
    setting: Floats
    """(m,) step sizes or tolerances."""
    seconds: Floats
    """(m,) processor time of the thread (s), of the fastest repeat after a first run that is not timed."""
    evaluations: Floats
    """(m,) evaluations of the (discrete) field; nan for heyoka, which does not count them."""
    state_error: Floats
    """(m,) ‖x − x*‖ at the end."""
    time_error: Floats
    """(m,) |t̂ − t*| of the last crossing; nan where there is none, or where their sequence is wrong."""
    invariant_error: Floats
    """(m,) largest |Δψ| since the start off the surface, after any step, see `Trajectory.change_of_psi`; nan where no ψ
    is known."""
    crossings: Floats
    """(m,) number of crossings and jumps found."""
    status: tuple[str, ...]
    """(m,) `DONE`, `WAITING`, `CANCELLED`, or what is wrong."""
    compile_seconds: float
    """Processor time (s) to compile, or to load from disk, not included in `seconds`; nan if not measured."""
    correct_sequence: NDArray[np.bool_]
    """(m,) whether the run has the crossings of the solution, in order; see `CrossingSequence.difference`."""


@dataclass(frozen=True, eq=False)
class WorkPrecision:
    """Run time and errors of several integrators on the same initial value problem."""

    t_span: tuple[float, float]
    curves: tuple[CostCurve, ...]
    met: Tally
    """How often the solution meets a surface."""
    reference: str
    """Name of the reference solution."""
    floor: Mapping[str, float]
    """Errors that are round-off of run and reference, of "state", "time" and "invariant"."""
    repeats: int
    """Most timed runs at one setting, of which the fastest counts."""

    @property
    def crossings(self) -> int:
        """Number of crossings and jumps of the solution."""
        return int(crossed(np.array(self.met)))

    def __repr__(self) -> str:
        names = ", ".join(curve.name for curve in self.curves)
        done = "complete" if self.complete else "not complete"
        span = f"t = {self.t_span[0]:g} … {self.t_span[1]:g}"
        return f"<WorkPrecision of {names} over {span}: {self.met}, against {self.reference}; {done}>"

    @property
    def complete(self) -> bool:
        """Whether everything has been measured."""
        return not any({WAITING, CANCELLED} & set(curve.status) for curve in self.curves)


def work_precision(
    system: System,
    t_span: tuple[float, float] | None = None,
    x0: Start | None = None,
    methods: Sequence[str | Method] | str | Method | None = None,
    settings: Mapping[str, Sequence[float]] | None = None,
    peers: Sequence[str] | str = ("scipy",),
    repeats: int = 3,
    budget: float = 2.0,
    executor: Executor | None = None,
    progress: Callable[[int, int, WorkPrecision], object] | None = None,
    cancel: Cancel | None = None,
    transition: str = "mannshardt",
    sliding: str = "stop",
) -> WorkPrecision:
    """Measure run time and error of several integrators, each at several step sizes or tolerances.

    Times are processor time of the running thread, which excludes other load of the machine but not its effect on
    caches and memory. In one process only one run goes on at a time, since threads spend processor time on waiting for
    the interpreter; several processes, as of a cluster, measure in parallel. Times are those of the whole call:
    ``integrate(..., record="end")`` for the methods of this package, the loop from crossing to crossing for an external
    solver. The first run is not timed, the garbage collector is off, the least of the repeats counts, and compilation
    is listed separately.

    Parameters
    ----------
    system
        A system, or a key of CATALOGUE.
    t_span
        Start and end time; where not given, from 0 to halfway between the tenth crossing and the next.
    x0
        d numbers, or a mapping from the names of the variables; the system's own x0 where not given.
    methods
        Keys of METHODS, or its values. Where not given, those of dmm2, dmm4, rk4, prk8 and taylor that the system
        admits.
    settings
        Name of a method or an external solver -> step sizes, or tolerances. Names that are missing get defaults that
        suit the system.
    peers
        Keys of core.studies.external_solvers.EXTERNAL_SOLVERS: "scipy", and "heyoka", which need not be installed.
    repeats
        Most timed runs at one setting.
    budget
        Seconds that one run may take; a longer one is given up, and its results are nan.
    executor
        Where to measure (see `core.interface.tasks.as_completed`); None: on threads of its own.
    progress
        Called as ``progress(done, total, partial)`` after every setting of every integrator.
    cancel
        Called twenty times a second; once it returns True, what has been measured is returned.
    transition
        As in `integrate`, for the methods of this package; an external solver always stops on the surface.
    sliding
        As in `integrate`, for all: to slide, an external solver is restarted with Filippov's field.

    Raises
    ------
    ValueError
        On arguments that make no sense, and where the solution ends before `t_span` does.
    """
    check_hooks(cancel, progress, executor)
    system = system_of(system)
    names = _checked_names(system, methods, peers)
    span = _checked_span(t_span)
    start = checked_start(system, span[0], x0)
    repeats, budget = count(repeats, "repeats", _MAX_REPEATS), _checked_budget(budget)
    given = _checked_ladders(names, settings if settings is not None else {})
    checked_settings(METHODS[_METHODS[0]], None, transition=transition, sliding=sliding)
    try:
        reference = reference_solution(system, start, span[0], cancel=cancel, sliding=sliding)
        target = target_of(system, reference, start, span)
    except Cancelled:
        target = Target.unknown(system, start, span)
    ladders = {name: given.get(name) or _ladder(name, target, budget) for name in names}
    study, given_up = _Study(target, ladders, repeats), GivenUp()
    most = 2 * len(target.crossings) + 10
    problem = Problem(system, span[0], target.end, start, most, repeats, budget, transition, sliding, given_up)
    tasks = [(problem, name, setting) for _, name, setting in study.places]
    for done, (place, measured) in enumerate(as_completed(measure, tasks, executor, cancel, given_up), 1):
        study.put(place, measured)
        if progress is not None:
            progress(done, len(tasks), study.result())
    return study.result(CANCELLED)


class _Study:
    """The curves of a study, filled point by point."""

    def __init__(self, target: Target, ladders: Mapping[str, Sequence[float]], repeats: int) -> None:
        self._target, self._repeats = target, repeats
        self._curves = [_empty(name, ladder) for name, ladder in ladders.items()]
        rounds = range(max(map(len, ladders.values())))
        #: Column of a curve, its name and the setting; the cheapest settings of all integrators come first.
        self.places = [
            (k, curve.name, float(curve.setting[k])) for k in rounds for curve in self._curves if k < len(curve.setting)
        ]
        self._by_name = {curve.name: number for number, curve in enumerate(self._curves)}

    def put(self, number: int, measured: Measured) -> None:
        """Enter the result of task `number`."""
        k, name, _ = self.places[number]
        place = self._by_name[name]
        self._curves[place] = _with_point(self._curves[place], k, measured, self._target)

    def result(self, waiting: str = WAITING) -> WorkPrecision:
        """The study so far; settings without a result get the status `waiting`."""
        curves = [
            replace(curve, status=tuple(waiting if s == WAITING else s for s in curve.status)) for curve in self._curves
        ]
        target = self._target
        span = (target.t0, target.end)
        met = target.crossings.tally
        return WorkPrecision(span, tuple(curves), met, target.reference, target.floor, self._repeats)


def _empty(name: str, ladder: Sequence[float]) -> CostCurve:
    external = EXTERNAL_SOLVERS.get(name)
    setting_name = "tolerance" if external is not None or METHODS[name].adaptive else "tau"
    nothing = np.full(len(ladder), np.nan)
    title = name if external is None else external.title
    status = (WAITING,) * len(ladder)
    return CostCurve(
        name, title, external is not None, setting_name, np.array(ladder), nothing, nothing, nothing, nothing, nothing,
        nothing, status, math.nan, np.zeros(len(ladder), dtype=bool),
    )  # fmt: skip


def _with_point(curve: CostCurve, k: int, measured: Measured, target: Target) -> CostCurve:
    """A copy of the curve with column k filled, as earlier ones are already in use."""
    status = measured.reason or DONE
    values: dict[str, float] = {}
    found = measured.crossings
    if measured.x is not None and found is not None:
        difference = found.difference(target.crossings)
        status = difference or status
        values = {
            "seconds": measured.seconds,
            "evaluations": measured.evaluations,
            "state_error": float(np.linalg.norm(measured.x - target.x)),
            "time_error": math.nan if difference or not len(found) else abs(found.t[-1] - target.crossings.t[-1]),
            "invariant_error": measured.change_of_psi,
            "crossings": int(crossed(np.array(found.tally))),
            "correct_sequence": not difference,
        }
    columns: dict[str, Any] = {name: np.array(getattr(curve, name)) for name in values}
    for name, value in values.items():
        columns[name][k] = value
    compiling = float(np.fmax(curve.compile_seconds, measured.compiling))
    return replace(
        curve, status=(*curve.status[:k], status, *curve.status[k + 1 :]), compile_seconds=compiling, **columns
    )


def _checked_names(
    system: PiecewiseSystem, methods: Sequence[str | Method] | str | Method | None, peers: Sequence[str] | str
) -> list[str]:
    if methods is None:
        known = bool(system.psi_minus or system.psi_plus)
        methods = [name for name in _METHODS if known or not METHODS[name].needs_conserved]
    given = listed(methods, "methods", "a tuple is needed, as in ('dmm2', 'rk4')", (str, Method))
    names = [checked_method(system, name).name for name in given]
    others = listed(peers, "peers", "a tuple is needed, as in ('scipy', 'heyoka')", str)
    for name in others:
        if not isinstance(name, str) or name not in EXTERNAL_SOLVERS:
            raise ValueError(f"external solver {name!r} is not known: choose from {', '.join(EXTERNAL_SOLVERS)}")
    names += others
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{twice[0]!r} stands twice among the methods and external solvers (peers): name each once")
    if not names:
        raise ValueError("methods and peers are both empty: name at least one integrator")
    return names


def _checked_span(t_span: tuple[float, float] | None) -> tuple[float, float | None]:
    if t_span is None:
        return 0.0, None
    try:
        t0, end = t_span
    except (TypeError, ValueError):
        raise ValueError(f"t_span = {t_span!r}: a start and an end time are needed, as in (0.0, 60.0)") from None
    wanted = f"t_span = {t_span!r}: the end must be after the start, and both finite"
    span = number(t0, f"{wanted}; start"), number(end, f"{wanted}; end")
    if not span[0] < span[1]:
        raise ValueError(wanted)
    return span


def _checked_budget(budget: float) -> float:
    seconds = number(budget, "budget")
    if not seconds > 0:
        raise ValueError(f"budget = {budget!r}: a positive number of seconds is needed")
    return seconds


def _checked_ladders(names: Sequence[str], settings: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    if not isinstance(settings, Mapping):
        raise ValueError(f"settings = {settings!r}: a mapping is needed, as in {{'rk4': (0.1, 0.05)}}")
    if unknown := [name for name in settings if name not in names]:
        raise ValueError(f"settings of {unknown[0]!r}, which is not among {', '.join(names)}")
    ladders = {}
    for name, values in settings.items():
        ladder = [number(v, f"setting of {name!r}") for v in listed(values, f"settings of {name!r}", _NUMBERS)]
        if not 1 <= len(ladder) <= _MAX_SETTINGS:
            raise ValueError(f"settings of {name!r} are {len(ladder)} numbers: 1 to {_MAX_SETTINGS} are possible")
        for value in ladder:
            _check_setting(name, value)
        ladders[name] = ladder
    return ladders


def _check_setting(name: str, value: float) -> None:
    if name in METHODS:
        adaptive = METHODS[name].adaptive
        checked_settings(METHODS[name], None if adaptive else value, value if adaptive else None)
    elif not EXTERNAL_SOLVERS[name].finest <= value <= 0.1:
        raise ValueError(f"tolerance = {value!r} of {name!r} is outside {EXTERNAL_SOLVERS[name].finest:.2g} … 0.1")


def _ladder(name: str, target: Target, budget: float) -> list[float]:
    """Default settings from coarse to fine, chosen so that the errors range over many powers of ten."""
    if name in EXTERNAL_SOLVERS:
        return list(EXTERNAL_SOLVERS[name].tolerances)
    order = METHODS[name].order
    if order is None:
        return list(_TOLERANCES)
    length = target.end - target.t0
    coarsest = _COARSEST * length / (len(target.crossings) + 1)
    finest = max(coarsest * 10 ** (-_ALL_DIGITS / order), length / (_STEPS_A_SECOND * budget))
    count = max(int(math.log10(coarsest / finest) * order / _DIGITS), 1)
    return [coarsest * 10 ** (-_DIGITS / order * k) for k in range(count + 1)]
