"""Solutions to measure others against: exact ones where a closed form is known, else a peer integrator's.

Both come as a `ReferenceSolution`: crossing k, and the state and side at any time, computed when first asked
for.  The side is carried, never read from the sign of g near the surface.  The solution ends, with a reason
in words, where it cannot cross: on a sliding piece of the surface, and at a tangency.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator
from itertools import islice, pairwise
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

from core.flows import Extended, Flow, exact_numbers, extended_number, recognise

Time: TypeAlias = float | np.longdouble
State: TypeAlias = NDArray[np.floating]
Watch: TypeAlias = Callable[[Time], tuple[Time, Time]]

TANGENT = 1e-8  # |ġ| below this fraction of its largest value on the arc: a tangency, not a crossing
MAX_CROSSINGS = 100_000
_MAX_SAMPLES = 20_000  # exact flow: samples of one arc, over 300 periods of its fastest mode
_LOOKS = (0.25, 0.5, 0.75)  # peer: where within a step g is looked at, besides its ends
_MAX_STEPS = 200_000  # peer: steps of one arc
_CHUNK = 128  # samples taken in one vectorised call of the flow
_RESOLUTION = 0.1  # sampling interval × fastest rate: 63 samples a period
_GROWTH = 0.25  # sampling interval / time since leaving the surface, to see quick returns
_FIRST = 1e-7  # first sample after leaving the surface, × fastest rate
_POLE = 1e-10  # relative distance to a pole at which the search for a crossing ends
_PEER_RTOL = 1e-13


class Stop(NamedTuple):
    """Where, when and why a solution ends."""

    t: float
    x: NDArray[np.float64]
    reason: str


class Arc(Protocol):
    """A piece of the solution on one side, from (t, x) until it next reaches the surface."""

    side: int
    t: Time
    x: State
    steepest: float  # largest |ġ| seen on it

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`.

        ValueError if `until` is inf and there is none, or if none is found within the bounds on work.
        """

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""


class ReferenceSolution:
    """Piecewise smooth solution from (t0, x0), extended lazily from crossing to crossing.

    Parameters
    ----------
    name : str
        What it rests on, for display.
    start : callable (t, x, side, on_surface) -> Arc
    gdot : callable (side, t, x) -> float
        Rate of g along the field of a side.
    first : Arc
    max_crossings : int
    """

    def __init__(
        self,
        name: str,
        start: Callable[[Time, State, int, bool], Arc],
        gdot: Callable[[int, Time, State], Time],
        first: Arc,
        max_crossings: int,
    ) -> None:
        self.name = name
        self.stop: Stop | None = None  #: set once the solution is known to end
        self._start, self._gdot, self._max_crossings = start, gdot, max_crossings
        self._arcs = [first]
        self._times = [float(first.t)]

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        if not 1 <= k <= self._max_crossings:
            raise ValueError(f"crossing must be from 1 to {self._max_crossings}, not {k}")
        while len(self._arcs) <= k:
            self._advance(np.inf)
        return self._times[k], self._arcs[k].x.astype(float)

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0; ValueError past the end of the solution."""
        return self._arc(t).state(t).astype(float)

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; at a crossing the side entered."""
        return self._arc(t).side

    def _arc(self, t: float) -> Arc:
        if not self._times[0] <= t < np.inf:
            raise ValueError(f"time must be finite and at least {self._times[0]:.17g}, not {t}")
        while self._times[-1] <= t and self._advance(t):
            if len(self._arcs) > self._max_crossings:
                raise ValueError(f"more than {self._max_crossings} crossings before t = {t}")
        return self._arcs[bisect_right(self._times, t) - 1]

    def _advance(self, until: float) -> bool:
        """Append the next arc; False if there is no crossing up to `until`."""
        arc = self._arcs[-1]
        if self.stop is None or self.stop.t > until:
            arrived = arc.arrival(until)
            if arrived is None or arrived[0] > until:
                return False
            t, x = arrived
            reason = self._obstacle(arc, t, x)
            if reason is None:
                self._arcs.append(self._start(t, x, -arc.side, True))
                self._times.append(float(t))
                return True
            self.stop = Stop(float(t), x.astype(float), reason)
        if self.stop.t >= until:
            return False
        raise ValueError(f"the solution ends at t = {self.stop.t:.16g}, x = {self.stop.x}: {self.stop.reason}")

    def _obstacle(self, arc: Arc, t: Time, x: State) -> str | None:
        """Why the solution cannot cross at (t, x), or None if it crosses transversally."""
        tangent = TANGENT * arc.steepest
        if -arc.side * self._gdot(arc.side, t, x) <= tangent:
            return "it touches the surface tangentially"
        onward = -arc.side * self._gdot(-arc.side, t, x)
        if onward < -tangent:
            return "the field of the other side points back, so it slides along the surface"
        return "the field of the other side is tangent to the surface" if onward <= tangent else None


def exact_solution(
    field_minus: tuple[sympy.Expr, ...],
    field_plus: tuple[sympy.Expr, ...],
    g: sympy.Expr,
    variables: tuple[sympy.Symbol, ...],
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
) -> ReferenceSolution | None:
    """Exact solution of x' = field_± (x), or None if no closed form of one of the fields is known.

    Parameters
    ----------
    field_minus, field_plus : tuple of d expressions
    g : expression
        In the variables only, like the fields; otherwise None is returned.
    variables : tuple of d symbols
    t0 : float
    x0 : (d,)
        ValueError if it lies on the surface and the two fields do not say which side it enters.
    """
    below, above = recognise(field_minus, variables), recognise(field_plus, variables)
    if below is None or above is None or g.free_symbols - set(variables):
        return None
    flows = {-1: below, 1: above}
    gradient = [g.diff(v) for v in variables]
    rates = {
        side: sum((a * b for a, b in zip(gradient, f, strict=True)), sympy.Integer(0))
        for side, f in ((-1, field_minus), (1, field_plus))
    }
    surface = _extended_function(g, variables)
    slopes = {side: _extended_function(rate, variables) for side, rate in rates.items()}
    slope = _extended_function(sympy.sqrt(sum(u**2 for u in gradient)), variables)

    def gdot(side: int, t: Time, x: State) -> Time:
        return np.longdouble(slopes[side](x[None].astype(np.longdouble))[0])

    def start(t: Time, x: State, side: int, on_surface: bool) -> Arc:
        return _ExactArc(t, x, side, on_surface, flows[side], surface, slopes[side])

    x = np.asarray(x0, dtype=np.longdouble)
    height = surface(x[None])[0]
    reach = 2 * np.finfo(float).eps * slope(x[None])[0] * np.abs(x).max()
    names = sorted({below.name, above.name})
    first = _first_arc(start, gdot, np.longdouble(t0), x, height, reach)
    return ReferenceSolution(f"exact ({', '.join(names)})", start, gdot, first, max_crossings)


def peer_solution(
    f: Callable[[int, float, NDArray[np.float64]], ArrayLike],
    g: Callable[[float, NDArray[np.float64]], float],
    gdot: Callable[[int, float, NDArray[np.float64]], float],
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
) -> ReferenceSolution:
    """Solution by SciPy's DOP853 at its tightest sensible tolerance, restarted on the surface.

    Parameters
    ----------
    f : callable (side, t, x) -> (d,)
    g : callable (t, x) -> float
    gdot : callable (side, t, x) -> float
        ∂g/∂t + ∇g·f of the side.
    t0 : float
    x0 : (d,)
        On the surface only if g vanishes there exactly; ValueError as for `exact_solution`.
    """

    def start(t: Time, x: State, side: int, on_surface: bool) -> Arc:
        return _PeerArc(float(t), x.astype(float), side, on_surface, f, g, gdot)

    def rate(side: int, t: Time, x: State) -> Time:
        return float(gdot(side, float(t), x.astype(float)))

    x = np.asarray(x0, dtype=float)
    first = _first_arc(start, rate, float(t0), x, g(float(t0), x), 0.0)
    return ReferenceSolution(f"SciPy DOP853, rtol {_PEER_RTOL:g}", start, rate, first, max_crossings)


def _first_arc(
    start: Callable[[Time, State, int, bool], Arc],
    gdot: Callable[[int, Time, State], Time],
    t: Time,
    x: State,
    height: Time,
    reach: Time,
) -> Arc:
    """The arc from (t, x): the side is the sign of g = `height`, or of ġ where |g| ≤ `reach`."""
    if not (np.isfinite(x).all() and np.isfinite(t) and np.isfinite(height)):
        raise ValueError(f"the start t0 = {t}, x0 = {x}, with g = {height}, must be finite")
    if np.abs(height) > reach:
        return start(t, x, 1 if height > 0 else -1, False)
    below, above = gdot(-1, t, x), gdot(1, t, x)
    if below < 0 and above < 0:
        return start(t, x, -1, True)
    if below > 0 and above > 0:
        return start(t, x, 1, True)
    kind = "attracts both fields (sliding)" if below > 0 > above else "repels both, or is tangent to one"
    raise ValueError(f"x0 = {x.astype(float)} is on the surface, which there {kind}: no side to start on")


def _extended_function(expression: sympy.Expr, variables: tuple[sympy.Symbol, ...]) -> Callable[[Extended], Extended]:
    """Function of states (n, d) -> (n,) in extended precision, its constants included."""
    exact = exact_numbers(expression)
    inexact = [c for c in exact.atoms(sympy.Number, sympy.NumberSymbol) if not c.is_Integer]
    names = [sympy.Dummy() for _ in inexact]
    values = [extended_number(c) for c in inexact]
    compiled = sympy.lambdify([*variables, *names], exact.xreplace(dict(zip(inexact, names, strict=True))), "numpy")

    def evaluate(x: Extended) -> Extended:
        return np.broadcast_to(np.asarray(compiled(*x.T, *values), dtype=np.longdouble), x.shape[:1])

    return evaluate


class _Sample(NamedTuple):
    """One look at an arc: the time, side·g (positive inside) and its rate."""

    t: Time
    depth: Time
    rate: Time


class _ExactArc:
    """An arc along an exact flow, sampled from its start on as far as anyone asked."""

    def __init__(
        self, t: Time, x: State, side: int, on_surface: bool,
        flow: Flow, surface: Callable[[Extended], Extended], slope: Callable[[Extended], Extended],
    ) -> None:  # fmt: skip
        self.t, self.x, self.side = t, x, side
        self._flow, self._surface, self._slope = flow, surface, slope
        depth, rate = self._look(np.zeros(1, dtype=np.longdouble))
        self.steepest = float(np.abs(rate[0]))
        self._last = _Sample(np.longdouble(0), 0 if on_surface else depth[0], rate[0])
        self._times = _sample_times(flow.rate(x), min(flow.lifetime(x), flow.period(x)))
        self._found: tuple[Time, State] | None = None

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`."""
        while self._found is None and self.t + self._last.t < until:
            chunk = list(islice(self._times, _CHUNK))
            if chunk:
                self._search(np.array(chunk, dtype=np.longdouble))
            elif until < np.inf:
                return None
            else:
                raise ValueError(f"the solution never reaches the surface after t = {self.t:.17g}: {self._fate()}")
        return self._found

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""
        if t - self.t >= self._flow.lifetime(self.x):
            raise ValueError(f"no state at t = {t}: {self._fate()}")
        return self._at(t - self.t)

    def _at(self, elapsed: Time) -> Extended:
        state: Extended = self._flow(self.x, np.array([elapsed], dtype=np.longdouble))[0]
        return state

    def _fate(self) -> str:
        life = self._flow.lifetime(self.x)
        if life < np.inf:
            return f"it escapes to infinity at t = {self.t + life:.17g}"
        return f"its orbit closes after a period {self._flow.period(self.x):.17g}"

    def _look(self, elapsed: Extended) -> tuple[Extended, Extended]:
        states = self._flow(self.x, elapsed)
        return self.side * self._surface(states), self.side * self._slope(states)

    def _search(self, elapsed: Extended) -> None:
        """Look at further elapsed times (n,) and keep the first crossing among them."""
        samples = [self._last, *map(_Sample, elapsed, *self._look(elapsed))]
        for a, b in pairwise(samples):
            self.steepest = max(self.steepest, float(np.abs(a.rate)))
            when = _first_zero(self._watch, a, b)
            if when is not None:
                self._found = self.t + when, self._at(when)
                return
        self._last = samples[-1]

    def _watch(self, elapsed: Time) -> tuple[Time, Time]:
        depth, rate = self._look(np.array([elapsed], dtype=np.longdouble))
        return depth[0], rate[0]


def _sample_times(rate: float, end: float) -> Iterator[Time]:
    """Elapsed times at which to look for a crossing, before `end`: denser at the start and towards a pole."""
    unit = 1 / rate if rate > 0 else 1.0
    widest = _RESOLUTION * unit if rate > 0 else np.inf  # without a rate the flow is polynomial in time
    t = 0.0
    for _ in range(_MAX_SAMPLES):
        t += min(max(_FIRST * unit, _GROWTH * t), widest, _RESOLUTION * (end - t))
        if end - t < _POLE * end or not np.isfinite(t):
            return
        yield t
    raise ValueError(f"no crossing found in {_MAX_SAMPLES} samples, up to {t:.6g} after the last one")


class _PeerArc:
    """An arc by DOP853, one node a step."""

    def __init__(
        self, t: float, x: NDArray[np.float64], side: int, on_surface: bool,
        f: Callable[[int, float, NDArray[np.float64]], ArrayLike],
        g: Callable[[float, NDArray[np.float64]], float],
        gdot: Callable[[int, float, NDArray[np.float64]], float],
    ) -> None:  # fmt: skip
        self.t: Time = t
        self.x: State = x
        self.side = side
        self._g, self._gdot = g, gdot
        self._f = lambda u, y: np.asarray(f(side, u, y), dtype=float)
        self._atol = _PEER_RTOL / 10 * (np.abs(x).max() or 1.0)
        self._solver = DOP853(self._f, t, x, np.inf, rtol=_PEER_RTOL, atol=self._atol)
        self._times, self._states = [t], [x]
        depth, rate = self._look(t, x)
        self.steepest = abs(rate)
        self._last = _Sample(t, 0.0 if on_surface else depth, rate)
        self._found: tuple[Time, State] | None = None

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`."""
        while self._found is None and self._last.t < until:
            if len(self._times) > _MAX_STEPS:
                raise ValueError(f"no crossing found in {_MAX_STEPS} steps, up to t = {self._times[-1]:.17g}")
            message = self._solver.step()
            t, x = float(self._solver.t), self._solver.y
            if self._solver.status == "failed" or not np.isfinite(x).all():
                raise ValueError(f"the reference integrator stops at t = {self._times[-1]:.17g}: {message}")
            self._search(t, x)
            self._times.append(t)
            self._states.append(x.copy())
        return self._found

    def _search(self, t: float, x: NDArray[np.float64]) -> None:
        """Look along the step just taken, to (t, x), and keep the first crossing on it."""
        path, start = self._solver.dense_output(), self._times[-1]
        inner = [start + (t - start) * part for part in _LOOKS]
        samples = [
            self._last, *(_Sample(u, *self._look(u, path(u))) for u in inner), _Sample(t, *self._look(t, x))
        ]  # fmt: skip
        for a, b in pairwise(samples):
            self.steepest = max(self.steepest, abs(float(a.rate)))
            when = _first_zero(self._watch, a, b)
            if when is not None:
                self._found = float(when), self.state(float(when))
                return
        self._last = samples[-1]

    def _watch(self, t: Time) -> tuple[Time, Time]:
        return self._look(float(t), self.state(float(t)))

    def state(self, t: float) -> State:
        """State (d,) at time t, by a step of the integrator itself from the node before: no interpolant."""
        node = bisect_right(self._times, t) - 1
        t0, x0 = self._times[node], self._states[node]
        if t == t0:
            return x0
        run = solve_ivp(self._f, (t0, t), x0, "DOP853", rtol=_PEER_RTOL, atol=self._atol, first_step=t - t0)
        if not run.success:
            raise ValueError(f"the reference integrator stops after t = {t0:.17g}: {run.message}")
        return np.asarray(run.y[:, -1])

    def _look(self, t: float, x: NDArray[np.float64] | State) -> tuple[float, float]:
        y = x.astype(float)
        return self.side * float(self._g(t, y)), self.side * float(self._gdot(self.side, t, y))


def _first_zero(watch: Watch, a: _Sample, b: _Sample) -> Time | None:
    """First time in (a, b] at which the depth vanishes, or None; not the zero at a itself.

    Two zeros between a and b show in the sign of the rate: the extremum between them is looked at.
    """
    if a.depth > 0 and b.depth <= 0:
        return _newton(watch, a.t, b.t)
    if a.rate < 0 < b.rate:
        bottom = _extremum(watch, a.t, b.t)
        return _newton(watch, a.t, bottom) if watch(bottom)[0] <= 0 else None
    if b.depth <= 0:  # and a is on the surface: left and met again between two looks
        top = _extremum(watch, a.t, b.t) if a.rate > 0 > b.rate else a.t
        if watch(top)[0] <= 0:
            raise ValueError(f"the solution leaves the surface tangentially; it is back after {b.t - a.t:.3g}")
        return _newton(watch, top, b.t)
    return None


def _extremum(watch: Watch, a: Time, b: Time) -> Time:
    """Time between a and b, where the rate has opposite signs, at which it vanishes."""
    return a + (b - a) * brentq(lambda s: float(watch(a + (b - a) * s)[1]), 0.0, 1.0)


def _newton(watch: Watch, inside: Time, outside: Time) -> Time:
    """Zero of the depth in a bracket, to the last digit: Newton's method, bisecting where it would leave."""
    t = inside + (outside - inside) / 2
    for _ in range(200):
        depth, rate = watch(t)
        if depth > 0:
            inside = t
        else:
            outside = t
        step = -depth / rate if rate != 0 else np.inf
        new = t + step if inside < t + step < outside else inside + (outside - inside) / 2
        if depth == 0 or new in (t, inside, outside):
            break
        t = new
    return t
