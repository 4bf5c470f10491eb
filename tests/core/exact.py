"""Divided differences in hundreds of digits, and round-off bounds: what the tests compare with."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import sympy

EPS = 2.0**-52
#: Two ends may be 1e-300 apart, and a difference of values cancels twice as many digits.
DIGITS = 700
#: φ, φ', φ''.
FUNCTIONS: dict[str, tuple[Any, Any, Any]] = {
    "sin": (mp.sin, mp.cos, lambda u: -mp.sin(u)),
    "cos": (mp.cos, lambda u: -mp.sin(u), lambda u: -mp.cos(u)),
    "tan": (mp.tan, lambda u: mp.sec(u) ** 2, lambda u: 2 * mp.tan(u) * mp.sec(u) ** 2),
    "exp": (mp.exp, mp.exp, mp.exp),
    "log": (mp.log, lambda u: 1 / u, lambda u: -1 / u**2),
    "sinh": (mp.sinh, mp.cosh, mp.sinh),
    "cosh": (mp.cosh, mp.sinh, mp.cosh),
    "tanh": (mp.tanh, lambda u: mp.sech(u) ** 2, lambda u: -2 * mp.tanh(u) * mp.sech(u) ** 2),
}


def differences(name: str, a: Any, b: Any) -> tuple[Any, Any, Any]:
    """φ[a, b], φ[a, a, b] and φ[a, b, b]."""
    phi, first, second = FUNCTIONS[name]
    with mp.workdps(DIGITS):
        a, b = mp.mpf(a), mp.mpf(b)
        if abs(b - a) <= mp.mpf(10) ** (-DIGITS // 2) * abs(b):
            return first(b), second(b) / 2, second(b) / 2
        slope = (phi(b) - phi(a)) / (b - a)
        return slope, (slope - first(a)) / (b - a), (first(b) - slope) / (b - a)


def condition(name: str, a: Any, b: Any) -> Any:
    """How far φ[a, b] moves, relative to eps, if it and both ends are moved by eps of the larger end."""
    slope, in_a, in_b = differences(name, a, b)
    return abs(slope) + (abs(in_a) + abs(in_b)) * max(abs(mp.mpf(a)), abs(mp.mpf(b)))


class Bounded:
    """A number with a bound, in units of eps, of the round-off of its making (running error analysis)."""

    def __init__(self, value: Any, bound: Any = 0) -> None:
        self.value, self.bound = mp.mpmathify(value), mp.mpf(bound)
        assert isinstance(self.value, mp.mpf), "no real number"

    @classmethod
    def of(cls, u: Any) -> Bounded:
        """A number, taken as exact, or what is bounded already."""
        return u if isinstance(u, cls) else cls(mp.mpf(u.numerator) / u.denominator if hasattr(u, "numerator") else u)

    def rounded(self) -> Bounded:
        """With one rounding more."""
        self.bound += abs(self.value)
        return self

    def __add__(self, other: Any) -> Bounded:
        other = self.of(other)
        return Bounded(self.value + other.value, self.bound + other.bound).rounded()

    def __mul__(self, other: Any) -> Bounded:
        other = self.of(other)
        bound = abs(self.value) * other.bound + abs(other.value) * self.bound
        return Bounded(self.value * other.value, bound).rounded()

    def __neg__(self) -> Bounded:
        return Bounded(-self.value, self.bound)

    def __sub__(self, other: Any) -> Bounded:
        return self + -self.of(other)

    def __rsub__(self, other: Any) -> Bounded:
        return self.of(other) - self

    def __truediv__(self, other: Any) -> Bounded:
        return self * self.of(other) ** -1

    def __rtruediv__(self, other: Any) -> Bounded:
        return self.of(other) / self

    def __pow__(self, exponent: Any) -> Bounded:
        p = self.of(exponent)
        value = self.value**p.value
        bound = abs(value) * abs(p.value) * (self.bound + abs(self.value)) / abs(self.value) if self.value else 0
        if p.bound:
            bound += abs(value * mp.log(self.value)) * p.bound
        return Bounded(value, bound).rounded()

    def __rpow__(self, base: Any) -> Bounded:
        return self.of(base) ** self

    __radd__, __rmul__ = __add__, __mul__


def _lifted(name: str) -> Any:
    phi, first, _ = FUNCTIONS[name]

    def function(u: Any) -> Bounded:
        u = Bounded.of(u)
        return Bounded(phi(u.value), abs(first(u.value)) * u.bound).rounded()

    def slope(a: Any, b: Any) -> Bounded:
        a, b = Bounded.of(a), Bounded.of(b)
        value, in_a, in_b = differences(name, a.value, b.value)
        return Bounded(value, abs(in_a) * a.bound + abs(in_b) * b.bound + 4 * condition(name, a.value, b.value))

    return {name: function, f"{name}_slope": slope}


#: Names of a lambdified expression that take `Bounded` numbers.
LIFTED: dict[str, Any] = {"sqrt": lambda u: Bounded.of(u) ** mp.mpf("0.5"), "pi": mp.pi, "E": mp.e}
for _name in FUNCTIONS:
    LIFTED |= _lifted(_name)


def bounded(expression: sympy.Expr, at: dict[sympy.Symbol, Any]) -> Bounded:
    """Value and round-off bound of an expression at numbers that are exact."""
    function = sympy.lambdify(list(at), expression, modules=[LIFTED, "mpmath"])
    return Bounded.of(function(*(Bounded(v) for v in at.values())))
