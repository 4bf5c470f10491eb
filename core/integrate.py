"""integrate(): check the arguments, run the time loop, return a Trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from core.codegen.rounding import with_roundings
from core.integration.events import NOTHING, Event, Watched, checked_events
from core.integration.finished import trajectory_of
from core.integration.recording import Sampler
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.starting import first_place
from core.integration.trajectory import Trajectory
from core.interface.arguments import checked_sliding, choice, count, number, numbers
from core.interface.tasks import check_hooks
from core.kernels.arrays import Floats
from core.methods import METHODS, Method, method_named
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem, Start
from core.systems import System, system_of
from core.transition.records import NO_MODE

__all__ = [
    "checked_method", "checked_region", "checked_settings", "checked_span", "checked_start", "integrate", "run_warning",
]  # fmt: skip

_TRANSITIONS = ("mannshardt", "none")
_EPS = 2.0**-52
_RECORDS = ("steps", "crossings", "end")
#: Advice on a start that is refused.
_OTHER = "choose another state"
#: Default step size.
_TAU = 1e-2
#: Default tolerance of a variable-step method.
_TOLERANCE = 1e-12
#: Least tolerance, the spacing of doubles at 1.
_EPS = 2.0**-52
#: Largest tolerance.
_COARSEST = 1e-2
#: Default max_crossings where crossings are counted and not recorded.
_MAX_COUNTED = 10**9
#: Largest max_crossings and max_steps that the loop's counters, 64-bit integers, can hold.
_UNLIMITED = 2**62
#: Default max_steps with record="steps", so that memory suffices.
_MAX_ROWS = 10**7


def integrate(
    system: System,
    t_span: tuple[float, float],
    x0: Start | None = None,
    tau: float | None = None,
    method: str | Method = "dmm2",
    *,
    tolerance: float | None = None,
    transition: str = "mannshardt",
    perturbation_order: int | None = None,
    perturbation_scale: float = 1.0,
    record: str = "steps",
    max_crossings: int | None = None,
    max_steps: int | None = None,
    envelope: int | None = None,
    cancel: Callable[[], bool] | None = None,
    progress: Callable[[float], object] | None = None,
    t_eval: ArrayLike | None = None,
    sliding: str = "stop",
    events: str | Event | Sequence[str | Event] = (),
    max_events: int | None = None,
    region: str | None = None,
) -> Trajectory:
    """Integrate a piecewise system across its switching surface.

    Parameters
    ----------
    system
        A system, or a key of CATALOGUE.
    t_span
        Start and end time; the end may be the earlier.
    x0
        d numbers, or a mapping from the name of every variable to its number; the system's own x0 where not given.
    tau
        Step size, positive; 1e-2 where not given. The last step is shortened to end at the end time. For a
        variable-step method ("taylor") it is the largest step allowed; there is no limit where it is not given.
    method
        A key of METHODS, or one of its values.
    tolerance
        Of a variable-step method, relative to the state; 1e-12 where not given. Other methods accept none.
    transition
        "mannshardt": locate the crossing on the scheme, land on it, switch to the other field (paper, Algorithm 1).
        "none": step over the surface, and switch to the other field only then.
    perturbation_order, perturbation_scale
        p and c: every crossing time is moved, t̂ ← t̂ + c·τᵖ, and the step to it solved anew. p = None: no perturbation.
    record
        "steps": every step; "crossings": first and last state, and the crossings; "end": first and last state only.
        `message` judges the first 50,000 steps whatever is recorded; they are made again if need be. Of a single later
        step that leads elsewhere than shorter ones it warns with "steps" wherever it lies, else if there is none of 128
        steps before and after it in which a surface is met.
    max_crossings, max_steps
        Numbers of crossings and of steps after which the run stops. Where not given: 5·10⁶ crossings, or 10⁹ with
        record="end"; 10⁷ steps where every step is recorded, else 10⁹.
    envelope
        Number of equal parts of the time span, at most 10⁷, for each of which the least and the greatest error of ψ
        are kept. The
        loop takes them at every step, for a run of any length, and whatever is recorded.
    cancel
        Called every few milliseconds; the run stops when it returns True. An exception that it raises ends the run and
        is passed on.
    progress
        Called every few milliseconds, and at the end, with the part of the time span done, from 0 to 1. An exception
        that it raises is passed on, too.
    t_eval
        Times at which to record, in any order, instead of at the steps, which do not change: see `Trajectory.at`. The
        first and the last state are recorded, too (``run.at(t_eval)`` returns those at `t_eval` alone), and a repeated
        time is recorded once. Crossings are recorded as `record` says; with "end", memory is used for these states
        only. Where the run stops early, later times are left out.
    sliding
        What happens where both fields point to the surface. "stop": the run ends there, as the paper's theory does.
        "continue": it slides along the surface by Filippov's field, until one of the fields turns (see `core.symbolic.
        sliding`); a system with a jump stops all the same.
    events
        Functions h(t, x) whose zeros are found along the run, each an expression or an `Event`. The steps are those of
        a run without events, bit by bit. A zero is located on the scheme, as crossings are, and counts where the sign
        of h changes: not at the start, nor where a jump changes the sign. An event at a crossing is at its time and
        state, before its jump; it counts if h comes to zero there, also where a jump turns h back, as the height of a
        ball at its wall. A perturbation moves crossings, and events are those of the steps that are taken all the
        same: next to a moved crossing one may be missing, or stand twice.
    max_events
        Number of events after which the run stops; 10⁶ where not given.
    region
        Name of the region in which the run begins, where regions have names and more than one contains x0, as with
        hysteresis; the first of them where not given.

    Returns
    -------
    Trajectory
        Its `status` tells what went wrong during the run, if anything; all that was computed before is kept. Its
        `events` are in the order in which they took place.

    Raises
    ------
    ValueError
        On arguments that make no sense; the message names the value and what would be accepted.
    """
    check_hooks(cancel, progress)
    system = system_of(system)
    chosen = checked_method(system, method)
    choice(record, "record", _RECORDS)
    t0, t1 = checked_span(t_span)
    start = checked_start(system, t0, x0, region)
    times = None if t_eval is None else _checked_times(t_eval, t0, t1)
    if max_steps is None and record == "steps" and times is None:
        max_steps = _MAX_ROWS
    if max_crossings is None and record == "end":
        max_crossings = _MAX_COUNTED
    settings = checked_settings(
        chosen, tau, tolerance, transition, perturbation_order, perturbation_scale, max_crossings, max_steps, cancel,
        sliding, checked_events(system, events), max_events, checked_region(system, region),
    )  # fmt: skip
    columns = 0 if envelope is None else count(envelope, "envelope", _MAX_ROWS)
    runner = Runner(system, chosen, t0, start, settings, columns)
    sampler = None if times is None or not times.size else Sampler(runner, chosen, times)
    record_steps = sampler is not None or (times is None and record == "steps")
    told = None if sampler is None and progress is None else _after_each_call(runner, t0, t1, sampler, progress)
    runner.advance(t1, record_steps, record != "end", told)
    if sampler is not None:
        sampler.take(final=True)
    run = trajectory_of(runner, record if times is None else "t_eval", record != "end", sampler, run_warning)
    runner.release()
    return run


def _after_each_call(
    runner: Runner, t0: float, t1: float, sampler: Sampler | None, progress: Callable[[float], object] | None
) -> Callable[[], None]:
    """Function to call whenever the loop returns."""

    def after() -> None:
        if sampler is not None:
            sampler.take()
        if progress is not None:
            progress(min(max((runner.t - t0) / (t1 - t0), 0.0), 1.0))

    return after


def _checked_times(t_eval: ArrayLike, t0: float, t1: float) -> Floats:
    """Return the times after the start, in the order of the run; ValueError if one is outside the time span."""
    times = np.unique(numbers(t_eval, "t_eval"))
    low, high = min(t0, t1), max(t0, t1)
    outside = (times < low) | (times > high)
    if outside.any():
        raise ValueError(f"t_eval holds {float(times[outside][0])!r}, which is outside t_span = {(t0, t1)!r}")
    times = times[times != t0]
    return np.array(times if t1 >= t0 else times[::-1])


def checked_method(system: PiecewiseSystem, name: str | Method) -> Method:
    """Return the method of that name; ValueError if it cannot be used on the system."""
    method = method_named(name)
    if method.needs_conserved and not system.laws.most_conserved:
        others = ", ".join(m.name for m in METHODS.values() if not m.needs_conserved)
        raise ValueError(
            f"method {method.name!r} conserves known quantities, and {system.name!r} has none: use one of {others}"
        )
    return method


def checked_start(system: PiecewiseSystem, t0: float, x0: Start | None, region: str | None = None) -> tuple[float, ...]:
    """Return the initial state; ValueError if no run can start there, or not in the region of that name."""
    start, laws = system.x0 if x0 is None else system.check_state(x0), system.laws
    if region is not None:
        _check_inside(system, checked_region(system, region), t0, start)
    values = laws.numbers("start", laws.at_start, t0, start, system.parameter_array)
    heights = values[: len(laws.surfaces)]
    if math.isfinite(sum(values)) and 0.0 not in heights and (laws.two_sided or _regions_at(laws, heights)):
        return start  # inside a region, and all is finite
    count, d = len(laws.surfaces), system.dimension
    gradients, rest = np.split(values[count:], [count * (1 + d)])  # of each g in (t, x), where g = 0 is a surface
    word = "g" if laws.two_sided else "a switching function"
    if not all(map(math.isfinite, heights)):
        raise ValueError(f"x0 = {start!r}: {word} has no finite value there; {_OTHER}")
    for k, g in enumerate(heights):
        if g == 0.0 and not gradients[k * (1 + d) : (k + 1) * (1 + d)].any():
            if k in laws.instants:
                raise ValueError(
                    f"t0 = {t0!r}: {word} and its rate vanish then; write it with a simple zero, or "
                    "choose another start time"
                )
            raise ValueError(
                f"x0 = {start!r}: {word} and its gradient vanish there, so {word} has no surface; {_OTHER}"
            )
    inside = _regions_at(laws, heights)
    if not inside and first_place(system, t0, np.array(start)).region is None:
        raise ValueError(f"x0 = {start!r} lies in a region for which no law is declared; {_OTHER}")
    if not all(math.isfinite(f) for k in inside for f in rest[k * d : (k + 1) * d]):
        raise ValueError(f"x0 = {start!r}: the field has no finite value there; {_OTHER}")
    return start


def _regions_at(laws: Laws, heights: list[float]) -> list[int]:
    """Numbers of the regions in which, or at the boundary of which, switching functions have these values."""
    return [k for k, ways in enumerate(laws.ways) if all(way.sign * heights[way.surface] >= 0.0 for way in ways)]


def checked_settings(
    method: Method,
    tau: float | None,
    tolerance: float | None = None,
    transition: str = "mannshardt",
    perturbation_order: int | None = None,
    perturbation_scale: float = 1.0,
    max_crossings: int | None = None,
    max_steps: int | None = None,
    cancel: Callable[[], bool] | None = None,
    sliding: str = "stop",
    events: Watched = NOTHING,
    max_events: int | None = None,
    region: int = NO_MODE,
) -> Settings:
    """Return the settings of a run; ValueError if they make no sense."""
    given = (
        method, tau, tolerance, transition, perturbation_order, perturbation_scale, max_crossings, max_steps, sliding,
        events, max_events,
    )  # fmt: skip
    try:
        settings = _known_settings(*given)
    except TypeError:  # of a type that cannot be looked up
        settings = _settings(*given)
    return settings if cancel is None and region == NO_MODE else replace(settings, cancel=cancel, region=region)


def _check_inside(system: PiecewiseSystem, region: int, t0: float, start: tuple[float, ...]) -> None:
    """Refuse a state that is outside a region, given by its number, by more than rounding."""
    heights = system.laws.mode(region).heights
    found = system.laws.evaluate(("within", region), with_roundings(heights), t0, [start], system.parameter_array)[0]
    for guard, height, rounding in zip(heights, *np.split(found, 2), strict=True):
        if height < -_EPS * rounding:
            name = system.laws.regions[region].name
            raise ValueError(
                f"x0 = {start!r} is outside the region {name!r}, which ends where {guard} = 0: it is {height:.6g} there"
            )


def checked_region(system: PiecewiseSystem, name: str | None) -> int:
    """Return the number of the region of that name; NO_MODE without one, ValueError if no run can begin there."""
    if name is None:
        return NO_MODE
    laws = system.laws
    named = [] if laws.regions[0].sides else [mode.name for mode in laws.regions]
    if name not in named:
        known = f"one of {', '.join(named)} is needed" if named else "its regions have no names, so that x0 tells it"
        raise ValueError(f"region = {name!r} of the system {system.name!r}: {known}")
    return named.index(name)


def _settings(
    method: Method,
    tau: float | None,
    tolerance: float | None,
    transition: str,
    perturbation_order: int | None,
    perturbation_scale: float,
    max_crossings: int | None,
    max_steps: int | None,
    sliding: str,
    events: Watched,
    max_events: int | None,
) -> Settings:
    step, accuracy = _step_size(method, tau), _accuracy(method, tolerance)
    located, slides = choice(transition, "transition", _TRANSITIONS) == "mannshardt", checked_sliding(sliding)
    shift = 0.0
    if perturbation_order is not None:
        order = number(perturbation_order, "perturbation_order")
        if method.adaptive:
            raise ValueError(f"perturbation_order = {order:g}: method {method.name!r} has no fixed step size tau")
        if order <= 0:
            raise ValueError(f"perturbation_order = {perturbation_order!r}: a positive number, or None for none")
        shift = _shift(number(perturbation_scale, "perturbation_scale"), step, order)
    limits = {"max_crossings": max_crossings, "max_steps": max_steps, "max_events": max_events}
    given: Any = {name: min(count(n, name), _UNLIMITED) for name, n in limits.items() if n is not None}
    return Settings(step, accuracy, located, shift, slides=slides, events=events, **given)


#: Checked once for all runs that take the same ones; 1, 1.0 and True are told apart.
_known_settings = lru_cache(maxsize=256, typed=True)(_settings)


def _shift(scale: float, step: float, order: float) -> float:
    """c·τᵖ."""
    try:
        power = step**order
    except OverflowError:
        power = math.inf
    return number(scale * power, "perturbation_scale * tau**perturbation_order") if scale else 0.0


def _step_size(method: Method, tau: float | None) -> float:
    if tau is None:
        return math.inf if method.adaptive else _TAU
    step = number(tau, "tau")
    if not step > 0:
        raise ValueError(f"tau = {step!r}: the step size must be positive")
    return step


def _accuracy(method: Method, tolerance: float | None) -> float:
    if tolerance is None:
        return _TOLERANCE
    if not method.adaptive:
        raise ValueError(f"tolerance = {tolerance!r}: method {method.name!r} takes steps of size tau, and no tolerance")
    accuracy = number(tolerance, "tolerance")
    if not _EPS <= accuracy <= _COARSEST:
        raise ValueError(f"tolerance = {accuracy!r} is outside {_EPS:.2g} … {_COARSEST:g}")
    return accuracy


def checked_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Return start and end time; ValueError if they are none."""
    try:
        t0, t1 = t_span
    except (TypeError, ValueError):
        raise ValueError(f"t_span = {t_span!r}: a start and an end time are needed, as in (0.0, 60.0)") from None
    return number(t0, "start time"), number(t1, "end time")


def run_warning(run: Trajectory) -> str:
    """Return what `diagnostics` warns of; it is loaded when a message is first read."""
    from core.diagnostics import start_warning, step_warning

    return " ".join(filter(None, (start_warning(run), step_warning(run))))
