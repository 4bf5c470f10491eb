"""Texts beside the figures: on runs, on order studies, on methods that are left out."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from html import escape

import core
from core.studies import FIT_ABOVE, FIT_BELOW
from pwsviz.figures.colours import on_either_ground
from pwsviz.figures.lines import line_of
from pwsviz.figures.order import Row, Studied, limits, lower_end
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import has_bare
from pwsviz.results.run_summary import Summary
from pwsviz.results.studies import STUDY_CROSSINGS
from pwsviz.scene.scene import Scene
from pwsviz.text.numbers import printed
from pwsviz.text.words import as_text, duration, listed, plural, rounded, sentences

TIMED = 0.01
"""Seconds of a run from which on its time is told: a shorter one, taken once, would mislead. The view Cost repeats."""

DOT = 10
"""Size in pixels of a dot in the colour of an integrator."""


def run_line(summary: Summary, warned: bool = False) -> str:
    """Return the figures of one run, such as “dmm2: 2,000 steps, 21 crossings, max |Δψ| = 8.2e-16”.

    If `warned`, or if the run ends early, they refer to the words above, which a projector may show in part.
    """
    figures = f"{plural(summary.steps, 'step')}, {summary.course}"
    if summary.status is not core.Status.COMPLETED:
        figures += f", ends at t = {summary.t_end:.4g} (see above)"
    if summary.seconds >= TIMED:
        figures += f", {duration(summary.seconds)}"
    if math.isfinite(summary.worst_error):
        figures += f', <span style="white-space: nowrap">max |Δψ| = {rounded(summary.worst_error)}</span>'
    figures += " (see the warning)" * warned
    colour = line_of(summary.method).colour
    return f'<div class="run">{dot(colour)}<span><b>{escape(summary.method)}</b>: {figures}</span></div>'


def run_lines(summaries: Sequence[Summary], warnings: Sequence[str] = ()) -> str:
    """Return a line for each run, with its figures."""
    said = [*warnings, *[""] * len(summaries)]
    return "".join(run_line(each, bool(words)) for each, words in zip(summaries, said, strict=False))


def run_warnings(summaries: Sequence[Summary], warnings: Sequence[str] = ()) -> str:
    """Return, for each reason to stop, the message of the first run that stopped for it, and the warning of each run.

    The messages name their integrators and come in the order of the runs. A sentence that several of them end with,
    such as an advice, stands once.
    """
    stopped: dict[str, list[Summary]] = {}
    for each in summaries:
        if each.status is not core.Status.COMPLETED:
            reason = each.message.partition(": ")[2]  # after the time and the state
            stopped.setdefault(reason, []).append(each)
    reasons = [_reason(*group) for group in stopped.values()]
    warned = [f"{each.method}: {words}" for each, words in zip(summaries, warnings, strict=False) if words]
    return "".join(as_text(words, "stopped") for words in _said_once([*reasons, *warned]))


def _said_once(paragraphs: Sequence[str]) -> Iterator[str]:
    """Yield paragraphs, each without the sentences after its first that one before it has."""
    known: set[str] = set()
    for paragraph in paragraphs:
        first, *others = sentences(paragraph)
        yield " ".join([first, *(words for words in others if words not in known)])
        known.update(others)


def run_words(summaries: Sequence[Summary]) -> str:
    """Say in a sentence of each run how it went, such as “dmm2: 21 crossings, end time reached.”."""
    said = (
        one.message or f"{', '.join(filter(None, (one.course, _drift(one), 'end time reached')))}." for one in summaries
    )
    return printed(" ".join(f"{one.method}: {words}" for one, words in zip(summaries, said, strict=True)))


def _drift(one: Summary) -> str:
    """Return how far ψ has drifted, if that is known."""
    return f"max |Δψ| = {rounded(one.worst_error)}" if math.isfinite(one.worst_error) else ""


def _reason(first: Summary, *others: Summary) -> str:
    """Say where and why a run stopped, and which others stopped for the same reason."""
    likewise = f" Likewise {listed([f'{one.method} at t = {one.t_end:.4g}' for one in others])}." if others else ""
    return f"{first.method}: {first.message}{likewise}"


def dot(colour: str) -> str:
    """Return a dot in the colour of an integrator, as SVG."""
    return (
        f'<svg width="{DOT}" height="{DOT}" viewBox="0 0 2 2" aria-hidden="true">'
        f'<circle cx="1" cy="1" r="1" fill="{colour}" style="fill: {on_either_ground(colour)}"/></svg>'
    )


def slopes_text(shown: Sequence[Studied]) -> str:
    """Return the slopes of an order plot in words; those of several integrators stand in a table."""
    if len(shown) > 1:
        return ""
    alike: dict[str, list[Row]] = {}
    for row in shown[0].rows:
        alike.setdefault(row.slope_text, []).append(row)
    return f"{shown[0].method}: {'; '.join(f'{slope} {_all_where(rows)}' for slope, rows in alike.items())}."


def all_slopes_text(shown: Sequence[Studied]) -> str:
    """Return the slopes of several integrators, curve by curve, in a sentence; of a single one the legend has them."""
    if len(shown) < 2:
        return ""
    each = [f"{one.method} {', '.join(row.slope_number for row in one.rows)}" for one in shown]
    return f"Fitted slopes {_all_where(shown[0].rows)}: {'; '.join(each)}."


def _all_where(rows: Sequence[Row]) -> str:
    """Return where errors of several curves are taken: “before the first crossing and after 10 and 20 crossings”."""
    first = [row.name for row in rows if not row.crossing]
    numbers = [row.crossing for row in rows if row.crossing]
    if any(map(_of_time, rows)):
        return f"for {numbered_crossings(numbers)}"
    later = [f"after {listed(list(map(str, numbers)))} crossing{'s' * (numbers != [1])}"] * bool(numbers)
    return " and ".join([*first, *later])


def study_text(shown: Sequence[Studied], early: bool) -> str:
    """Return with what an order plot is compared, and what its slopes are fitted to.

    Parameters
    ----------
    shown
        What the plot shows.
    early
        Whether a trajectory has too few crossings to look at the usual ones.
    """
    words = f"Reference: {listed(list(dict.fromkeys(one.reference for one in shown)))}."
    words += f" {fit_rule(shown)}."
    if early:
        usual = listed([str(k) for k in STUDY_CROSSINGS])
        others = "earlier ones are used" if any(row.crossing for one in shown for row in one.rows) else "none is used"
        words += f" The trajectory has too few crossings for the usual ones, {usual}: {others}."
    return words


def study_times(study: core.OrderStudy, states: bool, slides: bool, met: str = "crossings") -> str:
    """Return at which times an order study compares, and what it counts as crossings; empty before that is known.

    Parameters
    ----------
    states
        Whether states are compared, or else times of crossings.
    slides
        Whether the trajectory slides.
    met
        What it meets: crossings, jumps or both.
    """
    if not math.isfinite(study.times[-1]):
        return ""
    counted = numbered_crossings(study.crossings)
    if states:
        words = (
            "‖x − x*‖₂ is the Euclidean distance between the states of the run and of the reference, "
            f"at {_instants(study)}"
        )
    else:
        words = (
            f"t* and t̂ are the crossing times of the reference and of the run, for {counted} of runs to "
            f"t = {study.times[-1]:.4g}"
        )
    counted_too = ["jumps"] * ("jumps" in met) + ["the beginning and the end of sliding"] * slides
    return words + f"; {listed(counted_too)} count as crossings" * bool(counted_too) + "."


def _instants(study: core.OrderStudy) -> str:
    """Return in words when states are compared."""
    first, *later = (f"{t:.4g}" for t in study.times)
    if not later:
        return f"t = {first}, up to which there is no crossing"
    after = f"halfway from {numbered_crossings(study.crossings)} to the next (“after”)"
    if study.until is not None:
        after = "after the only crossing up to then"
    return f"t = {first}, halfway to the first crossing (“before”), and at t = {listed(later)}, {after}"


def numbered_crossings(crossings: Sequence[int]) -> str:
    """Return “crossing 1”, or “crossings 10, 20 and 30”."""
    return f"crossing{'s' * (len(crossings) > 1)} {listed([str(k) for k in crossings])}"


def fit_rule(shown: Sequence[Studied]) -> str:
    """Return which errors enter the fits, or of which there are too few."""
    drawn = [(f"to {one.method} " * (len(shown) > 1) + _where(row), row) for one in shown for row in one.rows]
    without: dict[str, list[str]] = {}
    for name, row in drawn:
        if not math.isfinite(row.slope):
            without.setdefault(_why_no_slope(row), []).append(name)
    between = _bounds(shown)
    if [len(drawn)] == [len(names) for names in without.values()]:
        (why,) = without
        none = f"No slope is fitted, as {why}" + f" {between}" * (why == _TOO_FEW)
        return ". ".join([none, *_not_drawn(drawn, lower_end(shown))])
    if len(drawn) == sum(map(len, without.values())):
        each = [f"No slope is fitted {listed(names)}, as {why}" for why, names in without.items()]
        return ". ".join([*each, *_not_drawn(drawn, lower_end(shown))])
    fitted = [f"Slopes are least-squares fits to errors {between}", *_reach(shown)]
    fitted += [_IRREGULAR] * any("±" in row.slope_text for _, row in drawn)
    off = [name for name, row in drawn if row.is_off]
    fitted += [f"No line is drawn {listed(off)}, as the errors scatter about it"] * bool(off)
    reasons = [(names, why + " between these limits" * (why == _TOO_FEW)) for why, names in without.items()]
    unfitted = [f"No slope is fitted {listed(names)}, as {why}" for names, why in reasons]
    return ". ".join([*fitted, *unfitted, *_not_drawn(drawn, lower_end(shown))])


def all_fitted(shown: Sequence[Studied]) -> bool:
    """Whether each curve has a slope: then how they are fitted is of no concern to most."""
    return all(math.isfinite(row.slope) for one in shown for row in one.rows)


def _not_drawn(drawn: Sequence[tuple[str, Row]], end: float) -> Iterator[str]:
    """Yield why points or curves are missing, or at the lower end of the plot, if some are."""
    exact = [name for name, row in drawn if _is_zero(row)]
    if exact:
        yield f"The errors {listed([re.sub('^to ', 'of ', name) for name in exact])} are 0 and are not drawn"
    rest = [error for _, row in drawn if not _is_zero(row) for error in row.error]
    if any(error < end for error in rest):
        yield "Errors of 0 or below the plot’s range are drawn as downward triangles"
    if not all(map(math.isfinite, rest)):
        yield _GAPS


def _is_zero(row: Row) -> bool:
    """Whether all known errors of a curve are 0: it is not drawn, so that its gaps are not to be seen either."""
    known = [error for error in row.error if math.isfinite(error)]
    return bool(known) and not any(known)


_IRREGULAR = "Where the local slope is irregular, all errors between the limits are fitted; ± is the standard error"

_TOO_FEW = "too few errors lie"

_GAPS = "Points are missing where a run does not reach the time, or reaches it in fewer than four steps"


def _reach(shown: Sequence[Studied]) -> Iterator[str]:
    """Yield up to which step size errors are fitted, unless all between the limits are."""
    ends = [(row.window[1], _greatest(one.taus, row)) for one in shown for row in one.rows if math.isfinite(row.slope)]
    cut = [reached < greatest for reached, greatest in ends]
    if cut and all(cut):
        yield "Only step sizes below the one at which the local slope changes are fitted"
    elif any(cut):
        yield "Where the local slope changes, only smaller step sizes are fitted"


def _greatest(taus: Floats, row: Row) -> float:
    """Return the greatest step size whose error lies between the limits of a fit, but for rounding."""
    return float(taus[(row.error > row.fit_above) & (row.error < row.fit_below)].max(initial=0.0)) * (1 - 1e-9)


def _why_no_slope(row: Row) -> str:
    """Return the reason why a curve has no slope."""
    if row.at_round_off:
        return "all errors are near round-off, of the run or of the reference"
    return _TOO_FEW if any(map(math.isfinite, row.error)) else "no error is known"


def _bounds(shown: Sequence[Studied]) -> str:
    """Return between which errors a fit is made, and what these limits are; the lower may differ between curves."""
    rows = [row for one in shown for row in one.rows]
    found, below = limits(shown), rounded(min(row.fit_below for row in rows))
    size = f"{FIT_BELOW:g} times the largest |xᵢ| of the reference"
    of_times = f"{FIT_BELOW:g} times the mean time between crossings"
    upper = of_times if any(map(_of_time, rows)) else f"{size} at these times"
    lower = f"{FIT_ABOVE:g} times accumulated round-off or the error of the reference, whichever is larger"
    if found is None:
        return f"below {below} ({upper})"
    if found[0].fit_above == found[1].fit_above:
        return f"between {rounded(found[0].fit_above)} ({lower}) and {below} ({upper})"
    least, greatest = sorted(row.fit_above for row in found)
    between = f"above a limit between {rounded(least)} and {rounded(greatest)}, depending on the curve"
    return f"{between} ({lower}), and below {below} ({upper})"


def _where(row: Row) -> str:
    """Return to which errors a curve belongs: “after 10 crossings”, “for crossing 10”."""
    return f"for {row.name}" if _of_time(row) else row.name


def _of_time(row: Row) -> bool:
    """Return whether the errors of a curve are those of the time of a crossing."""
    return row.name.startswith("crossing")


def method_notes(scene: Scene) -> str:
    """Return which integrators conserve ψ, and which are left out of which studies, and why."""
    resting = [name for name in core.METHODS if name not in scene.offered]
    notes = []
    if scene.declaration.laws.most_conserved:
        keeping = listed([name for name in scene.offered if core.METHODS[name].conservative])
        exact = scene.locate and scene.perturbation_order is None
        where = f"{' between crossings' * (not exact)}{' where it is known' * has_bare(scene.declaration)}"
        notes.append(f"{keeping} conserve ψ to round-off{where}.")
    if resting:
        notes.append(f"{listed(resting)} need a conserved quantity; none is known here, so they are not offered.")
    if not set(scene.methods) & set(scene.used):
        notes.append(f"{scene.used[0]} is used in place of {listed(scene.methods)}.")
    for name in [name for name in scene.used if core.METHODS[name].adaptive]:
        lacks = "order to study"
        if scene.locate and scene.perturbation_order is not None:
            lacks += ", and no power of τ by which to perturb its crossing times"
        notes += [f"{name} chooses its own steps, none longer than τ: it has no {lacks}."]
    return as_text(" ".join(notes), "about")
