"""The discrete field fᵗ of a run's method, for many states at once in numpy.

The mean velocity of a step, (x₁ − x₀)/h, is the discrete field of any one-step method: fᵗ(t₀, x₀, t₁, x₁) in
x₁ = x₀ + h fᵗ, paper (eq:twoSchemes). Here it is computed anew from the points where the run met the surface, so that
it does not depend on what the run recorded, and is never a quotient of small differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Any

import numba
import numpy as np
import sympy
from sympy import Symbol

from core.kernels import divided_differences
from core.kernels.arrays import Floats
from core.methods import METHODS, Composition, DiscreteMultiplier, Method
from core.methods.runge_kutta import CLASSICAL, RK4, ButcherTableau
from core.symbolic.laws import Laws, coordinates
from core.symbolic.multiplier import DividedDifference
from core.system import PiecewiseSystem

__all__ = ["Scheme", "largest_component", "stand_in"]

#: Change by an iteration, relative to the velocity, at which the step's equation is solved (lem:wellposed-lemma1).
_SOLVED = 1e-13
#: Most iterations: one that needs more does not contract, or too slowly.
_PASSES = 100
#: Highest order of an explicit method that is used itself, rather than RK4 in its place.
_LOW = 4

DiscreteFunction = Callable[[Floats, Floats, Floats, Floats, Floats], Floats]


@dataclass(frozen=True)
class Scheme:
    """The discrete field of a method on a system, or of a method that stands in for it.

    A discrete multiplier method stands for itself and for compositions of its steps, which are all shorter than τ. An
    explicit method of low order stands for itself, and one classical Runge-Kutta step for every other method, whose
    mean velocity differs from it by O(τ⁴) and the method's own error.
    """

    system: PiecewiseSystem
    method: str

    @property
    def implicit(self) -> bool:
        """Whether a step is the solution of an equation."""
        return isinstance(METHODS[self.method].scheme, DiscreteMultiplier | Composition)

    def field(self, mode: int, t: Floats, x: Floats) -> Floats:
        """f of a mode, given by its number, at states (..., d) -> (..., d)."""
        return self.system.field(self.system.laws.name(mode), t, x)

    def discrete(self, mode: int, t0: Floats, x0: Floats, t1: Floats, x1: Floats) -> Floats:
        """fᵗ of dmm2 at times (...) and states (..., d), broadcast against each other -> (..., d)."""
        return discrete_function(self.system.laws, mode)(t0, x0, t1, x1, self.system.parameter_array)

    def velocity(self, mode: int, t: Floats, x: Floats, h: Floats) -> Floats:
        """Mean velocity of steps of lengths (k,), which may be negative, from states (k, d) at times (k,) -> (k, d).

        nan where the step's equation is not solved by iterating the map T of lem:wellposed-lemma1.
        """
        scheme = stand_in(self.method).scheme
        if isinstance(scheme, ButcherTableau):
            return self._explicit(scheme, mode, t, x, h)
        return self._solved(mode, t, x, h, self.runge_kutta(mode, t, x, h))

    def runge_kutta(self, mode: int, t: Floats, x: Floats, h: Floats) -> Floats:
        """Mean velocity of one step of the classical Runge-Kutta method with the field of a mode."""
        return self._explicit(CLASSICAL, mode, t, x, h)

    def _explicit(self, tableau: ButcherTableau, mode: int, t: Floats, x: Floats, h: Floats) -> Floats:
        slopes: list[Floats] = []
        nodes, rows, weights = tableau.in_floats
        for node, row in zip(nodes, rows, strict=True):
            moved = sum((a * k for a, k in zip(row, slopes, strict=False) if a), np.zeros_like(x))
            slopes.append(self.field(mode, t + node * h, x + h[:, None] * moved))
        return sum((b * k for b, k in zip(weights, slopes, strict=True)), np.zeros_like(x))

    def _solved(self, mode: int, t: Floats, x: Floats, h: Floats, v: Floats) -> Floats:
        open_rows = np.ones(len(t), dtype=bool)
        for _ in range(_PASSES):
            new = self.discrete(mode, t, x, t + h, x + h[:, None] * v)
            size = largest_component(new)
            open_rows = ~((largest_component(new - v) <= _SOLVED * size) & (size < np.inf))
            v = new
            if not open_rows.any():
                break
        v[open_rows] = np.nan
        return v


def stand_in(method: str) -> Method:
    """The method whose discrete field a `Scheme` uses for a method: itself, or one that is close enough."""
    scheme = METHODS[method].scheme
    if isinstance(scheme, Composition):
        return next(m for m in METHODS.values() if m.scheme is scheme.of)
    low = isinstance(scheme, ButcherTableau) and scheme.explicit and scheme.order <= _LOW
    return METHODS[method] if low or isinstance(scheme, DiscreteMultiplier) else RK4


def largest_component(vectors: Floats) -> Floats:
    """Maximum norm over the last axis, which is short: ten times as fast as numpy's own reduction."""
    return reduce(np.maximum, map(np.abs, coordinates(vectors)))


@lru_cache(maxsize=64)
def discrete_function(laws: Laws, mode: int) -> DiscreteFunction:
    """fᵗ of dmm2 as a numpy function of (t₀, x₀, t₁, x₁, p).

    The minimal-norm DMM, f̄ − Λᵗᵀ(ΛᵗΛᵗᵀ)⁻¹(Λᵗ f̄ + s_t), is assembled from its parts, with a numerical inverse.
    """
    discrete = laws.mode(mode).discrete
    d, m = len(discrete.field), len(discrete.conserved)
    if discrete.factor is not None or m == 0:
        values = _components(laws, mode, list(discrete.expression))
        return lambda *at: np.moveaxis(values(*at), 0, -1)
    parts = _components(laws, mode, [*discrete.mean_field, *discrete.time_slope, *discrete.gradient])

    def minimal_norm(t0: Floats, x0: Floats, t1: Floats, x1: Floats, p: Floats) -> Floats:
        values = parts(t0, x0, t1, x1, p)
        mean, time_slope = values[:d], values[d : d + m]
        rows = values[d + m :].reshape(m, d, *values.shape[1:])
        residual = np.einsum("ij...,j...->i...", rows, mean) + time_slope
        multipliers = _solve_definite(np.einsum("ij...,kj...->ik...", rows, rows), residual)
        return np.moveaxis(mean - np.einsum("ij...,i...->j...", rows, multipliers), 0, -1)

    return minimal_norm


def _components(laws: Laws, mode: int, expressions: list[Any]) -> DiscreteFunction:
    """Numpy function of the ends of a step that returns the values (len(expressions), ...) of expressions in them."""
    ends = laws.mode(mode).discrete.ends
    symbols = (ends.times[0], *ends.start, ends.times[1], *ends.end, *laws.p)
    names = {s: Symbol(f"u{k}") for k, s in enumerate(symbols)}
    used = {type(e) for e in sympy.Matrix(expressions).atoms(DividedDifference)}
    modules = [{cls.__name__: _vectorised(cls.__name__) for cls in used}, "numpy"]
    function = sympy.lambdify(list(names.values()), [e.xreplace(names) for e in expressions], modules, cse=True)

    def values(t0: Floats, x0: Floats, t1: Floats, x1: Floats, p: Floats) -> Floats:
        shape = np.broadcast_shapes(np.shape(t0), x0.shape[:-1], np.shape(t1), x1.shape[:-1])
        result = np.empty((len(expressions), *shape))
        columns = function(t0, *coordinates(x0), t1, *coordinates(x1), *p)
        for row, column in zip(result, columns, strict=True):
            row[...] = column
        return result

    return values


@lru_cache(maxsize=32)
def _vectorised(name: str) -> Any:
    """A divided difference of `core.kernels.divided_differences`, for arrays: compiled in a tenth of a second."""
    make: Any = numba.vectorize  # untyped
    return make(["float64(float64, float64)"])(getattr(divided_differences, name).py_func)


def _solve_definite(a: Floats, b: Floats) -> Floats:
    """Solve a·z = b for many symmetric positive definite (m, m, ...), by elimination: nan or inf if singular."""
    a, z = a.copy(), b.copy()
    m = len(b)
    for k in range(m):
        for i in range(k + 1, m):
            factor = a[i, k] / a[k, k]
            a[i, k:] -= factor * a[k, k:]
            z[i] -= factor * z[k]
    for k in reversed(range(m)):
        z[k] = (z[k] - np.einsum("j...,j...->...", a[k, k + 1 :], z[k + 1 :])) / a[k, k]
    return z
