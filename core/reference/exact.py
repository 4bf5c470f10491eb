"""Exact piecewise solutions: closed-form flows between crossings located to the last digit."""

from collections.abc import Callable, Iterator
from itertools import islice, pairwise

import numpy as np
import sympy
from numpy.typing import ArrayLike

from core.reference.flows import Flow, exact_numbers, extended_number, recognise
from core.reference.solution import (
    MAX_CROSSINGS,
    Arc,
    ReferenceSolution,
    Sample,
    State,
    Time,
    first_arc,
    first_zero,
)
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
    first = first_arc(start, gdot, np.longdouble(t0), x, height, reach)
    return ReferenceSolution(f"exact ({', '.join(names)})", start, gdot, first, max_crossings)


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
        self._last = Sample(np.longdouble(0), 0 if on_surface else depth[0], rate[0])
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
        samples = [self._last, *map(Sample, elapsed, *self._look(elapsed))]
        for a, b in pairwise(samples):
            self.steepest = max(self.steepest, float(np.abs(a.rate)))
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
