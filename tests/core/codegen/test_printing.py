"""Expressions as compiled lines: in floating point to the last digit, in double-double to thirty."""

import mpmath as mp
import numpy as np
import pytest
import sympy

from core.codegen.functions import function_text, module_text
from core.codegen.printing import doubled_assignments, printed
from core.compilation.compiled import _load
from tests.core.frames import pointer

X, Y, A = sympy.symbols("x y a")
#: Each with the largest error allowed, relative to its terms.
ALGEBRAIC = dict.fromkeys(
    [
        Y**2 - X**3 - A * X,
        (A * X**2 + Y**2) / 2,
        X**7 - Y**5 / 3,
        X / Y - A / (X + Y),
        sympy.sqrt(X**2 + Y**2) - 1,
        (X**2 + Y**2) ** sympy.Rational(-3, 2),
        sympy.pi * X - sympy.Rational(1, 10),
    ],
    mp.mpf(2) ** -98,  # a few roundings of 2⁻¹⁰⁴ a term; powers and quotients a few more each
)
TRANSCENDENTAL = dict.fromkeys(
    [
        Y**2 / 2 - A * sympy.cos(X),
        sympy.log(X) - A * X + sympy.exp(-Y),
        sympy.sinh(X) * sympy.tanh(Y) + sympy.tan(X) / 10,
        sympy.cosh(X) + sympy.sin(Y) * X**A,
    ],
    mp.mpf(2) ** -73,  # errors of 2⁻⁷⁷, more where the tangent is large
)


@pytest.mark.parametrize(("expression", "bound"), [*ALGEBRAIC.items(), *TRANSCENDENTAL.items()], ids=str)
def test_double_double_lines_are_good_to_29_digits_or_to_22_where_they_call_functions(expression, bound):
    known = {X: ("w[0]", "w[1]"), Y: ("w[2]", "w[3]"), A: ("w[4]", None)}
    lines = doubled_assignments(["u"], [expression], known, sympy.numbered_symbols("v"))
    module = _load(module_text([function_text("value", [*lines, "w[5], w[6] = u, u_low", "return 0"])]))
    function = sympy.lambdify([X, Y, A], expression, "mpmath")
    sizes = sympy.lambdify([X, Y, A], list(sympy.Add.make_args(expression)), "mpmath")
    generator = np.random.default_rng(7)
    for _ in range(40):
        x, y, a = generator.uniform(0.3, 2.5, 3)
        w = np.array([x, x * 2.0**-54 * 0.7, y, -y * 2.0**-55 * 0.9, a, 0.0, 0.0])
        module.value.ctypes(0.0, 0.0, pointer(np.zeros(1)), pointer(w), pointer(np.zeros(1)))
        with mp.workdps(50):
            at = [mp.mpf(w[0]) + mp.mpf(w[1]), mp.mpf(w[2]) + mp.mpf(w[3]), mp.mpf(a)]
            size = sum(map(abs, sizes(*at)))
            assert abs(mp.mpf(w[5]) + mp.mpf(w[6]) - function(*at)) <= bound * size


def test_what_several_expressions_share_is_worked_out_once():
    known = {X: ("x", "c"), Y: ("y", "d")}
    lines = doubled_assignments(["u", "v"], [X**2 + Y, X**2 - Y], known, sympy.numbered_symbols("z"))
    assert sum("pair_square" in line for line in lines) == 1


def test_halves_are_exact_factors_and_not_quotients():
    lines = doubled_assignments(["u"], [X**2 / 2], {X: ("x", "c")}, sympy.numbered_symbols("z"))
    assert not any("div" in line for line in lines)
    assert any("0.5 *" in line for line in lines)


@pytest.mark.parametrize("number", [0.1, 1 / 3, 0.05293787936735, 1e-300, 123456789.12345679])
def test_numbers_are_printed_to_the_last_digit(number):
    assert float(printed(sympy.Float(number))) == number


@pytest.mark.parametrize("power", ["3/2", "5/2", "7/2", "9/2", "-1/2", "-3/2", "-5/2", "11/2", "2/3"])
def test_powers_are_good_to_a_rounding_for_each_factor(power):
    exponent = sympy.Rational(power)
    lines = [f"w[1] = {printed((X + 1) ** exponent)}".replace("x", "w[0]"), "return 0"]
    module = _load(module_text([function_text("value", lines)]))
    for x in (0.3, 1.7, 1e-20, 3e40):
        w = np.array([x, 0.0])
        module.value.ctypes(0.0, 0.0, pointer(np.zeros(1)), pointer(w), pointer(np.zeros(1)))
        wanted = (1.0 + x) ** float(exponent)
        assert abs(w[1] - wanted) <= 6 * 2.0**-53 * abs(wanted)
