"""A stability study in words and in small tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Sized

import numpy as np

import core
from core.studies import ENDINGS, NOT_YET, UNCERTAIN, Drift, Grazing, LargestTau, OutcomeMap
from pwsviz.figures.marks import ENDS
from pwsviz.figures.stability_outcomes import OUTCOMES, outcomes_shown
from pwsviz.results.resting import ROUND_OFF
from pwsviz.results.studies import LIMITS_OF_TAU
from pwsviz.text.advice import on_page
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed
from pwsviz.text.tables import Numbers
from pwsviz.text.words import listed, plural, rounded_up

__all__ = ["has_limit", "map_text", "runs_drawn", "side_words", "stability_numbers", "stability_text", "wrong_number"]

_ROUNDING_DECIDES = "rounding decides the crossings of the reference"

UNKNOWN = "–"
"""In place of a number that is not known, or that there is not."""


def side_words(study: core.StabilityStudy, side: int) -> str:
    """Return one side of the tangency, such as “x < −1.55”."""
    value = np.nan if study.grazing is None else study.grazing.value
    return printed(f"{variable_name(study.coordinate_name)} {'<>'[side]} {value:.6g}")


def wrong_number(grazing: Grazing) -> str:
    """Return what a run near a tangency has that misses or adds something."""
    numbers = [core.Tally(*one) for one in (*grazing.met.reshape(-1, 4), *grazing.expected_met.reshape(-1, 4))]
    return "wrong number of crossings" + " or slides" * any(one.slides > 0 for one in numbers)


# Words ---------------------------------------------------------------------------------------------------------------


def stability_text(study: core.StabilityStudy, part: str, caption: bool = False) -> str:
    """Return in words what one part of a study is; its figures are in `stability_numbers`.

    Parameters
    ----------
    part
        "map" (which includes the largest step sizes), "drift" or "grazing".
    caption
        Whether it follows `runs_drawn`, which says already for which start the largest step size holds.
    """
    if part == "map" and (study.map is not None or study.largest_tau is not None):
        words = f"{_grid(study, not caption)}{map_text(study) * caption}"
        return " ".join(filter(None, (words.strip(), f"Reference for the crossings: {study.reference}.")))
    if part == "drift" and study.drift is not None:
        return _drift_words(study.drift)
    if part == "grazing" and study.grazing is not None:
        return _grazing_words(study, study.grazing)
    return "Nothing is computed yet."


def map_text(study: core.StabilityStudy) -> str:
    """Return what counts as correct in the map where the solution ends early, or meets no surface; empty elsewhere."""
    return f"{_ends_early(study)}{_never_cross(study)}".strip()


def runs_drawn(study: core.StabilityStudy, part: str, method: str) -> str:
    """Return integrators, time and starts of the runs in one part of a study; `method` is that of the map."""
    methods = listed(study.methods)
    if part == "map":
        start = printed(f"{variable_name(study.coordinate_name)} = {study.x0[study.coordinate]:.6g}")
        limits = study.largest_tau if has_limit(study, method) else None
        mark = ""
        if limits is not None:
            last = ", at the largest τ tried," * (not limits.reason[study.methods.index(method)])
            mark = f"; the diamond{last} is for {start} and runs{_until(study, limits)}"
        to = f"t = {study.t_span[1]:.6g}, or to a time clear of nearby crossings"
        return f"each cell is one run of {method} to {to}{mark}"
    if part == "drift" and study.drift is not None:
        tau, steps = study.drift.tau, study.drift.steps
        return f"integrated by {methods} with step size τ = {tau:.6g} to t = {steps * tau:,.6g}"
    return f"integrated by {methods}"


def has_limit(study: core.StabilityStudy, method: str) -> bool:
    """Whether the largest successful step size of an integrator is known."""
    return study.largest_tau is not None and bool(study.largest_tau.found[study.methods.index(method)])


def _grid(study: core.StabilityStudy, limits_too: bool) -> str:
    """Say of which runs the map consists, and for which start the largest step sizes hold; empty without a map."""
    if study.map is None:
        return ""
    taus, values = study.map.taus, study.map.values
    varied = variable_name(study.coordinate_name)
    across, up = f"τ from {taus[0]:.3g} to {taus[-1]:.3g}", f"from {values[0]:.4g} to {values[-1]:.4g}"
    name = f"initial {varied} {up}"
    limits = ""
    if limits_too and study.largest_tau is not None and study.largest_tau.found.any():
        limits = f"“Largest successful τ” refers only to runs from the chosen start{_until(study, study.largest_tau)}. "
    return f"{len(taus)} × {len(values)} values: {across} (logarithmically spaced), {name}. {limits}"


def _ends_early(study: core.StabilityStudy) -> str:
    """Say from how many starts of the map the solution, or the reference alone, ends before the end time, and how."""
    expected = study.map.expected if study.map is not None else np.empty(0, dtype=int)
    ends = [core.Status(code) for code in expected[np.isin(expected, list(ENDS))].tolist()]
    solution, reference = ([one for one in ends if (one in ENDINGS) is known] for known in (True, False))
    until, words = f"before t = {study.t_span[1]:.4g}", ""
    if solution:
        how = "blows up" if {*solution} == {core.Status.ESCAPED} else f"ends ({_counted(solution)})"
        met = "" if {*solution} & {core.Status.ZENO, core.Status.GRAZING} else " after the same crossings"
        same = f"a run that does likewise{met} counts as successful, at whatever time it ends"
        words = f"{_how_many(solution, expected)} the solution itself {how} {until}; {same}. "
    if reference:
        early = f"the reference ends early ({_counted(reference)})"
        words += f"{_how_many(reference, expected)} {early}; these are not judged. "
    if lost := expected[expected == UNCERTAIN].tolist():
        words += f"{_how_many(lost, expected)} {_ROUNDING_DECIDES} {until}; these are not judged. "
    return words


def _never_cross(study: core.StabilityStudy) -> str:
    """Say from how many starts of the map the solution meets no surface; empty if from none."""
    if study.map is None or not len(study.map.expected):
        return ""
    met = study.map.expected_met.any(axis=1) | (study.map.expected != core.Status.COMPLETED)
    without = met[~met].tolist()
    words = f"{_how_many(without, met)} the solution has no crossings to t = {study.t_span[1]:.4g}, and "
    return f"{words}a run without any counts as correct. " if without else ""


def _how_many(ends: Sized, expected: Sized) -> str:
    """Return “For 3 of the 25 initial states”, or “For all 25 initial states”."""
    return f"For {'all' if len(ends) == len(expected) else f'{len(ends)} of the'} {len(expected)} initial states"


def _counted(ends: list[core.Status]) -> str:
    """Return how often each end occurs, such as “blow-up: 2, sliding: 1”."""
    return ", ".join(f"{ENDS[status].word}: {ends.count(status)}" for status in dict.fromkeys(ends))


def _drift_words(drift: Drift) -> str:
    if not np.isfinite(drift.error).any():
        return "No conserved quantity is known, so there is no |Δψ| to show."
    return f"{plural(drift.steps, 'step')} of size τ = {drift.tau:.3g}."


def _grazing_words(study: core.StabilityStudy, grazing: Grazing) -> str:
    """Say where the tangency is."""
    name = variable_name(study.coordinate_name)
    if grazing.instants:
        return "There is no tangency: the law changes at instants only, which a trajectory meets wherever it is."
    if not grazing.found:
        low, high = grazing.between
        where = f"{name} from {low:.4g} to {high:.4g}"
        return f"No tangency was found: for no {where} does the trajectory touch the surface."
    size = max(np.abs(grazing.state).max(), np.abs(study.x0).max())
    place = ", ".join(f"{0.0 if abs(v) < ROUND_OFF * size else v:.4g}" for v in grazing.state)
    start = f"Started at {name} = {grazing.value:.15g}, the trajectory touches the surface at t = {grazing.time:.5g},"
    words = [
        f"{start} at ({place}).",
        f"Runs start at the distance δ from there, with step size τ = {grazing.tau:.3g}{_until_after(grazing)}.",
    ]
    if not grazing.judged.any():
        words.append("There is nothing to compare with: the reference ends early.")
    else:
        words.append("Reference for the crossings: the exact solution where one is known, else the Taylor method.")
    return " ".join(words)


def _until_after(grazing: Grazing) -> str:
    """Return up to when runs near a tangency go, before the next crossing; empty while there is none."""
    ends = grazing.horizon[np.isfinite(grazing.horizon)]
    if not len(ends):
        return ""
    first, last = (f"t = {end:.4g}" for end in (ends.min(), ends.max()))
    return f", to {first}" if first == last else f", to times from {first} to {last}"


# Tables --------------------------------------------------------------------------------------------------------------


def stability_numbers(study: core.StabilityStudy, part: str, method: str) -> list[Numbers]:
    """Return the figures of one part of a study, as far as it is computed; `method` is the integrator of the map."""
    tables = []
    if part == "map" and study.largest_tau is not None:
        tables.append(_limits(study, study.largest_tau))
    if part == "map" and study.map is not None:
        tables.append(_shares(study, study.map, method))
    if part == "drift" and study.drift is not None:
        tables.append(_drifts(study, study.drift))
    if part == "grazing" and study.grazing is not None:
        tables.append(_misses(study, study.grazing))
    return tables


def _limits(study: core.StabilityStudy, largest: LargestTau) -> Numbers:
    """Return the largest step size that works, for each integrator."""
    rows = tuple(
        (
            name,
            "≥ " * (not largest.reason[k]) + _size(largest.tau[k], math.floor),
            _size(largest.beyond[k], math.ceil),
            on_page(largest.reason[k]) or _all_work(float(largest.taus[-1])),
        )
        for k, name in enumerate(study.methods)
        if largest.done[k]
    )
    caption = f"Largest step size with correct crossings, of runs from the chosen start{_until(study, largest)}"
    return Numbers(("integrator", "largest successful τ", "smallest failing τ", "reason"), rows, caption=caption)


def _all_work(last: float) -> str:
    """Say up to which step size an integrator works for which no larger one was tried."""
    most = ", the largest tried" * (last == LIMITS_OF_TAU[1])
    return f"successful up to τ = {last:.3g}{most}"


def _until(study: core.StabilityStudy, largest: LargestTau) -> str:
    """Return up to which time crossings are counted, and why if that is not the end time."""
    end, horizon = study.t_span[1], largest.horizon
    if largest.expected == UNCERTAIN:
        return f", from which {_ROUNDING_DECIDES} before t = {end:.4g}: no run is judged"
    if largest.expected not in ENDINGS:
        return f", from which the reference ends early, before t = {end:.4g}: no run is judged"
    if largest.expected != core.Status.COMPLETED:
        return f", from which the solution itself ends before t = {end:.4g}: a run has to end likewise"
    near = f" (t = {end:.4g} is too close to a crossing)"
    return f" to t = {horizon:.4g}{near * (horizon != end)}"


def _shares(study: core.StabilityStudy, found: OutcomeMap, method: str) -> Numbers:
    """Return the shares of the outcomes in the map of one integrator, the most frequent first."""
    k = study.methods.index(method)
    codes = outcomes_shown(found, k)
    done = codes[codes != NOT_YET]
    words, counts = np.unique([OUTCOMES[code].words for code in done.tolist()], return_counts=True)
    order = np.argsort(-counts, kind="stable")
    rows = [(str(words[n]), _share(counts[n] / len(done)), _bound(found, k, str(words[n]))) for n in order]
    runs = plural(codes.size, "run")
    runs = runs if len(done) == codes.size else f"{len(done):,} of {runs} so far"
    columns = ("outcome", "share", "|Δψ| at most")
    shown = 3 if np.isfinite(found.error).any() else 2  # no ψ is known
    return Numbers(columns[:shown], tuple(row[:shown] for row in rows), caption=f"Map of {method}, {runs}")


def _bound(found: OutcomeMap, k: int, words: str) -> str:
    """Return the largest |Δψ| among the runs with one outcome, and of how many it is known if not of all."""
    codes = outcomes_shown(found, k)
    there = np.isin(codes, [code for code, outcome in OUTCOMES.items() if outcome.words == words])
    error = found.error[k][there]
    known = int(np.isfinite(error).sum())
    of = f" ({known:,} of {plural(len(error), 'run')})" * (0 < known < len(error))
    return _at_most(float(np.fmax.reduce(error, initial=np.nan))) + of


def _share(part: float) -> str:
    """Return a share above 0 in per cent, not rounded to 0% or 100%."""
    return f"{part:.0%}" if 0.005 <= part <= 0.995 or part == 1.0 else ("under 1%" if part < 0.5 else "over 99%")


def _drifts(study: core.StabilityStudy, drift: Drift) -> Numbers:
    """Return the worst error of each integrator in its long run, and how it ended."""
    rows = []
    each = zip(study.methods, drift.error, drift.reached, drift.status, drift.message, strict=True)
    for name, error, reached, status, message in each:
        until = f"{reached:,.6g}" if np.isfinite(error).any() else UNKNOWN
        going = "under way" if status is core.Status.RUNNING else "reaches the end"
        rows.append((name, _at_most(float(np.fmax.reduce(error))), until, on_page(message) or going))
    return Numbers(("integrator", "|Δψ| at most", "up to t", "outcome"), tuple(rows))


def _misses(study: core.StabilityStudy, grazing: Grazing) -> Numbers:
    """Return how close to the tangency each integrator finds the correct crossings."""
    rows = []
    judged = bool(grazing.judged.any())
    for k, method in enumerate(study.methods):
        if not grazing.computed[k].any():
            continue
        wrong = grazing.missed[k].any(axis=0)
        far = f"{float(grazing.delta[wrong].max()):.0e}" if wrong.any() else UNKNOWN
        many = f"{wrong.sum()} of {len(wrong)} distances" if judged else UNKNOWN
        rows.append((method, many, far, _at_most(float(np.fmax.reduce(grazing.error[k], axis=None)))))
    return Numbers(("integrator", wrong_number(grazing), "largest such δ", "|Δψ| at most"), tuple(rows))


def _size(tau: float, towards: Callable[[float], int]) -> str:
    """Return a step size in three digits, rounded downwards or upwards."""
    if not np.isfinite(tau):
        return UNKNOWN
    digit = 10.0 ** (math.floor(math.log10(tau)) - 2)
    return f"{towards(float(f'{tau / digit:.9g}')) * digit:.3g}"


def _at_most(error: float) -> str:
    return rounded_up(error) if np.isfinite(error) else UNKNOWN
