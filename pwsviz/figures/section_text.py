"""A Poincaré section in plain words, and as a table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import core
from core.integration import COMPARED
from pwsviz.figures.section_prospects import reset_words
from pwsviz.geometry.section_crossings import is_one_way, may_slide
from pwsviz.results.requests import SectionInputs
from pwsviz.results.sections import SectionPoints
from pwsviz.scene.names import as_met, met_at_surfaces, readable
from pwsviz.text.advice import on_page
from pwsviz.text.numbers import printed
from pwsviz.text.words import at_surface, listed, plural

__all__ = ["section_how", "section_rows", "section_text", "section_warnings", "surface_words"]

_WAYS = {0: "crossed in both directions", 1: "crossed upwards", -1: "crossed downwards"}
_NO_ZERO = {0: "change sign", 1: "rise through zero", -1: "fall through zero"}


def surface_words(inputs: SectionInputs) -> str:
    """Return where the points lie, as “S: g = 0, crossed in both directions”."""
    system = inputs.problem.declaration
    own = "S: g = 0" if system.two_sided else "all surfaces"
    at_instants = not inputs.of and len(system.laws.instants) == len(system.laws.surfaces)
    one_way = "at every instant" if at_instants else "met from one side only"
    way = one_way if is_one_way(system, inputs.of) else _WAYS[inputs.direction]
    if not inputs.of and inputs.scheme.slide and may_slide(system):
        way += ", or at which sliding begins"
    return f"{f'{readable(inputs.of, system)} = 0' if inputs.of else own}, {way}"


LATE = 0.9
"""Part of the time of a run before which its last point is worth a word."""

_AT_REST = "the motion has come to rest, up to round-off"
"""Of a start of which later points are left out."""


UNCOUNTED = (
    core.Status.SLIDING, core.Status.REPELLING, core.Status.GRAZING, core.Status.CORNER, core.Status.UNDECLARED,
)  # fmt: skip
"""Ends of runs at a surface that count neither as a crossing nor as a jump; where jumps accumulate, the last counts."""


def section_text(outcome: SectionPoints) -> str:
    """Return how many points there are, and of which starts there are fewer, and why."""
    counts, inputs = outcome.counts, outcome.inputs
    after = reset_words(inputs.problem.declaration, inputs.of)
    whose = f" of {len(counts)} starts" if len(counts) > 1 else ""
    words = [f"{plural(sum(counts), 'point')}{whose} on {surface_words(inputs)}{after}; {_integrated(outcome)}."]
    return " ".join([*words, *_short_ones(outcome), *_same_ones(outcome)])


def _same_ones(outcome: SectionPoints) -> Iterator[str]:
    """Yield of which starts the points are the same, up to errors, below which the axes show no differences."""
    same = [k for k in range(len(outcome.statuses)) if k not in outcome.at_rest and outcome.is_one_point(k)]
    if same:
        of = f" of {_called(same).lower()}" * (len(outcome.statuses) > 1)
        each = ", each by itself," * (len(same) > 1)
        yield printed(f"All points{of} are the same{each} up to errors (differences below {outcome.noise:.0e}).")


def section_warnings(outcome: SectionPoints) -> list[str]:
    """Return what is said against the step size, each with the starts of whose runs it is said."""
    starts: dict[str, list[int]] = {}
    for k, words in enumerate(outcome.warnings):
        starts.setdefault(words, []).append(k)
    several = len(outcome.warnings) > 1
    return [f"{f'{_called(which)}: ' * several}{words}" for words, which in starts.items() if words]


def _short_ones(outcome: SectionPoints) -> Iterator[str]:
    """Yield which starts have all points requested, if others do not, and when and why the runs of these ended."""
    counts, points = outcome.counts, outcome.inputs.points
    short: dict[tuple[str, bool], list[int]] = {}
    for k in outcome.short:
        if (status := outcome.statuses[k]) is not None:
            met = as_met(on_page(status.reason), met_at_surfaces(outcome.inputs.problem.declaration))
            reason = _AT_REST if k in outcome.at_rest else met
            short.setdefault((reason, counts[k] > 0), []).append(k)
    whole = sum(count == points for count in counts)
    if short and whole:
        yield f"{_number(whole)} all {points:,}."
    for (reason, _), which in short.items():
        yield _ended(outcome, reason, which)


def _number(count: int) -> str:
    return "One start has" if count == 1 else f"{count} starts have"


def _ended(outcome: SectionPoints, reason: str, which: list[int]) -> str:
    """Say of some starts, all with points or all without, that their runs ended early, and why."""
    inputs, counts = outcome.inputs, [outcome.counts[k] for k in which]
    by = f" by t = {outcome.ends[which[0]]:.6g}" * (len(which) == 1)
    found = f"{', '.join(f'{count:,}' for count in counts)} point{'s' * (counts != [1])}{by}"
    if len(which) == 1 and counts[0]:
        last, end = outcome.of_start(which[0]).t[-1], outcome.ends[which[0]]
        if last == end and outcome.statuses[which[0]] in UNCOUNTED:
            found += ", the last of them where it ends, which is neither a jump nor a crossing"
        elif last < LATE * end:
            found += f", the last at t = {last:.6g}"
    if not any(counts):
        found = f"no point{by}"
        if not inputs.discard:
            reason = f"{'h' if inputs.of else 'g'} does not {_NO_ZERO[inputs.direction]} on the way; {reason}"
    who = f"{_called(which)} {'has' if len(which) == 1 else 'have'}" if len(outcome.statuses) > 1 else "The run has"
    return f"{who} ended with {found}: {reason}."


def _called(which: list[int]) -> str:
    return f"Start{'s' * (len(which) > 1)} {listed([str(k + 1) for k in which])}"


def section_how(outcome: SectionPoints) -> str:
    """Return how the points were found, for files and captions."""
    inputs = outcome.inputs
    left = f", after the first {inputs.discard:,} are discarded" if inputs.discard else ""
    after = reset_words(inputs.problem.declaration, inputs.of)
    system = inputs.problem.declaration
    crossings = at_surface(met_at_surfaces(system), inputs.scheme.locate, inputs.scheme.slide and may_slide(system))
    by = f"{_integrated(outcome)}; {crossings}"
    return " ".join(
        [f"{_drawn(outcome)} on {surface_words(inputs)}{after}{left}; {by}.", *_short_ones(outcome)]
    ).rstrip(".")


def _integrated(outcome: SectionPoints) -> str:
    """Return by what, in which steps and up to when the runs are integrated."""
    scheme = outcome.inputs.scheme
    adaptive = scheme.tolerance is not None
    step = f"tolerance {scheme.tolerance:.3g}" if adaptive else f"step size τ = {outcome.inputs.tau:.15g}"
    first, last = (f"t = {end:,.4g}" for end in (min(outcome.ends), max(outcome.ends)))
    until = COMPARED * outcome.inputs.tau
    unseen = max(map(abs, outcome.ends)) > until and not adaptive
    examined = f" (errors examined up to t = {until:,.4g})" * unseen
    to = first if first == last else f"times from {first} to {last}"
    return f"integrated by {scheme.method} with {step} to {to}{examined}"


def _drawn(outcome: SectionPoints) -> str:
    """Return how many points of how many starts there are, and at most how many of each if these differ."""
    counts = outcome.counts
    total = plural(sum(counts), "point")
    if len(counts) == 1:
        return total
    each = f"{counts[0]:,} of each" if len({*counts}) == 1 else f"at most {outcome.inputs.points:,} of each"
    return f"{total} of {len(counts)} starts ({each})"


def section_rows(outcome: SectionPoints) -> dict[str, NDArray[Any]]:
    """Return a row for each point: start, point, t and the variables by name."""
    starts = [outcome.of_start(k) for k in range(len(outcome.statuses))]
    table: dict[str, NDArray[Any]] = {
        "start": np.concatenate([np.full(len(one.t), one.start + 1) for one in starts]),
        "point": np.concatenate([np.arange(1, len(one.t) + 1) for one in starts]),
        "t": np.concatenate([one.t for one in starts]),
    }
    x = np.concatenate([one.x for one in starts])
    return table | {name: x[:, k] for k, name in enumerate(outcome.inputs.problem.declaration.variables)}
