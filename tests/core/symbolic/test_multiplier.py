"""Discrete gradients by slopes, and the discrete fields made of them."""

import math
from typing import Any

import mpmath as mp
import pytest
import sympy
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from core import PiecewiseSystem
from core.codegen.functions import assignments
from core.kernels import divided_differences
from core.kernels.doubledouble import error_free
from core.symbolic.expressions import parse
from core.symbolic.multiplier import DIFFERENCES, DiscreteField, Endpoints, slopes
from tests.core.exact import EPS, FUNCTIONS, bounded
from tests.core.sample_systems import ALL, DAMPED, ELLIPTIC, HARMONIC, KEPLER, RIGID_BODY
from tests.levels import tries

X, Y, A, T = sympy.symbols("x y a t")
ENDS = Endpoints.of((X, Y), {"x", "y", "a"})
STEP = tuple(zip((*ENDS.start, ENDS.times[0]), (*ENDS.end, ENDS.times[1]), strict=True))
DIGITS = 50
FIXED = settings(tries(60), suppress_health_check=list(HealthCheck))

_leaves = st.sampled_from(["x", "y", "t", "a", "x*y", "2", "0.3", "pi"])
_operations = ["({0}) + ({1})", "({0}) - ({1})", "({0})*({1})", "({0})/(2 + ({1})**2)", "({0})**2", "({0})**5"]
_operations += ["({0})**(-3)", "(1 + ({0})**2)**0.5", "sqrt(3 + sin({0}))", "(2 + cos({0}))**(-2/3)"]
_operations += ["(2 + tanh({0}))**a", "a**({0})", "2**sin({0})", "(1 + ({0})**2)**sin({1})", "log(1 + ({0})**2)"]
_operations += [f"{name}({{0}})" for name in FUNCTIONS if name != "log"]
_texts = st.recursive(
    _leaves,
    lambda inner: st.builds(lambda op, u, v: op.format(u, v), st.sampled_from(_operations), inner, inner),
    max_leaves=4,
)

_points = st.tuples(*[st.floats(0.2, 1.2)] * 3)
_gaps = st.tuples(*[st.just(0.0) | st.floats(-16, -0.3).map(lambda k: 10.0**k) | st.floats(-0.15, 0.9)] * 3)


def values(start: Any, gap: Any) -> dict[sympy.Symbol, float]:
    """Numbers for the symbols of a step in (x, y, t) and a."""
    at = {A: 1.7}
    for (first, last), u, du in zip(STEP, start, gap, strict=True):
        at |= {first: u, last: u + du}
    return at


def exactly(expression: sympy.Expr, at: dict[sympy.Symbol, float]) -> Any:
    with mp.workdps(DIGITS):
        return bounded(expression, at)


def in_double_precision(expression: sympy.Expr, at: dict[sympy.Symbol, float]) -> float:
    """The very text that is compiled, run on floats."""
    lines = assignments(["result"], [expression], sympy.numbered_symbols("v"))
    scope: dict[str, Any] = {
        "math": math,
        **vars(error_free),
        **vars(divided_differences),
        **{str(s): v for s, v in at.items()},
    }
    exec("\n".join(lines), scope)  # noqa: S102 - text of our own making
    return float(scope["result"])


def change_by_slopes(u: sympy.Expr) -> sympy.Expr:
    return sum(s * (last - first) for s, (first, last) in zip(slopes(u, ENDS), STEP, strict=True))


def change(u: sympy.Expr) -> sympy.Expr:
    return u.xreplace(ENDS.at_end) - u.xreplace(ENDS.at_start)


@FIXED
@given(_texts, _points, _gaps)
@example("x/(1 + y**2)**1.5 - tanh(x*y)**7 + cosh(t)", (0.5, 0.7, 0.3), (0.0, 0.0, 0.0))
@example("x**y", (0.5, 0.7, 0.3), (1e-16, -1e-9, 0.0))
@example("x**(-7/3) + y**(11/12) + x**0.123", (0.5, 0.7, 0.3), (0.4, -1e-9, 0.0))
def test_slopes_times_increments_are_the_change(text: str, start: Any, gap: Any) -> None:
    u, at = parse(text, ("x", "y", "a")), values(start, gap)
    total, wanted = exactly(change_by_slopes(u), at), exactly(change(u), at)
    assume(total.bound < 1e12)
    # An identity: what is left at 50 digits is their round-off.
    assert abs(total.value - wanted.value) <= (total.bound + wanted.bound) * mp.mpf(10) ** (2 - DIGITS)
    # In double precision: within the running bound of round-off, to which terms of second order add little.
    assert abs(in_double_precision(change_by_slopes(u), at) - total.value) <= 2 * EPS * total.bound + 1e-300


@FIXED
@given(_texts, _points, _gaps)
def test_slopes_are_symmetric_in_the_two_ends(text: str, start: Any, gap: Any) -> None:
    u, at = parse(text, ("x", "y", "a")), values(start, gap)
    back = at | {s: at[e] for s, e in STEP} | {e: at[s] for s, e in STEP}
    for s in slopes(u, ENDS):
        there, again = exactly(s, at), exactly(s, back)
        assert abs(there.value - again.value) <= (there.bound + again.bound) * mp.mpf(10) ** (2 - DIGITS)


@FIXED
@given(_texts, _points)
def test_slopes_at_one_point_are_the_gradient(text: str, start: Any) -> None:
    u, at = parse(text, ("x", "y", "a")), values(start, (0.0, 0.0, 0.0))
    for s, v in zip(slopes(u, ENDS), (X, Y, T), strict=True):
        slope, derivative = exactly(s, at), exactly(u.diff(v).xreplace(ENDS.at_start), at)
        assert abs(slope.value - derivative.value) <= (slope.bound + derivative.bound) * mp.mpf(10) ** (2 - DIGITS)


@pytest.mark.parametrize("exponent", [1, 2, 7, 64, -1, -5, "1/2", "-1/2", "3/2", "7/3", "-5/12", "0.123", "a", "a*y"])
def test_power_slopes_hold_for_every_kind_of_exponent(exponent: object) -> None:
    u = parse(f"x**({exponent})", ("x", "y", "a"))
    for gap in (0.0, 1e-15, 1e-3, 2.0):
        at = values((0.7, 0.4, 0.0), (gap, 0.0, 0.0))
        total, wanted = exactly(change_by_slopes(u), at), exactly(change(u), at)
        assert abs(total.value - wanted.value) <= (total.bound + wanted.bound) * mp.mpf(10) ** (2 - DIGITS)
        assert abs(in_double_precision(change_by_slopes(u), at) - total.value) <= 2 * EPS * total.bound


def test_names_of_the_ends_keep_clear_of_the_systems_own() -> None:
    ends = Endpoints.of((X,), {"x", "x_0", "t_1"})
    assert not {str(s) for s in (*ends.start, *ends.end, *ends.times)} & {"x", "x_0", "t_1"}


def field_of(system: PiecewiseSystem, side: int) -> DiscreteField:
    return system.laws.modes[side].discrete


@pytest.mark.parametrize(("side", "frequency"), [(-1, "omega2_minus"), (1, "omega2_plus")])
def test_oscillator_scheme_is_the_printed_implicit_midpoint(side: int, frequency: str) -> None:
    field = field_of(HARMONIC, side)
    (x0, y0), (x1, y1) = field.ends.start, field.ends.end
    printed = sympy.Matrix([(y0 + y1) / 2, -sympy.Symbol(frequency) * (x0 + x1) / 2])
    assert sympy.expand(field.expression - printed) == sympy.zeros(2, 1)


@pytest.mark.parametrize(("side", "parameter"), [(-1, "a_minus"), (1, "a_plus")])
def test_elliptic_curve_scheme_is_the_printed_one(side: int, parameter: str) -> None:
    field = field_of(ELLIPTIC, side)
    (x0, y0), (x1, y1) = field.ends.start, field.ends.end
    printed = sympy.Matrix([y0 + y1, x1**2 + x1 * x0 + x0**2 + sympy.Symbol(parameter)])
    assert sympy.expand(field.expression - printed) == sympy.zeros(2, 1)


SIDES = [pytest.param(system, side, id=f"{system.name} {side:+d}") for system in ALL for side in (-1, 1)]
STATES = {"Kepler": [(0.9, 0.3, -0.2, 1.1), (0.7, 0.45, -0.5, 0.8)]}
PLACES = [(0.83, 0.42, 0.61), (1.21, 0.77, 0.35)]


def places(system: PiecewiseSystem, field: DiscreteField) -> dict[sympy.Symbol, Any]:
    """Numbers for all symbols of a discrete field."""
    first, last = (p[: system.dimension] for p in STATES.get(system.name, PLACES))
    at: dict[sympy.Symbol, Any] = {sympy.Symbol(q.name): mp.mpf(system.values[q.name]) for q in system.parameters}
    at |= dict(zip(field.ends.start, first, strict=True)) | dict(zip(field.ends.end, last, strict=True))
    return at | dict(zip(field.ends.times, (0.25, 0.5), strict=True))


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_discrete_field_is_orthogonal_to_the_discrete_gradient_to_forty_digits(
    system: PiecewiseSystem, side: int
) -> None:
    field = field_of(system, side)
    excess = field.gradient * field.expression + field.time_slope
    for e in excess:
        rate = exactly(e, places(system, field))
        assert abs(rate.value) <= mp.mpf(10) ** -40 * max(rate.bound, 1)


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_discrete_field_is_the_field_where_the_step_has_no_length(system: PiecewiseSystem, side: int) -> None:
    field = field_of(system, side)
    at = places(system, field)
    at |= {last: at[first] for first, last in zip(field.ends.start, field.ends.end, strict=True)}
    at |= {field.ends.times[1]: at[field.ends.times[0]]}
    for discrete, f in zip(field.expression, field.field, strict=True):
        value, wanted = exactly(discrete, at), exactly(f.xreplace(field.ends.at_start), at)
        assert abs(value.value - wanted.value) <= mp.mpf(10) ** -40 * (value.bound + wanted.bound)


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_discrete_field_is_symmetric_in_the_two_ends(system: PiecewiseSystem, side: int) -> None:
    field = field_of(system, side)
    at = places(system, field)
    pairs = [*zip(field.ends.start, field.ends.end, strict=True), field.ends.times]
    back = at | {s: at[e] for s, e in pairs} | {e: at[s] for s, e in pairs}
    for e in field.expression:
        there, again = exactly(e, at), exactly(e, back)
        assert abs(there.value - again.value) <= mp.mpf(10) ** -40 * (there.bound + again.bound)


def test_factor_is_found_where_the_conserved_quantities_fix_the_orbit() -> None:
    assert field_of(RIGID_BODY, 1).factor == 1
    assert field_of(next(s for s in ALL if s.name == "Lotka-Volterra"), 1).factor == -X * Y
    assert field_of(KEPLER, -1).factor is None  # one of three
    assert field_of(KEPLER, 1).factor is None  # two of three
    assert field_of(DAMPED, 1).factor is None  # names t


@pytest.mark.parametrize(("system", "side"), SIDES)
def test_latex_of_the_discrete_field_shows_mathematics_only(system: PiecewiseSystem, side: int) -> None:
    text = sympy.latex(field_of(system, side).expression)
    assert "x_{0}" in text or "q_{0}" in text
    assert text.count("{") == text.count("}")
    for internal in ("slope", "Symbol", "Dummy", "operatorname{sin_", "xi", "n_{"):
        assert internal not in text


@pytest.mark.parametrize("phi", DIFFERENCES, ids=str)
def test_ends_that_are_called_as_the_template_calls_them_are_not_mixed_up(phi: Any) -> None:
    b, c = sympy.symbols("B C")
    assert sympy.latex(DIFFERENCES[phi](b, c)) == sympy.latex(DIFFERENCES[phi](X, Y)).replace("y", "C").replace(
        "x", "B"
    )
