"""What follows where a guard of a mode vanishes: another mode, a jump, sliding, or the end of the solution, in words.

The rules are those of the compiled loop (`core.transition`), for any arithmetic. Where rounding would decide, or the
laws do not determine what follows, the solution ends.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from core.integration.corner import Rate, way_out_of
from core.reference.search import Time
from core.reference.solution import Arc, Arrival, Ending, State
from core.symbolic.laws import Laws, Way

__all__ = ["Dynamics", "Entry", "Transitions", "UnknownFieldError"]

#: |g| after a jump, as part of its largest value so far, above which the jump leads off the surface.
OFF_SURFACE = 1e-9
#: Number of successive crossings of a surface that are tested for accumulation.
ACCUMULATED = 10
#: They accumulate if they take less than this part of the time since the start.
ACCUMULATION = 1e-9
#: Crossings accumulate, too, if two successive gaps together are at most this many ulps of the time. If each impact
#: leaves half the speed, the last gap is then 1e-12 of the time.
GAP_ULPS = 1000

_SLIDES = Ending("the field of the other side points back, so it slides along the surface")
_UNDECLARED = Ending("it enters a region for which no law is declared")
_NO_END_OF_SLIDING = Ending(
    "sliding ends where the rates do not tell where it leads: both fields turn at once, or one does infinitely slowly"
)


class UnknownFieldError(ValueError):
    """The solution begins in a mode whose field has no known closed form."""


@dataclass(frozen=True)
class Entry:
    """How an arc begins."""

    mode: int
    at: tuple[int, ...] = ()
    """Guards that vanish there, from whose zeros the field leads into the mode."""
    folded: bool = False
    """Whether their rates vanish there, too."""
    past: int | None = None
    """A guard beyond which the arc begins, so that it ends at once."""


@dataclass(frozen=True)
class Dynamics:
    """The functions from which a piecewise solution is put together. Modes and guards are those of the laws."""

    laws: Laws
    start: Callable[[Time, State, Entry], Arc]
    """(t, x, entry) -> the arc from there."""
    evaluate: Callable[[int, int, Time, State], tuple[Time, Time]]
    """(mode, guard, t, x) -> height of the guard, positive inside the mode, and its rate along the field."""
    jump: Callable[[int, int, Time, State], State]
    """(region, guard, t, x) -> the state (d,) after reaching that guard, if its way has a jump."""
    size: Callable[[int, int, Time, State], float] = lambda mode, guard, t, x: 0.0
    """(mode, guard, t, x) -> by how much t and x together change the height."""
    round_off: float = 0.0
    """Relative rounding of an initial value."""
    zero: float = 0.0
    """Height, as part of the largest or of its size, that is zero but for the rounding of this arithmetic."""
    tangent: float = 0.0
    """Rate of a guard where it vanishes, as part of its largest on the arc, that cannot be told from zero.

    Where a guard is touched, its height is found to be zero to rounding, and its rate to the root of that.
    """
    obstacle: Callable[[int], str] = lambda mode: ""
    """Why a mode cannot be followed in this arithmetic; empty if it can."""


@dataclass
class Transitions:
    """The rules of a piecewise solution; they remember its surfaces, so that each solution needs its own."""

    dynamics: Dynamics
    slides: bool = False
    """Whether the solution slides along a surface to which both fields point; else it ends there."""
    _begun: float = field(default=0.0, init=False)
    _zero: float = field(default=0.0, init=False)
    """`Dynamics.zero` once the solution has begun: an initial value is taken as it is given."""
    _heights: dict[int, float] = field(default_factory=dict, init=False)
    """Largest height of each surface so far, if states jump."""
    _crossings: dict[int, list[float]] = field(default_factory=dict, init=False)
    """Times of the crossings of each surface."""

    def __post_init__(self) -> None:
        laws = self.dynamics.laws
        self._ways = [laws.ways_from(mode) for mode in range(laws.count)]
        self._regions = len(laws.regions)

    def label(self, mode: int) -> int:
        """What tells a mode apart for the user: see `Laws.label`."""
        return self.dynamics.laws.label(mode)

    # The start -------------------------------------------------------------------------------------------------------

    def first(self, t: Time, x: State) -> Arc:
        """The arc from an initial value; ValueError if there is none.

        On a surface, where g is zero to round-off, the side is that to which both fields point.
        """
        self._begun = float(t)
        place = x.astype(float)
        if not _finite(t, *x):
            raise ValueError(f"the start t0 = {float(t)}, x0 = {place} must be finite")
        for mode in range(self._regions):
            zeros = self._zeros_at_start(mode, t, x)
            if zeros is not None:
                break
        else:
            raise ValueError(f"x0 = {place} lies in a region for which no law is declared")
        if len(zeros) > 1:
            found = self._beyond_corner(mode, dict.fromkeys((self._ways[mode][k].surface for k in zeros), 0.0), t, x)
        elif zeros and self._ways[mode][zeros[0]].back is not None:
            found = self._first_on_surface(t, x, mode, zeros[0])
        else:
            found = self._begin(t, x, mode, tuple(k for k in zeros if self._rate(mode, k, t, x) > 0))
        if isinstance(found, Ending):
            raise (UnknownFieldError if found.unknown else ValueError)(f"x0 = {place}: {found.reason}")
        self._zero = self.dynamics.zero
        return found

    def _zeros_at_start(self, mode: int, t: Time, x: State) -> list[int] | None:
        """Guards of a region that vanish at an initial value; None if that lies outside the region."""
        zeros = []
        for k in range(len(self._ways[mode])):
            height, bound = self._height(mode, k, t, x), self.dynamics.round_off * self.dynamics.size(mode, k, t, x)
            if not _finite(height):
                raise ValueError(f"at x0 = {x.astype(float)} the switching function is {float(height)}: not finite")
            if height < -bound:
                return None
            if height <= bound:
                zeros.append(k)
        return zeros

    def _first_on_surface(self, t: Time, x: State, mode: int, guard: int) -> Arc | Ending:
        way = self._ways[mode][guard]
        own, other = self._rate(mode, guard, t, x), self._rate_beyond(way, t, x)
        if own > 0 > other:
            return self._begin(t, x, mode, (guard,))
        if other > 0 > own and way.to is not None and way.back is not None:
            return self._begin(t, x, way.to, (way.back,))
        attracts = own < 0 and other < 0
        if attracts and self.slides and way.sliding is not None:
            return self._begin(t, x, way.sliding)
        kind = "attracts both fields (sliding)" if attracts else "repels both, or is tangent to one"
        return Ending(f"it is on the surface, which there {kind}: no side to start on")

    # From arc to arc -------------------------------------------------------------------------------------------------

    def onward(self, arc: Arc, met: Arrival) -> Arc | Ending:
        """The arc that follows another one, or why there is none."""
        way = self._ways[arc.mode][met.guard]
        turns = self._is_rate(arc.mode, met.guard)
        if self.dynamics.laws.jumps:
            self._heights[way.surface] = max(self._heights.get(way.surface, 0.0), arc.largest_height(met.guard))
        tangent = self.dynamics.tangent * arc.largest_rate(met.guard)
        if not met.at_once and -self._rate(arc.mode, met.guard, met.t, met.x) <= tangent:
            ending = (
                _NO_END_OF_SLIDING
                if turns
                else Ending("it touches the surface tangentially, or too nearly so to be told apart")
            )
            return ending._replace(doubtful=True)
        if self._accumulates(way.surface, float(met.t)):
            return Ending("its crossings or jumps accumulate: infinitely many follow in a finite time (Zeno)")
        corner = self._corner(arc, met)
        slid = arc.mode >= self._regions
        if corner or (slid and not turns):
            return self._through_corner(arc, met, [way.surface, *corner])
        if slid:
            return self._leave_sliding(arc, met)
        if way.jump is not None:
            return self._after_jump(arc, met, tangent)
        return self._beyond(arc, met, tangent)

    def _beyond(self, arc: Arc, met: Arrival, tangent: float) -> Arc | Ending:
        """The arc in the region beyond a surface, or along it."""
        way, t, x = self._ways[arc.mode][met.guard], met.t, met.x
        if way.to is None:
            return _UNDECLARED
        if way.back is None or (met.at_once and not self._is_zero(way.to, way.back, t, x)):
            return self._begin(t, x, way.to)
        onward = self._rate_beyond(way, t, x)
        if onward > tangent:
            return self._begin(t, x, way.to, (way.back,))
        if onward >= -tangent:
            return Ending("the field of the other side is tangent to the surface", doubtful=bool(onward != 0))
        if self.slides and way.sliding is not None:
            return self._begin(t, x, way.sliding)
        return _SLIDES

    def _after_jump(self, arc: Arc, met: Arrival, tangent: float) -> Arc | Ending:
        """The arc after a jump; on the surface the fields decide its side."""
        way, mode, guard, t = self._ways[arc.mode][met.guard], arc.mode, met.guard, met.t
        x = self.dynamics.jump(mode, guard, t, met.x)
        height, rate = self.dynamics.evaluate(mode, guard, t, x)
        if not _finite(*x, height):
            return Ending(f"the reset map leads to {x.astype(float)}, where nothing is defined")
        if way.back is None and way.to is not None:  # a one-way transition
            return self._begin(t, x, way.to, jumped=True)
        if np.abs(height) > OFF_SURFACE * self._heights[way.surface]:
            to = mode if height > 0 else way.to
            return _UNDECLARED if to is None else self._begin(t, x, to, jumped=True)
        beyond = self._rate_beyond(way, t, x)
        back, on = rate > tangent, beyond > tangent
        if back and on:
            return Ending("after the reset both fields lead away from the surface")
        if on and way.to is not None and way.back is not None:
            return self._begin(t, x, way.to, (way.back,), jumped=True)
        if back:
            return self._begin(t, x, mode, (guard,), jumped=True)
        doubtful = any(0 < abs(u) <= tangent for u in (rate, beyond))
        return Ending("after the reset neither field leads away from the surface, so it stays there", doubtful=doubtful)

    def _leave_sliding(self, arc: Arc, met: Arrival) -> Arc | Ending:
        """The arc that leaves the surface to the side whose field has turned, tangentially."""
        way, other = self._ways[arc.mode][met.guard], 1 - met.guard
        attracting = self._height(arc.mode, other, met.t, met.x)
        if attracting <= self.dynamics.tangent * arc.largest_height(other) or way.to is None or way.back is None:
            return _NO_END_OF_SLIDING._replace(doubtful=bool(attracting != 0))
        return self._begin(met.t, met.x, way.to, (way.back,), folded=True)

    def _through_corner(self, arc: Arc, met: Arrival, surfaces: list[int]) -> Arc | Ending:
        """The arc that leaves a corner; while sliding, the surface along which it slides meets there, too."""
        guards = {way.surface: k for k, way in enumerate(self._ways[arc.mode]) if not self._is_rate(arc.mode, k)}
        scales = {surface: arc.largest_rate(guards[surface]) for surface in surfaces if surface in guards}
        if arc.mode >= self._regions:  # the first two guards are the rates of that surface
            along = self.dynamics.laws.pairs[arc.mode - self._regions][2]
            scales[along] = max(arc.largest_height(0), arc.largest_height(1))
        tangent = {surface: self.dynamics.tangent * scales[surface] for surface in sorted(scales)}
        return self._beyond_corner(arc.mode, tangent, met.t, met.x)

    def _beyond_corner(self, mode: int, tangent: Mapping[int, float], t: Time, x: State) -> Arc | Ending:
        """The same from the boundary of a mode: up to `tangent` of each surface that meets there a rate is unclear."""
        laws = self.dynamics.laws

        def rate(region: int, surface: int) -> Rate:
            return Rate(float(self._rate_of(surface, region, t, x)), tangent[surface])

        way = way_out_of(laws, laws.sides[mode].tolist(), list(tangent), rate)
        if way.mode is None:
            return Ending(f"it meets several surfaces at once, and {way.reason}", doubtful=way.unclear)
        if way.mode >= self._regions and not self.slides:
            return _SLIDES
        ways = enumerate(self._ways[way.mode])
        at = tuple(k for k, one in ways if one.surface in tangent and not self._is_rate(way.mode, k))
        return self._begin(t, x, way.mode, at)

    def _begin(
        self, t: Time, x: State, mode: int, at: tuple[int, ...] = (), folded: bool = False, jumped: bool = False
    ) -> Arc | Ending:
        """The arc in a mode from the zeros of some guards, or why there is none.

        Beyond another guard, a jump has led across its surface as well; without one the mode ends at once, as it does
        at the zero of a guard if its field leads out.
        """
        if reason := self.dynamics.obstacle(mode):
            return Ending(reason, unknown=True)
        leaving, past = list(at), None
        for k, way in enumerate(self._ways[mode]):
            if k in at:
                continue
            height, rate = self.dynamics.evaluate(mode, k, t, x)
            if not _finite(height):
                return Ending("a switching function is not defined there")
            zero = self._is_zero(mode, k, t, x)
            if height > 0 and not zero:
                continue
            if self._is_rate(mode, k):
                return _NO_END_OF_SLIDING
            if jumped and not zero and way.back is not None:
                if way.to is None:
                    return _UNDECLARED
                on = {self._ways[mode][j].surface for j in at}
                there = tuple(j for j, other in enumerate(self._ways[way.to]) if other.surface in on)
                if not all(self._leads_in(way.to, j, t, x) for j in there):
                    return Ending("after the reset, across another surface, the fields do not tell the side it enters")
                return self._begin(t, x, way.to, there, folded, jumped)
            if rate == 0 and zero:
                return Ending("it touches another surface tangentially, or too nearly so to be told apart")
            if zero and rate > 0:
                leaving.append(k)
            elif past is None:
                past = k
        return self.dynamics.start(t, x, Entry(mode, tuple(leaving), folded, past))

    # At a surface ----------------------------------------------------------------------------------------------------

    def _height(self, mode: int, guard: int, t: Time, x: State) -> Time:
        return self.dynamics.evaluate(mode, guard, t, x)[0]

    def _rate(self, mode: int, guard: int, t: Time, x: State) -> Time:
        return self.dynamics.evaluate(mode, guard, t, x)[1]

    def _rate_of(self, surface: int, region: int, t: Time, x: State) -> Time:
        """Rate of a switching function with the field of a region."""
        guard = self._guard_of(region, surface)
        return self._ways[region][guard].sign * self._rate(region, guard, t, x)

    def _rate_beyond(self, way: Way, t: Time, x: State) -> Time:
        """Rate with which the field beyond a surface leads away from it; 0 where no law is declared."""
        return 0 if way.to is None or way.back is None else self._rate(way.to, way.back, t, x)

    def _leads_in(self, mode: int, guard: int, t: Time, x: State) -> bool:
        """Whether the field of a region leads into it from the zero of a guard, and that beyond leads there, too."""
        return bool(self._rate(mode, guard, t, x) > 0 >= self._rate_beyond(self._ways[mode][guard], t, x))

    def _is_rate(self, mode: int, guard: int) -> bool:
        """Whether a guard is a rate, which ends sliding, and not a switching function."""
        return mode >= self._regions and guard < 2

    def _is_zero(self, mode: int, guard: int, t: Time, x: State) -> bool:
        """Whether a height is zero but for the rounding of this arithmetic."""
        bound = self._zero * self.dynamics.size(mode, guard, t, x)
        return bool(np.abs(self._height(mode, guard, t, x)) <= bound)

    def _guard_of(self, mode: int, surface: int) -> int:
        """Number of the guard of a mode that is a given switching function."""
        ways = enumerate(self._ways[mode])
        return next(k for k, way in ways if way.surface == surface and not self._is_rate(mode, k))

    def _corner(self, arc: Arc, met: Arrival) -> list[int]:
        """Other surfaces that are met at the same time."""
        found = []
        for k, way in enumerate(self._ways[arc.mode]):
            if k != met.guard and not self._is_rate(arc.mode, k):
                height = np.abs(self._height(arc.mode, k, met.t, met.x))
                if height <= self.dynamics.zero * arc.largest_height(k):
                    found.append(way.surface)
        return found

    def _accumulates(self, surface: int, t: float) -> bool:
        """Whether crossings of a surface accumulate at t (Zeno): it follows too soon on those before it."""
        crossings = self._crossings.setdefault(surface, [])
        last = crossings[-ACCUMULATED:]
        crossings.append(t)
        if len(last) == ACCUMULATED and t - last[0] < ACCUMULATION * (t - self._begun):
            return True
        return len(last) >= 2 and t - last[-2] <= GAP_ULPS * np.spacing(abs(t))


def _finite(*numbers: Time) -> bool:
    return bool(np.isfinite([float(u) for u in numbers]).all())
