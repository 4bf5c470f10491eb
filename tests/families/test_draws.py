"""The draws themselves: the same cases every time, and each its own."""

import numpy as np


def test_cases_differ_from_each_other(draws):
    first = [int(rng.integers(2**60)) for rng in draws(20)]
    assert len(set(first)) == len(first)


def test_cases_are_the_same_when_drawn_again(draws):
    assert [rng.random() for rng in draws(3)] == [rng.random() for rng in draws(3)]
    assert isinstance(next(iter(draws(1))), np.random.Generator)
