"""The comparison: time to a given error of every method of ours, of SciPy and of heyoka, and the ratios."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import core
from pwsviz.bench.curves import TARGETS, Curve
from pwsviz.bench.heyoka_rival import heyoka_curves, installed_heyoka
from pwsviz.bench.own import own_curve
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import problem_named
from pwsviz.bench.reference import reference_of
from pwsviz.bench.scipy_rivals import scipy_curves
from pwsviz.bench.tables import aligned, milliseconds

__all__ = ["Best", "Comparison", "best_of", "comparison", "ratio_lines"]

NOT_INSTALLED = "not installed"
_GOALS = {1e-3: 0.5, 1e-6: 0.5, 1e-9: 0.5, 1e-12: 1.0}  #: ours / heyoka at most
_SCIPY_GOAL = 0.01  #: ours / SciPy at most


class Comparison(NamedTuple):
    """What was measured on one system."""

    system: str
    own: Sequence[Curve]
    heyoka: Sequence[Curve] | None
    """None where heyoka is not installed."""
    scipy: Sequence[Curve]


class Best(NamedTuple):
    """The fastest of some integrators to an error."""

    seconds: float | None
    """None where none gets there."""
    name: str
    bound: float | None = None
    """Where none gets there: the shortest time after which one was given up."""


def comparison(plan: Plan) -> Iterable[str]:
    """Measure all integrators on all systems of the plan; lines of the tables, and of the ratios at the end."""
    yield "Time to a state error after hundreds of crossings, in ms: by the clock on the wall, and of the compiled"
    yield "loop alone (processor time); the least of repeats after a discarded warm-up, interpolated between two"
    yield "settings. Ours is all of core.integrate(record='end'), heyoka's is propagate_until alone. first (s), in no"
    yield "other time: what a first call takes longer, to compile or to load from disk; heyoka's is to build. '-': not"
    yield f"reached, be it within runs of {plan.own_budget:g} s of ours or {plan.rival_budget:g} s of SciPy's."
    measured = []
    for name in plan.systems:
        yield ""
        one, lines = _measure(name, plan)
        measured.append(one)
        yield from lines
    yield ""
    yield from ratio_lines(measured)


def _measure(name: str, plan: Plan) -> tuple[Comparison, Iterable[str]]:
    problem = problem_named(name, plan.share)
    exact = reference_of(problem)
    given = (problem, exact.state, exact.crossings, plan)
    one = Comparison(
        name,
        [
            own_curve(problem, core.METHODS[method], exact.state, exact.crossings, plan)
            for method in plan.methods
            if problem.system.psi_plus or not core.METHODS[method].needs_conserved
        ],
        None if installed_heyoka() is None else heyoka_curves(*given),
        scipy_curves(*given),
    )
    head = f"  {name}: T = {problem.end:g}, {exact.crossings} crossings; measured against: {exact.name}"
    return one, [head, *_table(one)]


def _table(one: Comparison) -> Iterable[str]:
    headers = [text for target in TARGETS for text in (f"{target:.0e} wall", "loop")]
    rows = []
    for curve in [*one.own, *(one.heyoka or ()), *one.scipy]:
        times = [milliseconds(seconds) for target in TARGETS for seconds in curve.reach(target)]
        finest = curve.finest
        rows.append([curve.name, *times, f"{finest.error:.0e}", str(finest.crossings), f"{curve.compiling:.2f}"])
    if one.heyoka is None:
        rows.append(["heyoka", *[NOT_INSTALLED] * 2, *["-"] * (len(headers) + 1)])
    return aligned(["", *headers, "least error", "crossings", "first"], rows)


def best_of(curves: Sequence[Curve], target: float) -> Best:
    """The integrator that gets to an error first by the clock on the wall."""
    times = {curve.name: curve.reach(target)[0] for curve in curves}
    reached = {name: seconds for name, seconds in times.items() if seconds is not None}
    if not reached:
        return Best(None, "", min(max(point.wall for point in curve.points) for curve in curves))
    name = min(reached, key=reached.__getitem__)
    return Best(reached[name], name)


def ratio_lines(measured: Sequence[Comparison]) -> Iterable[str]:
    """Lines of the ratios, each with whether it is what we aim at."""
    goals = ", ".join(f"{goal:g} at {target:.0e}" for target, goal in _GOALS.items())
    yield "Ratios: wall time of the fastest of ours over that of the fastest of each rival, in ms, at the same error."
    yield "'<': no such rival gets there, and the time after which the first was given up stands for its time."
    yield f"Aims: at most {goals} of heyoka; at most {_SCIPY_GOAL:g} of SciPy."
    header = ("system", "error", "ours", "", "heyoka", "", "ours / heyoka", "aim", "SciPy", "", "ours / SciPy", "aim")
    rows = []
    for one in measured:
        for target, goal in _GOALS.items():
            own, scipy = best_of(one.own, target), best_of(one.scipy, target)
            peer = Best(None, NOT_INSTALLED) if one.heyoka is None else best_of(one.heyoka, target)
            cells = [milliseconds(own.seconds), own.name]
            for rival, aim in ((peer, goal), (scipy, _SCIPY_GOAL)):
                cells += [milliseconds(rival.seconds), rival.name, *_ratio(own, rival, aim)]
            rows.append([one.system, f"{target:.0e}", *cells])
    yield from aligned(header, rows)


def _ratio(own: Best, rival: Best, aim: float) -> tuple[str, str]:
    """The ratio, or a bound on it, and whether the aim is met."""
    slower = rival.seconds if rival.seconds is not None else rival.bound
    if own.seconds is None or slower is None:
        return "-", ""
    ratio = own.seconds / slower
    text = f"{ratio:.2g}" if ratio < 0.1 else f"{ratio:.2f}"
    if rival.seconds is None:
        return f"< {text}", "met" if ratio <= aim else ""
    return text, "met" if ratio <= aim else "missed"
