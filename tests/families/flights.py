"""Closed forms of motions, in NumPy's extended precision: (side, t, x (d,)) -> times (n,) -> states (n, d)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.families.oracles import Array, Flight, Real

__all__ = ["Flow", "Modes", "accelerated", "forced", "integrated", "linear", "real", "rotating"]

Flow = Callable[[int, Any, Array], Flight]
Sided = Mapping[int, Any]

_PIECE = 0.25  # time that a flight is worked out for at once: little of it is in vain where crossings are many


def real(**values: float) -> dict[str, Any]:
    """Numbers in extended precision, each the float it is given as."""
    return {name: Real(float(v)) for name, v in values.items()}


def accelerated(acceleration: Sided) -> Flow:
    """y' = v, v' = a constant of each side."""

    def flow(side: int, t0: Any, x0: Array) -> Flight:
        (y, v), a = x0, acceleration[side]
        return lambda t: np.stack([y + (t - t0) * (v + a * (t - t0) / 2), v + a * (t - t0)], -1)

    return flow


def forced(acceleration: Sided, strength: Any, rate: Any) -> Flow:
    """y' = v, v' = a + b cos(c t), with a of each side."""

    def flow(side: int, t0: Any, x0: Array) -> Flight:
        (y, v), a = x0, acceleration[side]
        push = strength / rate
        v -= push * np.sin(rate * t0)
        y += push / rate * np.cos(rate * t0)

        def flight(t: Array) -> Array:
            s, angle = t - t0, rate * t
            return np.stack(
                [y + s * (v + a * s / 2) - push / rate * np.cos(angle), v + a * s + push * np.sin(angle)], -1
            )

        return flight

    return flow


def rotating(stiffness: Sided) -> Flow:
    """x' = y, y' = −k x with k of each side."""

    def flow(side: int, t0: Any, x0: Array) -> Flight:
        (x, y), w = x0, np.sqrt(stiffness[side])

        def flight(t: Array) -> Array:
            c, s = np.cos(w * (t - t0)), np.sin(w * (t - t0))
            return np.stack([x * c + y / w * s, y * c - w * x * s], -1)

        return flight

    return flow


class Modes:
    """A matrix of real modes in the plane and in space: decay and rotation of a plane, decay of a line, and a basis."""

    def __init__(self, decay: float, rate: float, third: float, basis: NDArray[np.float64]) -> None:
        self.decay, self.rate, self.third = Real(decay), Real(rate), Real(third)
        self.basis, self.inverse = basis.astype(Real), _inverse(basis)
        block = np.array([[decay, rate, 0.0], [-rate, decay, 0.0], [0.0, 0.0, third]], dtype=Real)
        self.matrix = np.asarray(self.basis @ block @ self.inverse, dtype=float)

    def flight(self, t0: Any, x0: Array) -> Flight:
        """exp((t − t₀) A) x₀."""
        a, b, c = self.inverse @ x0

        def states(t: Array) -> Array:
            s = t - t0
            size, u, v = np.exp(self.decay * s), np.cos(self.rate * s), np.sin(self.rate * s)
            modes = np.stack([size * (a * u + b * v), size * (b * u - a * v), c * np.exp(self.third * s)], -1)
            return modes @ self.basis.T

        return states


def _inverse(matrix: NDArray[np.float64]) -> Array:
    """Inverse in extended precision: NumPy's, and two steps of Newton."""
    inverse, identity = np.linalg.inv(matrix).astype(Real), np.eye(len(matrix), dtype=Real)
    for _ in range(2):
        inverse = inverse + inverse @ (identity - matrix.astype(Real) @ inverse)
    return inverse


def linear(modes: Mapping[int, Modes]) -> Flow:
    """x' = A x in space, with A of each side."""
    return lambda side, t0, x0: modes[side].flight(t0, x0)


class _Integrated:
    """A flight worked out piece by piece, as far as it is asked for."""

    def __init__(self, field: Callable[[float, Any], Any], t0: float, x0: Any) -> None:
        self.field, self.ends, self.pieces = field, [t0], [x0]

    def __call__(self, t: Array) -> Array:
        times = np.asarray(t, dtype=float)
        while self.ends[-1] < times.max(initial=-np.inf) or len(self.ends) == 1:
            self._extend()
        which = np.clip(np.searchsorted(self.ends, times, side="right") - 1, 0, len(self.ends) - 2)
        states = np.empty((len(times), len(self.pieces[0])), dtype=Real)
        for k in np.unique(which):
            states[which == k] = self.pieces[k + 1].sol(times[which == k]).T
        return states

    def _extend(self) -> None:
        start = self.pieces[0] if len(self.pieces) == 1 else self.pieces[-1].y[:, -1]
        span = (self.ends[-1], self.ends[-1] + _PIECE)
        self.pieces.append(solve_ivp(self.field, span, start, "DOP853", dense_output=True, rtol=3e-14, atol=1e-15))
        self.ends.append(span[1])


def integrated(fields: Mapping[int, Callable[[float, Any], Any]]) -> Flow:
    """x' = f(t, x) of each side by SciPy's DOP853, to some 1e-11 in the state."""
    return lambda side, t0, x0: _Integrated(fields[side], float(t0), x0.astype(float))
