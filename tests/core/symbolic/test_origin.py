"""Expressions are written most simply about their origin, and come back from there as they were."""

import pytest
import sympy

from core.symbolic.origin import Origin

x, y, a, b, s = sympy.symbols("x y a b s", real=True)


@pytest.mark.parametrize(
    ("expressions", "about"),
    [
        (((x - a) ** 2 + y,), (x**2 + y,)),
        ((2 * (x - a) + 3 * (y - b), x - a), (2 * x + 3 * y, x)),
        (((x / s - a) ** 3, y * (x / s - a)), (x**3, x * y)),
        (((x - 1000) ** 2 + (x - 1000),), (x**2 + x,)),
        ((x**2 + y, x * y), (x**2 + y, x * y)),
        (((x - a) * (x - b), x - a), (x * (x + a - b), x)),
        (((s * x - a) ** 3, s * x - a, x * y), ((s * x - a) ** 3, s * x - a, x * y)),  # not divided by s: it may be 0
    ],
)
def test_expressions_about_their_origin_are_the_simplest(expressions, about):
    origin = Origin.of(expressions, (x, y))
    found = origin.about(expressions)
    assert [sympy.expand(u - v) for u, v in zip(found, about, strict=True)] == [0] * len(about)
    for u, v in zip(expressions, found, strict=True):
        assert sympy.expand(origin.back(v) - u) == 0
