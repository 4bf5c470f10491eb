"""Systems with polynomial Hamiltonians and a conic as the surface, whose coefficients are parameters.

Each is compiled once; a case is a draw of numbers. What a run claims is checked against NumPy's extended precision.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import core

__all__ = ["CONIC", "FULL", "SEPARABLE", "Case", "Powers", "system_of", "terms"]

Powers = tuple[tuple[int, int], ...]
Coefficients = tuple[float, ...]

#: Exponents of x and y.
CONIC: Powers = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
SEPARABLE: Powers = ((0, 2), (1, 0), (2, 0), (3, 0), (4, 0))
FULL: Powers = tuple((k - j, j) for k in range(1, 5) for j in range(k + 1))


def _polynomial(stem: str, powers: Powers) -> str:
    return " + ".join(f"{stem}{k}*x**{i}*y**{j}" for k, (i, j) in enumerate(powers))


def _slope(stem: str, powers: Powers, which: int) -> str:
    """Text of the derivative in x (0) or y (1)."""
    terms = []
    for k, (i, j) in enumerate(powers):
        n = (i, j)[which]
        if n:
            terms.append(f"{n}*{stem}{k}*x**{i - (which == 0)}*y**{j - (which == 1)}")
    return " + ".join(terms)


@cache
def system_of(powers: Powers) -> core.PiecewiseSystem:
    """x' = ∂H/∂y, y' = −∂H/∂x with one H a side."""
    sides: dict[str, tuple[str, ...]] = {}
    for stem, word in (("a", "minus"), ("b", "plus")):
        sides[f"f_{word}"] = (_slope(stem, powers, 1), f"-({_slope(stem, powers, 0)})")
        sides[f"psi_{word}"] = (_polynomial(stem, powers),)
    counts = {"a": len(powers), "b": len(powers), "c": len(CONIC)}
    parameters = tuple(core.Parameter(f"{stem}{k}", 1.0) for stem, n in counts.items() for k in range(n))
    return core.PiecewiseSystem(
        "Polynomials", ("x", "y"), sides["f_minus"], sides["f_plus"], _polynomial("c", CONIC),
        sides["psi_minus"], sides["psi_plus"], parameters,
    )  # fmt: skip


def terms(powers: Powers, coefficients: Coefficients, x: Any, dx: int = 0, dy: int = 0) -> NDArray[Any]:
    """Terms (..., k) of a polynomial, or of a first derivative, at states (..., 2), in extended precision."""
    x = np.asarray(x, dtype=np.longdouble)
    values = []
    for a, (i, j) in zip(coefficients, powers, strict=True):
        factor = (i if dx else 1) * (j if dy else 1)
        power = x[..., 0] ** max(i - dx, 0) * x[..., 1] ** max(j - dy, 0)
        values.append(np.longdouble(a) * factor * power)
    return np.stack(values, axis=-1)


@dataclass(frozen=True)
class Case:
    """Numbers for one run."""

    powers: Powers
    minus: Coefficients
    plus: Coefficients
    conic: Coefficients
    x0: tuple[float, float]
    t_end: float
    tau: float

    def of(self, side: int) -> Coefficients:
        """Coefficients of the Hamiltonian of a side."""
        return self.plus if side > 0 else self.minus

    @property
    def system(self) -> core.PiecewiseSystem:
        """The system with these coefficients."""
        drawn = {"a": self.minus, "b": self.plus, "c": self.conic}
        values = {f"{stem}{k}": v for stem, numbers in drawn.items() for k, v in enumerate(numbers)}
        return system_of(self.powers).with_parameters(**values)

    def run(self, method: str, **more: Any) -> core.Trajectory:
        """Integrate."""
        tau = None if core.METHODS[method].adaptive else self.tau
        return core.integrate(self.system, (0.0, self.t_end), self.x0, tau=tau, method=method, **more)

    def hamiltonian(self, side: int, x: Any) -> tuple[NDArray[Any], NDArray[Any]]:
        """H of a side at states, and its largest term."""
        each = terms(self.powers, self.of(side), x)
        return each.sum(axis=-1), np.abs(each).max(axis=-1)

    def height(self, x: Any) -> tuple[NDArray[Any], NDArray[Any]]:
        """G at states, and its largest term."""
        each = terms(CONIC, self.conic, x)
        return each.sum(axis=-1), np.abs(each).max(axis=-1)

    def rate(self, side: int, x: Any) -> tuple[NDArray[Any], NDArray[Any]]:
        """ġ with the field of a side at states, and the sizes of what it is the sum of."""
        slope = [terms(CONIC, self.conic, x, dx, dy) for dx, dy in ((1, 0), (0, 1))]
        field = [s * terms(self.powers, self.of(side), x, dx, dy) for s, dx, dy in ((1, 0, 1), (-1, 1, 0))]
        value = sum(u.sum(axis=-1) * v.sum(axis=-1) for u, v in zip(slope, field, strict=True))
        size = sum(np.abs(u).sum(axis=-1) * np.abs(v).sum(axis=-1) for u, v in zip(slope, field, strict=True))
        return np.asarray(value), np.asarray(size)
