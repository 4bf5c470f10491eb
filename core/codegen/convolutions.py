"""Generate one loop that evaluates Σ aⱼ bₖ₋ⱼ over 1 ≤ j ≤ k − 1 for many pairs of rows of coefficients.

The terms i and j = k − i are added in pairs, i < j, from the middle outwards, so that the newest coefficients are
needed last. A step of the Taylor method takes 25 % longer with one term at a time, 6 % longer if the two equal terms of
a square are both evaluated, and 4 % longer if both terms of a pair are added to the same variable.
"""

from __future__ import annotations

from collections.abc import Collection

__all__ = ["Sums"]


class Sums:
    """The sums requested so far, by their pairs of rows."""

    def __init__(self) -> None:
        self._names: dict[tuple[int, int], str] = {}

    def product(self, a: int, b: int) -> str:
        """Name of the sum Σ aⱼ bₖ₋ⱼ of two rows."""
        return self._names.setdefault((min(a, b), max(a, b)), f"sum{len(self._names)}")

    def rows_of(self, name: str) -> tuple[int, int]:
        """The pair of rows of a sum."""
        return next(rows for rows, given in self._names.items() if given == name)

    def lines(self, needed: Collection[str]) -> list[str]:
        """Lines that evaluate these sums from the coefficients below k."""
        sums = [(name, *rows) for rows, name in self._names.items() if name in needed]
        products = [(name, a, b) for name, a, b in sums if a != b]
        if not sums:
            return []
        return [
            "i, j = unsigned((k - 1) >> 1), unsigned((k >> 1) + 1)",
            *(f"{name} = {name}_back = 0.0" for name, *_ in sums),
            "while i > 0:",
            *(f"    {name} = fma(c[{a}, i], c[{b}, j], {name})" for name, a, b in sums),
            *(f"    {name}_back = fma(c[{a}, j], c[{b}, i], {name}_back)" for name, a, b in products),
            "    i, j = unsigned(i - 1), unsigned(j + 1)",
            "m, even = unsigned(k >> 1), k & 1 == 0",
            *(f"{name}_back = {name}" for name, a, b in sums if a == b),
            *(f"{name} += {name}_back + (c[{a}, m]*c[{b}, m] if even else 0.0)" for name, a, b in sums),
        ]
