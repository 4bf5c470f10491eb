"""α_S², α̂_S², M, M̂ and the step bounds τ₋*, τ₊* of the paper, at every crossing of a run."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np
import sympy
from numpy.typing import NDArray

from core.codegen.rounding import with_roundings
from core.diagnostics.encounters import Branch, by_number
from core.diagnostics.scheme import Scheme, largest_component
from core.integration.crossings import Integers
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem

__all__ = ["discrete_constants", "meets_again", "rates", "second_rate_bound", "wellposed_bound"]

#: Number of Runge-Kutta steps by which the exact solution is followed over a step.
_PARTS = 4
#: Lengths of the discrete steps examined, besides 0, in units of the longest step.
_DISCRETE_PARTS = (0.5, 1.0)
#: The same, of those at whose ends the sign of g is looked at.
_PARTS_AFTER = np.arange(1, 17) / 16.0
#: Radii δ tried for τ*, in units of ‖fᵗ‖/L₂, the distance over which the discrete field changes by its own size.
_RADII = 4.0 ** np.arange(-1, 5)
#: Radius of the differences from which that L₂ is computed, relative to the size of the state.
_NEARBY = 1e-3
_EPS = 2.0**-52


def second_rate_bound(scheme: Scheme, branch: Branch) -> Floats:
    """½ sup |d²g/dt²| along the exact solution on one branch: its part of M, paper (eq:M).

    d²g/dt² = x'·H_g x' + ∇g·x'' (and g_tt + 2∇g_t·x' where g depends on t) is exact, with x'' = f_t + (Df) f; the
    supremum is taken over five points of the arc, which is followed from the surface by the classical Runge-Kutta
    method.

    Returns
    -------
    (k,); inf where d²g/dt² is infinite at one of the points, nan where it is not defined at one, as beyond a root.
    """
    t, x, h = branch.t, branch.x, branch.length / _PARTS
    largest = np.abs(_second_rate(scheme.system, branch, t, x))
    for _ in range(_PARTS):
        x = x + h[:, None] * by_number(branch.mode, scheme.runge_kutta, t, x, h)
        t = t + h
        largest = np.maximum(largest, np.abs(_second_rate(scheme.system, branch, t, x)))
    return 0.5 * largest


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
    gradient = _slopes(system, branch)
    v = by_number(branch.mode, scheme.field, branch.t, branch.x)
    least, largest = np.abs(branch.rate), np.abs(_curvature(system, branch, branch.t, branch.x, v))
    end = branch.x
    for part in _DISCRETE_PARTS:
        h = part * branch.length
        v = by_number(branch.mode, scheme.velocity, branch.t, branch.x, h)
        least = np.minimum(least, way * (gradient[:, 0] + np.einsum("ki,ki->k", gradient[:, 1:], v)))
        for along in (0.0, 0.5, 1.0):
            s = along * h
            end = branch.x + s[:, None] * v
            largest = np.maximum(largest, np.abs(_curvature(system, branch, branch.t + s, end, v)))
    return least, 0.5 * largest, end


def meets_again(scheme: Scheme, branch: Branch) -> NDArray[np.bool_]:
    """(k,) whether g has the wrong sign at the end of a step from the surface, or the step has no solution.

    The steps are parts of the longest, in either direction. Where all have the right sign, the scheme does not meet
    the surface again within a step, whatever the sufficient conditions of the theory leave open. A sign within the
    rounding of g is not wrong: a state may leave the surface so slowly that it moves by no unit in its last place.
    """
    way, wrong = np.sign(branch.rate), np.zeros(len(branch.t), dtype=bool)
    for part in _PARTS_AFTER:
        h = part * branch.length
        v = by_number(branch.mode, scheme.velocity, branch.t, branch.x, h)
        g, rounding = _heights(scheme.system, branch, branch.t + h, branch.x + h[:, None] * v).T
        wrong |= ~(way * np.sign(h) * g > -_EPS * rounding) & (h != 0.0)
    return np.asarray(wrong & branch.known)


def wellposed_bound(scheme: Scheme, mode: Integers, t0: Floats, x0: Floats, t1: Floats) -> Floats:
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
    return by_number(mode, lambda n, *at: _contraction_bound(scheme, n, *at), t0, x0, t1)


def _contraction_bound(scheme: Scheme, mode: int, t0: Floats, x0: Floats, t1: Floats) -> Floats:
    d = x0.shape[-1]
    centre = scheme.discrete(mode, t0, x0, t1, x0)
    speed = np.linalg.norm(centre, axis=1)
    directions = np.concatenate([np.eye(d), -np.eye(d)])[:, None, :]

    def lipschitz(radius: Floats) -> Floats:
        there = x0 + radius[..., None, :, None] * directions  # (…, 2d, k, d)
        quotients = np.abs(scheme.discrete(mode, t0, x0, t1, there) - centre) / radius[..., None, :, None]
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


def rates(system: PiecewiseSystem, mode: Integers, at: Branch) -> Floats:
    """∇g·f + g_t of the surface of a branch, with the fields of regions given by their numbers; nan for none (−1)."""

    def of(number: int, surface: int, t: Floats, x: Floats) -> Floats:
        law, g = system.laws.mode(number).written, system.laws.surfaces[surface]
        return _values(system, ("g'", number, surface), (law.rate_of(g),), t, x)[:, 0]

    return _by_mode_and_surface(mode, at.surface, of, at.t, at.x)


def _by_mode_and_surface(mode: Integers, surface: Integers, function: Callable[..., Floats], *arrays: Floats) -> Floats:
    """Call function(mode, surface, *arrays) on the rows of each pair that occurs, and merge; nan for no mode (−1)."""
    count = int(surface.max(initial=0)) + 1
    both = np.where(mode < 0, -1, mode * count + surface)
    return by_number(both, lambda n, *at: function(*divmod(n, count), *at), *arrays)


def _values(system: PiecewiseSystem, key: object, expressions: tuple[sympy.Expr, ...], t: Floats, x: Floats) -> Floats:
    return system.laws.evaluate(key, expressions, t, x, system.parameter_array)


def _second_rate(system: PiecewiseSystem, branch: Branch, t: Floats, x: Floats) -> Floats:
    def of(mode: int, surface: int, t: Floats, x: Floats) -> Floats:
        return _values(system, ("g''", mode, surface), (second_rate(system.laws, mode, surface),), t, x)[:, 0]

    return _by_mode_and_surface(branch.mode, branch.surface, of, t, x)


def _slopes(system: PiecewiseSystem, branch: Branch) -> Floats:
    """(k, 1 + d) g_t and ∇g at the surface of a branch."""

    def of(surface: int, t: Floats, x: Floats) -> Floats:
        return _values(system, ("g_t, grad g", surface), slopes(system.laws, surface), t, x)

    return by_number(branch.surface, of, branch.t, branch.x)


def _heights(system: PiecewiseSystem, branch: Branch, t: Floats, x: Floats) -> Floats:
    """(k, 2) g of the surface of a branch at other points, and a bound on its rounding in units of eps."""

    def of(surface: int, t: Floats, x: Floats) -> Floats:
        return _values(system, ("g and rounding", surface), with_roundings((system.laws.surfaces[surface],)), t, x)

    return by_number(branch.surface, of, t, x)


def _curvature(system: PiecewiseSystem, branch: Branch, t: Floats, x: Floats, v: Floats) -> Floats:
    """Second derivative of g along the line of direction (1, v) in (t, x): v·H_g v where g does not depend on t."""

    def of(surface: int, t: Floats, x: Floats, w: Floats) -> Floats:
        entries, result = hessian(system.laws, surface), np.zeros(len(t))
        values = _values(system, ("hessian", surface), tuple(e for _, _, e in entries), t, x)
        for k, (i, j, _) in enumerate(entries):
            result += (1.0 if i == j else 2.0) * values[:, k] * w[:, i] * w[:, j]
        return result

    return by_number(branch.surface, of, t, x, np.concatenate([np.ones((len(t), 1)), v], axis=1))


@lru_cache(maxsize=64)
def second_rate(laws: Laws, mode: int, surface: int) -> sympy.Expr:
    """d²g/dt² of a surface along the field of a mode."""
    law = laws.mode(mode).written
    return law.rate_of(law.rate_of(laws.surfaces[surface]))


@lru_cache(maxsize=64)
def slopes(laws: Laws, surface: int) -> tuple[sympy.Expr, ...]:
    """g_t and ∇g of a surface."""
    return laws.surfaces[surface].diff(TIME), *laws.gradients[surface]


@lru_cache(maxsize=64)
def hessian(laws: Laws, surface: int) -> tuple[tuple[int, int, sympy.Expr], ...]:
    """Entries (i, j, expression), i ≤ j, of the Hessian of g of a surface in (t, x) that do not vanish."""
    pairs = combinations_with_replacement(enumerate((TIME, *laws.x)), 2)
    entries = ((i, j, laws.surfaces[surface].diff(u, v)) for (i, u), (j, v) in pairs)
    return tuple((i, j, e) for i, j, e in entries if e != 0)
