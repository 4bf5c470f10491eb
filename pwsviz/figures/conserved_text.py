"""The plot of the conserved quantity in words: what each integrator makes of ψ, and what is drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.results.error_curve import ROUND_OFF, ErrorCurve
from pwsviz.text.numbers import RAISED
from pwsviz.text.words import listed, rounded, rounded_up, whose_marks

__all__ = [
    "CEILING", "MOST_BANDS", "TELLABLE", "axis_name", "conserved_text", "excluded", "largest", "largest_of_each",
    "meaning", "round_off_grows",
]  # fmt: skip

CEILING = 1e9
"""|Δψ| at which a curve leaves the plot: a method that blows up would leave no room for the others."""

MOST_BANDS = 400
"""Most crossings for which segments and ticks are drawn; more of them could not be told apart."""

TELLABLE = 3.0
"""Least ratio of two levels whose marks on the axis can be told apart."""

SEEN_TO_RISE = 1.1
"""Ratio of |Δψ| in the last third of the time to that in the first one beyond which a curve is seen to rise: by less
it rises by a pixel or two, on an axis of so many decades."""

DRIFT = 2.0
"""The same ratio beyond which a rise is no wave any more, but a drift: one in proportion to time has 3."""

STEADY = 0.2
"""`ErrorCurve.shift` up to which a curve shows no drift: a drift that its oscillation hides moves its mean by more."""

LOST = 0.1
"""|Δψ|, relative to the size of ψ’s terms before, from which on no bound is told: less than a digit of ψ is right."""

RELATIVE = "relative:"
"""Before a change of ψ as part of the size of ψ’s terms."""

#: Relative error that is no number of its own any more: half of the least to which a number can be known.
_LEAST = 2.0**-54

NEAR_ONE = 10.0
"""Factor by which the size of ψ’s terms must differ from 1 for a change to be stated relative to it, too."""

LEVEL = f"2⁻{str(52 - round(math.log2(ROUND_OFF))).translate(RAISED)}"
"""`ROUND_OFF` times 2⁻⁵², in words."""

CHANGE_OF_PSI = "of ψ, |Δψ|"
"""Whose error the vertical axis shows."""

CHANGE_OF_G = "of g while sliding, |Δg|"
"""The same where a run slides."""


def axis_name(curves: Sequence[ErrorCurve] = ()) -> str:
    """Return what is drawn: |Δψ|, |Δg| where runs slide, or both."""
    slides = any(np.isfinite(curve.error[curve.sliding]).any() for curve in curves)
    other = any((~curve.sliding & np.isfinite(curve.error)).any() for curve in curves)
    return f"error {'; '.join(filter(None, (CHANGE_OF_PSI * (other or not slides), CHANGE_OF_G * slides)))}"


def excluded(curves: Sequence[ErrorCurve], met: str, bare: bool) -> str:
    """Return which changes of ψ are not counted.

    Parameters
    ----------
    curves : sequence of ErrorCurve
        All curves.
    met : str
        What runs meet: crossings, jumps or both; empty if nothing.
    bare : bool
        Whether no ψ is known somewhere.
    """
    off_surface = any(one.jumps and one.between is not None for one in curves)
    which = ["all changes at jumps" if off_surface else f"the changes that the system itself makes at {met}"] * bool(
        met
    )
    which += [f"{'all changes' if which else 'the changes'} where no ψ is known"] * bare
    return f", excluding {listed(which)}" * bool(which)


def meaning(curves: Sequence[ErrorCurve], met: str, bare: bool = False, round_off: bool = True) -> str:
    """Return what is drawn, in the sentences of a caption.

    Parameters
    ----------
    curves : sequence of ErrorCurve
        All curves.
    met : str
        What runs meet: crossings, jumps or both.
    bare : bool
        Whether no ψ is known somewhere.
    round_off : bool
        Whether the line of round-off is drawn.
    """
    name, words = axis_name(curves), []
    if CHANGE_OF_PSI in name:
        met = met if any(len(one.crossings) for one in curves) else ""
        words.append(f"|Δψ| is the change of ψ since the start{excluded(curves, met, bare)}")
        if any(curve.between is not None for curve in curves):
            counted = "is not counted at jumps" if any(one.jumps for one in curves) else "is counted"
            words.append(f"Crossings lie off the surface here, and the change of ψ that this causes {counted}")
        when = "up to each time" if round_off_grows(curves[0]) else "in the run"
        words += [f"The round-off line is {LEVEL} times the largest |ψ| + Σᵢ |xᵢ\u00a0∂ψ/∂xᵢ| {when}"] * round_off
    if CHANGE_OF_G in name:
        words.append("While a run slides, |Δg| is drawn, the change of g since it began to slide")
    if any(np.nanmax(curve.error, initial=0.0) >= CEILING for curve in curves):
        words.append("A curve ends at a triangle where it leaves the plot")
    if 0 < len(curves[0].crossings) <= MOST_BANDS:
        words.append("Marks near the lower edge are the times at which the run meets a surface")
    return f"{'. '.join(words)}.{_about_marks(curves)}"


def round_off_grows(curve: ErrorCurve) -> bool:
    """Whether the level of round-off grows so much along a run that its line is drawn as it grows, not as its end."""
    return bool(curve.round_off[-1] > TELLABLE * curve.round_off[0] > 0.0)


def conserved_text(curves: Sequence[ErrorCurve]) -> str:
    """Return what each integrator makes of ψ in a sentence, and what is not drawn; empty if no ψ is known."""
    told = [words for curve in curves for words in (_change(curve), _undefined(curve), _off_surface(curve)) if words]
    if not told:
        return ""
    words = "; ".join(told) + "."
    terms = " “Relative”: divided by the largest |ψ| + Σ |xᵢ ∂ψ/∂xᵢ| of the run." * (RELATIVE in words)
    return words + terms + _about_marks(curves)


def largest_of_each(curves: Sequence[ErrorCurve]) -> str:
    """Return the largest |Δψ| by each integrator, for captions; empty if no ψ is known."""
    known = ((curve.method, curve.error[~np.isnan(curve.error) & ~curve.sliding]) for curve in curves)
    worst = [(method, float(error.max())) for method, error in known if len(error)]
    told = [f"{rounded(most) if most < math.inf else 'unbounded'} for {method}" for method, most in worst]
    return f"Largest |Δψ|: {listed(told)}." if told else ""


def _about_marks(curves: Sequence[ErrorCurve]) -> str:
    """Say that crossings are too many to be marked, or whose are marked where there are several integrators."""
    first, many = curves[0], len(curves[0].crossings)
    if many > MOST_BANDS:
        whose = f" of {first.method}" * (len(curves) > 1)
        return f" The {many:,} crossings{whose} are too dense to mark; the sides are not shaded."
    return f" {whose_marks([curve.method for curve in curves], many)}".rstrip()


def _change(curve: ErrorCurve) -> str:
    """Say whether the change of ψ by one integrator is round-off, bounded, or a drift; empty without ψ.

    Of a method that does not conserve ψ a change that rounding could explain is said to be at its level, not its
    effect. Where crossings lie off the surface, ψ may be conserved between them only.
    """
    known = (np.isfinite(curve.error) | np.isinf(curve.error)) & ~curve.sliding
    t, error, method = curve.t[known], curve.error[known], curve.method
    if not len(error):
        return ""
    worst, size = float(error.max()), float(curve.psi_size[-1])
    if curve.steps == 0 and curve.runs_off:
        return f"{method} stops before its first step"
    until = f"up to t = {_end_of(curve, known):.4g}"
    stops = f" {until}, where the run stops" * curve.runs_off
    if worst == 0:
        return f"{method} conserves ψ exactly{stops}"
    if kind := _kind_of_rounding(curve, error, known):
        kept = f"{method} {'conserves ψ to' if curve.keeps else 'stays at the level of'} {kind}"
        between = " between jumps, which lie off the surface" * (curve.between is not None and curve.jumps)
        return f"{kept}{between}{stops}: max |Δψ| = {rounded(worst)}{_relative(worst, size)}"
    if worst > CEILING:
        left = f"leaves the plot at t = {t[np.argmax(error > CEILING)]:.4g}"
        return f"{method} {f'stops at t = {curve.t_end:.4g}' if curve.runs_off else left}: {largest(error)}"
    value = f"max |Δψ| = {rounded(worst)}{_relative(worst, size)}"
    if curve.runs_off:
        return f"{method}: max |Δψ| = {rounded(worst)}{stops}"  # ψ may grow large only there
    if curve.keeps and curve.between is not None and (kind := _kind_of_rounding(curve, curve.between[known], known)):
        kept = f"{method} conserves ψ to {kind} between crossings"
        return f"{kept}, but crossings off the surface change it: {value} {until}"
    share = _share_of_crossings(curve, known)
    if 0.0 < LOST * _size_before(curve, error, known) <= worst:
        told = value if worst >= LOST * size else f"max |Δψ| = {rounded(worst)}"
        return f"{method} does not conserve ψ: {told}{share}"
    early, late = (float(part.max(initial=0.0)) for part in (error[t <= t[-1] / 3], error[t >= 2 * t[-1] / 3]))
    if late <= SEEN_TO_RISE * early and curve.shift <= STEADY:
        return f"{method} shows no visible drift {until}: {value}{share}"
    return f"{method}{' drifts' * (late > DRIFT * early)}: {value} {until}{share}"


def _size_before(curve: ErrorCurve, error: Floats, known: NDArray[np.bool_]) -> float:
    """Return the size of ψ’s terms before the error has come to half its largest, which enlarges them itself."""
    half = int(np.argmax(error >= 0.5 * error.max()))
    return float(np.broadcast_to(curve.psi_size, curve.t.shape)[known][max(half - 1, 0)])


def _share_of_crossings(curve: ErrorCurve, known: NDArray[np.bool_]) -> str:
    """Say how much of a change arises between crossings where these lie off the surface; empty where they do not."""
    if curve.between is None:
        return ""
    most = rounded_up(float(np.nanmax(curve.between[known])))
    return f"; between two crossings ψ changes by at most {most}, and crossings off the surface change it, too"


def _kind_of_rounding(curve: ErrorCurve, error: Floats, known: NDArray[np.bool_]) -> str:
    """Say that an error is round-off, if it is no larger than that of ψ or of all steps; empty if it is larger."""
    most = np.maximum(curve.round_off[known], curve.accumulated_round_off[known])
    return "round-off" * bool((error <= most).all())


def _end_of(curve: ErrorCurve, known: NDArray[np.bool_]) -> float:
    """Return until when an error is known: the end of the run, or the crossing from which on it slides."""
    if known[-1]:
        return curve.t_end
    last = curve.t[known][-1]
    return float(next((t for t in curve.crossings if t >= last), last))


def _undefined(curve: ErrorCurve) -> str:
    """Say from when on ψ is not defined along a run, as where it has a logarithm of x < 0; empty if it always is."""
    if np.isnan(curve.undefined):
        return ""
    since = f" from t = {curve.undefined:.4g} on" if curve.undefined > curve.t[0] else ""
    return f"ψ is not defined along the run of {curve.method}{since}, and no |Δψ| is drawn there"


def _off_surface(curve: ErrorCurve) -> str:
    """Say how far g changes while one integrator slides; empty if it does not slide."""
    error = curve.error[curve.sliding & np.isfinite(curve.error)]
    if not len(error):
        return ""
    worst = float(error.max())
    kept = f"changes g by at most {rounded_up(worst)}" if worst > 0 else "keeps g exactly"
    return f"{curve.method} {kept} while it slides"


def _relative(error: float, size: float) -> str:
    """Return an error relative to the size of ψ’s terms, in brackets; empty where that is about 1, or unknown."""
    if not np.isfinite(size) or size == 0 or 1 / NEAR_ONE < size < NEAR_ONE:
        return ""
    return f" ({RELATIVE} {rounded(error / size) if error >= _LEAST * size else 'below 10⁻¹⁶'})"


def largest(error: Floats) -> str:
    """Return the largest of some errors in words, be it infinite."""
    worst = float(np.fmax.reduce(error))
    return f"max |Δψ| = {rounded(worst)}" if np.isfinite(worst) else "the numerical solution blows up"
