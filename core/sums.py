"""Σ aⱼ bₖ₋ⱼ over 1 ≤ j ≤ k − 1, of many rows of coefficients: the text of one loop that works all of them out.

The terms i and j = k − i go in pairs, i < j, from the middle outwards, so that the newest coefficients are waited for
last. One loop for all sums loads every coefficient once, and has its end mispredicted once.
"""

from __future__ import annotations

__all__ = ["Sums"]


class Sums:
    """The sums so far, by name."""

    def __init__(self) -> None:
        self._names: dict[tuple[object, ...], str] = {}
        self._begin: list[str] = []
        self._pair: list[str] = []
        self._end: list[str] = []

    def product(self, a: int, b: int) -> str:
        """Name of Σ aⱼ bₖ₋ⱼ, of two rows."""
        if a == b:
            return self._square(a)
        name, new = self._named("product", *sorted((a, b)))
        if new:
            self._begin.append(f"{name}, {name}_back = c[{a}, m]*c[{b}, m] if even else 0.0, 0.0")
            self._pair.append(f"{name} = fma(c[{a}, i], c[{b}, j], {name})")
            self._pair.append(f"{name}_back = fma(c[{a}, j], c[{b}, i], {name}_back)")
            self._end.append(f"{name} += {name}_back")
        return name

    def power(self, a: int, b: int, exponent: str) -> str:
        """Name of Σ (j (exponent + 1) − k) aⱼ bₖ₋ⱼ: the recurrence of b = a**exponent."""
        name, new = self._named("power", a, b, exponent)
        if new:
            weight = f"({{}}*({exponent} + 1.0) - k)"
            middle = f"{weight.format('m')}*(c[{a}, m]*c[{b}, m])"
            self._begin.append(f"{name}, {name}_back = {middle} if even else 0.0, 0.0")
            self._pair.append(f"{name} += {weight.format('i')}*(c[{a}, i]*c[{b}, j])")
            self._pair.append(f"{name}_back += {weight.format('j')}*(c[{a}, j]*c[{b}, i])")
            self._end.append(f"{name} += {name}_back")
        return name

    def lines(self) -> list[str]:
        """Lines that work all sums out from the coefficients below k."""
        if not self._names:
            return []
        head = ["m, even = unsigned(k >> 1), k & 1 == 0", *self._begin]
        head.append("i, j = unsigned((k - 1) >> 1), unsigned((k >> 1) + 1)")
        loop = [*self._pair, "i, j = unsigned(i - 1), unsigned(j + 1)"]
        return [*head, "while i > 0:", *(f"    {line}" for line in loop), *self._end]

    def _square(self, a: int) -> str:
        """Each pair once, and the term in the middle."""
        name, new = self._named("square", a)
        if new:
            self._begin.append(f"{name} = 0.0")
            self._pair.append(f"{name} = fma(c[{a}, i], c[{a}, j], {name})")
            self._end.append(f"{name} = ({name} + {name}) + (c[{a}, m]*c[{a}, m] if even else 0.0)")
        return name

    def _named(self, *key: object) -> tuple[str, bool]:
        new = key not in self._names
        return self._names.setdefault(key, f"sum{len(self._names)}"), new
