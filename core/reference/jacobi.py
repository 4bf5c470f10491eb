"""Orbits of x' = yz, y' = −zx, z' = −xy, moved by addition of (sn, cn, dn).

In extended precision, like `flows`. The free rigid body and the pendulum's half angle are such orbits, stretched.
Sources: NIST DLMF §22.6(i), §22.8(i), §22.20(ii); Bulirsch, Numer. Math. 7 (1965) 78–90.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from core.reference.weierstrass import Extended

__all__ = ["Orbit", "jacobi_functions", "orbit", "quarter_period"]

_HALF_PI = np.longdouble("1.57079632679489661923132169163975144")
_EPS = np.finfo(np.longdouble).eps
_SMALL = np.sqrt(_EPS) / 4  # |u| below which sn u = u, cn u = dn u = 1 to round-off
_SATURATION = np.log(np.finfo(np.longdouble).max) / 4  # time on a separatrix: sech² is not yet 0, and tanh long 1


def quarter_period(complement: np.longdouble) -> np.longdouble:
    """K = π/(2 agm(1, k')) of the complementary modulus k' ≥ 0 (DLMF 19.8.5); inf at 0."""
    if complement == 0:
        return np.longdouble(np.inf)
    return np.longdouble(_HALF_PI / _means(complement)[-1][0])


def jacobi_functions(u: Extended, complement: np.longdouble) -> tuple[Extended, Extended, Extended]:
    """sn, cn and dn (n,) of the real arguments u (n,), |u| ≤ 2K, for the complementary modulus k' in [0, 1].

    By the descending Landen transformation in Bulirsch's form: cs = cn/sn and dn go from mean to mean through sums
    and products of what is of one sign, so that neither loses digits however close k' is to 0. At k' = 0 itself
    they are tanh and sech.
    """
    if complement == 0:
        sech = np.reciprocal(np.cosh(u))
        return np.tanh(u), sech, sech
    *means, (last, _) = _means(complement)
    small = np.abs(u) < _SMALL
    phase = last * np.where(small, 1, u)
    sine = np.sin(phase)  # its sign is that of sn: phase may be a rounding beyond π
    cot = np.divide(np.cos(phase), sine)
    cs, dn = last * cot, np.ones_like(u)
    for a, b in reversed(means):
        square = cs * cot
        cs, dn, cot = cs * dn, (b + square) / (a + square), cs * dn / a
    sn = np.copysign(1 / np.sqrt(1 + cs * cs), sine)
    return np.where(small, u, sn), np.where(small, 1, cs * sn), np.where(small, 1, dn)


def _means(complement: np.longdouble) -> list[tuple[np.longdouble, np.longdouble]]:
    """Arithmetic and geometric means from (1, k') on until they agree to round-off."""
    a, b = np.longdouble(1), complement
    means = [(a, b)]
    while np.abs(a - b) > 4 * _EPS * a:
        a, b = (a + b) / 2, np.sqrt(a * b)
        means.append((a, b))
    return means


@dataclass(frozen=True)
class Orbit:
    """Orbit of x' = yz, y' = −zx, z' = −xy through (x, y, z); x² + y² and x² + z² stay what they are.

    With |z| ≥ |y| it is x = A sn, y = ±A cn, z = ±B dn of B·t, A² = x² + y², B² = x² + z², k = A/B; else y and z change
    places. The start gives sn, cn and dn themselves: no phase of the orbit, hence no inverse function.
    """

    x: np.longdouble
    y: np.longdouble
    z: np.longdouble

    @cached_property
    def _fixed(self) -> tuple[np.longdouble, np.longdouble, np.longdouble]:
        """A, B and k' = √(B² − A²)/B, which keeps its digits where k is close to 1."""
        low, high = sorted((np.abs(self.y), np.abs(self.z)))
        a, b = np.hypot(self.x, low), np.hypot(self.x, high)
        return a, b, np.longdouble(np.sqrt((high - low) * (high + low)) / b if b > 0 else 1)

    @property
    def speed(self) -> np.longdouble:
        """B: sn, cn and dn are functions of B·t."""
        return self._fixed[1]

    @property
    def swings(self) -> bool:
        """Whether z is the one to change sign, and y keeps its own."""
        return bool(np.abs(self.z) < np.abs(self.y))

    @cached_property
    def period(self) -> np.longdouble:
        """4K/B; inf on a separatrix, and at rest."""
        _, b, complement = self._fixed
        return np.longdouble(4 * quarter_period(complement) / b if b > 0 else np.inf)

    def at(self, t: Extended) -> Extended:
        """Points (n, 3) after the times t (n,)."""
        a, b, complement = self._fixed
        if a == 0:  # at rest, on the axis of y or z
            return np.tile(np.array([self.x, self.y, self.z]), (len(t), 1))
        u = np.clip(b * t, -_SATURATION, _SATURATION)
        if self.period < np.inf:
            u = b * (t - self.period * np.rint(t / self.period))
        small, large = (self.z, self.y) if self.swings else (self.y, self.z)
        sign = np.copysign(1, large)
        start = self.x / a, sign * small / a, np.abs(large) / b
        sn, cn, dn = _add(start, jacobi_functions(u, complement), (a / b) ** 2)
        x, small, large = a * sn, sign * a * cn, sign * b * dn
        return np.stack([x, large, small] if self.swings else [x, small, large], axis=-1)


#: Orbits met again and again, as one run asks for many times.
orbit = lru_cache(maxsize=256)(Orbit)


def _add(
    p: tuple[np.longdouble, np.longdouble, np.longdouble], q: tuple[Extended, Extended, Extended], m: np.longdouble
) -> tuple[Extended, Extended, Extended]:
    """sn, cn and dn (n,) of u + v from those of u and of v, m = k² (DLMF 22.8.1–22.8.3).

    The denominator 1 − m sn²u sn²v is written as a sum of squares, which does not cancel near a separatrix.
    """
    (s0, c0, d0), (s, c, d) = p, q
    bottom = c0**2 + (s0 * d) ** 2
    return (
        (s0 * c * d + s * c0 * d0) / bottom,
        (c0 * c - s0 * d0 * s * d) / bottom,
        (d0 * d - m * s0 * c0 * s * c) / bottom,
    )
