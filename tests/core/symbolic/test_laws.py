"""Laws are evaluated on numbers whatever constants stand in them."""

import copy
import math
from typing import Any

import numpy as np
import pytest

import core

CONSTANTS = [
    ("sin(1e300)*x", math.sin(1e300)),
    ("cos(1e20)*x", math.cos(1e20)),
    ("exp(1e-300)*x", 1.0),
    ("sqrt(1e300)*x", 1e150),
    ("log(1e300 + 1)*x", math.log(1e300)),
    ("tanh(1e30)*x", 1.0),
    ("(1e300*x - 1e300)/1e300", 0.0),
    ("x*(1e30 + 1)/(1e30 - 1)", 1.0),
    ("x/1e30", 1e-30),
    ("1e30*x", 1e30),
]


@pytest.mark.parametrize(("text", "value"), CONSTANTS)
def test_long_constants_are_evaluated(text: str, value: float) -> None:
    system = core.PiecewiseSystem("own", ("x", "y"), (text, "y"), (text, "y"), "x + 1e300*y")
    one: Any = system.field(1, 0.0, (1.0, 0.0))
    many = system.field(1, np.zeros(3), np.ones((3, 2)))
    assert one[0] == pytest.approx(value, rel=1e-14, abs=1e-16)
    assert many[:, 0] == pytest.approx([value] * 3, rel=1e-14, abs=1e-16)
    numbers = system.laws.numbers("test", system.laws.modes[1].field, 0.0, (1.0, 0.0), system.parameter_array)
    assert numbers[0] == pytest.approx(value, rel=1e-14, abs=1e-16)
    assert system.switching(0.0, (0.0, 1.0)) == 1e300


def test_checking_a_declaration_leaves_the_laws_that_others_share_as_they_are() -> None:
    def declared(low: float) -> core.PiecewiseSystem:
        parameters = [core.Parameter("k", 2.0, (low, 3.0))]
        return core.PiecewiseSystem("own", ("x", "y"), ("y", "-k*x"), ("y", "-x"), "x + y", parameters=parameters)

    laws = declared(0.5).laws
    before = {name: copy.copy(value) for name, value in vars(laws).items()}
    assert declared(1.5).laws is laws
    assert vars(laws) == before


def test_a_rate_is_differentiated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    mode, g = core.CATALOGUE["elliptic_curve"].laws.regions[0], core.CATALOGUE["elliptic_curve"].laws.g
    first = mode.rate_of(g)
    monkeypatch.setattr("core.symbolic.mode.rate_along", lambda *_: pytest.fail("differentiated again"))
    assert mode.rate_of(g) == first
