"""The sums of the recurrences, as the text that is compiled works them out."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from core.codegen.convolutions import Sums
from core.codegen.functions import function_text, module_text
from core.compilation.compiled import _load
from tests.core.exact import EPS
from tests.core.frames import pointer

LENGTH = 32


@cache
def compiled() -> Callable[..., int]:
    """A function that works sums out for every k up to t, and leaves those of the last in w."""
    sums = Sums()
    names = [sums.product(1, 3), sums.product(2, 2), sums.product(3, 1)]
    assert names.pop() == names[0]  # worked out once
    loop = [*sums.lines(names), *(f"w[{i}] = {name}" for i, name in enumerate(names))]
    lines = [f"c = carray(scratch, (4, {LENGTH}))", "for k in range(1, int(t) + 1):"]
    lines += [f"    {line}" for line in loop]
    return _load(module_text([function_text("sums", [*lines, "return 0"])])).sums.ctypes


def exact_sum(a: Any, b: Any, k: int) -> tuple[Fraction, Fraction]:
    """Σ of the terms, and of their sizes."""
    terms = [Fraction(a[j]) * Fraction(b[k - j]) for j in range(1, k)]
    return sum(terms, Fraction(0)), sum(map(abs, terms), Fraction(0))


@pytest.mark.parametrize("k", range(1, LENGTH))
def test_sums_are_exact_but_for_one_rounding_a_term(k: int) -> None:
    c = np.random.default_rng(20260102).uniform(-1, 1, (4, LENGTH))
    values, nothing = np.empty(2), np.empty(1)
    compiled()(float(k), 0.0, *(pointer(array) for array in (nothing, values, c)))
    wanted = [exact_sum(c[1], c[3], k), exact_sum(c[2], c[2], k)]
    for value, (exact, size) in zip(values, wanted, strict=True):
        assert abs(Fraction(value) - exact) <= Fraction((k + 4) * EPS / 2) * size
