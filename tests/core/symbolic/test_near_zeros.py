"""Quotients near a zero of their denominator, as they are written for evaluation."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core.symbolic.near_zeros import Choice


def declared(f, **parameters):
    fields = (f, "1")
    return core.PiecewiseSystem("Near", ("x", "y"), fields, fields, "y + 9", parameters=parameters, x0=(2.1, 0.6))


#: Fields that lose their digits near x = 1, with the same in mpmath.
LOST = {
    "(x - 1 - sin(x - 1))/(x - 1)**3": lambda x: (x - 1 - mpmath.sin(x - 1)) / (x - 1) ** 3,
    "1/(x - 1) - 1/tan(x - 1)": lambda x: 1 / (x - 1) - 1 / mpmath.tan(x - 1),
    "(x**3 + x - 2 - sin(x**3 + x - 2))/(x**3 + x - 2)**3": lambda x: (
        (x**3 + x - 2 - mpmath.sin(x**3 + x - 2)) / (x**3 + x - 2) ** 3
    ),
    "(cos(x) - cos(1))/(x**2 - 1)": lambda x: (mpmath.cos(x) - mpmath.cos(1)) / (x**2 - 1),
    "1/(x**2 - 1) - 1/log(x**2)": lambda x: 1 / (x**2 - 1) - 1 / mpmath.log(x**2),
    "(exp(x) - 3 + x - exp(1) + 2)**2/(1 - cosh(exp(x) + x - exp(1) - 1))": lambda x: (
        (mpmath.exp(x) + x - mpmath.e - 1) ** 2 / (1 - mpmath.cosh(mpmath.exp(x) + x - mpmath.e - 1))
    ),
}


@pytest.mark.parametrize("f", LOST)
def test_a_field_keeps_its_digits_however_near_to_the_zero(f):
    system = declared(f)
    for distance in (0.3, -0.1, 1e-2, -1e-3, 1e-5, -1e-7, 1e-9, -1e-12, 2.0**-52):
        x = 1.0 + distance
        with mpmath.workdps(100):
            right = float(LOST[f](mpmath.mpf(x)))
        assert system.field(1, 0.0, (x, 0.0))[0] == pytest.approx(right, rel=1e-11), x
    assert np.isfinite(system.field(1, 0.0, (1.0, 0.0))).all()


@pytest.mark.parametrize(
    "f", ["sin(x)/x", "x + 1/a", "x/(x**2 + y**2 + 1)", "(1 - cos(x))/x**2", "1/x", "(exp(x) - 1)/x"]
)
def test_a_field_that_keeps_its_digits_as_it_is_declared_is_evaluated_so(f):
    mode = declared(f, a=2.0).laws.mode(0)
    assert mode.written is mode


def test_what_is_shown_is_the_declared_field_and_its_scheme():
    mode = declared("(x - sin(x))/x**3").laws.mode(0)
    assert mode.written.field[0].has(Choice)
    assert not any(part.has(Choice) for part in (*mode.field, *mode.discrete.expression))
    assert mode.written.discrete.expression.has(Choice)


@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_a_run_stops_where_digits_are_lost_and_no_series_is_found(method):
    """The zero, x = 0.3776…, is no number that algebra finds; the quotient is exp(x) cos(x)."""
    system = declared("(exp(x)*sin(2*x) - 1)/(2*sin(x) - exp(-x)/cos(x))")
    with mpmath.workdps(40):
        zero = mpmath.findroot(lambda x: mpmath.exp(x) * mpmath.sin(2 * x) - 1, 0.38)
    for distance in (1e-12, 1e-9):
        step = {} if method == "taylor" else {"tau": 1e-13}
        run = core.integrate(system, (0.0, 1e-12), x0=(float(zero) + distance, 0.0), method=method, **step)
        assert run.status is core.Status.NO_CONVERGENCE
        assert "0/0" in run.message


@pytest.mark.parametrize(("b", "zero_over_zero"), [(4.0, True), (3.9, False), (2.5, False)])
def test_a_zero_common_to_numerator_and_denominator_for_some_parameters_is_called_so(b, zero_over_zero):
    run = core.integrate(declared("(x**2 - b)/(x - a)", a=2.0, b=b), (0.0, -5.0), tau=0.013, method="rk4")
    assert run.status is core.Status.SINGULAR
    assert ("0/0" in run.message) is zero_over_zero
    assert ("has no value" in run.message) is not zero_over_zero


def _turning(_t, phi):
    """Rate of the angle on x² + y² = 2 by Filippov's field of the fields below, for a = 2, p = 0.012, q = 0.27."""
    x = np.sqrt(2) * np.array([np.cos(phi[0]), np.sin(phi[0])])
    pulse = 0.05 / (0.012 + (x[1] - 0.27) ** 2)
    inside = np.array([2 * x[0] - 2 * x[1] + 1, 2 * x[0] + 2 * x[1] + pulse])
    outside = np.array([-2 * x[0] - 2 * x[1], 2 * x[0] - 2 * x[1] - pulse])
    rates = inside @ x, outside @ x
    v = (rates[0] * outside - rates[1] * inside) / (rates[0] - rates[1])
    return [(x[0] * v[1] - x[1] * v[0]) / 2]


@pytest.mark.parametrize("tau", [0.01, 0.005, 0.0025])
def test_a_field_that_passes_zero_far_from_a_zero_of_its_denominators_is_no_round_off(tau):
    """The slide passes x = 0, where the rate of y vanishes; p + (y − q)² vanishes for p < 0 alone."""
    pulse = "0.05/(p + (y - q)**2)"
    system = core.PiecewiseSystem(
        "Slide", ("x", "y"), ("a*x - 2*y + 1", f"2*x + a*y + {pulse}"), ("-a*x - 2*y", f"2*x - a*y - {pulse}"),
        "x**2 + y**2 - 2", parameters={"a": 2.0, "p": 0.012, "q": 0.27}, x0=(1.0, 0.5),
    )  # fmt: skip
    run = core.integrate(system, (0.0, 8.0), tau=tau, method="rk8", sliding="continue")
    assert run.status is core.Status.COMPLETED, run.message
    (begins,) = run.crossings
    span, start = (begins.t, 8.0), (np.arctan2(begins.x[1], begins.x[0]),)
    angle = solve_ivp(_turning, span, start, method="DOP853", rtol=1e-12, atol=1e-13).y[0, -1]
    assert run.x[-1] == pytest.approx(np.sqrt(2) * np.array([np.cos(angle), np.sin(angle)]), abs=1e-8)
