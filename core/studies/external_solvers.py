"""External solvers on any declared system: SciPy's DOP853 and heyoka, restarted where they reach the surface.

They are used as their manuals say: a terminal event stops them on the surface, the jump is applied, and they start anew
with the field beyond. The mode is carried, so that a restart does not trigger the event again. Modes are told by their
labels (`Laws.label`): the sides −1 and +1 of one surface, and 0 for sliding; of several surfaces, their numbers.
(`core.reference.external` locates crossings itself, at one tolerance: it is meant to be reliable, not fast.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np
import scipy  # loads a subpackage when it is first used
import sympy
from sympy import Expr

from core.integration.conserved_error import level_residual_along
from core.integration.starting import first_place
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.symbolic.mode import Mode
from core.system import PiecewiseSystem

__all__ = [
    "EXTERNAL_SOLVERS",
    "Arcs",
    "ExternalSolver",
    "ManyCrossings",
    "Stopped",
    "external_arcs",
    "heyoka_integrator",
]

#: Spacing of doubles at 1, the least tolerance of heyoka.
_EPS = 2.0**-52
#: |g| after a jump, as part of |ġ| times the time since the last crossing, above which the jump leads off the surface.
_OFF_SURFACE = 1e-9
#: Added to g for heyoka, far below round-off: where g starts at exactly 0, as after a jump, it misses later roots.
_ROOT_SHIFT = 2.0**-100
#: Height at the start of a segment, at least: positive.
_LEAST = np.nextafter(0.0, 1.0)
#: Method whose compiled functions evaluate ψ along a run: explicit, so that it admits every system.
_PSI_OF = "rk2"
#: Steps of heyoka between two checks of the time used.
_STEPS_AT_ONCE = 4096


K = TypeVar("K")
V = TypeVar("V")
Seen: TypeAlias = "list[tuple[float, Floats]]"
Jump: TypeAlias = "tuple[Expr, ...]"


class Stopped(Exception):  # noqa: N818 - not an error of the program
    """An external solver cannot continue, or was told not to; the text says why."""


class ManyCrossings(Stopped):
    """A run is given up for the number of its crossings."""


@dataclass
class Arcs:
    """The ends of all segments of a run: k crossings, k + 1 segments."""

    side: list[int] = field(default_factory=list)
    """Label of the mode of each segment: the side, −1 or +1, of one surface, or 0 while sliding."""
    entered: list[tuple[float, Floats]] = field(default_factory=list)
    """Time and state at the start, and after each crossing."""
    left: list[tuple[float, Floats]] = field(default_factory=list)
    """Time and state at each crossing, before its jump, and at the end."""
    evaluations: float = np.nan
    """Number of evaluations of the field; nan if unknown."""
    seen: list[list[tuple[float, Floats]]] = field(default_factory=list)
    """Times and states after each step of each segment, the last where it is left; empty if not recorded."""

    @property
    def crossings(self) -> int:
        """Number of crossings."""
        return len(self.left) - 1

    def change_of_psi(self, system: PiecewiseSystem) -> float:
        """Largest |Δψ| off the surface over the states recorded, see `Trajectory.change_of_psi`; nan without ψ."""
        laws, counts = system.laws, [len(states) for states in self.seen]
        t, x = (np.array(column) for column in zip(*(one for states in self.seen for one in states), strict=True))
        mode = np.array([laws.labelled(side) for side in self.side])
        segment, entered_t = np.repeat(np.arange(len(mode)), counts), np.array([t for t, _ in self.entered])
        entered = entered_t, np.array([x for _, x in self.entered])
        error = level_residual_along(system, _PSI_OF, t, x, mode[segment], segment, *entered)
        error[mode[segment] >= len(laws.regions)] = np.nan  # of sliding, where g is what is kept
        lost = np.cumsum(np.nan_to_num(error[np.cumsum(counts) - 1]), axis=0)
        error[segment > 0] += lost[segment[segment > 0] - 1]
        return float(np.fmax.reduce(np.abs(error), axis=None, initial=np.nan))


class Arrival(NamedTuple):
    """Where an external solver stopped: on the surface, or at the end time."""

    t: float
    x: Floats
    on_surface: bool
    evaluations: float
    guard: int = 0
    """The guard of the mode that was met."""


class Prepared(Protocol):
    """An external solver set up for a system and a tolerance, to be run any number of times."""

    def arc(
        self, side: int, t: float, x: Floats, end: float, check: Callable[[], None], seen: Seen | None = None
    ) -> Arrival:
        """Integrate from (t, x) on a side to the surface or to `end`; raise `Stopped` where neither is reached.

        Times and states after each step are added to `seen` where given.
        """


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
    compiled: bool
    """Whether it compiles the field, as the methods of this package do; else it calls a Python function."""


class _OnDemand(dict[K, V]):
    """A mapping whose values are made when they are first asked for."""

    def __init__(self, make: Callable[[K], V]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, key: K) -> V:
        self[key] = made = self._make(key)
        return made


class ScalarFunctions:
    """A system as Python functions of plain numbers: half a microsecond a call, less than a call of compiled code.

    Parameters
    ----------
    slides
        Whether it slides along surfaces.

    Attributes
    ----------
    field
        Label of a mode -> (t, x) -> f (d,).
    heights
        Label of a mode -> functions (t, x) -> (1,), positive in it, of which each ends it where it vanishes.
    rates
        Label of a mode and number of a surface -> (t, x) -> (ġ,).
    """

    def __init__(self, system: PiecewiseSystem, slides: bool = False) -> None:
        laws = self.laws = system.laws
        self.slides, self.system, self._p = slides, system, system.parameter_array.tolist()
        self._names = {s: sympy.Symbol(f"u{k}") for k, s in enumerate((TIME, *laws.x, *laws.p))}
        self.field = _OnDemand[int, Callable[[float, Floats], Floats]](lambda k: self._function(self.mode(k).field))
        self.heights = _OnDemand[int, "list[Callable[[float, Floats], Floats]]"](
            lambda k: [self._function((u,)) for u in self.mode(k).heights]
        )
        self.rates = _OnDemand[tuple[int, int], Callable[[float, Floats], Floats]](
            lambda key: self._function((self.mode(key[0]).rate_of(laws.surfaces[key[1]]),))
        )
        self._jumps = _OnDemand[Jump, Callable[[float, Floats], Floats]](self._function)

    def mode(self, label: int) -> Mode:
        """The mode with a label."""
        return self.laws.mode(self.laws.labelled(label))

    def _function(self, expressions: Sequence[Expr]) -> Callable[[float, Floats], Floats]:
        compute = sympy.lambdify(list(self._names.values()), [e.xreplace(self._names) for e in expressions], "math")
        p = self._p

        def values(t: float, x: Floats) -> Floats:
            try:
                return np.array(compute(t, *x.tolist(), *p), dtype=float)
            except (ArithmeticError, ValueError, TypeError):
                return np.full(len(expressions), np.nan)  # undefined at a trial step: the solver then shortens it

        return values

    def first_mode(self, t: float, x: Floats) -> int:
        """Label of the mode in which a trajectory from (t, x) begins."""
        if self.laws.two_sided:
            return self.laws.label(self._of_two(0, 0, t, x, 0.0))
        place = first_place(self.system, t, x)
        region = place.region or 0
        way = self.laws.ways[region][place.guard]
        if way.to is not None and way.back is not None:  # of two sides of the surface on which it may begin
            region = self._of_two(region, place.guard, t, x, 0.0)
        return self.laws.label(region)

    def landing(self, t: float, x: Floats, label: int, guard: int, since: float) -> tuple[int, Floats]:
        """Label and state (d,) after a segment in a mode, begun at time `since`, has met its guard at (t, x)."""
        laws, number = self.laws, self.laws.labelled(label)
        if number >= len(laws.regions):  # it leaves to the side whose field has turned
            low, high, surface = laws.pairs[number - len(laws.regions)]
            if guard > 1:
                raise Stopped(f"sliding reaches another surface at t = {t:.6g}")
            turned = [abs(self.rates[laws.label(region), surface](t, x)[0]) for region in (low, high)]
            return laws.label(low if turned[0] < turned[1] else high), x
        way = laws.ways[number][guard]
        if way.jump is not None:
            reach = _OFF_SURFACE * abs(self.rates[label, way.surface](t, x)[0]) * (t - since)
            after = self._jumps[way.jump](t, x)
            return laws.label(self._of_two(number, guard, t, after, reach)), after
        if way.to is None:
            raise Stopped(f"no law is declared beyond the surface met at t = {t:.6g}")
        if self.slides and way.sliding is not None:
            back = self.rates[laws.label(way.to), way.surface](t, x)[0]
            if way.sign * back > 0:
                return laws.label(way.sliding), x
        return laws.label(way.to), x

    def _of_two(self, region: int, guard: int, t: float, x: Floats, reach: float) -> int:
        """Choose a region or the one beyond its guard by the sign of g; where |g| ≤ `reach`, by where f leads.

        Beyond a wall there is none, and a one-way guard leads to its region from wherever the state is.
        """
        way = self.laws.ways[region][guard]
        if way.to is None:
            return region
        if way.back is None:
            return way.to
        plus, minus = (region, way.to) if way.sign > 0 else (way.to, region)
        height = way.sign * self.heights[self.laws.label(region)][guard](t, x)[0]
        if abs(height) > reach:
            return plus if height > 0 else minus
        return plus if self.rates[self.laws.label(plus), way.surface](t, x)[0] > 0 else minus


def external_arcs(
    functions: ScalarFunctions,
    prepared: Prepared,
    t0: float,
    end: float,
    x0: Floats,
    max_crossings: int,
    check: Callable[[], None],
    record: bool = False,
) -> Arcs:
    """Integrate from crossing to crossing.

    Parameters
    ----------
    max_crossings
        Number of crossings beyond which the run is given up.
    check
        Called from time to time; it raises `Stopped` if the run should be given up.
    record
        Whether to keep the states after each step.

    Raises
    ------
    Stopped
        If the run does not reach the end.
    """
    arcs = Arcs(evaluations=0.0)
    t, x, side = t0, x0, functions.first_mode(t0, x0)
    while True:
        arcs.side.append(side)
        arcs.entered.append((t, x))
        since = t
        seen: Seen | None = [] if record else None
        t, x, on_surface, evaluations, guard = prepared.arc(side, t, x, end, check, seen)
        arcs.left.append((t, x))
        if seen is not None:
            arcs.seen.append([*seen, (t, x)])
        arcs.evaluations += evaluations
        if not on_surface:
            return arcs
        if arcs.crossings > max_crossings:
            raise ManyCrossings(f"more than {max_crossings} crossings, up to t = {t:.6g}")
        side, x = functions.landing(t, x, side, guard, since)


class _PreparedScipy:
    """SciPy's `solve_ivp` with DOP853 and a terminal event per guard, triggered only on leaving its side."""

    def __init__(self, functions: ScalarFunctions, tolerance: float, size: float) -> None:
        self._field = functions.field
        self._options: dict[str, Any] = {"method": "DOP853", "rtol": tolerance, "atol": tolerance * size}
        self._check: Callable[[], None]
        self._since = np.nan
        self._events = _OnDemand[int, "list[Any]"](lambda k: [self._leaving(one) for one in functions.heights[k]])

    def _leaving(self, height: Callable[[float, Floats], Floats]) -> Any:
        def event(t: float, x: Floats) -> float:  # called once a step, so the time used is checked here
            self._check()
            value = float(height(t, x)[0])
            # The surface at which the segment begins is left: a zero there would be found in place of a later one.
            return max(value, _LEAST) if t == self._since else value

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        return event

    def arc(
        self, side: int, t: float, x: Floats, end: float, check: Callable[[], None], seen: Seen | None = None
    ) -> Arrival:
        """Integrate to the surface or to `end`."""
        self._check, self._since = check, t
        if not np.isfinite(self._field[side](t, x)).all():  # SciPy would try steps of length nan for ever
            raise Stopped(f"the field is undefined at t = {t:.6g}")
        run = scipy.integrate.solve_ivp(self._field[side], (t, end), x, events=self._events[side], **self._options)
        if not run.success:
            raise Stopped(f"SciPy stops at t = {run.t[-1]:.6g}: {run.message}")
        if seen is not None:
            seen += zip(run.t[1:].tolist(), run.y.T[1:], strict=True)
        met = next((k for k, times in enumerate(run.t_events or ()) if len(times)), 0)
        return Arrival(float(run.t[-1]), np.ascontiguousarray(run.y[:, -1]), run.status == 1, run.nfev, met)


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
        # An integrator, and its state, looked up once, as each access is slow.
        self._integrators = _OnDemand[int, "tuple[Any, Any]"](lambda k: self._made(functions, k, tolerance))

    @staticmethod
    def _made(functions: ScalarFunctions, label: int, tolerance: float) -> tuple[Any, Any]:
        one = heyoka_integrator(functions.system, functions.mode(label), tolerance)
        return one, one.state

    def arc(
        self, side: int, t: float, x: Floats, end: float, check: Callable[[], None], seen: Seen | None = None
    ) -> Arrival:
        """Integrate to the surface or to `end`."""
        (one, state), outcomes = self._integrators[side], self._outcomes
        one.time, state[:] = t, x
        one.reset_cooldowns()
        options: dict[str, Any] = {"max_steps": _STEPS_AT_ONCE}
        if seen is not None:

            def keep(taken: Any) -> bool:
                seen.append((taken.time, taken.state.copy()))
                return True

            options["callback"] = keep
        while (outcome := one.propagate_until(end, **options)[0]) == outcomes.step_limit:
            check()
        met = -1 - int(outcome.value)
        if outcome != outcomes.time_limit and not 0 <= met < len(one.t_events):
            raise Stopped(f"heyoka stops at t = {one.time:.6g}: {outcome}")
        return Arrival(one.time, state.copy(), outcome != outcomes.time_limit, np.nan, met)


def heyoka_integrator(system: PiecewiseSystem, mode: Mode, tolerance: float, fast_math: bool = False) -> Any:
    """heyoka's integrator of one mode of a system, with a terminal event for each of its guards, in their order.

    ImportError if heyoka is not installed.
    """
    import heyoka as hy

    laws, d = system.laws, system.dimension
    variables = [hy.expression(f"u{k}") for k in range(d)]
    wanted = [_in_floats(e) for e in (*mode.field, *mode.heights)]
    used = [q for q in laws.p if any(q in e.free_symbols for e in wanted)]  # heyoka accepts no unused ones
    names = dict(zip(laws.x, variables, strict=True)) | {TIME: hy.time} | {q: hy.par[k] for k, q in enumerate(used)}
    values = [hy.from_sympy(e, names) for e in wanted]
    events = [hy.t_event(height + _ROOT_SHIFT, direction=hy.event_direction.negative) for height in values[d:]]
    return hy.taylor_adaptive(
        list(zip(variables, values[:d], strict=True)), [0.0] * d, tol=tolerance,
        pars=[system.values[str(q)] for q in used], t_events=events, fast_math=fast_math,
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
        ExternalSolver("scipy", "SciPy DOP853", 100 * _EPS, _tolerances(3, 5, 7, 9, 11, 12, 13), _PreparedScipy, False),
        ExternalSolver("heyoka", "heyoka", _EPS, _tolerances(3, 5, 7, 9, 11, 13, 15), _PreparedHeyoka, True),
    )
})  # fmt: skip
