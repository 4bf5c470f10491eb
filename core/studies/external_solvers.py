"""External solvers on any declared system: SciPy's DOP853 and heyoka, restarted where they reach the surface.

They are used as their manuals say: a terminal event stops them on the surface, the jump is applied, and they start anew
with the field of the other side. The side is carried, so that a restart does not trigger the event again.
(`core.reference.external` locates crossings itself, at one tolerance: it is meant to be reliable, not fast.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np
import scipy  # loads a subpackage when it is first used
import sympy
from sympy import Expr

from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.system import PiecewiseSystem

__all__ = ["EXTERNAL_SOLVERS", "Arcs", "ExternalSolver", "Stopped", "external_arcs"]

#: Spacing of doubles at 1, the least tolerance of heyoka.
_EPS = 2.0**-52
#: |g| after a jump, as part of |ġ| times the time since the last crossing, above which the jump leads off the surface.
_OFF_SURFACE = 1e-9
#: Added to g for heyoka, far below round-off: where g starts at exactly 0, as after a jump, it misses later roots.
_ROOT_SHIFT = 2.0**-100
#: Steps of heyoka between two checks of the time used.
_STEPS_AT_ONCE = 4096


class Stopped(Exception):  # noqa: N818 - not an error of the program
    """An external solver cannot continue, or was told not to; the text says why."""


@dataclass
class Arcs:
    """The ends of all segments of a run: k crossings, k + 1 segments."""

    side: list[int] = field(default_factory=list)
    """Side, −1 or +1, of each segment; 0 while sliding."""
    entered: list[tuple[float, Floats]] = field(default_factory=list)
    """Time and state at the start, and after each crossing."""
    left: list[tuple[float, Floats]] = field(default_factory=list)
    """Time and state at each crossing, before its jump, and at the end."""
    evaluations: float = np.nan
    """Number of evaluations of the field; nan if unknown."""

    @property
    def crossings(self) -> int:
        """Number of crossings."""
        return len(self.left) - 1

    def conserved_error(self, system: PiecewiseSystem) -> float:
        """Largest change of any ψ over a segment; nan where there is no ψ."""
        worst = np.nan
        for side in sorted(set(self.side)):
            ends = [(a, b) for s, a, b in zip(self.side, self.entered, self.left, strict=True) if s == side]
            if system.laws.of_side(side).conserved:
                psi = [
                    system.conserved(side, np.array([t for t, _ in one]), np.array([x for _, x in one]))
                    for one in zip(*ends, strict=True)
                ]
                worst = np.fmax(worst, np.abs(psi[1] - psi[0]).max())
        return float(worst)


class Arrival(NamedTuple):
    """Where an external solver stopped: on the surface, or at the end time."""

    t: float
    x: Floats
    on_surface: bool
    evaluations: float


class Prepared(Protocol):
    """An external solver set up for a system and a tolerance, to be run any number of times."""

    def arc(self, side: int, t: float, x: Floats, end: float, check: Callable[[], None]) -> Arrival:
        """Integrate from (t, x) on a side to the surface or to `end`; raise `Stopped` where neither is reached."""


class ExternalSolver(NamedTuple):
    """An integrator of another package."""

    name: str
    """Its key in EXTERNAL_SOLVERS."""
    title: str
    """Name for display."""
    finest: float
    """The least tolerance it accepts."""
    tolerances: tuple[float, ...]
    """Default tolerances of a study."""
    prepare: Callable[[ScalarFunctions, float, float], Prepared]
    """(system, tolerance, size of the state) -> the solver set up for it; raises `Stopped` if not installed."""


class ScalarFunctions:
    """A system as Python functions of plain numbers: half a microsecond a call, less than a call of compiled code.

    Parameters
    ----------
    slides
        Whether it slides along the surface, as side 0.
    """

    def __init__(self, system: PiecewiseSystem, slides: bool = False) -> None:
        laws = self.laws = system.laws
        self.slides = slides and laws.jump is None
        self.sides = (-1, 1, 0) if self.slides else (-1, 1)
        self.system, self._p = system, system.parameter_array.tolist()
        self._names = {s: sympy.Symbol(f"u{k}") for k, s in enumerate((TIME, *laws.x, *laws.p))}

    @cached_property
    def field(self) -> Mapping[int, Callable[[float, Floats], Floats]]:
        """(t, x) -> f (d,), of each side."""
        return {side: self._function(self.laws.of_side(side).field) for side in self.sides}

    @cached_property
    def heights(self) -> Mapping[int, Sequence[Callable[[float, Floats], Floats]]]:
        """Functions (t, x) -> (1,) of each side, positive there, of which each ends a segment where it vanishes."""
        return {side: [self._function((u,)) for u in self.laws.of_side(side).heights] for side in self.sides}

    @cached_property
    def rate(self) -> Mapping[int, Callable[[float, Floats], Floats]]:
        """(t, x) -> (ġ,), of each side."""
        return {side: self._function(self.laws.modes[side].guard_rates) for side in (-1, 1)}

    @cached_property
    def jump(self) -> Callable[[float, Floats], Floats] | None:
        """(t, x) -> the state (d,) after the jump; None where there is none."""
        return None if self.laws.jump is None else self._function(self.laws.jump)

    def _function(self, expressions: Sequence[Expr]) -> Callable[[float, Floats], Floats]:
        compute = sympy.lambdify(list(self._names.values()), [e.xreplace(self._names) for e in expressions], "math")
        p = self._p

        def values(t: float, x: Floats) -> Floats:
            try:
                return np.array(compute(t, *x.tolist(), *p), dtype=float)
            except (ArithmeticError, ValueError, TypeError):
                return np.full(len(expressions), np.nan)  # undefined at a trial step: the solver then shortens it

        return values

    def first_side(self, t: float, x: Floats) -> int:
        """Side on which a trajectory from (t, x) begins."""
        return self._side(t, x, 0.0)

    def landing(self, t: float, x: Floats, side: int, since: float) -> tuple[int, Floats]:
        """Side and state (d,) after a segment on `side`, begun at time `since`, has met its guard at (t, x)."""
        if side == 0:  # it leaves to the side whose field has turned
            return (-1 if abs(self.rate[-1](t, x)[0]) < abs(self.rate[1](t, x)[0]) else 1), x
        if self.jump is None:
            return (0 if self.slides and side * self.rate[-side](t, x)[0] > 0 else -side), x
        reach = _OFF_SURFACE * abs(self.rate[side](t, x)[0]) * (t - since)
        after = self.jump(t, x)
        return self._side(t, after, reach), after

    def _side(self, t: float, x: Floats, reach: float) -> int:
        """The sign of g; where |g| ≤ `reach`, the side to which f₊ leads."""
        height = self.heights[1][0](t, x)[0]
        if abs(height) > reach:
            return 1 if height > 0 else -1
        return 1 if self.rate[1](t, x)[0] > 0 else -1


def external_arcs(
    functions: ScalarFunctions,
    prepared: Prepared,
    t0: float,
    end: float,
    x0: Floats,
    max_crossings: int,
    check: Callable[[], None],
) -> Arcs:
    """Integrate from crossing to crossing.

    Parameters
    ----------
    max_crossings
        Number of crossings beyond which the run is given up.
    check
        Called from time to time; it raises `Stopped` if the run should be given up.

    Raises
    ------
    Stopped
        If the run does not reach the end.
    """
    arcs = Arcs(evaluations=0.0)
    t, x, side = t0, x0, functions.first_side(t0, x0)
    while True:
        arcs.side.append(side)
        arcs.entered.append((t, x))
        since = t
        t, x, on_surface, evaluations = prepared.arc(side, t, x, end, check)
        arcs.left.append((t, x))
        arcs.evaluations += evaluations
        if not on_surface:
            return arcs
        if arcs.crossings > max_crossings:
            raise Stopped(f"more than {max_crossings} crossings, up to t = {t:.6g}")
        side, x = functions.landing(t, x, side, since)


class _PreparedScipy:
    """SciPy's `solve_ivp` with DOP853 and a terminal event per guard, triggered only on leaving its side."""

    def __init__(self, functions: ScalarFunctions, tolerance: float, size: float) -> None:
        self._field = functions.field
        self._options: dict[str, Any] = {"method": "DOP853", "rtol": tolerance, "atol": tolerance * size}
        self._check: Callable[[], None]
        self._events = {side: [self._leaving(one) for one in functions.heights[side]] for side in functions.sides}

    def _leaving(self, height: Callable[[float, Floats], Floats]) -> Any:
        def event(t: float, x: Floats) -> float:  # called once a step, so the time used is checked here
            self._check()
            return float(height(t, x)[0])

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        return event

    def arc(self, side: int, t: float, x: Floats, end: float, check: Callable[[], None]) -> Arrival:
        """Integrate to the surface or to `end`."""
        self._check = check
        run = scipy.integrate.solve_ivp(self._field[side], (t, end), x, events=self._events[side], **self._options)
        if not run.success:
            raise Stopped(f"SciPy stops at t = {run.t[-1]:.6g}: {run.message}")
        return Arrival(float(run.t[-1]), np.ascontiguousarray(run.y[:, -1]), run.status == 1, run.nfev)


class _PreparedHeyoka:
    """heyoka: one Taylor integrator per side, with a terminal event triggered only on leaving that side.

    The change from one to the other takes some four microseconds a crossing. Where the sides differ in one coefficient
    only, a single integrator whose event changes it avoids this, and takes half the time if crossings are many.
    """

    def __init__(self, functions: ScalarFunctions, tolerance: float, size: float) -> None:
        try:
            import heyoka
        except ImportError:
            raise Stopped("heyoka is not installed") from None
        self._outcomes = heyoka.taylor_outcome
        self._integrators = {
            side: _heyoka_integrator(heyoka, functions.system, side, tolerance) for side in functions.sides
        }
        # Looked up once, as each access is slow.
        self._states = {side: one.state for side, one in self._integrators.items()}

    def arc(self, side: int, t: float, x: Floats, end: float, check: Callable[[], None]) -> Arrival:
        """Integrate to the surface or to `end`."""
        one, state, outcomes = self._integrators[side], self._states[side], self._outcomes
        one.time, state[:] = t, x
        one.reset_cooldowns()
        while (outcome := one.propagate_until(end, max_steps=_STEPS_AT_ONCE)[0]) == outcomes.step_limit:
            check()
        if outcome != outcomes.time_limit and outcome.value != -1:
            raise Stopped(f"heyoka stops at t = {one.time:.6g}: {outcome}")
        return Arrival(one.time, state.copy(), outcome != outcomes.time_limit, np.nan)


def _heyoka_integrator(hy: Any, system: PiecewiseSystem, side: int, tolerance: float) -> Any:
    laws, d = system.laws, system.dimension
    variables = [hy.expression(f"u{k}") for k in range(d)]
    mode = laws.of_side(side)
    wanted = [_in_floats(e) for e in (*mode.field, *mode.heights)]
    used = [q for q in laws.p if any(q in e.free_symbols for e in wanted)]  # heyoka accepts no unused ones
    names = dict(zip(laws.x, variables, strict=True)) | {TIME: hy.time} | {q: hy.par[k] for k, q in enumerate(used)}
    values = [hy.from_sympy(e, names) for e in wanted]
    events = [hy.t_event(height + _ROOT_SHIFT, direction=hy.event_direction.negative) for height in values[d:]]
    return hy.taylor_adaptive(
        list(zip(variables, values[:d], strict=True)), [0.0] * d, tol=tolerance,
        pars=[system.values[str(q)] for q in used], t_events=events,
    )  # fmt: skip


def _in_floats(expression: Expr) -> Expr:
    """The expression with ratios and constants as floating-point numbers: heyoka accepts no others."""
    exact = {q for q in expression.atoms(sympy.Rational, sympy.NumberSymbol) if not q.is_Integer}
    return expression.xreplace({q: sympy.Float(q, 17) for q in exact})


def _tolerances(*digits: int) -> tuple[float, ...]:
    return tuple(10.0**-k for k in digits)


#: Name -> external solver.
EXTERNAL_SOLVERS: Mapping[str, ExternalSolver] = MappingProxyType({
    solver.name: solver
    for solver in (
        ExternalSolver("scipy", "SciPy DOP853", 100 * _EPS, _tolerances(3, 5, 7, 9, 11, 12, 13), _PreparedScipy),
        ExternalSolver("heyoka", "heyoka", _EPS, _tolerances(3, 5, 7, 9, 11, 13, 15), _PreparedHeyoka),
    )
})  # fmt: skip
