"""Exact flows of smooth fields.

Four families have closed forms here: affine fields (matrix exponential), the fields equivalent to X'' = 6X² − g₂/2
(Weierstrass ℘), the free rigid body (Jacobi sn, cn, dn) and the pendulum (am).  Everything is evaluated in extended
precision (``np.longdouble``, 64-bit mantissa on x86; plain double where the platform has nothing better), so that a
result rounded to double is good to its last digit and round-off does not pile up over many surface crossings.

Sources: those of `weierstrass` and `jacobi`; Higham, *Functions of Matrices* (2008), ch. 10.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from core.reference import jacobi, weierstrass
from core.reference.weierstrass import Extended

__all__ = ["Flow", "LinearFlow", "PendulumFlow", "RigidBodyFlow", "WeierstrassFlow"]

_PI = np.longdouble("3.14159265358979323846264338327950288")
_TAYLOR_DEGREE = 20  # 2⁻²⁰/20! = 4e-25: below the last extended digit for ‖Z‖ ≤ ½


class Flow(Protocol):
    """Exact flow of one autonomous field."""

    @property
    def name(self) -> str:
        """The closed form, for display."""

    def __call__(self, x0: ArrayLike, t: ArrayLike) -> Extended:
        """States (n, d) at the elapsed times t (n,), of either sign, from the state x0 (d,).

        Raises ValueError for a time at or past a pole of the orbit.
        """

    def lifetime(self, x0: ArrayLike) -> float:
        """Time after which the orbit of x0 is at infinity; inf if it never is."""

    def period(self, x0: ArrayLike) -> float:
        """Period of the orbit of x0; inf if it is not closed, or not known to be."""

    def rate(self, x0: ArrayLike) -> float:
        """Fastest rate (1/time) of the flow on the orbit of x0: how finely it must be sampled."""


@dataclass(frozen=True, eq=False)
class LinearFlow:
    """Flow of x' = a x + b, for any square a, singular or defective too.

    The exponential of [[a, b], [0, 0]] t by scaling, Taylor series and squaring (Higham, ch. 10), carried as
    exp − 1 and squared as F ← 2F + F², which keeps small times accurate however often it is done.
    """

    a: Extended
    b: Extended
    name: str = "linear flow"

    def __call__(self, x0: ArrayLike, t: ArrayLike) -> Extended:
        """States (n, d) at the elapsed times t (n,) from x0 (d,)."""
        x, times = _extended(x0), _extended(t)
        d = len(x)
        norm, offset = np.abs(self.a).sum(axis=1).max(), np.abs(self.b).max()
        # the constant state that carries b is chosen to make both blocks of the same size: fewest squarings
        unit = offset / norm if norm > 0 and offset > 0 else max(offset, np.longdouble(1))
        generator = np.zeros((d + 1, d + 1), dtype=np.longdouble)
        generator[:d, :d], generator[:d, d] = self.a, self.b / unit
        grown = _exponential_less_one(generator, times) @ np.append(x, unit)
        states: Extended = x + grown[:, :d]
        return states

    def lifetime(self, x0: ArrayLike) -> float:
        """Inf: the states of a linear system are finite at all times."""
        return np.inf

    def period(self, x0: ArrayLike) -> float:
        """2π/√det a for a centre of the plane; inf otherwise (a closed orbit in space is not looked for)."""
        if self.a.shape != (2, 2) or self.a[0, 0] + self.a[1, 1] != 0:
            return np.inf
        det = self.a[0, 0] * self.a[1, 1] - self.a[0, 1] * self.a[1, 0]
        return float(2 * np.pi / np.sqrt(det)) if det > 0 else np.inf

    def rate(self, x0: ArrayLike) -> float:
        """Largest modulus of an eigenvalue of a."""
        return float(np.abs(np.linalg.eigvals(self.a.astype(float))).max())


def _exponential_less_one(generator: Extended, t: Extended) -> Extended:
    """exp(generator·t) − 1, (n, k, k)."""
    size = np.abs(generator).sum(axis=1).max() * np.abs(t).max(initial=0)
    squarings = max(0, int(np.ceil(np.log2(float(size)))) + 1) if size > 0 else 0
    z = generator * np.ldexp(t, -squarings)[:, None, None]
    one = np.eye(len(generator), dtype=np.longdouble)
    f = z / _TAYLOR_DEGREE
    for k in range(_TAYLOR_DEGREE - 1, 0, -1):
        f = z @ (one + f) / k
    for _ in range(squarings):
        f = 2 * f + f @ f
    return f


@dataclass(frozen=True, eq=False)
class WeierstrassFlow:
    """Flow of u' = αv, v' = βu² + γu + δ, αβ ≠ 0, where u = x[position] and v is the other variable.

    u = sX + r turns it into X'' = 6X² − g₂/2, hence X'² = 4X³ − g₂X − g₃ with g₃ fixed by the state.  The
    points (X, X') of the cubic are a group and the flow is addition of (℘(t), ℘'(t)) (DLMF 23.10.1): no phase
    of the orbit, hence no inverse function and no loss of digits at its turning points.
    """

    position: int
    alpha: np.longdouble
    beta: np.longdouble
    gamma: np.longdouble
    delta: np.longdouble
    name: str = "Weierstrass ℘"
    _scale: np.longdouble = field(init=False, repr=False)
    _shift: np.longdouble = field(init=False, repr=False)
    _g2: np.longdouble = field(init=False, repr=False)

    def __post_init__(self) -> None:
        scale, shift = 6 / (self.alpha * self.beta), -self.gamma / (2 * self.beta)
        force = (self.beta * shift + self.gamma) * shift + self.delta
        object.__setattr__(self, "_scale", scale)
        object.__setattr__(self, "_shift", shift)
        object.__setattr__(self, "_g2", -2 * self.alpha * force / scale)

    def __call__(self, x0: ArrayLike, t: ArrayLike) -> Extended:
        """States (n, 2) at the elapsed times t (n,) from x0 (2,); ValueError at or past a pole."""
        points = self._orbit(x0).at(_extended(t))
        states = np.empty((len(points), 2), dtype=np.longdouble)
        states[:, self.position] = self._scale * points[:, 0] + self._shift
        states[:, 1 - self.position] = self._scale / self.alpha * points[:, 1]
        return states

    def lifetime(self, x0: ArrayLike) -> float:
        """Time to the pole ahead; inf on the oval of the cubic, at equilibria, and towards a saddle."""
        return float(self._orbit(x0).life)

    def period(self, x0: ArrayLike) -> float:
        """The real period of ℘ on the oval of the cubic; inf on its unbounded branch."""
        return float(self._orbit(x0).period)

    def rate(self, x0: ArrayLike) -> float:
        """Twice max(|g₂|^¼, |g₃|^⅙): at least the rate at the centre and at the saddle, (12 g₂)^¼."""
        return 2 * float(self._orbit(x0).inverse_time)

    def _orbit(self, x0: ArrayLike) -> weierstrass.Orbit:
        x = _extended(x0)
        return weierstrass.orbit(
            self._g2, (x[self.position] - self._shift) / self._scale,
            self.alpha * x[1 - self.position] / self._scale,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class RigidBodyFlow:
    """Flow of x' = (c₁ x₂x₃, c₂ x₃x₁, c₃ x₁x₂), the c not 0 and not all of one sign, so that orbits are bounded.

    Divided by √|c| the variables move as `jacobi.Orbit`, the one whose c is alone in its sign as its x, in the time
    ±√|c₁c₂c₃| t.
    """

    c: Extended
    name: str = "Jacobi sn, cn, dn"

    def __call__(self, x0: ArrayLike, t: ArrayLike) -> Extended:
        """States (n, 3) at the elapsed times t (n,) from x0 (3,)."""
        order = self._order
        states = np.empty((len(_extended(t)), 3), dtype=np.longdouble)
        states[:, order] = self._orbit(x0).at(np.sign(self.c[order[0]]) * self._tempo * _extended(t))
        return states * np.sqrt(np.abs(self.c))

    def lifetime(self, x0: ArrayLike) -> float:
        """Inf: both quadratic invariants are bounded."""
        return np.inf

    def period(self, x0: ArrayLike) -> float:
        """4K over the speed; inf on a separatrix, and at rest."""
        return float(self._orbit(x0).period / self._tempo)

    def rate(self, x0: ArrayLike) -> float:
        """That of dn, whose period is 2K ≥ π."""
        return 2 * float(self._orbit(x0).speed * self._tempo)

    @property
    def _tempo(self) -> np.longdouble:
        return np.longdouble(np.prod(np.sqrt(np.abs(self.c))))

    @property
    def _order(self) -> list[int]:
        """The variables, the one that is alone in its sign first."""
        alone = int(np.argmax(np.sign(self.c) == -np.sign(self.c).sum()))
        return [alone, (alone + 1) % 3, (alone + 2) % 3]

    def _orbit(self, x0: ArrayLike) -> jacobi.Orbit:
        return jacobi.orbit(*(_extended(x0) / np.sqrt(np.abs(self.c)))[self._order])


@dataclass(frozen=True, eq=False)
class PendulumFlow:
    """Flow of u' = αv, v' = κ sin(γu + δ), ακγ ≠ 0, where u = x[position] and v is the other variable.

    With ω² = |ακγ| and the angle from the bottom θ = γu + δ (+ π where ακγ > 0), sin θ/2, cos θ/2 and θ'/2ω move as
    `jacobi.Orbit` in the time ωt. The angle is the one of the start and the turn since, whole turns counted by time.
    """

    position: int
    alpha: np.longdouble
    kappa: np.longdouble
    gamma: np.longdouble
    delta: np.longdouble
    name: str = "Jacobi am"

    def __call__(self, x0: ArrayLike, t: ArrayLike) -> Extended:
        """States (n, 2) at the elapsed times t (n,) from x0 (2,)."""
        x, orbit, time = _extended(x0), self._orbit(x0), self._frequency * _extended(t)
        turns = np.zeros_like(time)
        if not orbit.swings and orbit.period < np.inf:  # over the top, once in half the period of sin θ/2
            turns = np.rint(2 * time / orbit.period)
            time = time - turns * (orbit.period / 2)
            turns *= np.sign(orbit.z)
        sine, cosine, speed = orbit.at(time).T
        half_turn = np.arctan2(sine * orbit.y - cosine * orbit.x, cosine * orbit.y + sine * orbit.x)
        states = np.empty((len(time), 2), dtype=np.longdouble)
        states[:, self.position] = x[self.position] + 2 * (half_turn + _PI * turns) / self.gamma
        states[:, 1 - self.position] = 2 * self._frequency / (self.alpha * self.gamma) * speed
        return states

    def lifetime(self, x0: ArrayLike) -> float:
        """Inf: sin θ/2, cos θ/2 and the energy are bounded."""
        return np.inf

    def period(self, x0: ArrayLike) -> float:
        """4K/ω where it swings; inf where it goes over the top, on the separatrix, and at rest."""
        orbit = self._orbit(x0)
        return float(orbit.period / self._frequency) if orbit.swings else np.inf

    def rate(self, x0: ArrayLike) -> float:
        """2ω, or more where it goes over the top: sin θ has the period 2K, K ≥ π/2."""
        return 2 * float(self._orbit(x0).speed * self._frequency)

    @property
    def _frequency(self) -> np.longdouble:
        return np.longdouble(np.sqrt(np.abs(self.alpha * self.kappa * self.gamma)))

    def _orbit(self, x0: ArrayLike) -> jacobi.Orbit:
        x = _extended(x0)
        half = (self.gamma * x[self.position] + self.delta) / 2
        speed = self.alpha * self.gamma * x[1 - self.position] / (2 * self._frequency)
        if self.alpha * self.kappa * self.gamma > 0:
            return jacobi.orbit(np.cos(half), -np.sin(half), speed)
        return jacobi.orbit(np.sin(half), np.cos(half), speed)


def _extended(values: ArrayLike) -> Extended:
    return np.atleast_1d(np.asarray(values, dtype=np.longdouble))
