"""Families: event functions drawn at random, along orbits that are known in closed form."""

import math

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq

import core
from core.symbolic.expressions import parse

#: x' = y, y' = −x, with walls nowhere: the surface is never reached.
CIRCLE = core.PiecewiseSystem(
    "circle", ("x", "y"), g="x - 50", f_minus=("y", "-x"), f_plus=("y", "-x"), psi_minus=("x**2 + y**2",),
    psi_plus=("x**2 + y**2",),
)  # fmt: skip
SHAPES = (
    "x - {a}", "x*y - {a}/2", "sin({b}*x + {a})", "x**2 - y/2 - {a}", "cos({b}*t)*y - {a}", "exp(x) - 1 - {a}",
    "tanh({b}*x)*y + {a}*sin(t)", "x**3 - {a}*y**2", "log(3 + x) - 1 - {a}/3", "sqrt(4 + y) - 2 - {a}/3",
    "sin({b}*t) - {a}",
)  # fmt: skip
SETTINGS = {
    "taylor": {"tolerance": 1e-13}, "rk8": {"tau": 0.02}, "prk8": {"tau": 0.02}, "dmm8": {"tau": 0.02},
}  # fmt: skip
T = 15.0


def exact(start, t):
    """State at a time, or states at times."""
    x, y = start
    return x * np.cos(t) + y * np.sin(t), y * np.cos(t) - x * np.sin(t)


def zeros(function, start, t_end):
    """Times at which a function changes its sign along the orbit, and whether it rises with time there."""
    value = sympy.lambdify(sympy.symbols("x y t"), parse(function, ("x", "y")), "numpy")

    def along(t):
        return value(*exact(start, t), t)

    times = np.linspace(0.0, t_end, 20_001)
    values = along(times)
    at = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    found = [brentq(along, times[k], times[k + 1], xtol=1e-15, rtol=1e-14) for k in at]
    rises = np.sign(values[at + 1] - values[at]) * math.copysign(1.0, t_end)
    return np.array(found), rises.astype(int)


@pytest.mark.parametrize("method", SETTINGS)
def test_all_zeros_of_drawn_functions_are_found_and_no_others(method, draws):
    for random in draws(12):
        function = str(random.choice(SHAPES)).format(
            a=round(random.uniform(-0.9, 0.9), 3), b=round(random.uniform(0.5, 9.0), 3)
        )
        start, t_end = random.uniform(0.3, 1.5, 2), float(random.choice([-T, T]))
        run = core.integrate(CIRCLE, (0.0, t_end), start, method=method, events=function, **SETTINGS[method])
        wanted, rises = zeros(function, start, t_end)
        assert len(run.events) == len(wanted), (function, start, t_end)
        assert run.events.t == pytest.approx(wanted, abs=1e-9), (function, start, t_end)
        assert np.array_equal(run.events.direction, rises), (function, start, t_end)
        alone = core.integrate(CIRCLE, (0.0, t_end), start, method=method, **SETTINGS[method])
        assert np.array_equal(alone.x, run.x)


@pytest.mark.parametrize("method", ["rk4", "gauss4", "dmm2", "taylor"])
def test_a_zero_at_the_end_of_a_step_is_one_event_and_a_touch_there_is_none(method, draws):
    line = core.PiecewiseSystem("line", ("x", "y"), g="y - 1e3", f_minus=("1", "0"), f_plus=("1", "0"))
    odd = ("sin({w}*{s} + {a})", "cos({w}*{s} + {a} + pi/2)", "sin({w}*{s} + {a})*(2 + cos(x))")
    even = ("sin({w}*{s} + {a})**2", "cos(2*({w}*{s} + {a})) - 1", "sin({w}*{s} + {a})**2*(2 + sin(t))")
    for random in draws(40):
        tau, every = round(float(random.choice([0.01, 0.02, 0.05, 0.1, 0.3])), 3), int(random.integers(8, 40))
        period = tau * every
        shape, off = str(random.choice(odd + even)), float(random.choice([0.0, 1e-16, -3e-16, 1e-15, 1e-14, 3e-9]))
        function = shape.format(w=f"pi/{period!r}", s=random.choice(["t", "x"]), a=off)
        start, sign = float(random.choice([0.0, -7.0 * period])) + period / 2, int(random.choice([-1, 1]))
        start = round(start / tau) * tau
        run = core.integrate(
            line, (start, start + sign * 12.3 * period), (start, 0.0), tau=tau, method=method, events=function
        )  # fmt: skip
        zeros = np.arange(-30, 30) * period
        wanted = zeros[(zeros - start) * (zeros - run.t[-1]) < 0.0][::sign] if shape in odd else []
        assert len(run.events) == len(wanted), (function, tau, start, sign)
        assert run.events.t == pytest.approx(wanted, abs=3e-9 * period), (function, tau, start, sign)
        assert (run.events.direction[1:] == -run.events.direction[:-1]).all()
