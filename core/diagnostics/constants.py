"""α_S², α̂_S², M, M̂ and the step bounds τ₋*, τ₊* of the paper, at every crossing of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np
import sympy
from numpy.typing import NDArray

from core.diagnostics.scheme import Scheme, largest_component
from core.integration.crossings import Crossings, Integers
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem

__all__ = ["Branch", "Encounters", "discrete_constants", "encounters", "second_rate_bound", "wellposed_bound"]

#: Number of Runge-Kutta steps by which the exact solution is followed over a step.
_PARTS = 4
#: Lengths of the discrete steps examined, besides 0, in units of the longest step.
_DISCRETE_PARTS = (0.5, 1.0)
#: Radii δ tried for τ*, in units of ‖fᵗ‖/L₂, the distance over which the discrete field changes by its own size.
_RADII = 4.0 ** np.arange(-1, 5)
#: Radius of the differences from which that L₂ is computed, relative to the size of the state.
_NEARBY = 1e-3


@dataclass(frozen=True)
class Branch:
    """One side of every crossing: the arc that leads to the surface, or the arc that leads away from it."""

    t: Floats
    """(k,) time at the surface."""
    x: Floats
    """(k, d) state at the surface; for an arc after a jump, the state after the jump."""
    side: Integers
    """(k,) side of the arc."""
    rate: Floats
    """(k,) ∇g·f + g_t of that side there."""
    length: Floats
    """(k,) signed length of the longest step examined: negative for an arc before a crossing, if time increases."""

    def where(self, rows: NDArray[np.bool_] | slice) -> Branch:
        """The branch at some of the crossings."""
        return Branch(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass(frozen=True)
class Encounters:
    """Both branches of every crossing."""

    before: Branch
    after: Branch
    transversal: NDArray[np.bool_]
    """(k,) whether the trajectory arrives and leaves at rates other than 0."""
    slid: NDArray[np.bool_]
    """(k,) whether it slides up to there."""

    def where(self, rows: slice) -> Encounters:
        """Both branches of some of the crossings."""
        return Encounters(self.before.where(rows), self.after.where(rows), self.transversal[rows], self.slid[rows])


def encounters(run: Trajectory, crossings: Crossings) -> Encounters:
    """Both branches of every crossing of a run.

    The longest steps examined have length τ, or that of the arc if it is shorter: from one crossing to the next, or
    between a crossing and an end of the run.
    """
    t, count = crossings.t, len(crossings)
    jumped = crossings.kind == "jump"
    left = np.concatenate([run.side[:1], crossings.side])[:count]
    entered = np.where(crossings.side == 0, -left, crossings.side)
    slid = left == 0  # the theory does not cover sliding: another side stands for it, and no bound is given
    left = np.where(slid, np.where(entered == 0, 1, entered), left)
    entered = np.where(entered == 0, left, entered)
    last = run.crossings.t[count] if count < len(run.crossings) else run.t[-1]
    gaps = np.minimum(np.abs(np.diff(np.concatenate([run.t[:1], t, [last]]))), run.tau)
    direction = 1.0 if run.t[-1] >= run.t[0] else -1.0
    onward = np.where(jumped[:, None], crossings.x_after, crossings.surface)
    before, after = crossings.rate_before, crossings.rate_after
    crosses = (crossings.side != 0) & np.where(jumped, before * after != 0.0, before * after > 0.0)
    return Encounters(
        Branch(t, crossings.surface, left, before, -direction * gaps[:-1]),
        Branch(t, onward, entered, after, direction * gaps[1:]),
        crosses,
        slid,
    )


def second_rate_bound(scheme: Scheme, branch: Branch) -> Floats:
    """½ sup |d²g/dt²| along the exact solution on one branch: its part of M, paper (eq:M).

    d²g/dt² = x'·H_g x' + ∇g·x'' (and g_tt + 2∇g_t·x' where g depends on t) is exact, with x'' = f_t + (Df) f; the
    supremum is taken over five points of the arc, which is followed from the surface by the classical Runge-Kutta
    method.

    Returns
    -------
    (k,); inf where d²g/dt² is not finite at one of the points.
    """
    t, x, h = branch.t, branch.x, branch.length / _PARTS
    largest = np.abs(_second_rate(scheme.system, branch.side, t, x))
    for _ in range(_PARTS):
        x = x + h[:, None] * _by_side(branch.side, scheme.runge_kutta, t, x, h)
        t = t + h
        largest = np.maximum(largest, np.abs(_second_rate(scheme.system, branch.side, t, x)))
    return 0.5 * np.where(np.isfinite(largest), largest, np.inf)


def discrete_constants(scheme: Scheme, branch: Branch) -> tuple[Floats, Floats, Floats]:
    """α̂² and M̂ of one branch, and the far end of its longest step.

    Over steps of length 0, τ/2 and τ between the surface and the arc: the least ∇g(x̂)·fᵗ + g_t in the direction of
    the crossing, paper (eq:discrete_transversality), and ½ sup |fᵗ·H_g fᵗ| over both ends and the middle of the chord,
    paper (eq:hatM). Where g depends on t, H_g is its Hessian in (t, x) and fᵗ is (1, fᵗ).

    Returns
    -------
    (k,), (k,), (k, d); nan where the step's equation is not solved.
    """
    system, way = scheme.system, np.sign(branch.rate)
    gradient = system.switching_gradient(branch.t, branch.x)
    g_t = system.laws.evaluate("g_t", (system.laws.g.diff(TIME),), branch.t, branch.x, system.parameter_array)[:, 0]
    v = _by_side(branch.side, system.field, branch.t, branch.x)
    least, largest = np.abs(branch.rate), np.abs(_curvature(system, branch.t, branch.x, v))
    end = branch.x
    for part in _DISCRETE_PARTS:
        h = part * branch.length
        v = _by_side(branch.side, scheme.velocity, branch.t, branch.x, h)
        least = np.minimum(least, way * (g_t + np.einsum("ki,ki->k", gradient, v)))
        for along in (0.0, 0.5, 1.0):
            s = along * h
            end = branch.x + s[:, None] * v
            largest = np.maximum(largest, np.abs(_curvature(system, branch.t + s, end, v)))
    return least, 0.5 * largest, end


def wellposed_bound(scheme: Scheme, side: Integers, t0: Floats, x0: Floats, t1: Floats) -> Floats:
    """τ* of lem:wellposed-lemma1 and -lemma2 for steps from (t₀, x₀): the largest over δ of min(δ/M(δ), 1/L₂(δ)).

    The lemmas leave the radius δ open; here the best of six is taken, from a quarter to 256 times ‖fᵗ‖/L₂, with ε → 0.
    No finite computation gives a Lipschitz constant over B_δ(x₀): L₂(δ) is the norm (bounded by √(‖·‖₁‖·‖_∞)) of the
    largest difference quotients of fᵗ in its second state between x₀ and x₀ ± δeᵢ, and M(δ) ≤ ‖fᵗ(x₀)‖ + L₂δ. A radius
    is skipped where fᵗ is not finite. inf for explicit methods, which have no equation to solve.

    Returns
    -------
    (k,)
    """
    if not scheme.implicit:
        return np.full(len(t0), np.inf)
    return _by_side(side, lambda s, *at: _contraction_bound(scheme, s, *at), t0, x0, t1)


def _contraction_bound(scheme: Scheme, side: int, t0: Floats, x0: Floats, t1: Floats) -> Floats:
    d = x0.shape[-1]
    centre = scheme.discrete(side, t0, x0, t1, x0)
    speed = np.linalg.norm(centre, axis=1)
    directions = np.concatenate([np.eye(d), -np.eye(d)])[:, None, :]

    def lipschitz(radius: Floats) -> Floats:
        there = x0 + radius[..., None, :, None] * directions  # (…, 2d, k, d)
        quotients = np.abs(scheme.discrete(side, t0, x0, t1, there) - centre) / radius[..., None, :, None]
        largest = np.maximum(quotients[..., :d, :, :], quotients[..., d:, :, :])  # column, crossing, row
        norm: Floats = np.sqrt((largest @ np.ones(d)).max(axis=-2) * largest_component(largest.sum(axis=-3)))
        return norm

    size = np.linalg.norm(x0, axis=1)
    near = lipschitz(_NEARBY * np.where(size > 0.0, size, 1.0))
    natural = np.where((speed > 0.0) & (near > 0.0), speed / near, 1.0 + size)
    radius = _RADII[:, None] * natural
    rates = lipschitz(radius)
    bounds = 1.0 / (speed / radius + rates)
    bounds[-1, rates[-1] == 0.0] = np.inf  # a constant field: no radius is too large
    best: Floats = np.where(np.isnan(bounds), 0.0, bounds).max(axis=0)
    return best


def _by_side(side: Integers, function: Callable[..., Floats], *arrays: Floats) -> Floats:
    """Call function(side, *arrays) on the rows of each side that occurs, and merge the results."""
    signs = set(side.tolist()) or {1}
    if len(signs) == 1:
        return function(signs.pop(), *arrays)
    parts = [(rows, function(sign, *(a[rows] for a in arrays))) for sign in signs for rows in (side == sign,)]
    result = np.empty((len(side), *parts[0][1].shape[1:]))
    for rows, part in parts:
        result[rows] = part
    return result


def _second_rate(system: PiecewiseSystem, side: Integers, t: Floats, x: Floats) -> Floats:
    def of(sign: int, t: Floats, x: Floats) -> Floats:
        expression = second_rate(system.laws, sign)
        return system.laws.evaluate(("g''", sign), (expression,), t, x, system.parameter_array)[..., 0]

    return _by_side(side, of, t, x)


def _curvature(system: PiecewiseSystem, t: Floats, x: Floats, v: Floats) -> Floats:
    """Second derivative of g along the line of direction (1, v) in (t, x): v·H_g v where g does not depend on t."""
    entries = hessian(system.laws)
    w = np.concatenate([np.ones((len(t), 1)), v], axis=1)
    values = system.laws.evaluate("hessian", tuple(e for _, _, e in entries), t, x, system.parameter_array)
    result = np.zeros(len(t))
    for k, (i, j, _) in enumerate(entries):
        result += (1.0 if i == j else 2.0) * values[:, k] * w[:, i] * w[:, j]
    return result


@lru_cache(maxsize=64)
def second_rate(laws: Laws, side: int) -> sympy.Expr:
    """d²g/dt² along the field of a side."""
    return laws.modes[side].rate_of(laws.modes[side].guard_rates[0])


@lru_cache(maxsize=64)
def hessian(laws: Laws) -> tuple[tuple[int, int, sympy.Expr], ...]:
    """Entries (i, j, expression), i ≤ j, of the Hessian of g in (t, x) that do not vanish."""
    pairs = combinations_with_replacement(enumerate((TIME, *laws.x)), 2)
    entries = ((i, j, laws.g.diff(u, v)) for (i, u), (j, v) in pairs)
    return tuple((i, j, e) for i, j, e in entries if e != 0)
