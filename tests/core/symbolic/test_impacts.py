"""Whether a jump stays on the surface is told from the declaration, and soon."""

import pytest
import sympy

from core.symbolic.expressions import parse
from core.symbolic.impacts import stays_on_surface

X = sympy.symbols("x y")


def stays(g, *jump):
    return stays_on_surface(parse(g, "xy"), X, [parse(u, "xy") for u in jump])


@pytest.mark.parametrize(
    ("g", "jump", "expected"),
    [
        ("x", ("x", "-0.8*y"), True),
        ("x", ("-x", "y"), True),
        ("x**2 + y**2 - 1", ("y", "-x"), True),
        ("x**2 + y**2 - 1", ("(3*x - 4*y)/5", "(4*x + 3*y)/5"), True),
        ("x**2 + y**2 - 1", ("x", "y/2"), False),
        ("exp(x) - y", ("x + log(2)", "2*y"), True),
        ("exp(x) - y", ("x + log(2)", "2.0000000000000001*y"), False),
        ("x**2 + 1", ("x", "y"), True),
        ("x**2 + y**2 + 1", ("x", "y + 1"), False),
    ],
)
def test_a_jump_is_known_to_stay_on_the_surface_or_not(g, jump, expected):
    assert stays(g, *jump) == expected


@pytest.mark.parametrize(
    ("g", "jump"),
    [
        ("(4 + (x**2)**(-y))**3 - 1170.9768972995473", ("x + 0.05*tanh((1.2 + ((4 + x)**(pi/3))**2)**(-0.7))", "y")),
        ("exp(exp(exp(exp(x)))) - 2", ("x", "y + 1")),
        ("x - y", ("exp(exp(exp(exp(exp(x)))))", "y")),
        ("sin(exp(exp(exp(x)))) - y/10", ("x", "-y")),
    ],
)
def test_a_search_that_strays_to_where_numbers_are_too_large_ends(g, jump):
    assert stays(g, *jump) in (True, False)
