"""Order across the surface: errors of state and crossing time against step size, and their slopes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.integrate import checked_method, checked_settings, checked_start
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.trajectory import Status
from core.interface.arguments import count, listed, number
from core.interface.cancelling import Cancel, Cancelled
from core.interface.tasks import check_hooks
from core.kernels.arrays import Floats
from core.methods import Method
from core.reference import Solution, reference_solution
from core.system import PiecewiseSystem, Start
from core.systems import System, system_of

__all__ = ["FIT_ABOVE", "FIT_BELOW", "OrderStudy", "order_study"]

#: Least error that enters a fit, in units of the floor: below it round-off is seen.
FIT_ABOVE = 50.0
#: Largest error that enters a fit, as part of the size of the state.
FIT_BELOW = 0.3
#: All step sizes from the finest to this many times it enter a fit.
_SPAN = 2.0
#: Coarser ones enter it as long as all slopes between neighbouring points differ by at most this.
_AGREE = 0.15
#: Least number of points of a fit.
_LEAST = 3
#: If the slopes within `_SPAN` differ by more than this, as without a transition, all points enter the fit.
_SCATTER = 1.0
#: Least number of steps to a state that is compared: after fewer, the shortened last step distorts the order.
_FEWEST_STEPS = 4
#: Round-off of state and reference together, in units of eps times the size of the state.
_ROUND_OFF = 16.0
#: How far starts are moved to see how round-off grows, in units of eps times the size of the state: about one rounding.
_MOVED = 2.0
#: Number of such starts, in directions of their own.
_DIRECTIONS = 2
#: Relative change of their step size: it changes every rounding on the way, and the error of the method by far less.
_OTHER_STEPS = 2.0**-40
#: They are followed with the largest step size up to this many times the least, which is cheaper.
_COARSER = 4.0
#: Error of a reference, as part of its own estimate, which is the error of the worse of two solutions.
_OF_ESTIMATE = 0.1
#: Most step sizes of a study.
_MAX_TAUS = 64

Progress: TypeAlias = "Callable[[int, int, OrderStudy], object]"


@dataclass(frozen=True, eq=False)
class OrderStudy:
    """Errors over step sizes (paper: fig:harmonic_timeError, fig:harmonic_transition and their elliptic twins)."""

    method: str
    taus: Floats
    """(m,) step sizes, as given."""
    crossings: tuple[int, ...]
    """(k,) numbers of the crossings compared, from 1."""
    times: Floats
    """(1 + k,) times at which states are compared: halfway to the first crossing, and halfway from each to the next, or
    at `until` in place of the last of these."""
    time_error: Floats
    """(k, m) |t* − t̂| of these crossings; nan where a run did not reach them."""
    state_error: Floats
    """(1 + k, m) ‖x − x*‖ at `times`: row 0 before the first crossing; nan where fewer than four steps lead there."""
    time_slope: Floats
    """(k,) fitted orders; nan where fewer than three step sizes lie in the window."""
    state_slope: Floats
    """(1 + k,) likewise of the state."""
    time_window: Floats
    """(k, 2) least and greatest step size of each fit."""
    window: Floats
    """(1 + k, 2) likewise of the state."""
    floor: Floats
    """(1 + k,) error of the state that is round-off of run and reference, grown along the orbit until then."""
    time_floor: Floats
    """(k,) likewise of the crossing times."""
    reference: str
    """Name of the reference solution."""
    size: float = math.nan
    """Largest coordinate of the states compared."""
    spacing: float = math.nan
    """Mean time between crossings, up to the last one compared; without any, the time until the state is compared."""
    until: float | None = None
    """Time at which the last state is compared, where it was given."""

    @property
    def fit_above(self) -> Floats:
        """(1 + k,) errors of the state above this enter the fits: 50 times `floor`, as round-off adds up."""
        return FIT_ABOVE * self.floor

    @property
    def time_fit_above(self) -> Floats:
        """(k,) errors of crossing times above this enter the fits: 50 times `time_floor`."""
        return FIT_ABOVE * self.time_floor

    @property
    def at_round_off(self) -> NDArray[np.bool_]:
        """(1 + k,) whether no known error of the state exceeds `fit_above`, and there is one."""
        return _all_below(self.state_error, self.fit_above)

    @property
    def time_at_round_off(self) -> NDArray[np.bool_]:
        """(k,) likewise of the crossing times."""
        return _all_below(self.time_error, self.time_fit_above)

    @property
    def fit_below(self) -> float:
        """Errors of the state below this enter the fits: 0.3 times `size`."""
        return FIT_BELOW * self.size

    @property
    def time_fit_below(self) -> float:
        """Errors of crossing times below this enter the fits: 0.3 times `spacing`."""
        return FIT_BELOW * self.spacing

    def __repr__(self) -> str:
        slopes, numbers = ", ".join(f"{slope:.2f}" for slope in self.state_slope), ", ".join(map(str, self.crossings))
        return (
            f"<OrderStudy of {self.method}: {len(self.taus)} step sizes {self.taus.min():g} … {self.taus.max():g}, "
            f"crossings {numbers or 'none'}; slopes of the state {slopes}>"
        )


def order_study(
    system: System,
    taus: Iterable[float],
    x0: Start | None = None,
    method: str | Method = "dmm2",
    crossings: Sequence[int] = (10, 20, 30),
    perturbation_order: int | None = None,
    perturbation_scale: float = 1.0,
    transition: str = "mannshardt",
    t0: float = 0.0,
    cancel: Cancel | None = None,
    progress: Progress | None = None,
    sliding: str = "stop",
    until: float | None = None,
) -> OrderStudy:
    """Measure the order of a method before the first crossing and after later ones.

    Errors are measured against exact crossing times and states where the system has a closed form, else against a
    reference (see `reference_solution`).

    Parameters
    ----------
    taus
        Step sizes, 2 to 64 of them.
    crossings
        Numbers of the crossings to compare, increasing, from 1; none of them, (), if there is none until `until`.
    until
        Time at which to compare states after the last of the crossings, for solutions that have no further one. If not
        given, it is halfway to the next.
    system, x0, method, perturbation_order, perturbation_scale, transition, cancel, sliding
        As in `integrate`; sliding begins and ends with a crossing.
    progress
        Called as ``progress(done, total, partial)`` after each step size. How round-off grows is measured with the
        largest step size up to four times the least; slopes of a study without it may still contain round-off.

    Raises
    ------
    ValueError
        On arguments that make no sense, and where the trajectory has fewer crossings than asked for, or others until
        `until`.
    """
    check_hooks(cancel, progress)
    system, t0 = system_of(system), number(t0, "t0")
    chosen = checked_method(system, method)
    if chosen.adaptive:
        raise ValueError(f"method {chosen.name!r} chooses its step size and its order: there is no order to study")
    start = checked_start(system, t0, x0)
    steps = _checked_taus(taus)
    until = None if until is None else number(until, "until")
    numbers = _checked_crossings(crossings, until)
    options = (transition, perturbation_order, perturbation_scale)
    settings = [checked_settings(chosen, tau, None, *options, cancel=cancel, sliding=sliding) for tau in steps]
    try:
        exact = reference_solution(system, start, t0, cancel=cancel, sliding=sliding)
        target = _target(exact, t0, numbers, until)
    except Cancelled:
        return _nothing(chosen, steps, numbers, until)
    times, states = target.times, target.states
    size = float(np.abs(states).max())
    spacing = float(target.crossing_times[-1] - t0) / numbers[-1] if numbers else float(times[-1] - t0)

    def run(x0: Floats, setting: Settings) -> _Found:
        return _run(system, chosen, t0, tuple(x0.tolist()), setting, times, numbers)

    time_floor, floor = _least_floors(target)
    followed = _followed(settings)
    time_error = np.full((len(numbers), len(steps)), np.nan)
    state_error = np.full((1 + len(numbers), len(steps)), np.nan)

    def study() -> OrderStudy:
        time_slope, time_window = _fits(steps, time_error, time_floor, spacing)
        state_slope, window = _fits(steps, state_error, floor, size)
        return OrderStudy(
            chosen.name, steps, numbers, times, time_error.copy(), state_error.copy(), time_slope, state_slope,
            time_window, window, floor, time_floor, exact.name, size, spacing, until,
        )  # fmt: skip

    for j, setting in enumerate(settings):
        if cancel is not None and cancel():
            break
        t_hat, found = run(np.array(start), setting)
        time_error[:, j] = np.abs(t_hat - target.crossing_times)
        state_error[:, j] = np.linalg.norm(found - states, axis=1)
        state_error[times - t0 < _FEWEST_STEPS * setting.tau, j] = np.nan
        if setting is followed:
            grown = _grown(run, np.array(start), setting, target.states[0], (t_hat, found))
            time_floor, floor = np.fmax(time_floor, grown[0]), np.fmax(floor, grown[1])
        if progress is not None:
            progress(j + 1, len(settings), study())
    return study()


def _nothing(method: Method, taus: Floats, numbers: tuple[int, ...], until: float | None) -> OrderStudy:
    """Return a study that was cancelled before its reference was known."""
    k, m = len(numbers), len(taus)

    def empty(*shape: int) -> Floats:
        return np.full(shape, np.nan)

    return OrderStudy(
        method.name, taus, numbers, empty(1 + k), empty(k, m), empty(1 + k, m), empty(k), empty(1 + k), empty(k, 2),
        empty(1 + k, 2), empty(1 + k), empty(k), "not computed", until=until,
    )  # fmt: skip


def _checked_taus(taus: Iterable[float]) -> Floats:
    steps = np.array([number(tau, "tau") for tau in listed(taus, "taus", "a tuple is needed, as in (0.1, 0.05)")])
    if not 2 <= len(steps) <= _MAX_TAUS:
        raise ValueError(f"taus has {len(steps)} step sizes: 2 to {_MAX_TAUS} are possible")
    if len(set(steps)) < len(steps):
        raise ValueError(f"taus = {steps.tolist()!r} has a step size twice: give different ones")
    return steps


def _checked_crossings(crossings: Sequence[int], until: float | None) -> tuple[int, ...]:
    given = listed(crossings, "crossings", "a tuple is needed, as in (10, 20, 30)")
    numbers = tuple(count(k, "crossings") for k in given)
    if (not numbers and until is None) or any(b <= a for a, b in pairwise(numbers)):
        raise ValueError(f"crossings = {crossings!r}: increasing numbers from 1 are needed, as in (10, 20, 30)")
    return numbers


class _Target(NamedTuple):
    """What runs are compared with."""

    times: Floats
    """(1 + k,) times at which states are compared."""
    states: Floats
    """(1 + k, d) the solution there."""
    crossing_times: Floats
    """(k,) its times of the crossings."""
    error: Floats
    """(1 + k,) its own estimate of its error until `times`."""


def _target(exact: Solution, t0: float, numbers: tuple[int, ...], until: float | None) -> _Target:
    """Ask a solution for its states halfway to the first crossing and after each of some, and for their times."""
    t_star, times, states, error = [t0], [], [], []
    last = max(numbers, default=0)
    if until is not None:
        _check_until(exact, t0, until, last)
    for k in (0, *numbers):
        given = until if k == last else None
        while len(t_star) < k + (2 if given is None else 1):
            t_star.append(_crossing_time(exact, len(t_star), numbers))
        times.append((t_star[k] + t_star[k + 1]) / 2 if given is None else given)
        states.append(exact.state(times[-1]))
        error.append(exact.error)
    return _Target(np.array(times), np.array(states), np.array([t_star[k] for k in numbers]), np.array(error))


def _check_until(exact: Solution, t0: float, until: float, last: int) -> None:
    """Refuse a time that is not between the last crossing and the one after it."""
    if not until > t0:
        raise ValueError(f"until = {until!r}: a time after t0 = {t0!r} is needed")
    if (there := exact.count(until)) != last:
        raise ValueError(f"until = {until!r}: the solution has {there} crossings until then, not {last} as asked for")


def _crossing_time(exact: Solution, k: int, numbers: tuple[int, ...]) -> float:
    """Time of a crossing; ValueError, which says that it is needed, where there is none."""
    try:
        return exact.crossing(k)[0]
    except ValueError as why:
        needed = f"crossings = {numbers!r}: crossing {numbers[-1]} and the one after it are needed"
        known = "none is known" if k == 1 else f"only {k - 1} {'is' if k == 2 else 'are'} known"
        raise ValueError(f"{needed}, but {known}: {why}") from None


#: Times of the crossings (k,), and states (1 + k, d), of one run.
_Found: TypeAlias = tuple[Floats, Floats]


def _followed(settings: Sequence[Settings]) -> Settings:
    """Settings of the runs that show how round-off grows."""
    most = _COARSER * min(one.tau for one in settings)
    return max((one for one in settings if one.tau <= most), key=lambda one: one.tau)


def _least_floors(target: _Target) -> _Found:
    """Errors (k,) of crossing times and (1 + k,) of states that are round-off, even if that does not grow."""
    eps = float(np.finfo(float).eps)
    least = np.fmax(_ROUND_OFF * eps * np.abs(target.states).max(), _OF_ESTIMATE * target.error)
    return np.fmax(least[1:], eps * np.abs(target.crossing_times)), least


def _grown(
    run: Callable[[Floats, Settings], _Found], start: Floats, settings: Settings, early: Floats, found: _Found
) -> _Found:
    """Round-off (k,) of crossing times and (1 + k,) of states as it has grown along the orbit.

    Runs from starts a rounding away, with a step size that is hardly another, so that they round differently all along,
    differ from the one found by what has become of this.

    Parameters
    ----------
    early
        (d,) state before the first crossing: of its size or that of the start is what is rounded first.
    """
    moved = _MOVED * float(np.finfo(float).eps) * max(np.abs(start).max(), np.abs(early).max())
    other = replace(settings, tau=(1.0 - _OTHER_STEPS) * settings.tau)
    runs = [run(start + moved * direction, other) for direction in _directions(len(start))]
    times = [_apart(found[0][:, None], t_hat[:, None]) for t_hat, _ in runs]
    return np.fmax.reduce(times), np.fmax.reduce([_apart(found[1], states) for _, states in runs])


def _directions(dimension: int) -> Floats:
    """Directions (n, d) in which starts are moved, none of them special: each coordinate by 1/2 to 1, up or down."""
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (_DIRECTIONS, dimension))
    return 0.5 * (np.sign(drawn) + drawn)


def _apart(found: Floats, moved: Floats) -> Floats:
    """Distance of rows of two runs: infinite where the second does not get there, nan where the first does not."""
    apart = np.linalg.norm(moved - found, axis=1)
    return np.where(np.isnan(apart) & np.isfinite(found).all(axis=1), np.inf, apart)


def _run(
    system: PiecewiseSystem,
    method: Method,
    t0: float,
    x0: tuple[float, ...],
    settings: Settings,
    times: Floats,
    numbers: tuple[int, ...],
) -> _Found:
    """Times of the crossings, and states at `times`, of one run; nothing else is recorded."""
    runner = Runner(system, method, t0, x0, settings)
    states = np.full((len(times), system.dimension), np.nan)
    for row, t in enumerate(times):
        grid = t0 + math.floor((t - t0) / settings.tau) * settings.tau
        if runner.advance(grid) is not Status.COMPLETED or (state := runner.state_at(float(t))) is None:
            break
        states[row] = state
    runner.advance(float(times[-1]))
    t_hat = runner.crossings().t
    return np.array([t_hat[k - 1] if k <= len(t_hat) else np.nan for k in numbers]), states


def _fits(taus: Floats, errors: Floats, floors: Floats, size: float) -> tuple[Floats, Floats]:
    """Least-squares slopes of log error over log τ, for each row, and the least and greatest step size of each fit."""
    slopes, windows = np.full(len(errors), np.nan), np.full((len(errors), 2), np.nan)
    for k, (row, floor) in enumerate(zip(errors, floors, strict=True)):
        clear = np.flatnonzero((row > FIT_ABOVE * floor) & (row < FIT_BELOW * size))
        finest_first = clear[np.argsort(taus[clear])]
        if len(finest_first) >= _LEAST:
            used = finest_first[: _asymptotic(np.log(taus[finest_first]), np.log(row[finest_first]))]
            slopes[k] = np.polyfit(np.log(taus[used]), np.log(row[used]), 1)[0]
            windows[k] = taus[used].min(), taus[used].max()
    return slopes, windows


def _all_below(errors: Floats, floors: Floats) -> NDArray[np.bool_]:
    """Whether each row has known errors, none of which exceeds its floor."""
    known = np.isfinite(errors)
    return np.asarray(known.any(axis=1) & ~(known & (errors > floors[:, None])).any(axis=1))


def _asymptotic(x: Floats, y: Floats) -> int:
    """Number of points, from the finest on, in the asymptotic range as judged by the slopes."""
    between = np.diff(y) / np.diff(x)
    near = max(_LEAST, int(np.count_nonzero(x <= x[0] + math.log(_SPAN) + 1e-9))) if len(x) else 0
    if np.ptp(between[: near - 1]) > _SCATTER:
        return len(x)
    count = _LEAST
    while count <= len(between) and np.ptp(between[:count]) <= _AGREE:
        count += 1
    return max(near, count)
