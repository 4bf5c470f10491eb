"""METHODS: what each says of itself is so."""

import math

import pytest

import core
from core.methods import registry


@pytest.mark.parametrize(
    ("half", "order"), [(registry._SUZUKI4, 4), (registry._KAHAN_LI6, 6), (registry._KAHAN_LI8, 8)], ids=["4", "6", "8"]
)
def test_weights_of_the_compositions_meet_the_order_conditions(half, order):
    # Necessary for a symmetric composition of a symmetric method (Hairer, Lubich, Wanner, Theorem V.3.1 and after):
    # the sums of the odd powers below the order vanish, but for the first, which is one.
    weights = (*half, 1 - 2 * math.fsum(half), *reversed(half))
    assert math.fsum(weights) == pytest.approx(1.0, abs=4e-16)
    for power in range(3, order, 2):
        assert math.fsum(w**power for w in weights) == pytest.approx(0.0, abs=4e-15)


def test_names_are_keys():
    assert all(name == method.name for name, method in core.METHODS.items())


def test_an_unknown_method_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="known are dmm2"):
        registry.method_named("euler")
