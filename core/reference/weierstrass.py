"""Orbits of X'' = 6X² − g₂/2: points of the cubic Y² = 4X³ − g₂X − g₃, moved by addition with (℘(t), ℘'(t)).

In extended precision, like `flows`. Sources: NIST DLMF §19.20, §19.25(vi), §23.3, §23.9, §23.10.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np
import scipy  # loads a subpackage when it is first used
from numpy.typing import NDArray

__all__ = ["Extended", "orbit", "weierstrass_p"]

Extended: TypeAlias = NDArray[np.longdouble]

_LAURENT_TERMS = 36  # remainder 7e-24: the nearest pole is at least 2.6 scaled units away
_LAURENT_REACH = 1.2  # scaled time |t|·max(|g₂|^¼, |g₃|^⅙) up to which the series is summed
_SATURATION = 80.0  # scaled time: longer than any passage by a saddle that round-off can tell from a stay
_NEWTON_STEPS = 6  # from within a sixth of the root
_POLISH_STEPS = 3  # Newton squares the error: 1e-8 at worst from elliprf, then 1e-16, then round-off


@dataclass(frozen=True)
class Orbit:
    """Orbit of X'' = 6X² − g₂/2 through (x, y) = (X, X')."""

    g2: np.longdouble
    x: np.longdouble
    y: np.longdouble

    @cached_property
    def g3(self) -> np.longdouble:
        return 4 * self.x**3 - self.g2 * self.x - self.y**2

    @cached_property
    def roots(self) -> Extended | NDArray[np.clongdouble]:
        """Roots of 4X³ − g₂X − g₃: the largest real one first, the other two after it, real or conjugate."""
        saddle = np.sqrt(np.maximum(self.g2, 0) / 12)
        above = self.y**2 - 4 * (self.x - saddle) ** 2 * (self.x + 2 * saddle)  # Y² less that of the separatrix
        if 0 < np.abs(above) < saddle**3 / 10:
            return _nearly_double_roots(saddle, above)
        e1 = _largest_root(self.g2, self.g3)
        gap = self.g2 - 3 * e1**2  # (e2 − e3)²
        half = np.sqrt(gap) if gap >= 0 else 1j * np.sqrt(-gap)
        return np.array([e1, (half - e1) / 2, (-half - e1) / 2])

    @cached_property
    def is_oval(self) -> bool:
        e = self.roots
        return not np.iscomplexobj(e) and bool(2 * self.x < e[0].real + e[1].real)

    @property
    def is_equilibrium(self) -> bool:
        return bool(self.y == 0 and 6 * self.x**2 == self.g2 / 2)

    @cached_property
    def period(self) -> np.longdouble:
        """Period on the oval, 2 R_F(0, e1−e2, e1−e3) (DLMF 19.25.40), polished by coming back; inf off it."""
        if not self.is_oval:
            return np.longdouble(np.inf)
        e = self.roots
        period = np.longdouble(2 * _carlson(np.array([0, e[0] - e[1], e[0] - e[2]])))
        for _ in range(_POLISH_STEPS if period < np.inf else 0):
            after = self._move(np.array([period]))[0]
            change = self._time_between(after[0], after[1], self.x, self.y)
            # a larger change is not elliprf's round-off: close to a separatrix coming back is ill-conditioned
            period += change if np.abs(change) < 1e-14 * period else 0
        return period

    @cached_property
    def poles(self) -> tuple[np.longdouble, np.longdouble]:
        """Elapsed times behind (< 0) and ahead (> 0) at which the orbit is at infinity; ∓inf if never."""
        return -Orbit(self.g2, self.x, -self.y).life, self.life

    @cached_property
    def life(self) -> np.longdouble:
        """Time to the pole ahead: R_F (DLMF 19.25.35) once the orbit has left all roots behind, polished."""
        never = np.longdouble(np.inf)
        if self.is_oval or self.is_equilibrium:
            return never
        # less than any half period: a move of half of it cannot pass a pole
        reach = _LAURENT_REACH / self.inverse_time if self.inverse_time > 0 else never
        x, y, elapsed = self.x, self.y, np.longdouble(0)
        while elapsed * self.inverse_time < _SATURATION:
            left = self._time_to_pole(x, y) if y > 0 else never
            if left <= reach:  # at once if g₂ = g₃ = 0: the reach is infinite
                return elapsed + left
            ((x, y),) = self._at_once(np.array([x]), np.array([y]), np.array([reach / 2]))
            elapsed += reach / 2
        return never

    @cached_property
    def inverse_time(self) -> np.longdouble:
        """max(|g₂|^¼, |g₃|^⅙): the poles of ℘ are at least 2.6 times its inverse apart."""
        return np.longdouble(max(np.sqrt(np.sqrt(np.abs(self.g2))), np.cbrt(np.sqrt(np.abs(self.g3)))))

    def at(self, t: Extended) -> Extended:
        """Points (n, 2) of the cubic after the times t (n,)."""
        behind, ahead = self.poles
        if not np.all((behind < t) & (t < ahead)):
            raise ValueError(
                f"the orbit is finite only for elapsed times in ({behind:.17g}, {ahead:.17g}); "
                f"asked for {t.min():.17g} … {t.max():.17g}"
            )
        if self.is_equilibrium:
            return self._move(np.zeros_like(t))
        if self.period < np.inf:
            return self._move(np.fmod(t, self.period))
        limit = _SATURATION / self.inverse_time if self.inverse_time > 0 else np.longdouble(np.inf)
        return self._move(np.clip(t, -limit, limit))

    def _move(self, t: Extended) -> Extended:
        """Points (n, 2) after the times t, in equal moves within reach of the Laurent series.

        One long move would be as exact, but magnifies round-off as a passage of the saddle does, whether or
        not the orbit passes there.
        """
        moves = np.maximum(np.ceil(np.abs(t) * self.inverse_time / _LAURENT_REACH), 1).astype(int)
        points = np.tile(np.array([self.x, self.y]), (len(t), 1))
        moves[np.abs(t) < np.finfo(float).tiny ** 0.25] = 0  # 1/t³ stays finite
        for done in range(int(moves.max(initial=0))):
            more = moves > done
            points[more] = self._at_once(points[more, 0], points[more, 1], t[more] / moves[more])
        return points

    def _at_once(self, x: Extended, y: Extended, t: Extended) -> Extended:
        return _add(x, y, *weierstrass_p(t, self.g2, self.g3), self.g2)

    def _time_to_pole(self, x: np.longdouble, y: np.longdouble) -> np.longdouble:
        difference = x - self.roots
        difference[0] = max(difference[0].real, 0)  # round-off at a turning point
        t = np.longdouble(_carlson(difference))  # DLMF 19.25.35: the t > 0 with ℘(t) = X
        for _ in range(_POLISH_STEPS):
            if t * self.inverse_time > _LAURENT_REACH:
                break
            p, q = weierstrass_p(np.array([t]), self.g2, self.g3)
            t += self._time_between(p[0], q[0], x, -y)
        return t

    def _time_between(
        self, xa: np.longdouble, ya: np.longdouble, xb: np.longdouble, yb: np.longdouble
    ) -> np.longdouble:
        """Time from a point to another one close by, to first order along the curve."""
        bend, weight = 6 * xa**2 - self.g2 / 2, np.abs(xa) + self.inverse_time**2
        speed = weight * ya**2 + bend**2
        return np.longdouble((weight * (xb - xa) * ya + (yb - ya) * bend) / speed if speed > 0 else 0)


#: Orbits met again and again, as one run asks for many times.
orbit = lru_cache(maxsize=256)(Orbit)


def weierstrass_p(t: Extended, g2: np.longdouble, g3: np.longdouble) -> tuple[Extended, Extended]:
    """℘(t) and ℘'(t), (n,), by their Laurent series (DLMF 23.9.2); t (n,) not 0 and within reach."""
    p, q, square = np.zeros_like(t), np.zeros_like(t), t * t
    for k, c in reversed(list(enumerate(_laurent(g2, g3)))):
        p = p * square + c
        q = q * square + (2 * k - 2) * c
    return p / square, q / (square * t)


@lru_cache(maxsize=256)
def _laurent(g2: np.longdouble, g3: np.longdouble) -> list[np.longdouble]:
    """Coefficients of t²℘(t) in powers of t² (DLMF 23.9.3–23.9.5)."""
    c = np.zeros(_LAURENT_TERMS, dtype=np.longdouble)
    c[0], c[2], c[3] = 1, g2 / 20, g3 / 28
    for n in range(4, _LAURENT_TERMS):
        c[n] = 3 * (c[2 : n - 1] @ c[n - 2 : 1 : -1]) / ((2 * n + 1) * (n - 3))
    return list(c)


def _add(x: Extended, y: Extended, p: Extended, q: Extended, g2: np.longdouble) -> Extended:
    """Sums (n, 2) of the points (x, y) and the points (p, q) (n,) of Y² = 4X³ − g₂X − g₃ (DLMF 23.10.1).

    The chord's slope ΔY/ΔX also is (4(X₁² + X₁X₂ + X₂²) − g₂)/(Y₁ + Y₂), which is right where the points
    meet: the form with the smaller bound on its round-off is taken.  X is computed as a change from the point
    farther from infinity.
    """
    swap = np.abs(p) < np.abs(x)
    xa, ya = np.where(swap, p, x), np.where(swap, q, y)
    xb, yb = np.where(swap, x, p), np.where(swap, y, q)
    dx, dy = xb - xa, yb - ya
    bend, extent = 6 * xa**2 - g2 / 2, np.abs(xa) + np.abs(xb)
    with np.errstate(divide="ignore", invalid="ignore"):
        chord = dy / dx
        by_chord = (bend * dx - ya * dy) / dx / dx / 2
        chord_error = np.abs(bend / dx) + np.abs(ya * chord / dx) + np.abs(by_chord / dx) * extent
        tangent = (4 * (xa**2 + xa * xb + xb**2) - g2) / (ya + yb)
        terms = 4 * extent**2 + np.abs(g2) + np.abs(tangent) * (np.abs(ya) + np.abs(yb))
        tangent_error = np.abs(tangent) * terms / np.abs(ya + yb) + extent
        meet = ~(chord_error <= tangent_error)
    slope = np.where(meet, tangent, chord)
    change = np.where(meet, tangent**2 / 4 - 2 * xa - xb, by_chord)
    return np.stack([xa + change, -(ya + slope * change)], axis=-1)


def _nearly_double_roots(saddle: np.longdouble, above: np.longdouble) -> Extended | NDArray[np.clongdouble]:
    """Roots of 4(X − s)²(X + 2s) + a, s = `saddle`, a = `above` small, as in `_Orbit.roots`.

    Newton's method for z = X − s from ±√(−a/12s): their distance 2z keeps the digits that g₃ has lost.
    """
    z = np.sqrt(np.array([-above / (12 * saddle)], dtype=np.clongdouble)) * np.array([1, -1])
    for _ in range(_NEWTON_STEPS):
        z = z - (z**2 * (z + 3 * saddle) + above / 4) / (3 * z * (z + 2 * saddle))
    pair, third = saddle + z, -(2 * saddle + z.sum())
    return np.append(pair.real, third.real) if above < 0 else np.insert(pair, 0, third.real)


def _largest_root(g2: np.longdouble, g3: np.longdouble) -> np.longdouble:
    """The largest real root of 4X³ − g₂X − g₃, by the trigonometric form or Cardano's."""
    discriminant = g2**3 - 27 * g3**2
    if discriminant >= 0:
        if g2 == 0:
            return g2
        cosine = np.clip(np.sqrt(np.longdouble(27)) * g3 / g2 ** np.longdouble(1.5), -1, 1)
        return np.longdouble(np.sqrt(g2 / 3) * np.cos(np.arccos(cosine) / 3))
    radical = np.sqrt(-discriminant / 27)
    u = np.cbrt((g3 + np.copysign(radical, g3)) / 8)  # the sum without cancellation
    return np.longdouble(u + g2 / (12 * u))


def _carlson(arguments: Extended | NDArray[np.clongdouble]) -> float:
    """R_F (DLMF 19.16.1) of a real argument and a real or conjugate pair: real but for round-off."""
    return float(scipy.special.elliprf(*arguments.astype(complex)).real)
