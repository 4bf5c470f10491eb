"""Exact piecewise solutions: closed-form flows between crossings located to the last digit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice, pairwise

import numpy as np
import sympy
from numpy.typing import ArrayLike

from core.expressions import TIME
from core.reference.flows import Flow
from core.reference.recognition import exact_numbers, extended_number, recognise
from core.reference.search import Sample, Time, first_zero
from core.reference.solution import MAX_CROSSINGS, Arc, Motion, ReferenceSolution, State, first_arc
from core.reference.weierstrass import Extended

__all__ = ["exact_solution"]

_MAX_SAMPLES = 20_000  # of one arc: over 300 periods of its fastest mode
_CHUNK = 128  # samples taken in one vectorised call of the flow
_RESOLUTION = 0.1  # sampling interval × fastest rate: 63 samples a period
_GROWTH = 0.25  # sampling interval / time since leaving the surface, to see quick returns
_FIRST = 1e-7  # first sample after leaving the surface, × fastest rate
_POLE = 1e-10  # relative distance to a pole at which the search for a crossing ends


def exact_solution(
    field_minus: tuple[sympy.Expr, ...],
    field_plus: tuple[sympy.Expr, ...],
    g: sympy.Expr,
    variables: tuple[sympy.Symbol, ...],
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
    jump: tuple[sympy.Expr, ...] | None = None,
) -> ReferenceSolution | None:
    """Exact solution of x' = field_± (x), or None if no closed form of one of the fields is known.

    Parameters
    ----------
    field_minus, field_plus : tuple of d expressions
        In the variables only.
    g : expression
        In the variables and time.
    variables : tuple of d symbols
    t0 : float
    x0 : (d,)
        ValueError if it lies on the surface and the two fields do not say which side it enters.
    max_crossings : int
    jump : tuple of d expressions, or None
        In the variables and time: the state after reaching the surface.
    """
    below, above = recognise(field_minus, variables), recognise(field_plus, variables)
    names = {TIME, *variables}
    if below is None or above is None or any(e.free_symbols - names for e in (g, *(jump or ()))):
        return None
    flows, surface = {-1: below, 1: above}, _Surface(g, {-1: field_minus, 1: field_plus}, variables)
    jumps = None if jump is None else [_extended_function(u, variables) for u in jump]

    def start(t: Time, x: State, side: int, on_surface: bool) -> Arc:
        return _ExactArc(t, x, side, on_surface, flows[side], surface)

    def land(t: Time, x: State) -> State:
        with np.errstate(all="ignore"):  # where it leads is looked at
            return np.array([u(_column(t), _rows(x))[0] for u in jumps or ()])

    motion = Motion(start, surface.height_at, surface.rate_at, land if jumps else None)
    t, x = np.longdouble(t0), np.asarray(x0, dtype=np.longdouble)
    first = first_arc(motion, t, x, surface.reach(t, x))
    basis = sorted({below.name, above.name})
    return ReferenceSolution(f"exact ({', '.join(basis)})", motion, first, max_crossings)


class _Surface:
    """g and its rates, compiled in extended precision: of times (n,) and states (n, d) -> (n,)."""

    def __init__(
        self, g: sympy.Expr, fields: dict[int, tuple[sympy.Expr, ...]], variables: tuple[sympy.Symbol, ...]
    ) -> None:
        gradient, drift = [g.diff(v) for v in variables], g.diff(TIME)
        self.moves = TIME in g.free_symbols
        self.height = _extended_function(g, variables)
        self.rates = {
            side: _extended_function(sum((a * b for a, b in zip(gradient, f, strict=True)), drift), variables)
            for side, f in fields.items()
        }
        self._slope = _extended_function(sympy.sqrt(sum(u**2 for u in gradient)), variables)
        self._drift = _extended_function(drift, variables)
        arguments = {a for f in g.atoms(sympy.Function) for a in f.args if a.has(TIME)}
        self._clocks = [_extended_function(a.diff(TIME), variables) for a in arguments]

    def height_at(self, t: Time, x: State) -> Time:
        """g at one state (d,)."""
        return np.longdouble(self.height(_column(t), _rows(x))[0])

    def rate_at(self, side: int, t: Time, x: State) -> Time:
        """ġ = g_t + ∇g·f of a side at one state (d,)."""
        return np.longdouble(self.rates[side](_column(t), _rows(x))[0])

    def reach(self, t: Time, x: State) -> Time:
        """How far g may be from 0 on the surface by the rounding of t and x to double."""
        slope, drift = (f(_column(t), _rows(x))[0] for f in (self._slope, self._drift))
        return np.longdouble(2 * np.finfo(float).eps * (slope * np.abs(x).max() + np.abs(drift * t)))

    def tempo(self, t: Time, x: State) -> float:
        """Fastest rate (1/time) at which g itself changes with time: of the arguments of its functions."""
        return max((float(np.abs(clock(_column(t), _rows(x))[0])) for clock in self._clocks), default=0.0)


class _ExactArc:
    """An arc along an exact flow, sampled from its start on as far as anyone asked."""

    def __init__(
        self, t: Time, x: State, side: int, on_surface: bool,
        flow: Flow, surface: _Surface,
    ) -> None:  # fmt: skip
        self.t, self.x, self.side = t, x, side
        self._flow, self._surface = flow, surface
        depth, rate = self._look(np.zeros(1, dtype=np.longdouble))
        self.steepest, self.deepest = float(np.abs(rate[0])), float(np.abs(depth[0]))
        self._last = Sample(np.longdouble(0), 0 if on_surface else depth[0], rate[0])
        end = flow.lifetime(x) if surface.moves else min(flow.lifetime(x), flow.period(x))
        self._times = _sample_times(max(flow.rate(x), surface.tempo(t, x)), end)
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
        times, states = self.t + elapsed, self._flow(self.x, elapsed)
        height, rate = self._surface.height(times, states), self._surface.rates[self.side](times, states)
        return self.side * height, self.side * rate

    def _search(self, elapsed: Extended) -> None:
        """Look at further elapsed times (n,) and keep the first crossing among them."""
        samples = [self._last, *map(Sample, elapsed, *self._look(elapsed))]
        for a, b in pairwise(samples):
            self.steepest, self.deepest = (
                max(self.steepest, float(np.abs(a.rate))), max(self.deepest, float(np.abs(a.depth))),
            )  # fmt: skip
            when = first_zero(self._watch, a, b)
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


def _column(t: Time) -> Extended:
    return np.array([t], dtype=np.longdouble)


def _rows(x: State) -> Extended:
    return x[None].astype(np.longdouble)


def _extended_function(
    expression: sympy.Expr, variables: tuple[sympy.Symbol, ...]
) -> Callable[[Extended, Extended], Extended]:
    """Function of times (n,) and states (n, d) -> (n,) in extended precision, its constants included."""
    exact = exact_numbers(expression)
    inexact = [c for c in exact.atoms(sympy.Number, sympy.NumberSymbol) if not c.is_Integer]
    names = [sympy.Dummy() for _ in inexact]
    values = [extended_number(c) for c in inexact]
    body = exact.xreplace(dict(zip(inexact, names, strict=True)))
    compiled = sympy.lambdify([TIME, *variables, *names], body, "numpy")

    def evaluate(t: Extended, x: Extended) -> Extended:
        return np.broadcast_to(np.asarray(compiled(t, *x.T, *values), dtype=np.longdouble), x.shape[:1])

    return evaluate
