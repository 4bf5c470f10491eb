"""Sizes of coordinates that expressions name."""

import numpy as np
import pytest
import sympy

from core.symbolic.landmarks import at_landmarks, landmarks

X, Y, A = sympy.symbols("x y a")


@pytest.mark.parametrize(
    ("text", "sizes"),
    [
        ("x + y - 300", {X: (300,), Y: (300,)}),
        ("2*x**2 + y**2 - 72", {X: (6,), Y: (72**0.5,)}),
        ("y - a", {Y: (40,)}),  # a lies between 30 and 50
        ("3*x*y - 12", {X: (4,), Y: (4,)}),
        ("x + y", {}),
    ],
)
def test_a_coordinate_balances_the_constant_of_its_sum(text: str, sizes: dict[sympy.Symbol, tuple[float, ...]]) -> None:
    found = landmarks((sympy.sympify(text),), (X, Y, A), {A: (30.0, 50.0)})
    assert found.keys() == sizes.keys()
    for symbol, expected in sizes.items():
        assert found[symbol] == pytest.approx(expected)


def test_points_are_drawn_up_to_twice_a_landmark_and_elsewhere_left_as_they_are() -> None:
    drawn = at_landmarks(np.ones((400, 2)), (X, Y), {Y: (300.0,)}, np.random.default_rng(0))
    assert (drawn[:, 0] == 1).all()
    assert np.abs(drawn[:, 1]).max() <= 600
    assert (np.abs(drawn[:, 1]) > 150).mean() > 0.4
