"""How a run ended: what made it fail, in words a user can act on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from core.codegen.rounding import with_roundings
from core.integration.ahead import Ahead, what_is_ahead
from core.integration.at_surface import AtSurface, at_surface
from core.integration.corner import BEYOND
from core.integration.failure import Growth, ends_beyond, ends_here, growth_of
from core.integration.growth_loop import GROWTH
from core.integration.overflow import overflowing
from core.integration.recorded import Point
from core.integration.run import SHORTER, Run
from core.methods import METHODS, Method
from core.symbolic.source_text import to_text
from core.system import PiecewiseSystem
from core.transition.event_location import BOUND
from core.transition.records import NO_MODE
from core.transition.status import Status

if TYPE_CHECKING:
    from core.integration.runner import Runner

__all__ = ["Cause", "Ending", "cause_of", "cause_of_failure", "ending_of", "outcome", "reason"]

#: Part of the largest size of a coordinate along a run below which it is zero to rounding.
_ROUNDING = 16.0 * float(np.finfo(float).eps)
#: A pole is searched beyond the end of the run by this part of the time since the mode was entered.
_MARGIN = 0.1
#: Ratio of the sizes of two variables from which on a least-norm change of a step is one of the smaller: systems drawn
#: at random keep their dmm2 to 1e2, and lose it in a third of the cases at 1e4.
_UNLIKE = 1e3
#: Part of a step ahead within which a law may cease to be defined, of a step that fails, and of ever shorter ones.
_UNDEFINED_WITHIN = {Status.NO_CONVERGENCE: 1.0, Status.STEP_LIMIT: 2.0**-30}
#: How runs end that what lies ahead may have ended, as do some that have escaped.
_FAILS_AHEAD = (Status.NO_CONVERGENCE, Status.UNSTABLE, Status.GRAZING, Status.SINGULAR)
#: How many times as many steps as were allowed are left where a higher limit does not help.
_HIGHER = 100.0
#: Number of regions in a row from which on a run that leaves each where it entered it goes round: it ends at 16.
_AT_ONCE = 8
#: Steps ahead of a failed step within which the solution must run away to be the cause of the failure.
_AHEAD = 16.0


def cause_of_failure(runner: Runner) -> tuple[Status, Growth | None]:
    """Status of a run whose step has failed: the solution runs away, the scheme alone does, or the step fails.

    If the step passes a singularity of the field, the solution runs away or ends there. Else, if the state has grown
    beyond bounds, the exact solution is followed from where the mode was entered, through the step that failed. If a
    step fails elsewhere, the solution is followed for some steps from here. For a state beyond bounds, how the solution
    grows is returned, too: None where a step fails before the state has grown.

    It is followed by shorter steps of the method itself, and where these do not tell, by an implicit method.
    """
    size, cancel = float(np.abs(runner.start).max()), runner.settings.cancel
    if runner.met is not None:
        t, h = runner.t, runner.met[1]
        grown = float(np.abs(runner.x).max()) > GROWTH * (size or 1.0)
        grows = grown or runner.follow(t, runner.x, t + h, h, size) in (Growth.LARGE, Growth.POLE)
        return Status.ESCAPED if grows else Status.SINGULAR, None
    if runner.slides or runner.mode == NO_MODE:
        return runner.status, None
    system, here, step = runner.system, runner.x, _step_length(runner)
    if what_is_ahead(system, runner.last, step) is Ahead.UNBOUNDED_FIELD:
        return Status.SINGULAR, None
    name = system.laws.name(runner.mode)
    grown = runner.status is Status.ESCAPED or float(np.abs(here).max()) > GROWTH * size > 0.0
    if grown:
        entry = runner.entry
        t, x, beyond = entry.t, np.array(entry.x), _MARGIN * (runner.t - entry.t)
        end = runner.t + max(beyond, step, key=abs)
    else:
        t, x, end = runner.t, here, runner.t + _AHEAD * step
    growth: Growth | None = Growth.BOUNDED
    if end != t:
        growth = runner.follow(t, x, end, step, size) or growth_of(system, name, t, x, end, size, cancel)
    if growth is None:
        return Status.CANCELLED if cancel is not None and cancel() else runner.status, None
    if growth is Growth.BOUNDED and grown and float(np.abs(x).max()) > GROWTH * (size or 1.0):
        growth = Growth.LARGE  # it had grown before the mode was entered, in which it turns at bounds
    if growth is Growth.BOUNDED:
        return Status.UNSTABLE if grown else runner.status, growth
    if runner.status is not Status.ESCAPED:
        growth = Growth.POLE if grown else None
    return Status.ESCAPED, growth


class Cause(NamedTuple):
    """Why a run ended, besides its status."""

    step: float = math.nan
    """Signed length of a step; of a variable-step method, of its longest."""
    growth: Growth | None = None
    """How the solution grows where the run has failed, if that could be told."""
    why_cornered: str = ""
    """Why the laws do not tell how to go on from the last corner; empty if they do."""
    singular: str = ""
    """The expression whose zero lies in the step that failed, as a clause; empty if there is none."""
    removable: bool = False
    """Whether, for these values of the parameters, the field has a limit at that zero."""
    jumped: bool = False
    """Whether the run ended after a jump at the surface that it met last."""
    event: str = ""
    """The event function whose zero ended the run; empty if none did."""
    circles: bool = False
    """Whether the run goes from region to region in no time, without end."""
    remarks: tuple[str, ...] = ()
    """What is to be said of the event functions, a sentence each."""
    shift: float = 0.0
    """By how much crossing times were perturbed."""
    pole: float = math.nan
    """Time of a pole to which the run would need ever shorter steps, about; nan if none is known."""
    left: float = 0.0
    """Number of steps, as long as the last ones, that are left at a limit of steps; 0 if these are no shorter."""


#: Of a run that has reached its end time, and has nothing to remark.
_AS_ASKED = Cause()


class Ending(NamedTuple):
    """How a run ended."""

    system: PiecewiseSystem
    method: Method
    status: Status
    last: Point
    cause: Cause
    sizes: tuple[float, ...] = ()
    """Largest size of each coordinate along the run, as far as it is recorded."""

    @property
    def slides(self) -> bool:
        """Whether the run slides along a surface."""
        return self.last.mode >= len(self.system.laws.regions)


def ending_of(run: Run) -> Ending:
    """How a run has ended."""
    return Ending(run.system, run.method, run.status, run.last, cause_of(run))


def cause_of(run: Run) -> Cause:
    """Why a run has ended."""
    remarks = run.log.remarks()
    if run.status is Status.COMPLETED and not remarks:
        return _AS_ASKED
    event = run.log.last if run.status is Status.EVENT else ""
    return Cause(
        _step_length(run),
        run.growth,
        run.why_cornered,
        *_singular(run),
        run.jumps_here,
        event,
        run.status is Status.ZENO and int(run.record["chain"][0]) > _AT_ONCE,
        remarks,
        run.settings.shift,
        run.pole,
        _steps_left(run),
    )


def _singular(run: Run) -> tuple[str, bool]:
    """Which expression vanishes in the step ahead, as a clause, and whether the field has a limit there."""
    if run.status not in (Status.SINGULAR, Status.ESCAPED) or run.met is None:
        return "", False
    singularity, h = run.met
    removable = not run.system.laws.mode(run.mode).is_singular_with(run.system.values, singularity.zero)
    return f"{to_text(singularity.zero)} vanishes on the way to t = {run.t + h:.12g}", removable


def outcome(end: Ending) -> str:
    """Where a run ended, why, and what to do about it."""
    status, last = end.status, end.last
    digits = 7 if status is Status.GRAZING else 12  # g is flat there, and its rounding hides the rest of the time
    where, remarks = f"t = {last.t:.{digits}g}", " ".join(end.cause.remarks)
    if status is Status.COMPLETED:
        return f"{where}: {status.reason}. {remarks}".strip()
    places = zip(end.system.variables, last.x, strict=True)
    # Where crossings accumulate, what decreases from one to the next ends as round-off; elsewhere it may be meant.
    sizes = end.sizes if status is Status.ZENO and end.sizes else (0.0,) * len(last.x)
    where += ", " + ", ".join(_coordinate(*place, size) for place, size in zip(places, sizes, strict=True))
    return " ".join(filter(None, (f"{where}: {reason(end)}.", _advice(end), remarks)))


def _coordinate(name: str, value: float, size: float) -> str:
    """The value of a coordinate, of which the largest along the run is of this size."""
    return f"{name} = 0 up to rounding" if 0.0 < abs(value) <= _ROUNDING * size else f"{name} = {value:.6g}"


def reason(end: Ending) -> str:
    """Why a run ended."""
    if end.status is Status.ESCAPED and end.cause.growth is Growth.LARGE:
        return f"the numerical solution grows beyond {BOUND:.0e}, up to which a run takes its numbers".replace("+", "")
    if end.status is Status.ESCAPED and end.cause.growth is None and not end.cause.singular:
        return "the solution grows beyond bounds within a few steps from here, and the next step cannot be made"
    if end.cause.circles:
        return "the run goes from region to region here in no time: each one entered ends at once, without end"
    if end.status is Status.CORNER:
        why = end.cause.why_cornered
        return str(why) if why == BEYOND.reason else f"{end.status.reason}, and {why}"
    if end.status is Status.SLIDING and end.cause.jumped:
        return "the field does not lead away from the surface after the jump, so the state stays there"
    if end.status is Status.ESCAPED and math.isfinite(end.cause.pole):
        return (
            f"the solution seems to have a pole at about t = {end.cause.pole:.9g}, and steps get shorter without end "
            "on the way there"
        )
    if found := _ahead(end):
        return found.reason
    if _moved_astray(end):
        return "a perturbed crossing has moved the state beyond another surface, or through a wall"
    if found_there := _at_surface(end):
        return found_there.reason
    if end.status is Status.EVENT:
        return f"the event {end.cause.event!r} took place, which ends the run"
    if _lacks_psi(end):
        return "the next step has no solution, since ψ is not defined here and the method keeps it"
    if end.cause.removable:
        return f"the next step passes a place where the field is 0/0: {end.cause.singular}"
    if end.cause.singular:
        return f"{end.status.reason}: {end.cause.singular}"
    return end.status.reason_while_sliding if end.slides else end.status.reason


def _advice(end: Ending) -> str:
    """What to do; where a field is not defined ahead, to write it differently."""
    status, last, laws = end.status, end.last, end.system.laws
    if end.cause.circles:
        return "Declare the laws so that a region entered here does not end at once."
    if found := _ahead(end):
        return found.advice
    if _moved_astray(end):
        return f"Perturb crossing times by less than {abs(end.cause.shift):.3g}, or take a smaller tau."
    if end.cause.why_cornered == BEYOND.reason:
        return "Begin between them, and let each jump lead beyond one of them at most."
    if status is Status.UNDECLARED and end.cause.shift:
        by = f"{abs(end.cause.shift):.3g}"
        return f"{_plain_advice(end)} If a perturbed crossing, by {by}, has moved it there: perturb by less."
    if end.cause.removable:
        return (
            "With these values of the parameters the field has a limit there, with others it has none: write it "
            "without the factor that numerator and denominator have in common."
        )
    if status is Status.NO_CONVERGENCE and (term := overflowing(end.system, last, end.method.conservative)):
        return (
            f"{term}, or a power of it, is too large for a floating-point number here: write the law, or ψ, without "
            "it, as (1 + tanh(u/2))/2 for 1/(1 + exp(-u)), or take a method that needs neither its derivatives nor ψ "
            "(rk8)."
        )
    if edge := _edge(end):
        advice = (
            f"{edge} has values on one side of this time only, and rounding decides on which a step begins: write it "
            "so that it has values on both, as ((t - a)**2)**0.25 for sqrt(t - a)."
        )
        return f"{advice} There it has no Taylor series: take rk8, too." if end.method.adaptive else advice
    if (ahead := _UNDEFINED_WITHIN.get(status, 0.0)) and last.mode != NO_MODE and not end.slides:
        name = laws.name(last.mode)
        if ends_beyond(end.system, name, last.t, np.array(last.x), ahead * end.cause.step):
            return (
                f"{_field(end)} is not defined a step ahead. If that is beyond the surface, write it so that it has a "
                "value there too: (u**2)**0.75 for u**1.5."
            )
    if _lacks_psi(end):
        others = ", ".join(name for name, one in METHODS.items() if not one.conservative)
        return f"Take a method that does without ψ ({others})."
    if status is Status.NO_CONVERGENCE and (zeros := _zeros_of_mode(end)):
        ends = f"The field has no value where {zeros} vanishes: a solution that comes there may end."
        return f"{ends} {_plain_advice(end)}"
    if status is Status.NO_CONVERGENCE and (zeros := _zeros_of_noise(end)):
        return (
            f"The field is 0/0 where {zeros} vanishes, and beside such a place rounding leaves no digit of it: write "
            f"the quotient so that it has a value there. {_plain_advice(end)}"
        )
    if unlike := _unlike_sizes(end):
        others = ", ".join(
            name for name, one in METHODS.items() if one.conservative and one.family != end.method.family
        )
        return (
            f"The step is changed as little as keeping psi allows, in the units of the variables, and {unlike}: write "
            f"the system in units in which all are of about one size, or take another method that keeps psi ({others})."
        )
    if end.cause.left:
        return (
            f"Steps have become so short that {end.cause.left:.0e} more would lead to the end time. The solution seems "
            "to vary ever faster, as before a pole: end the run earlier."
        ).replace("+", "")
    if math.isfinite(end.cause.pole):
        return "End the run before it."
    if status is Status.ESCAPED and end.cause.growth is Growth.LARGE:
        return "The exact one grows, too, and no pole was found up to there: end the run before."
    if found_there := _at_surface(end):
        return found_there.advice
    if status is Status.SLIDING and laws.jumps:
        return "A system with a jump does not slide here: continue it with another system."
    if status in (Status.CORNER, Status.GRAZING) and end.slides:
        return status.advice_while_sliding
    return _plain_advice(end)


def _field(end: Ending) -> str:
    """The field of the region where a run ended, as it was declared."""
    laws, number = end.system.laws, end.last.mode
    return ("f_minus", "f_plus")[number] if laws.two_sided else f"the field of region {laws.name(number)!r}"


def _edge(end: Ending) -> str:
    """The field in whose mode no step could be made since it ends or begins at that time; '' if that is not so."""
    last, laws = end.last, end.system.laws
    if end.status is not Status.NO_CONVERGENCE or end.slides or last.mode == NO_MODE:
        return ""
    return _field(end) if ends_here(end.system, laws.name(last.mode), last.t, np.array(last.x)) else ""


def _plain_advice(end: Ending) -> str:
    return end.status.advice_without_tau if end.method.adaptive else end.status.advice


def _moved_astray(end: Ending) -> bool:
    """Whether the state lies beyond a surface because crossings are perturbed."""
    if end.cause.shift == 0.0:
        return False
    return end.status is Status.CONTRADICTION or (end.status is Status.NO_CONVERGENCE and _lies_beyond(end))


def _lies_beyond(end: Ending) -> bool:
    """Whether a guard of the region in which the run ended is negative there, by more than its rounding."""
    last, system = end.last, end.system
    if last.mode == NO_MODE or end.slides:
        return False
    wanted = with_roundings(system.laws.mode(last.mode).heights)
    values = system.laws.evaluate(
        ("heights at the end", last.mode), wanted, [last.t], [last.x], system.parameter_array
    )[0]
    heights, noise = np.split(values, 2)
    return bool((heights < -_ROUNDING * noise).any())


def _lacks_psi(end: Ending) -> bool:
    """Whether a step of a method that keeps ψ fails where a ψ of the region is not defined."""
    last, laws = end.last, end.system.laws
    fails = end.status is Status.NO_CONVERGENCE and end.method.conservative
    if not fails or end.slides or last.mode == NO_MODE:
        return False
    return not bool(np.isfinite(end.system.conserved(laws.name(last.mode), last.t, np.array(last.x))).all())


def _unlike_sizes(end: Ending) -> str:
    """Which variable is how much larger than another, where a least change of the step means a change of the small."""
    last, laws = end.last, end.system.laws
    if end.status is not Status.NO_CONVERGENCE or not end.method.needs_conserved or last.mode == NO_MODE:
        return ""
    mode = laws.mode(last.mode)
    if not mode.conserved or mode.discrete.factor is not None:
        return ""
    sizes = np.maximum(np.abs(last.x), end.sizes or 0.0)
    known = np.flatnonzero(sizes > _ROUNDING * sizes.max())
    small, large = (int(known[choose(sizes[known])]) for choose in (np.argmin, np.argmax)) if known.size else (0, 0)
    ratio = sizes[large] / sizes[small] if known.size else 1.0
    names = end.system.variables
    if ratio <= _UNLIKE:
        return ""
    return f"{names[large]} is about {float(f'{ratio:.0g}'):,.0f} times as large as {names[small]}"


def _zeros_of_mode(end: Ending) -> str:
    """The expressions at whose zeros the field of the mode is not bounded."""
    found = () if end.last.mode == NO_MODE else end.system.laws.mode(end.last.mode).singularities
    return " or ".join(to_text(singularity.zero) for singularity in found)


def _zeros_of_noise(end: Ending) -> str:
    """The expressions near whose zeros the field of the mode loses its digits."""
    found = () if end.last.mode == NO_MODE else end.system.laws.mode(end.last.mode).zeros.noisy
    return " or ".join(map(to_text, found))


def _ahead(end: Ending) -> Ahead | None:
    """What is known of the step ahead that could not be made; None where another cause is known."""
    fails = end.status in _FAILS_AHEAD or (end.status is Status.ESCAPED and end.cause.growth is None)
    if (
        not fails
        or end.cause.singular
        or math.isfinite(end.cause.pole)
        or (end.slides and end.status is Status.GRAZING)
    ):
        return None
    return what_is_ahead(end.system, end.last, end.cause.step)


def _at_surface(end: Ending) -> AtSurface | None:
    """What is known where a run ends at a surface as if it touched it; None if it may touch it."""
    if end.status is not Status.GRAZING or end.slides:
        return None
    return at_surface(end.system, end.last, forward=math.copysign(1.0, end.cause.step) > 0.0)


def _steps_left(run: Run) -> float:
    """Number of steps left at a limit of steps, if they are so short that a higher limit does not help; else 0."""
    if run.status is not Status.STEP_LIMIT or not run.method.adaptive or not run.recent < SHORTER * run.longest:
        return 0.0
    left = abs(run.t_end - run.t) / run.recent
    return left if left > _HIGHER * run.settings.max_steps else 0.0


def _step_length(run: Run) -> float:
    """Signed length of a step; for a variable-step method, of its longest."""
    length = run.settings.tau if math.isfinite(run.settings.tau) else run.longest
    return math.copysign(length, run.direction)
