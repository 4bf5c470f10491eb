"""Exact motions of piecewise smooth systems in NumPy's extended precision, and what a run of ours got wrong of them.

Nothing here uses `core`: flights are closed forms, and the surface is met where a dense sample of g along the flight
changes sign, or dips below zero between two samples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Event", "Exact", "Hybrid", "Real", "contradiction", "first_root", "mistake", "silent", "solve", "trusted"]

Real = np.longdouble
Array = NDArray[Any]
Flight = Callable[[Array], Array]

_CHUNK = 192  # samples of g taken at a time
_FIRST = 2.0**-30  # the first sample after an event, as a part of the spacing
_REFINED = 32  # parts of an interval that is looked into
_ACCUMULATED = 1e-7  # gaps below this part of the spacing: the motion chatters
_SHORTEST = 1e-3  # of the flights that are compared, at early times
_TOO_LARGE = 0.01  # relative to the state: with such an error, what comes next cannot be told
_PERTURBED = 30.0  # times its error is what a start is moved by, so that the errors on its way are less


@dataclass(frozen=True)
class Hybrid:
    """A piecewise smooth system whose flights are known exactly."""

    flow: Callable[[int, Any, Array], Flight]
    """(side, t, x (d,)) -> the flight from there: times (n,) -> states (n, d)."""
    height: Callable[[Array, Array], Array]
    """g: times (n,), states (n, d) -> (n,)."""
    spacing: float
    """Of the samples of g: far below the shortest time in which it turns."""
    jump: Callable[[Any, Array], Array] | None = None
    """(t, x) -> the state after reaching the surface."""


@dataclass(frozen=True)
class Event:
    """One meeting with the surface."""

    t: Any
    x: Array
    after: Array
    side: int
    """Side entered."""


@dataclass(frozen=True)
class Exact:
    """The exact motion, as far as it goes or can be told."""

    events: tuple[Event, ...]
    t: Any
    """Up to where."""
    x: Array
    why: str
    """What stopped it; "" at the end time."""
    slack: Array
    """(k + 1,) what the time of each event may be off by; last, of the end: nan where the end cannot be compared."""
    slack_x: Array
    """(k + 1,) the same of the states."""


def first_root(height: Callable[[Array], Array], start: Any, end: Any, spacing: float) -> Any:
    """The first time at which a height, positive just after the start, passes below zero; None if there is none."""
    for times in _samples(start, end, spacing):
        found = _bracket(height, times)
        if found is not None:
            return _narrowed(height, *found)
    return None


def _samples(start: Any, end: Any, spacing: float) -> Iterator[Array]:
    """Times after the start, first ever wider apart, then evenly; each chunk begins with the last two of the former."""
    first = start + spacing * np.exp2(np.arange(np.log2(_FIRST), 0.0)).astype(Real)
    last = first[first < end][-2:]
    yield np.append(first[first < end], end) if len(last) < 2 or first[-1] >= end else first
    begin = first[-1]
    while begin < end:
        times = begin + spacing * np.arange(1, _CHUNK + 1).astype(Real)
        times = np.append(times[times < end], end) if times[-1] >= end else times
        yield np.concatenate([last, times])
        last, begin = times[-2:], times[-1]


def _bracket(height: Callable[[Array], Array], times: Array) -> tuple[Any, Any] | None:
    """Two times between which the height passes below zero for the first time."""
    h = height(times)
    for i in range(len(h)):
        if h[i] <= 0.0:
            return (times[max(i - 1, 0)], times[i])
        if 0 < i < len(h) - 1 and h[i - 1] > h[i] <= h[i + 1] and h[i] < 2.0 * (h[i - 1] + h[i + 1] - 2.0 * h[i]):
            low = _lowest(height, times[i - 1], times[i + 1])
            if low is not None:
                return (times[i - 1], low)
    return None


def _lowest(height: Callable[[Array], Array], a: Any, b: Any) -> Any:
    """A time between two at which the height is negative, where its minimum is."""
    for _ in range(8):
        times = a + (b - a) * np.arange(_REFINED + 1).astype(Real) / _REFINED
        h = height(times)
        if h.min() < 0.0:
            return times[np.argmax(h < 0.0)]
        k = int(h.argmin())
        a, b = times[max(k - 1, 0)], times[min(k + 1, _REFINED)]
    return None


def _narrowed(height: Callable[[Array], Array], a: Any, b: Any) -> Any:
    """The first change of sign in an interval, to the last digit."""
    for _ in range(15):
        times = a + (b - a) * np.arange(_REFINED + 1).astype(Real) / _REFINED
        below = height(times) <= 0.0
        below[-1] = True
        k = int(below.argmax())
        if k == 0:
            return times[0]
        a, b = times[k - 1], times[k]
    return b


def solve(system: Hybrid, t0: float, x0: Any, t_end: float, most: int = 60) -> Exact:
    """The exact motion from a start off the surface."""
    t, x, end = Real(t0), np.asarray(x0, dtype=Real), Real(t_end)
    side = 1 if system.height(t[None], x[None])[0] > 0.0 else -1
    events: list[Event] = []
    why = ""
    while len(events) < most:
        flight = system.flow(side, t, x)
        hit = first_root(lambda s, f=flight, k=side: k * system.height(s, f(s)), t, end, system.spacing)
        if hit is None:
            return _exact(events, end, flight(end[None])[0], why)
        if events and hit - t < _ACCUMULATED * system.spacing:
            return _exact(events, t, x, "chatters")
        at = flight(hit[None])[0]
        after = at if system.jump is None else system.jump(hit, at)
        entered, why = _entered(system, side, hit, after)
        events.append(Event(hit, at, after, entered))
        t, x, side = hit, after, entered
        if why:
            break
    return _exact(events, t, x, why or "enough")


def _exact(events: list[Event], t: Any, x: Array, why: str) -> Exact:
    slack = np.zeros(len(events) + 1)
    return Exact(tuple(events), t, x, why, slack, slack)


def _entered(system: Hybrid, side: int, t: Any, x: Array) -> tuple[int, str]:
    """The side that a state on the surface (or, after a jump, beside it) goes on in, and why it cannot."""
    soon = t + _FIRST * system.spacing
    ahead = {k: k * system.height(soon[None], system.flow(k, t, x)(soon[None]))[0] for k in (-1, 1)}
    into = [k for k in (-1, 1) if ahead[k] > 0.0]
    if len(into) == 1:
        return into[0], ""
    return (0, "slides") if not into else (0, "repels")


def trusted(
    system: Hybrid, t0: float, x0: Any, t_end: float, error: float, floor: float = 1e-9, most: int = 60
) -> Exact:
    """The exact motion, up to where an error of the given size (relative to the state) would change what happens.

    Starts moved by ten times that error must meet the surface likewise, at times that differ by little of the gaps.
    """
    if error > _TOO_LARGE:
        return Exact((), Real(t0), np.asarray(x0, dtype=Real), "nothing can be told", *np.full((2, 1), np.nan))
    base = solve(system, t0, x0, t_end, most)
    x0 = np.asarray(x0, dtype=Real)
    size = _PERTURBED * error * np.maximum(np.abs(x0), 0.1)
    signs = np.sign(np.cos(np.outer(np.arange(1, 4), 1.0 + np.arange(len(x0)))))  # three directions
    others = [solve(system, t0, x0 + s * size, t_end, most) for s in signs]
    dt, dx = [], []
    times = [Real(t0), *(e.t for e in base.events), Real(t_end)]
    for k, event in enumerate(base.events):
        twins = [o.events[k] for o in others if len(o.events) > k and o.events[k].side == event.side != 0]
        off = max((float(abs(e.t - event.t)) for e in twins), default=np.inf)
        if len(twins) < len(others) or off > 0.05 * float(min(event.t - times[k], times[k + 2] - event.t)):
            break
        # A height is known to eps·t, and so the instants of a flight of length T to a multiple of eps·t/T.
        if event.t - times[k] < _SHORTEST * (1 + abs(event.t) / 100):
            break
        dt.append(3 * off + floor)
        changes = (np.abs(np.concatenate([e.x - event.x, e.after - event.after])).max() for e in twins)
        dx.append(3 * max(map(float, changes)) + floor)
    told = len(dt)
    if told < len(base.events) or base.why or any(o.why or len(o.events) > told for o in others):
        last = base.events[told - 1] if told else None
        slack = np.array([*dt, np.nan])
        t = Real(t0) if last is None else last.t
        return Exact(base.events[:told], t, base.x, base.why or "sensitive", slack, np.array([*dx, np.nan]))
    end = max(float(np.abs(o.x - base.x).max()) for o in others) + floor
    return Exact(base.events, base.t, base.x, "", np.array([*dt, 0.0]), np.array([*dx, end]))


def silent(run: Any) -> bool:
    """Whether a run ended as if all was well, without a word about its step."""
    return run.status.name == "COMPLETED" and run.message == run.outcome


def mistake(run: Any, exact: Exact) -> str:
    """What a run got wrong, of what can be told; "" where it is right. A run that stopped is judged up to there."""
    stop, got = min(float(exact.t), float(run.t[-1])), run.crossings
    expected = [e for e, s in zip(exact.events, exact.slack, strict=False) if e.t <= stop - s]
    for k, (e, s, s_x) in enumerate(zip(expected, exact.slack, exact.slack_x, strict=False)):
        if k >= len(got):
            return f"crossing {k} at t = {e.t:.12g} is missing"
        ended_here = k == len(got) - 1 and got.side[k] == 0
        if abs(got.t[k] - e.t) > s:
            return f"crossing {k} is at t = {e.t:.12g}, not {got.t[k]:.12g} (told to {s:.1e})"
        if got.side[k] != e.side and not ended_here:
            return f"crossing {k} at t = {e.t:.12g} enters side {e.side}, not {got.side[k]}"
        off = max(np.abs(got.x[k] - e.x).max(), 0.0 if ended_here else np.abs(got.x_after[k] - e.after).max())
        if off > s_x:
            return f"crossing {k} at t = {e.t:.12g} is off by {off:.2e} in the state (told to {s_x:.1e})"
    k, slack = len(expected), exact.slack[min(len(expected), len(exact.slack) - 1)]
    if len(got) > k and not np.isnan(slack) and got.t[k] < stop - slack:
        return f"crossing {k} at t = {got.t[k]:.12g} does not exist"
    if np.isnan(exact.slack_x[-1]) or run.t[-1] < exact.t or run.status.name != "COMPLETED":
        return ""
    off = np.abs(run.x[-1] - exact.x).max()
    return f"the end is off by {off:.2e} (told to {exact.slack_x[-1]:.1e})" if off > exact.slack_x[-1] else ""


def contradiction(run: Any, height: Callable[[Array, Array], Array], slack: float) -> str:
    """A recorded row that lies on the other side than it says, by more than the slack; "" where there is none."""
    g = run.side * height(run.t.astype(Real), run.x.astype(Real))
    k = int(np.argmin(g))
    return (
        f"at t = {run.t[k]:.12g} the run says side {run.side[k]}, with g = {g[k]:.2e} into it" if g[k] < -slack else ""
    )
