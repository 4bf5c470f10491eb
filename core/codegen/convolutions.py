"""Σ aⱼ bₖ₋ⱼ over 1 ≤ j ≤ k − 1, of many rows of coefficients: the text of one loop that works all of them out.

The terms i and j = k − i go in pairs, i < j, from the middle outwards, so that the newest coefficients are waited for
last. One loop for all sums loads every coefficient once, and has its end mispredicted once.

Where a function's next coefficient waits for such a sum of its own last one, as that of sine and cosine does, the last
pair comes after the loop, from registers: of row r, ``last{r}`` is coefficient k − 1, and ``one{r}`` is coefficient 1
(0 before k = 2), as ``again{r}`` is (0 before k = 3: the pair of k = 2 is one term).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

__all__ = ["Sums"]


class _Text(NamedTuple):
    """Lines for one sum: before the loop over its pairs, in that loop, after it without the last pair, and with it."""

    begin: str
    pairs: tuple[str, ...]
    rest: str
    last: str


class Sums:
    """The sums so far, by name."""

    def __init__(self) -> None:
        self._names: dict[tuple[object, ...], str] = {}
        self._texts: dict[str, _Text] = {}
        self._rows: dict[str, frozenset[int]] = {}
        self._awaited = False

    def product(self, a: int, b: int, awaited: bool = False) -> str:
        """Name of Σ aⱼ bₖ₋ⱼ, of two rows; `awaited` by a function one of whose rows this is."""
        if a == b:
            return self._square(a, awaited)
        name, new = self._named("product", *sorted((a, b)), awaited=awaited)
        if new:
            rest = f"{name} + {name}_back"
            self._add(name, {a, b}, _Text(
                f"{name}, {name}_back = c[{a}, m]*c[{b}, m] if even else 0.0, 0.0",
                (f"{name} = fma(c[{a}, i], c[{b}, j], {name})",
                 f"{name}_back = fma(c[{a}, j], c[{b}, i], {name}_back)"),
                f"{name} = {rest}", f"{name} = fma(one{a}, last{b}, fma(again{b}, last{a}, {rest}))",
            ))  # fmt: skip
        return name

    def _square(self, a: int, awaited: bool) -> str:
        """Each pair once, and the term in the middle."""
        name, new = self._named("square", a, awaited=awaited)
        if new:
            rest = f"({name} + {name}) + (c[{a}, m]*c[{a}, m] if even else 0.0)"
            self._add(name, {a}, _Text(
                f"{name} = 0.0", (f"{name} = fma(c[{a}, i], c[{a}, j], {name})",),
                f"{name} = {rest}", f"{name} = fma(one{a} + again{a}, last{a}, {rest})",
            ))  # fmt: skip
        return name

    def rows_of(self, name: str) -> frozenset[int]:
        """The rows that a sum is of."""
        return self._rows[name]

    def lines(self, needed: Collection[str]) -> list[str]:
        """Lines that work these sums out from the coefficients below k."""
        texts = self._texts_of(needed)
        if not texts:
            return []
        even, least = ("k & 1 == 0 and k > 2", 1) if self._awaited else ("k & 1 == 0", 0)
        head = [f"m, even = unsigned(k >> 1), {even}", *(text.begin for text in texts)]
        head.append("i, j = unsigned((k - 1) >> 1), unsigned((k >> 1) + 1)")
        loop = [*(line for text in texts for line in text.pairs), "i, j = unsigned(i - 1), unsigned(j + 1)"]
        ends = [text.last if self._awaited else text.rest for text in texts]
        return [*head, f"while i > {least}:", *(f"    {line}" for line in loop), *ends]

    def before(self, needed: Collection[str]) -> list[str]:
        """Lines that go before the loop over k."""
        return [f"last{r} = one{r} = again{r} = 0.0" for r in self._rows_of(needed)]

    def after(self, newest: Mapping[int, str], needed: Collection[str]) -> list[str]:
        """Lines that keep the coefficients k for the sums of the next k; `newest` names that of a row."""
        rows = self._rows_of(needed)
        if not rows:
            return []
        kept = [f"last{r} = {newest[r]}" for r in rows]
        first, second = ([f"    {to}{r} = {of}{r}" for r in rows] for to, of in (("one", "last"), ("again", "one")))
        return [*kept, "if k == 1:", *first, "elif k == 2:", *second]

    def _texts_of(self, needed: Collection[str]) -> list[_Text]:
        return [text for name, text in self._texts.items() if name in needed]

    def _rows_of(self, needed: Collection[str]) -> list[int]:
        """The rows whose newest coefficients are kept."""
        return sorted({row for name in needed for row in self._rows[name]}) if self._awaited else []

    def _named(self, *key: object, awaited: bool) -> tuple[str, bool]:
        self._awaited = self._awaited or awaited
        new = key not in self._names
        return self._names.setdefault(key, f"sum{len(self._names)}"), new

    def _add(self, name: str, rows: Iterable[int], text: _Text) -> None:
        self._rows[name], self._texts[name] = frozenset(rows), text
