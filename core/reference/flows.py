"""Exact flows of smooth fields, recognised from their symbolic declaration.

Two families have closed forms here: affine fields (matrix exponential) and the fields equivalent to
X'' = 6X² − g₂/2 (Weierstrass ℘).  Everything is evaluated in extended precision (``np.longdouble``, 64-bit
mantissa on x86; plain double where the platform has nothing better), so that a result rounded to double is
good to its last digit and round-off does not pile up over many surface crossings.

Sources: NIST DLMF the sources of `weierstrass`; Higham, *Functions of Matrices* (2008), ch. 10.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import sympy
from numpy.typing import ArrayLike

from core.reference.weierstrass import Extended, Orbit, orbit

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


def recognise(field: tuple[sympy.Expr, ...], variables: tuple[sympy.Symbol, ...]) -> Flow | None:
    """Exact flow of x' = field(x), or None if no closed form is known here.

    Parameters
    ----------
    field : tuple of d expressions
        In the variables only, parameter values substituted; a Float stands for its exact binary value.
    variables : tuple of d symbols
    """
    exact = [exact_numbers(u) for u in field]
    if any(u.free_symbols - set(variables) or not u.is_polynomial(*variables) for u in exact):
        return None
    polynomials = [sympy.Poly(u, *variables) for u in exact]
    if any(not c.is_real for p in polynomials for c in p.coeffs()):
        return None
    if all(p.total_degree() <= 1 for p in polynomials):
        a = [[extended_number(p.coeff_monomial(v)) for v in variables] for p in polynomials]
        b = [extended_number(p.coeff_monomial(1)) for p in polynomials]
        return LinearFlow(np.array(a), np.array(b))
    return _recognise_weierstrass(polynomials, variables) if len(variables) == 2 else None


def _recognise_weierstrass(
    polynomials: list[sympy.Poly], variables: tuple[sympy.Symbol, ...]
) -> "WeierstrassFlow | None":
    """The flow of u' = αv, v' = βu² + γu + δ with (u, v) the variables in either order."""
    for i in (0, 1):
        u, v = variables[i], variables[1 - i]
        alpha = polynomials[i].coeff_monomial(v)
        force = polynomials[1 - i]
        beta = force.coeff_monomial(u**2)
        is_force = force.total_degree() == 2 and v not in force.as_expr().free_symbols
        if alpha != 0 and polynomials[i].as_expr() == alpha * v and is_force:
            gamma, delta = force.coeff_monomial(u), force.coeff_monomial(1)
            a, b, c, d = map(extended_number, (alpha, beta, gamma, delta))
            return WeierstrassFlow(i, a, b, c, d)
    return None


def exact_numbers(expression: sympy.Expr) -> sympy.Expr:
    """The expression with every Float replaced by the rational number it is."""
    return sympy.sympify(expression).xreplace(
        {c: sympy.Rational(c) for c in sympy.sympify(expression).atoms(sympy.Float)}
    )


def extended_number(number: sympy.Expr) -> np.longdouble:
    """The number correctly rounded to extended precision."""
    return np.longdouble(str(sympy.N(number, 30)))


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

    def _orbit(self, x0: ArrayLike) -> Orbit:
        x = _extended(x0)
        return orbit(
            self._g2, (x[self.position] - self._shift) / self._scale,
            self.alpha * x[1 - self.position] / self._scale,
        )  # fmt: skip


def _extended(values: ArrayLike) -> Extended:
    return np.atleast_1d(np.asarray(values, dtype=np.longdouble))
