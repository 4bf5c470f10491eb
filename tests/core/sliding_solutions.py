"""Exact solutions that slide, of systems whose fields are linear and differ by a constant vector: in 30 digits.

With z = (x, cos wt, sin wt, 1), x' = M± z and M₊ z − M₋ z = k, a constant. While both fields point to n·z = 0, the
equivalent control λ keeps n·z: z' = M₋ z + λ k with λ = −n·M₋z / n·k (Utkin, Sliding Modes, 1992). All flows are matrix
exponentials; the instants between them are roots of n·z, or of the rates n·M±z. No code of core is used.
"""

from functools import cached_property

import mpmath as mp
import numpy as np

DIGITS = 30
#: Distance between the times at which signs are looked at: no sign changes twice within it here.
SPACING = mp.mpf(1) / 50


class Exact:
    """The solution from z₀ on: `events` (t, kind) up to the end time, and the state at any time before."""

    def __init__(self, minus, plus, normal, z0, end):
        with mp.workdps(DIGITS):
            below, above, self.n = mp.matrix(minus), mp.matrix(plus), mp.matrix([normal])
            k = (above - below)[:, len(z0) - 1]
            sliding = below - k * (self.n * below) / (self.n * k)[0]
            self.m, self.z0, self.end = {-1: below, 1: above, 0: sliding}, mp.matrix(z0), mp.mpf(end)

    def height(self, z):
        """n·z, the height above the surface."""
        return (self.n * z)[0]

    def rates(self, z):
        """Rates of n·z with the fields of both sides."""
        return (self.n * self.m[-1] * z)[0], (self.n * self.m[1] * z)[0]

    def guard(self, side, z):
        """What ends an arc where it becomes negative."""
        below, above = self.rates(z)
        return side * self.height(z) if side else -below * above

    @cached_property
    def arcs(self):
        """(start, state there, side, kind of the event that began it) of every arc."""
        with mp.workdps(DIGITS):
            t, z = mp.mpf(0), self.z0
            arcs = [(t, z, int(mp.sign(self.height(z))), None)]
            while (found := self._next(*arcs[-1][:3])) is not None:
                t, z = found
                below, above = self.rates(z)
                side = arcs[-1][2]
                if side == 0:
                    arcs.append((t, z, 1 if below + above > 0 else -1, "leaving"))
                else:
                    slides = below > 0 > above
                    arcs.append((t, z, 0 if slides else -side, "sliding" if slides else "transversal"))
            return arcs

    def _next(self, t, z, side):
        step, h = mp.expm(self.m[side] * SPACING), mp.mpf(0)
        y = z
        while t + h < self.end:
            y, h = step * y, h + SPACING
            if self.guard(side, y) < 0:
                h = self._zero(side, z, h - SPACING, h)
                return (t + h, self._flow(side, z, h)) if t + h < self.end else None
        return None

    def _zero(self, side, z, low, high):
        """Zero of the guard between two times; by bisection where a faster method does not come to an end."""

        def guard(s):
            return self.guard(side, self._flow(side, z, s))

        try:
            return mp.findroot(guard, (low, high), solver="anderson", tol=1e-50)
        except ValueError:
            return mp.findroot(guard, (low, high), solver="bisect", maxsteps=110, verify=False)

    def _flow(self, side, z, h):
        return mp.expm(self.m[side] * h) * z

    @property
    def kinds(self):
        """Kinds of the events."""
        return [kind for *_, kind in self.arcs[1:]]

    @property
    def times(self):
        """Times of the events."""
        return np.array([float(t) for t, *_ in self.arcs[1:]])

    def state(self, t, d):
        """The first d coordinates at time t."""
        with mp.workdps(DIGITS):
            begun, z, side, _ = next(arc for arc in reversed(self.arcs) if arc[0] <= t)
            return np.array([float(v) for v in self._flow(side, z, t - begun)[:d]])


def friction(y, v, end, mu, load, w):
    """y'' = −y − μ sign(y') + F cos wt: a block on a spring, pushed to and fro, that sticks and slips."""
    mu, load, w = mp.mpf(mu), mp.mpf(load), mp.mpf(w)

    def law(side):
        return [[0, 1, 0, 0, 0], [-1, 0, load, 0, -side * mu], [0, 0, 0, -w, 0], [0, 0, w, 0, 0], [0] * 5]

    return Exact(law(-1), law(1), [0, 1, 0, 0, 0], [y, v, 1, 0, 1], end)


def relay(x0, end):
    """A relay fed back to a plant of third order that is not minimum-phase: it slides until sliding blows up."""
    c = [1, mp.mpf("-0.2"), 1]

    def law(side):
        return [[0, 1, 0, 0], [0, 0, 1, 0], [-1, -2, mp.mpf("-1.5"), -side], [0] * 4]

    return Exact(law(-1), law(1), [*c, 0], [*map(mp.mpf, x0), 1], end)
