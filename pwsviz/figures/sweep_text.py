"""A bifurcation diagram in words, and its table of the values whose runs end early."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from core import Status
from pwsviz.figures.colours import GREY
from pwsviz.figures.section_prospects import examples_of, prospects, reset_words
from pwsviz.figures.stability_outcomes import OUTCOMES, Outcome
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.section_crossings import is_one_way, may_slide
from pwsviz.geometry.section_plane import TURN, angles, coordinate_label
from pwsviz.results.requests import SweepInputs
from pwsviz.results.sweeps import NO_CROSSING, NO_START, Diagram
from pwsviz.scene.names import met_at_surfaces, readable, short_name
from pwsviz.scene.sweeping import USUAL_DISCARD
from pwsviz.text.numbers import printed
from pwsviz.text.tables import Numbers
from pwsviz.text.words import FEW, at_surface, listed, plural

__all__ = [
    "SUMMARY",
    "coordinate_name",
    "ending",
    "examined_words",
    "growth_words",
    "of_examined",
    "parameter_name",
    "period_of",
    "stretches",
    "stretches_of",
    "surface_words",
    "sweep_details",
    "sweep_how",
    "sweep_numbers",
    "sweep_prospects",
    "sweep_text",
]  # fmt: skip

SUMMARY = "Bifurcation diagram: points that runs leave on a surface, against a parameter"
"""What the figure shows, for screen readers."""

GROWTH = (
    "Where small errors grow, as in chaos, single points are not those of the exact solution, but the set that they "
    "fill may be."
)
"""What the points mean there."""

TOO_FEW = Outcome("fewer points than requested", GREY)
"""Of a run that reaches the end time before it has all its points."""

NEVER = Outcome("no crossing", "#64748b")
"""Of a run that reaches the end time and has met no surface."""

LONGEST_PERIOD = 64
"""Most points after which those of a value are said to repeat."""

SAME = 1e-6
"""Distance of two points that are the same, relative to the height of the diagram."""

MOST_STRETCHES = 3
"""Most stretches of values that the table lists of one outcome."""


def parameter_name(inputs: SweepInputs) -> str:
    """Return the symbol of the parameter."""
    names = (short_name(q) for q in inputs.problem.declaration.parameters if q.name == inputs.parameter)
    return next(names, inputs.parameter)


def coordinate_name(inputs: SweepInputs) -> str:
    """Return the name of the coordinate as it is shown."""
    return coordinate_label(inputs.problem.declaration, inputs.column)


def of_examined(found: Diagram, some: Floats) -> str:
    """Return how many of the runs examined are those at some values."""
    return f"{len(some):,} of {plural(len(found.examined), 'run')} examined"


def growth_words(found: Diagram) -> str:
    """Return what the points mean where small errors grow; empty where they do not in any run examined."""
    return GROWTH * bool(len(found.sensitive))


def examined_words(found: Diagram) -> str:
    """Return which runs are examined, in which small errors grow, and which are in doubt; empty where none are."""
    if not len(found.examined):
        return ""
    which = "those whose rates of change differ most from step to step, and others all over the range"
    words = f"Of the {plural(int(found.done.sum()), 'run')}, {len(found.examined):,} were examined for errors: {which}"
    if not len(found.warned) and not len(found.sensitive):
        return f"{words}. No sign of an error was found in them."
    words += f", more of them beside those {'in doubt' if len(found.warned) else 'in which small errors grow'}."
    if len(found.warned):
        at = _at(found, found.warned)
        words += f" Dotted lines mark these, shaded in between: all that were examined {at}."
    if len(found.sensitive):
        words += f" Small errors grow in all that were examined {_at(found, found.sensitive)}."
    return words


def _at(found: Diagram, some: Floats) -> str:
    """Return in words the stretches in which all runs examined are those at some values."""
    name = parameter_name(found.inputs)
    parts = [" to ".join(map(found.told, dict.fromkeys(ends))) for ends in stretches_of(found, some)]
    return f"at {name} = {listed(parts)}" if len(parts) <= FEW else f"in {len(parts)} stretches of {name}"


def stretches_of(found: Diagram, some: Floats) -> list[tuple[float, float]]:
    """Return the first and the last value of each stretch in which all runs examined are those at some values."""
    parts = np.split(found.examined, np.flatnonzero(np.diff(np.isin(found.examined, some))) + 1)
    return [(float(part[0]), float(part[-1])) for part in parts if len(part) and part[0] in some]


def ending(code: int) -> Outcome:
    """Return words and colour for how a run ends before it has all its points; `NO_START` if it cannot begin."""
    if code == NO_START:
        return Outcome("no run begins here", "#404040")
    if code in (Status.COMPLETED, NO_CROSSING):
        return TOO_FEW if code == Status.COMPLETED else NEVER
    return OUTCOMES.get(code, Outcome(Status(code).reason, GREY))


def stretches(found: Diagram) -> Iterator[tuple[int, int, int]]:
    """Yield (outcome, first, last) for each stretch of values, by their numbers, whose runs end early in one way.

    Values that are still to come belong to none.
    """
    code: NDArray[np.int64] = np.where(found.done & ~found.whole, found.outcomes, Status.RUNNING)
    for piece in np.split(np.arange(len(code)), np.flatnonzero(np.diff(code)) + 1):
        if code[piece[0]] != Status.RUNNING:
            yield int(code[piece[0]]), int(piece[0]), int(piece[-1])


def period_of(points: Floats, height: float, turn: float = math.inf, least: float = 0.0) -> int:
    """Return after how many points they repeat, to `SAME` times a height or `least`, which is more; 0 if they do not.

    A period counts if it is seen twice at least. Points a full turn apart are the same.
    """
    for period in range(1, min(LONGEST_PERIOD, len(points) // 2) + 1):
        away = np.abs(points[period:] - points[:-period])
        if np.minimum(away, turn - away).max() <= max(SAME * height, least):
            return period
    return 0


def approached(points: Floats, turn: float = math.inf) -> int:
    """Return the length of the cycle that points come closer to each time; 0 if they do to none."""
    for period in range(1, min(LONGEST_PERIOD, len(points) // 4) + 1):
        away = np.abs(points[period:] - points[:-period])
        away = np.minimum(away, turn - away)
        if (away[period:] < away[:-period]).all():
            return period
    return 0


def sweep_text(found: Diagram, present: float, chosen: Diagram | None = None) -> str:
    """Return in words what the diagram shows at the chosen value of the parameter, and why it may show little.

    Parameters
    ----------
    found
        The diagram.
    present
        The chosen value.
    chosen
        The points of that value alone, if they are computed.
    """
    said = _at_present(found, present, chosen), _nothing_left(found), _accumulating(found), _refusal(found)
    return " ".join(filter(None, said))


def sweep_prospects(found: Diagram, shown: str) -> str:
    """Return what may be expected of the points, or which examples show more; `shown` is the title of this one."""
    done, whole = int(found.done.sum()), int(found.whole.sum())
    hope = prospects(found.inputs.problem.declaration, "sweep", shown) if found.counts.any() or not done else ""
    return hope or examples_of("sweep", shown) * (2 * whole < done)


def sweep_details(found: Diagram) -> str:
    """Return in words what is plotted, how many values have all their points, and which runs were examined."""
    inputs = found.inputs
    done, whole = int(found.done.sum()), int(found.whole.sum())
    words = (
        f"{plural(int(found.counts.sum()), 'point')}: {coordinate_name(inputs)} on {_where(inputs)} "
        f"for {plural(done, 'value')} of {parameter_name(inputs)} from {inputs.low:.6g} to {inputs.high:.6g}."
    )
    found_all = f"The {plural(inputs.points, 'point')} requested were found for"
    if done and whole == done:
        words += f" {found_all} every value."
    elif done:
        words += f" {found_all} {f'{whole:,}' if whole else 'none'} of the {plural(done, 'value')}."
    if found.sparse:
        few = f"have at most {USUAL_DISCARD} points, or points that have faded to 0 by then"
        words += f" No transient is discarded: most runs that meet the surface {few}."
    return f"{words} {examined_words(found)}".strip()


def _at_present(found: Diagram, present: float, chosen: Diagram | None) -> str:
    """Say whether the points at the chosen value repeat, or where there are none of it, at the nearest one."""
    name = parameter_name(found.inputs)
    if chosen is not None and chosen.whole.all():
        return _repeats(found, chosen, present, f"At {name} = {present:.6g}")
    there = np.flatnonzero(found.whole)
    if not len(there) or not found.values[0] <= present <= found.values[-1]:
        return ""
    nearest = found.values[there[np.abs(found.values[there] - present).argmin()]]
    if abs(nearest - present) > found.spacing:
        return ""
    beside = "the swept value nearest to " * bool(nearest != present)
    return _repeats(found, found, float(nearest), f"At {beside}{name} = {present:.6g}")


def _repeats(found: Diagram, among: Diagram, value: float, at: str) -> str:
    """Say whether the points at a value repeat, which are `among` others, beside the height of all that are found."""
    points = among.points_at(value)
    inputs = found.inputs
    spread = [(part.y.min(), part.y.max()) for part in found.portions if len(part.y)]
    if len(points) < 2 or not spread:  # at first only those of the chosen value may be there
        return ""
    height = max(high for _, high in spread) - min(low for low, _ in spread) or 1.0
    if value in among.warned:
        return f"{at} no period is stated: the run is in doubt."
    if len(doubt := among.doubtful_beside(value)):
        values = listed(list(map(found.told, doubt)))
        return f"{at} no period is stated: the nearest runs examined, at {values}, are in doubt."
    turn = TURN if inputs.column in angles(inputs.problem.declaration) else math.inf
    if (period := period_of(points, height, turn, found.round_off)) == 1:
        if np.abs(points).max() <= found.round_off:
            return f"{at} all points are 0 up to round-off."
        return f"{at} all points are the same: {points[-1]:.6g}."
    if period:
        declared = inputs.problem.declaration
        both = not inputs.direction and not is_one_way(declared, inputs.of)
        of = ", of crossings in both directions" * both or ", of all surfaces together" * (
            not inputs.of and len(declared.laws.surfaces) > 1
        )
        return f"{at} the points have period {period}{of}."
    if period := approached(points, turn):
        return f"{at} the points still approach {'a limit' if period == 1 else f'a cycle of {period}'}."
    least = min(LONGEST_PERIOD, len(points) // 2)
    if among.is_sensitive(value):
        return f"{at} no period up to {least} was found, and small errors grow: the motion may be chaotic."
    cause = "the transient or the period may be longer, or the motion quasi-periodic or chaotic"
    return f"{at} no period up to {least} was found: {cause}."


def _accumulating(found: Diagram) -> str:
    """Say that jumps may accumulate at further values than those of the table: there, after the points wanted."""
    if not found.whole.any() or not (found.outcomes[found.done & ~found.whole] == Status.ZENO).any():
        return ""
    wanted = plural(found.inputs.points, "point")
    return f"Where jumps accumulate only after the {wanted} wanted, the run ends with these and is not in the table."


def _refusal(found: Diagram) -> str:
    return f"Where no run begins: {found.refusal.rstrip('.')}." if found.refusal else ""


def _nothing_left(found: Diagram) -> str:
    """Say why most values have no point, if all were left out."""
    none = found.done & (found.counts == 0) & ~np.isin(found.outcomes, (NO_START, NO_CROSSING))
    if 2 * none.sum() <= found.done.sum() or not found.inputs.discard:
        return ""
    crossings = plural(found.inputs.discard, "crossing")
    longer = (found.outcomes[none] == Status.COMPLETED).any()
    do = "discard fewer, or let runs last longer, unless they have come to rest" if longer else "discard fewer"
    who = "No run has" if not found.counts.any() else f"For {none.sum():,} of the values no run has"
    return f"{who} more than the {crossings} discarded first: {do} (“more”)."


def _where(inputs: SweepInputs) -> str:
    """Return the surface, set off by a comma if it is more than a name, and which states its points are."""
    words = surface_words(inputs) + reset_words(inputs.problem.declaration, inputs.of)
    return f"{words}," if "," in words else words


def surface_words(inputs: SweepInputs) -> str:
    """Return the surface of the section, as “S where g decreases”."""
    declared = inputs.problem.declaration
    if not inputs.of:
        several = ("any of the surfaces gᵢ = 0", "gᵢ") if declared.surfaces else ("any of the surfaces", "its function")
        name, g = ("S", "g") if declared.two_sided else several
    else:
        name, g = f"the surface {readable(inputs.of, declared)} = 0", "the function"
    return name + {0: "", 1: f" where {g} increases", -1: f" where {g} decreases"}[inputs.direction]


def sweep_how(inputs: SweepInputs) -> str:
    """Return how a diagram was made, for files and captions."""
    scheme, name, system = inputs.scheme, parameter_name(inputs), inputs.problem.declaration
    slides = scheme.slide and may_slide(system)
    crossings = at_surface(met_at_surfaces(system), scheme.locate, slides)
    sliding = ", and where sliding begins on it" if slides and not inputs.of else ""
    begins = {
        "none": "each run begins at the initial state",
        "up": "each run begins where that of the next smaller value ends",
        "down": "each run begins where that of the next greater value ends",
    }[inputs.continuation]
    shown = f"at most {plural(inputs.points, 'point')}"
    if inputs.discard:
        shown = f"the first {inputs.discard:,} points of each run are discarded, and at most the next {inputs.points:,}"
    step = f"step size τ = {inputs.tau:.15g}" if scheme.tolerance is None else f"tolerance {scheme.tolerance:.3g}"
    return printed(
        f"values of {coordinate_name(inputs)} where the runs meet "
        f"{surface_words(inputs)}{reset_words(system, inputs.of)}{sliding}, for {inputs.values:,} values of {name} "
        f"from {inputs.low:.15g} to {inputs.high:.15g}: {shown} "
        f"(t ≤ {inputs.t_end:,.6g}) are plotted; {begins}; integrated by {scheme.method} with {step}; "
        f"{crossings}"
    )


def sweep_numbers(found: Diagram) -> Numbers:
    """Return how many values end early in which way, and where; no rows if none does."""
    name, places = parameter_name(found.inputs), dict[int, list[tuple[int, int]]]()
    for code, first, last in stretches(found):
        places.setdefault(code, []).append((first, last))
    early = found.done & ~found.whole
    counts = {code: int((early & (found.outcomes == code)).sum()) for code in places}
    rows = tuple(
        (_words(code, found.inputs), f"{counts[code]:,}", _places(found.values, places[code]))
        for code in sorted(places, key=lambda code: -counts[code])
    )
    return Numbers(("incomplete runs", "values", name), rows)


def _words(code: int, inputs: SweepInputs) -> str:
    words = ending(code).words
    return f"{words} by t = {inputs.t_end:.6g}" if code in (Status.COMPLETED, NO_CROSSING) else words


def _places(values: Floats, found: list[tuple[int, int]]) -> str:
    """Return stretches of values, the longest of many."""
    longest = sorted(sorted(found, key=lambda one: one[0] - one[1])[:MOST_STRETCHES])
    said = [
        f"{values[first]:.4g}" if first == last else f"{values[first]:.4g} to {values[last]:.4g}"
        for first, last in longest
    ]
    more = len(found) - len(longest)
    return "; ".join(said) + (f"; and {more:,} further" if more else "")
