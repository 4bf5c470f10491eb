"""Systems with numbers of many digits, as programs write them, are made and run as fast as others, and right."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core

#: Functions of v with numbers a, b: text, and the same in numpy.
FUNCTIONS = {
    "exp(-{a}*{v} + {b})": lambda v, a, b: np.exp(-a * v + b),
    "exp(-(({v} - {a})/{b})**2)": lambda v, a, b: np.exp(-(((v - a) / b) ** 2)),
    "1/(1 + exp(-{a}*{v} + {b}))": lambda v, a, b: 1 / (1 + np.exp(-a * v + b)),
    "{b}*(1 - exp(-2*{a}*{v}))*exp(-{a}*{v})": lambda v, a, b: b * (1 - np.exp(-2 * a * v)) * np.exp(-a * v),
    "(1 + {v}**2)**{a}/{b}": lambda v, a, b: (1 + v**2) ** a / b,
    "sinh({a}*{v})/cosh({b}*{v})": lambda v, a, b: np.sinh(a * v) / np.cosh(b * v),
}


@pytest.mark.parametrize("first", FUNCTIONS)
def test_a_field_with_long_decimals_is_followed_as_scipy_follows_it(draws, first):
    for rng in draws(2):
        second = str(rng.choice(list(FUNCTIONS)))
        a, b, c, d = rng.uniform(0.2, 2.0, 4).tolist()
        texts = (first.format(v="y", a=a, b=b), f"-{second.format(v='x', a=c, b=d)}")
        system = core.PiecewiseSystem("long", ("x", "y"), texts, texts, f"x - exp({a}*y) - 50", x0=(0.3, 0.2))
        field = lambda t, z: (FUNCTIONS[first](z[1], a, b), -FUNCTIONS[second](z[0], c, d))  # noqa: E731, B023
        right = solve_ivp(field, (0.0, 0.5), (0.3, 0.2), "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        run = core.integrate(system, (0.0, 0.5), method="taylor")
        if run.status is core.Status.COMPLETED:  # else the solution has a pole
            assert run.x[-1] == pytest.approx(right, rel=1e-9, abs=1e-9)
