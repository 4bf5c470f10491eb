"""A stability study in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import core
from core.studies import (
    ENDINGS,
    NO_START,
    NOT_YET,
    WENT_ON,
    WRONG_CROSSINGS,
    Drift,
    Grazing,
    LargestTau,
    OutcomeMap,
)
from pwsviz.text.words import listed, plural, rounded_up

__all__ = ["cell_words", "side_words", "stability_text"]

_SHORT: Mapping[int, str] = {
    core.Status.COMPLETED: "correct sequence of crossings",
    WRONG_CROSSINGS: "wrong number of crossings",
    WENT_ON: "goes on where the solution stops",
    core.Status.ESCAPED: "the numerical solution blows up",
    core.Status.UNSTABLE: "the scheme leaves the solution",
    core.Status.CONTRADICTION: "an error of the program",
    core.Status.NO_CONVERGENCE: "a step has no solution",
    core.Status.SLIDING: "stops: slides",
    core.Status.GRAZING: "stops: touches the surface",
    core.Status.ZENO: "stops: crossings accumulate",
    core.Status.REPELLING: "stops: repelled from both sides",
    core.Status.STEP_LIMIT: "too many steps",
    core.Status.CROSSING_LIMIT: "too many crossings",
    NO_START: "no start here",
}


def cell_words(code: int, expected: int) -> str:
    """Return the outcome of a run in a few words; if the outcome of the solution is not known, say that instead."""
    if expected not in ENDINGS and code != NO_START:
        return "the reference gives up"
    return _SHORT[code]


def side_words(study: core.StabilityStudy, side: int) -> str:
    """Return one side of the tangency, such as “x < −1.55”."""
    value = np.nan if study.grazing is None else study.grazing.value
    return f"{study.coordinate_name} {'<>'[side]} {value:.6g}".replace("-", "−")


def stability_text(study: core.StabilityStudy, part: str, method: str) -> str:
    """Return one part of a study in words: the same as its figure shows, also for screen readers.

    Parameters
    ----------
    part
        "largest_tau", "map" (which includes the former), "drift" or "grazing".
    method
        The integrator of the map.
    """
    words = []
    if part in ("largest_tau", "map") and study.largest_tau is not None:
        words += _limits(study, study.largest_tau)
    if part == "map" and study.map is not None:
        words += _outcomes(study, study.map, method)
    if part == "drift" and study.drift is not None:
        words += _drift(study, study.drift)
    if part in ("largest_tau", "map") and words:
        words.append(f"Crossings compared with: {study.reference}.")
    if part == "grazing" and study.grazing is not None:
        words += _grazing(study, study.grazing)
    return " ".join(words) or "Nothing is computed yet."


def _limits(study: core.StabilityStudy, largest: LargestTau) -> list[str]:
    """Return a sentence for each integrator on the largest step size that works."""
    sentences = []
    for k, name in enumerate(study.methods):
        tau, beyond, reason = largest.tau[k], largest.beyond[k], largest.reason[k]
        if not largest.done[k]:
            continue
        if np.isnan(beyond):
            every = f"{name}: every step size tried works, up to τ = {tau:.3g}."
            sentences.append(every if np.isfinite(tau) else f"{name}: no answer, {reason}.")
        elif np.isnan(tau):
            sentences.append(f"{name}: not even τ = {beyond:.3g} works: {reason}.")
        else:
            sentences.append(f"{name}: works up to τ = {tau:.3g}; at {beyond:.3g}: {reason}.")
    start = f"Largest step size from the start chosen, to t = {largest.horizon:.4g}:"
    return [start, *sentences] if sentences else []


def _outcomes(study: core.StabilityStudy, found: OutcomeMap, method: str) -> list[str]:
    """Return the shares of the outcomes in the map of one integrator."""
    k = study.methods.index(method)
    done = found.outcome[k] != NOT_YET
    total = int(done.sum())
    if not total:
        return []
    codes = np.where(found.works[k], core.Status.COMPLETED, found.outcome[k])
    expected = np.broadcast_to(found.expected, codes.shape)
    words = [cell_words(*given) for given in zip(codes[done], expected[done], strict=True)]
    counts = sorted(((words.count(word), word) for word in set(words)), reverse=True)
    shares = listed([f"{word}: {_share(count / total)}" for count, word in counts])
    sentences = [f"Map of {method}, {plural(total, 'run')}: {shares}."]
    errors = found.error[k][found.works[k]]
    if np.isfinite(errors).any():
        sentences.append(f"Where the sequence of crossings is correct, |Δψ| ≤ {rounded_up(float(np.nanmax(errors)))}.")
    return sentences


def _share(part: float) -> str:
    """Return a share above 0 in per cent, not rounded to 0% or 100%."""
    return f"{part:.0%}" if 0.005 <= part <= 0.995 or part == 1.0 else ("under 1%" if part < 0.5 else "over 99%")


def _drift(study: core.StabilityStudy, drift: Drift) -> list[str]:
    """Return the worst error of each integrator in its long run, and where it stopped."""
    sentences = [f"{plural(drift.steps, 'step')} of τ = {drift.tau:.3g}."]
    for name, error, status, message in zip(study.methods, drift.error, drift.status, drift.message, strict=True):
        known = np.flatnonzero(np.isfinite(error))
        if not len(known):
            if message:
                sentences.append(f"{name}: {message}")
            continue
        stopped = status not in (core.Status.COMPLETED, core.Status.RUNNING)
        until = "until it stops" if stopped else f"up to t = {drift.t[known[-1]]:.4g}"
        end = f"|Δψ| ≤ {rounded_up(float(error[known].max()))} {until}"
        sentences.append(f"{name}: {end}." + (f" It stops at {message}" if stopped else ""))
    if len(sentences) == 1:
        sentences.append("No conserved quantity is known, so there is no drift to see.")
    return sentences


def _grazing(study: core.StabilityStudy, grazing: Grazing) -> list[str]:
    """Say where the tangency is, and how close to it each integrator finds the right crossings."""
    name = study.coordinate_name
    if not grazing.found:
        return [f"No tangency: at no {name} in the range searched does the trajectory touch the surface in passing."]
    place = ", ".join(f"{v:.4g}" for v in grazing.state)
    start = f"Started at {name} = {grazing.value:.15g}, the trajectory touches the surface at t = {grazing.time:.5g} in"
    sentences = [f"{start} ({place}). Runs of τ = {grazing.tau:.3g} beside it:"]
    for k, method in enumerate(study.methods):
        wrong = grazing.missed[k].any(axis=0)
        if not (grazing.crossings[k] >= 0).any():
            continue
        if not (grazing.expected >= 0).any():
            tail = "has nothing to be compared with: the solution itself stops on the surface."
        elif not wrong.any():
            tail = "finds every crossing and no other, at every distance."
        else:
            far, many = float(grazing.delta[wrong].max()), f"{wrong.sum()} of {len(wrong)} distances"
            tail = f"has a wrong number of crossings at {many}, the farthest δ = {far:.0e}."
        worst = np.fmax.reduce(grazing.error[k], axis=None, initial=-np.inf)
        error = f" |Δψ| ≤ {rounded_up(float(worst))}." if np.isfinite(worst) else ""
        sentences.append(f"{method} {tail}{error}")
    return [*sentences, "Crossings are compared with the exact solution where one is known, else the Taylor method."]
