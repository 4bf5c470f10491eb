"""A text that is no expression is told what is wrong with it, and where."""

import pytest

from core.symbolic import parse


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("-2*x**2 - a sin(x)", "a multiplication sign is missing between a and sin: write a product as a*sin"),
        ("2x", "a multiplication sign is missing between 2 and x: write a product as 2*x"),
        ("(x + 1)y", "a multiplication sign is missing between ) and y"),
        ("2*(x + 1", "a closing bracket ) is missing"),
        ("sin(x]", "a bracket is missing before one of the ]"),
        ("x) + 1", "a bracket is missing before one of the )"),
        ("x + * y", "a number or a name is missing before *"),
        ("x -", "a number or a name is missing after -"),
        ("x = 3*y", "of a law write what stands right of = alone, of g or psi the difference of both sides"),
        ("-x*|x|", "write the absolute value |x| as abs(x)"),
        ("x; y", "';' has no meaning here"),
        ("x ^^ y", "write powers as **"),
        ("x\n+ y", "write products with *, powers with **"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(text, says):
    with pytest.raises(ValueError, match="this is not an expression; ") as caught:
        parse(text, ("x", "y", "a"), "f")
    assert says in str(caught.value)


def test_a_name_before_a_bracket_is_told_to_be_no_function():
    with pytest.raises(ValueError, match=r"a is not a function; write a product as a\*\(…\)"):
        parse("a(x + 1)", ("x", "a"), "f")


@pytest.mark.parametrize("text", ["sin^2(x)", "sin**2(x)", "1 + sin**2*x"])
def test_a_power_of_a_function_without_its_argument_is_told_where_that_stands(text):
    with pytest.raises(ValueError, match=r"sin is a function and needs an argument: its square is sin\(…\)\*\*2"):
        parse(text, ("x",), "f")


def test_a_decimal_comma_is_told_to_be_a_point():
    with pytest.raises(ValueError, match=r"a comma has no meaning here; write decimals with a point, as 0\.5"):
        parse("-x + 0,5*y", ("x", "y"), "f")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("sinn(x)", "'sinn(x)' is not allowed (did you mean sin?); allowed are"),
        ("2*ln(x)", "'ln(x)' is not allowed (did you mean log?)"),
        ("aplha*x", "unknown name 'aplha' (did you mean alpha?); known are x, alpha"),
        ("alpha*X", "unknown name 'X' (did you mean x?)"),
        ("alpha*y", "unknown name 'y'; known are"),
        ("open(x)", "'open(x)' is not allowed; allowed are"),
        ("-alphax", "unknown name 'alphax' (did you mean alpha*x?)"),
        ("2 + txx", "unknown name 'txx' (did you mean t*x*x?)"),
        ("sinx", "unknown name 'sinx' (did you mean sin(x)?)"),
        ("cosalphax", "(did you mean cos(alpha*x)?)"),
        ("alphax1", "unknown name 'alphax1' (did you mean alpha?)"),
    ],
)
def test_a_name_that_is_like_a_known_one_is_asked_about(text, says):
    with pytest.raises(ValueError, match=r"not allowed|unknown name") as caught:
        parse(text, ("x", "alpha"), "f")
    assert says in str(caught.value)
