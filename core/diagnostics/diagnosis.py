"""diagnose(): the theory's constants along a run, and what they say about its step size."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.amplification import amplified
from core.diagnostics.backward import not_undone
from core.diagnostics.cancellation import cancelled
from core.diagnostics.clock import blurs, by_its_own_clock, from_zero, is_blurred
from core.diagnostics.constants import (
    discrete_constants,
    meets_again,
    rates,
    second_rate_bound,
    wellposed_bound,
)
from core.diagnostics.corners import slid_into_corners, undecided_corners
from core.diagnostics.encounters import Encounters, encounters
from core.diagnostics.errors_of_steps import led_astray
from core.diagnostics.made_again import with_steps
from core.diagnostics.near_touches import near_touches
from core.diagnostics.remembered_peaks import remembered_peaks
from core.diagnostics.resolution import resolvable, unresolved
from core.diagnostics.scheme import Scheme
from core.diagnostics.slow_crossings import slow_crossings
from core.integration.crossings import Crossings
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["Diagnosis", "diagnose", "step_warning"]

#: Number of crossings treated at a time, times d²: it bounds the memory used.
_CHUNK = 65536
#: Number of crossings that `step_warning` examines.
_FIRST = 256


@dataclass(frozen=True, eq=False)
class Constants:
    """The theory's constants at each crossing; (k,) each."""

    rate_minus: Floats
    """∇g·f₋ (+ g_t) at the crossing, paper (eq:transverseA): of the surface met, with the field of the region that
    meets it there where g < 0. nan where no law is declared on that side."""
    rate_plus: Floats
    """∇g·f₊ (+ g_t) there, paper (eq:transverseA): that of the region where g > 0."""
    alpha2: Floats
    """α_S² at this crossing, paper (eq:transverseA): the smaller |ġ| of those at which the trajectory arrives and
    leaves. nan where the crossing is not transversal."""
    alpha_hat2: Floats
    """α̂_S² at this crossing, paper (eq:discrete_transversality) of lem:discTC: the least ∇g(x̂)·fᵗ (+ g_t), counted in
    the direction of the crossing, over steps of length 0, τ/2 and τ to and from the surface. Not positive where the
    condition fails, nan where the crossing is not transversal or iteration does not solve the step's equation."""
    M: Floats
    """M of lem:ctsTimeError, paper (eq:M): ½ sup |x'·H_g x' + ∇g·x''| over five points of the exact solution within τ
    before the crossing and five after it, not beyond the neighbouring crossings. Where g depends on t, with the
    derivatives in t. As the sup is over what a step can reach on this trajectory, it is also M^ε of (eq:PerturbedM) and
    (eq:PerturbedM2) for ε = τ, except that of the initial data y ∈ B_ε(x*) only x̂ is examined."""
    M_hat: Floats
    """M̂ of lem:discTimeError, paper (eq:hatM): ½ sup |fᵗ·H_g fᵗ| over the same steps as `alpha_hat2`, H_g at both ends
    and the middle of the chord. The absolute value, as in lem:discMonotonicTime, makes it hold in either direction."""
    tau_minus: Floats
    """τ₋* of lem:wellposed-lemma1, for the step from x_k to the surface with the field of the region left. x_k is the
    point one step back from the surface. An estimate: see `constants.wellposed_bound` for δ, L₂ and M."""
    tau_plus: Floats
    """τ₊* of lem:wellposed-lemma2, for the step on from x̂* with the field of the region entered."""
    window: Floats
    """α²/M of lem:ctsMonotonicTime and lem:ctsMonotonicTime2, paper (eq:ctsMonoLemma), (eq:ctsMonoLemma2): if τ is
    below it, the exact solution does not meet the surface again within a step. Nothing follows beyond the step, as M is
    a supremum within it. Sharp for a parabola. inf where M = 0, as for uniform motion to a plane."""
    window_hat: Floats
    """α̂²/M̂ of lem:discMonotonicTime and lem:discMonotonicTime2, paper (eq:disMonoLemma), (eq:disMonoLemma2): the same
    of the discrete solution, with the ½ that (eq:discGX-) gives and (eq:PerturbedHatM) leaves out. inf where g is
    linear, 0 where the discrete transversality fails."""


@dataclass(frozen=True, eq=False)
class Diagnosis(Constants):
    """The constants of the paper's theory, at every crossing of a run and over all of them.

    At a jump, which the paper's theory does not cover, the branch before it ends on the surface, and the branch after
    it starts from the state after the jump. A crossing moved by a perturbation is examined where the scheme met the
    surface, one that was stepped over (``transition="none"``) where the chord of the step meets it.

    Of several surfaces, the constants are those of the surface met and of the two regions that meet there. At a one-way
    guard, as of hysteresis, the trajectory only arrives: the mode entered has other guards, so that its field counts in
    `tau_plus` alone. Where a run slides, or stops, there is no branch in a region, and the constants of that branch
    are left out; corners and the ends of sliding are not transversal.
    """

    alpha_S2: float  # noqa: N815 - the paper's symbol
    """α_S², paper (eq:transverseA): the least of `alpha2`; nan where there is none."""
    alpha_hat_S2: float  # noqa: N815
    """α̂_S², paper (eq:discrete_transversality): the least of `alpha_hat2`."""
    tau: float
    """Step size of the run."""
    warnings: tuple[str, ...]
    """Where τ exceeds a bound, in plain words; () where it exceeds none."""
    summary: str
    """The constants and their comparison with τ in one line."""

    def __repr__(self) -> str:
        return f"<Diagnosis: {self.summary}>"


def diagnose(run: Trajectory) -> Diagnosis:
    """Compute the theory's constants and step bounds at every crossing of a run.

    Parameters
    ----------
    run
        A run that recorded its crossings: ``record="steps"`` or ``"crossings"``, with the same result. With ``"end"``
        there are none to diagnose, and the summary says so.

    Returns
    -------
    Diagnosis
        Without crossings its arrays are empty, its scalars nan, and there are no warnings.

    Raises
    ------
    ValueError
        If `run` is not a Trajectory.
    """
    if not isinstance(run, Trajectory):
        raise ValueError(f"run = {run!r}: give a Trajectory, as `integrate` returns it")
    return _diagnosis(run, run.crossings)


def step_warning(run: Trajectory) -> str:
    """Warning about the step size, in a sentence; '' where there is none.

    The first of `not_undone`: it goes back in time; of `cancelled`: the terms of a law cancel; else of `near_touches`
    with an error of rounding: smaller steps hardly help, and of `unresolved`: steps too long for g or for the field;
    else that of `undecided_corners`, of `slid_into_corners`, of `near_touches`, of `slow_crossings`, of `amplified`, of
    `led_astray`, of `remembered_peaks`, or of `Diagnosis.warnings` from the first 256 crossings. A run that has not
    recorded its steps is judged by its first steps, made again, and, if these are not all and nothing is said of them,
    by what it has recorded. One whose clock does not resolve its steps is judged by these with the clock set to zero at
    the start; if the time is named, that is what is said.
    """
    if run.status is Status.ZENO:  # accumulating crossings are closer than any step
        return ""
    if is_blurred(run):
        return _warning_apart_from_clock(run)
    again = with_steps(run)
    partly = again.steps < run.steps or again.crossing_count < run.crossing_count
    return _warning(again) or (_warning(run) if partly else "")


def _warning_apart_from_clock(run: Trajectory) -> str:
    """A warning of a run whose clock does not resolve its steps, with times counted from its start."""
    if not by_its_own_clock(run):
        return blurs(run)
    warning = _warning(from_zero(run))
    return f"Times counted from the start: {warning}" if warning else ""


def _warning(run: Trajectory) -> str:
    judged = run.crossings.first(min(_FIRST, _judged(run)))
    at_surfaces = (undecided_corners(run), slid_into_corners(run), near_touches(run), slow_crossings(run, judged))
    of_errors = (amplified(run), led_astray(run), remembered_peaks(run))
    doubts = chain(*at_surfaces, *of_errors, near_touches(run, far=True))
    warnings = (*not_undone(run), *cancelled(run))
    if not warnings:
        touches, coarse = tuple(islice(near_touches(run, rounding=True), 1)), unresolved(run)[:1]
        warnings = (". ".join((*touches, *coarse)),) if touches or coarse else tuple(islice(doubts, 1))
    if not warnings:
        warnings = _borne_out(run, judged, _diagnosis(run, judged))
    return f"{warnings[0]}." if warnings else ""


def _judged(run: Trajectory) -> int:
    """Number of crossings before those at the end beside which no bound is kept.

    These are within a step of a touch that ended the run, or where no step is short enough for the solution.
    """
    t = run.crossings.t
    beside_touch = (run.status is Status.GRAZING) & (np.abs(run.t[-1] - t) <= run.tau)
    return int((resolvable(run, t) & ~beside_touch).sum())


def _diagnosis(run: Trajectory, crossings: Crossings) -> Diagnosis:
    met = encounters(run, crossings)
    scheme = Scheme(run.system, run.method)
    size = _CHUNK // run.system.dimension**2
    with np.errstate(all="ignore"):  # inf or nan stand for what is not finite
        chunks = [_constants(scheme, met.where(slice(k, k + size))) for k in range(0, len(crossings), size)]
    names = [f.name for f in fields(Constants)]
    columns = {n: np.concatenate([np.empty(0), *(getattr(c, n) for c in chunks)]) for n in names}
    constants = Constants(**columns)
    least, least_hat = _least(constants.alpha2), _least(constants.alpha_hat2)
    chosen = METHODS[run.method].adaptive  # a variable-step method: the theory is about steps of one size
    warnings = () if chosen else tuple(_warnings(run.tau, crossings.t, constants))
    summary = _summary(run, crossings, constants, warnings)
    return Diagnosis(**columns, alpha_S2=least, alpha_hat_S2=least_hat, tau=run.tau, warnings=warnings, summary=summary)


def _borne_out(run: Trajectory, crossings: Crossings, found: Diagnosis) -> tuple[str, ...]:
    """The warnings of a diagnosis, of steps that may meet the surface again only where they do: see `meets_again`."""
    if not found.warnings:
        return ()
    met, scheme = encounters(run, crossings), Scheme(run.system, run.method)
    with np.errstate(all="ignore"):
        again = meets_again(scheme, met.before) | (meets_again(scheme, met.after) & ~met.one_way)
    close = np.abs(np.diff(crossings.t)) < run.tau  # it does meet a surface again, if not by a bounce
    close &= (crossings.kind[:-1] != "jump") & (crossings.kind[1:] != "jump")
    again |= np.append(close, False) | np.insert(close, 0, False)
    windows = {name: np.where(again, getattr(found, name), np.inf) for name in ("window", "window_hat", "alpha_hat2")}
    constants = Constants(**{f.name: windows.get(f.name, getattr(found, f.name)) for f in fields(Constants)})
    return tuple(_warnings(run.tau, crossings.t, constants))


def _constants(scheme: Scheme, met: Encounters) -> Constants:
    before, after = met.before, met.after
    arrives, leaves = before.known, after.known & ~met.one_way
    some = arrives | leaves

    def of_both(function: np.ufunc, neutral: float, at_end: Floats, at_start: Floats) -> Floats:
        """A constant of both branches, as far as they lead through a region from or to the surface."""
        both = function(np.where(arrives, at_end, neutral), np.where(leaves, at_start, neutral))
        return np.where(some, both, np.nan)

    alpha2 = of_both(np.minimum, np.inf, np.abs(before.rate), np.abs(after.rate))
    m = of_both(np.maximum, 0.0, second_rate_bound(scheme, before), second_rate_bound(scheme, after))
    hat_before, m_before, start = discrete_constants(scheme, before)
    hat_after, m_after, _ = discrete_constants(scheme, after)
    alpha_hat2 = of_both(np.minimum, np.inf, hat_before, hat_after)
    m_hat = of_both(np.maximum, 0.0, m_before, m_after)
    alpha2, alpha_hat2 = (np.where(met.transversal, u, np.nan) for u in (alpha2, alpha_hat2))
    # Where the step back has no solution, its far end is unknown: the point on the surface stands for it.
    start = np.where(np.isfinite(start), start, before.x)
    tau_minus = wellposed_bound(scheme, before.mode, before.t + before.length, start, before.t)
    tau_plus = wellposed_bound(scheme, after.mode, after.t, after.x, after.t + after.length)
    tau_minus, tau_plus = (np.where(b.known, u, np.nan) for b, u in ((before, tau_minus), (after, tau_plus)))
    window = alpha2 / m
    window_hat = np.where(alpha_hat2 <= 0.0, 0.0, alpha_hat2 / m_hat)
    minus, plus = (rates(scheme.system, number, before) for number in (met.minus, met.plus))
    return Constants(minus, plus, alpha2, alpha_hat2, m, m_hat, tau_minus, tau_plus, window, window_hat)


def _least(values: Floats) -> float:
    known = values[~np.isnan(values)]
    return float(known.min()) if known.size else math.nan


_SECOND = ", below which the theory excludes a second crossing within a step"
_UNSOLVED = (
    ": beyond it the theory does not guarantee that the step {} the surface has a unique solution; the bound is "
    "sufficient, not necessary, and depends on the units of the variables"
)
#: Bounds on τ: field of `Constants`, name in a warning, and what holds below it, or may happen beyond it.
_BOUNDS = (
    ("window", "alpha^2/M", _SECOND),
    ("window_hat", "alpha_hat^2/M_hat", f"{_SECOND} of the scheme"),
    ("tau_minus", "the bound tau_-^*", _UNSOLVED.format("to")),
    ("tau_plus", "the bound tau_+^*", _UNSOLVED.format("from")),
)


def _warnings(tau: float, t: Floats, constants: Constants) -> Iterator[str]:
    for name, bound, consequence in _BOUNDS:
        values = getattr(constants, name)
        if name == "window_hat":
            yield from _failures(tau, t, constants.alpha_hat2)
        # A bound of 0 says nothing: a second derivative is not bounded, as of a root, or `_failures` has reported it.
        rows = np.flatnonzero((values > 0.0) & (values < tau))
        if rows.size:
            worst = rows[np.argmin(values[rows])]
            advice = f"take tau below {_round_down(values[worst]):.2g}"
            where = _place(t, rows, worst)
            yield f"tau = {tau:.3g} exceeds {bound} = {values[worst]:.3g}{where}{consequence}; {advice}"


def _failures(tau: float, t: Floats, alpha_hat2: Floats) -> Iterator[str]:
    rows = np.flatnonzero(alpha_hat2 <= 0.0)
    if rows.size:
        yield (
            f"tau = {tau:.3g} breaks the discrete transversality condition"
            f"{_place(t, rows, rows[np.argmin(alpha_hat2[rows])])}: a step from the surface meets it again, "
            "or points back through it; take a smaller tau"
        )


def _place(t: Floats, rows: NDArray[np.intp], worst: np.intp) -> str:
    among = f", the worst of {len(rows)} crossings" if len(rows) > 1 else ""
    return f" at crossing {worst + 1} (t = {t[worst]:.3g}{among})"


def _round_down(value: float) -> float:
    """A positive number rounded down to two digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / unit * (1.0 + 1e-12)) * unit


def _summary(run: Trajectory, crossings: Crossings, constants: Constants, warnings: tuple[str, ...]) -> str:
    count = len(crossings)
    if not count:
        lost = run.crossing_count
        return f"{lost} crossings, none kept: record them to diagnose the run." if lost else "No crossings."
    through = int((~np.isnan(constants.alpha2)).sum())
    parts = [f"{count} crossing{'s' * (count != 1)}"]
    if through < count:
        parts[0] += f" ({count - through} not transversal)"
    if through:
        parts.append(f"alpha_S^2 = {_least(constants.alpha2):.3g}, alpha_hat_S^2 = {_least(constants.alpha_hat2):.3g}")
        parts.append(f"least window {_least(constants.window):.3g}")
    compared = _least(constants.window) > 0.0 and not METHODS[run.method].adaptive  # false for nan
    bounds = "exceeds a bound" if warnings else "satisfies all bounds" if compared else "is compared with no bound"
    return f"{'; '.join(parts)}: tau = {run.tau:.3g} {bounds}."
