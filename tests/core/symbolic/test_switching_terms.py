"""Surfaces and smooth laws found in text with sign, abs, max, …, against numpy's functions of these names."""

import ast
from functools import reduce
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import sympy

from core.symbolic.expressions import SWITCHING, parse
from core.symbolic.switching_terms import Found, read_switching
from tests.bounds import bounded_time

XV = ("x", "v")
#: Seconds for a refusal: loose for a busy machine, all measure below 0.3 s.

# The oracle: text evaluated by numpy ----------------------------------------------------------------------------------

BINARY = {ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power}
COMPARISONS = {ast.Lt: np.less, ast.LtE: np.less_equal, ast.Gt: np.greater, ast.GtE: np.greater_equal}
CALLS = {
    "sign": np.sign,
    "abs": np.abs,
    "max": lambda *u: reduce(np.maximum, u),
    "min": lambda *u: reduce(np.minimum, u),
    "Heaviside": lambda u: np.heaviside(u, 0.5),
    "Piecewise": lambda *pairs: reduce(lambda rest, pair: np.where(pair[1], pair[0], rest), reversed(pairs), np.nan),
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "sqrt", "cosh")},
}


def evaluated(text: str, at: dict[str, Any]) -> Any:
    return value_of(ast.parse(text, mode="eval").body, {"pi": np.pi} | at)


def value_of(node: ast.expr, at: dict[str, Any]) -> Any:
    match node:
        case ast.Constant(value=number):
            return number if isinstance(number, bool) else float(number)
        case ast.Name(id=name):
            return at[name]
        case ast.UnaryOp(op=ast.USub(), operand=u):
            return -value_of(u, at)
        case ast.UnaryOp(operand=u):
            return np.logical_not(value_of(u, at))
        case ast.BinOp(left=u, op=op, right=v) if type(op) in BINARY:
            return BINARY[type(op)](value_of(u, at), value_of(v, at))
        case ast.BinOp(left=u, op=op, right=v):
            both = np.logical_and if isinstance(op, ast.BitAnd) else np.logical_or
            return both(value_of(u, at), value_of(v, at))
        case ast.BoolOp(op=op, values=parts):
            both = np.logical_and if isinstance(op, ast.And) else np.logical_or
            return reduce(both, [value_of(u, at) for u in parts])
        case ast.Compare(left=u, ops=ops, comparators=rest):
            values = [value_of(v, at) for v in (u, *rest)]
            return reduce(np.logical_and, map(lambda op, a, b: COMPARISONS[type(op)](a, b), ops, values, values[1:]))
        case ast.Tuple(elts=parts):
            return [value_of(u, at) for u in parts]
        case ast.Call(func=ast.Name(id=name), args=args):
            return CALLS[name](*(value_of(u, at) for u in args))
    raise AssertionError(ast.dump(node))


def check_laws(found: Found, f: tuple[str, ...], psi: tuple[str, ...], at: dict[str, Any], count: int) -> None:
    """At each point, the law of the region that the signs of the surfaces name has the value of the given text."""
    heights = np.array([np.broadcast_to(evaluated(g, at), count) for g in found.surfaces])
    keys = np.array(["".join("+" if h > 0 else "-" for h in column) for column in heights.T])
    clear = (np.abs(heights) > 1e-9).all(axis=0)
    for k, text in enumerate((*f, *psi)):
        expected = np.broadcast_to(evaluated(text, at), count)
        for key in np.unique(keys[clear]):
            here = clear & (keys == key)
            law = (*found.fields[str(key)], *found.quantities[str(key)])[k]
            actual = np.broadcast_to(evaluated(law, at), count)
            np.testing.assert_allclose(actual[here], expected[here], rtol=1e-9, atol=1e-9, err_msg=f"{text} at {key}")


# Random fields --------------------------------------------------------------------------------------------------------

SMOOTH = (
    "x",
    "v",
    "x - v",
    "x*v",
    "2*x + v",
    "x**2",
    "sin(x)",
    "x*mu",
    "v - mu",
    "x - cos(t)",
    "x**2 - v**2",
    "1/v + x",
)


def drawn(rng: np.random.Generator, depth: int) -> str:
    """Text of a term with functions that switch nested to a depth."""
    number = f"{rng.integers(-8, 9) / 4}"
    if depth == 0:
        return rng.choice(SMOOTH)
    u, v = drawn(rng, depth - 1), drawn(rng, 0)
    return rng.choice(
        [
            *(
                f"sign({u} - {number})",
                f"abs({u} - {number})",
                f"abs({u})*{v}",
                f"max({u}, {number})",
                f"min({u}, {v})",
            ),
            *(f"max({u}, -1, 1)", f"Heaviside({u})*{v}", f"({u})*sign({v})", f"-({u})**2 + {v}", f"mu*abs({u})"),
            f"Piecewise(({v}, {u} < {number}), ({u}, True))",
            f"Piecewise((x, ({v} > 1) & ({u} >= 0)), ({u}, not {v} <= 2 or {u} < {number}), (v, True))",
            f"Piecewise(({u}, -1 < {v} <= 1), ({v}, True))",
        ]
    )


def random_field(rng: np.random.Generator) -> tuple[tuple[str, ...], Found]:
    """The texts of f and ψ, and what is found in them; drawn until there are surfaces, but not too many."""
    while True:
        depth = int(rng.integers(1, 4))
        texts = (drawn(rng, depth), drawn(rng, 1 if depth < 3 else 0), drawn(rng, int(rng.integers(2))))
        bounds = [None, (-2.0, 2.0), (0.5, 3.0)][rng.integers(3)]
        try:
            return texts, read_switching(XV, ("mu",), texts[:2], texts[2:], (bounds,))
        except ValueError as reason:
            if not any(words in str(reason) for words in ("at most 6", "nothing switches", " alone", "are one")):
                raise


def test_the_law_of_each_region_is_the_field_there(draws):
    for rng in draws(45):
        texts, found = random_field(rng)
        scale = rng.choice([0.7, 3.0])
        at = {name: rng.normal(scale=scale, size=2000) for name in ("x", "v", "t")}
        check_laws(found, texts[:2], texts[2:], at | {"mu": rng.uniform(0.5, 2.0, size=2000)}, 2000)


def cells(lines: np.ndarray) -> set[str]:
    """Keys of all cells that lines a·x + b·v + c = 0, not all parallel, make: each has a corner."""
    angles = np.linspace(0, 2 * np.pi, 720, endpoint=False) + 1e-3
    around = 1e-4 * np.stack([np.cos(angles), np.sin(angles)])
    keys = set()
    for pair in combinations(lines, 2):
        normals, offsets = np.array(pair)[:, :2], np.array(pair)[:, 2]
        if abs(np.linalg.det(normals)) > 1e-9:
            points = np.linalg.solve(normals, -offsets)[:, None] + around
            signs = (lines[:, :2] @ points + lines[:, 2:] > 0).T
            keys |= {"".join("+" if s else "-" for s in row) for row in signs}
    return keys


def test_between_lines_the_regions_are_exactly_those_that_occur(draws):
    for rng in draws(6):
        check_cells(rng)


def check_cells(rng: np.random.Generator) -> None:
    lines = np.concatenate([[[1, 0, 0], [0, 1, 0]], rng.integers(-3, 4, size=(4, 3))])
    lines = np.unique(lines[np.abs(lines[:, :2]).sum(axis=1) > 0], axis=0)
    f = "+".join(f"{k + 2}**2*sign({a}*x + {b}*v + {c})" for k, (a, b, c) in enumerate(lines))
    found = read_switching(XV, (), (f, "x"))
    at = {"x": np.array([0.0, 1.0, 0.0]), "v": np.array([0.0, 0.0, 1.0])}
    values = np.array([np.broadcast_to(evaluated(g, at), 3) for g in found.surfaces])
    coefficients = np.stack([values[:, 1] - values[:, 0], values[:, 2] - values[:, 0], values[:, 0]], axis=1)
    assert set(found.fields) == cells(coefficients)


# Surfaces -------------------------------------------------------------------------------------------------------------


def surfaces(*f: str, parameters: tuple[str, ...] = ("mu",), bounds: tuple = ()) -> tuple[str, ...]:
    return read_switching(XV, parameters, f, (), bounds).surfaces


def test_a_relay_has_one_surface_and_two_laws():
    found = read_switching(XV, ("mu",), ("v", "-x - mu*sign(v - 1)"))
    assert found.surfaces == ("v - 1",)
    assert found.fields == {"-": ("v", "mu - x"), "+": ("v", "-mu - x")}
    assert found.quantities == {"-": (), "+": ()}


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        ("sign(1 - v) + max(v, 1)", ("v - 1",)),
        ("sign(2*v - 2) + abs(v/3 - 1/3) + Heaviside(exp(x)*(1 - v)) + min(1, v)", ("v - 1",)),
        ("sign(0.1*x - v) + 2*sign(v - x/10)", ("x - 10*v",)),
        ("sign(x*v)", ("x", "v")),
        ("sign(x/v)", ("x", "v")),
        ("sign(x**2 - 1)", ("x - 1", "x + 1")),
        ("sign(x**2*(v - 1)**3)", ("v - 1",)),
        ("sign(x**3 - 1)", ("x - 1",)),
        ("sign(x**3 - v**3)", ("x - v",)),
        ("sign((x**2 + 1)*x*(sin(v) + 2)*sqrt(v)*cosh(v))", ("x",)),
        ("sign(x*sin(v) - sin(v))", ("x - 1", "sin(v)")),
        ("sign(tan(x))", ("sin(x)", "cos(x)")),
        ("abs(abs(x) - 1)", ("x", "x - 1", "x + 1")),
        ("abs(abs(x) + 1)", ("x",)),
        ("abs(abs(abs(abs(abs(abs(abs(x) + 1) + 1) + 1) + 1) + 1) + 1)", ("x",)),
        ("sign(abs(x)*v)", ("v",)),
        ("max(x, 0, 1)", ("x - 1",)),
        ("max(x, -1) + min(x, 1)", ("x + 1", "x - 1")),
        ("sign(x - mu)", ("x - mu",)),
        ("sign(x - cos(t))", ("x - cos(t)",)),
        ("sign(-(x - mu)**2 - v**2 + 1)", ("v**2 + (x - mu)**2 - 1",)),
        ("Piecewise((-1, x < -1), (x, x < 1), (1, True))", ("x + 1", "x - 1")),
        ("Piecewise((1, (x > 0) & ~(v > 0) | (x > 2)), (0, True))", ("x", "v", "x - 2")),
        ("Piecewise((1, not -1 < x < 1 or v >= 0), (0, True))", ("x + 1", "x - 1", "v")),
        ("abs(x - abs(x))", ("x",)),
        ("sign(cos(t))", ("cos(t)",)),
        ("sign(x*cos(t))", ("x", "cos(t)")),
        ("Piecewise((x, t < 1), (v, t < 3), (0, True))", ("t - 1", "t - 3")),
        ("Heaviside(mu - t)*x", ("t - mu",)),
    ],
)
def test_surfaces_are_the_factors_that_change_their_sign(f, expected):
    found = read_switching(XV, ("mu",), ("v", f))
    assert found.surfaces == expected
    rng = np.random.default_rng(1)
    at = {name: rng.uniform(-4, 4, size=500) for name in ("x", "v", "mu", "t")}
    at |= {"v": abs(at["v"])} if "sqrt" in f else {}
    check_laws(found, ("v", f), (), at, 500)


def test_a_surface_with_the_same_laws_on_both_sides_is_left_out():
    assert surfaces("abs(x)**2 + abs(v)", "sign(x)**2") == ("v",)


def test_a_switching_function_that_vanishes_everywhere_is_no_surface():
    found = read_switching(XV, (), ("abs(x) - x + sign(sin(x)**2 + cos(x)**2 - 1)", "max(abs(x), x)"))
    assert found.fields == {"-": ("-2*x", "-x"), "+": ("0", "x")}


def test_laws_of_nested_terms_are_short():
    found = read_switching(("x",), (), ("abs(abs(x) - 1)",))
    assert {law for (law,) in found.fields.values()} == {"-x - 1", "x + 1", "1 - x", "x - 1"}


def test_all_functions_together_are_read_by_the_ordinary_parser():
    f = "sign(x) + abs(v - mu) + max(x, v) + min(x, 2) + Heaviside(v) + Piecewise((x, x < 1), (v, True))"
    found = read_switching(XV, ("mu",), (f, "0"))
    for law in found.fields.values():
        assert not any(word in law[0] for word in SWITCHING)
        parse(law[0], ("x", "v", "mu"))


def test_sympy_expressions_are_read_as_their_text():
    x, v = sympy.symbols("x v", real=True)
    f = (sympy.Max(x, 1) + sympy.Heaviside(v), sympy.Piecewise((sympy.Abs(v), x < 1), (sympy.sign(v), True)))
    plain = ("max(x, 1) + Heaviside(v)", "Piecewise((abs(v), x < 1), (sign(v), True))")
    assert set(read_switching(XV, (), f).surfaces) == set(surfaces(*plain)) == {"x - 1", "v"}


# Regions --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("f", "bounds", "count"),
    [
        ("sign(x - 1) + 2*sign(x + 1)", None, 3),
        ("sign(x - 1e-12) + 2*sign(x)", None, 3),
        ("sign(x) + 2*sign(v) + 4*sign(x + v)", None, 6),
        ("sign(x) + 2*sign(v) + 4*sign(x + v - 1)", None, 7),
        ("sign(x**2 + v**2 - 1) + 2*sign(x**2 + v**2 - 4)", None, 3),
        ("sign(sin(x) - 0.5) + 2*sign(sin(x) + v**2 + 1.5)", None, 2),
        ("sign(x - pi) + 2*sign(x - 3.2)", None, 3),
        ("sign(x - mu) + 2*sign(x + mu)", None, 4),
        ("sign(x - mu) + 2*sign(x + mu)", (0.0, 2.0), 3),
        ("sign(x - mu) + 2*sign(x - 2)", (-1.0, 1.0), 3),
        ("sign(x - mu) + 2*sign(x - 2)", (-1.0, 3.0), 4),
        ("sign(x + t) + 2*sign(x + t - 1)", None, 3),
        ("sign(t) + 2*sign(t - 1)", None, 3),
    ],
)
def test_regions_that_cannot_occur_are_left_out(f, bounds, count):
    assert len(read_switching(XV, ("mu",), (f, "x"), (), (bounds,)).fields) == count


def test_smooth_quantities_go_to_every_region_as_they_stand_and_others_are_split():
    found = read_switching(XV, ("mu",), ("v", "-sign(x)"), (" v**2/2 + abs(x)", "(v + v)*1"))
    assert found.quantities == {"-": ("v**2/2 - x", "(v + v)*1"), "+": ("v**2/2 + x", "(v + v)*1")}


def test_quantities_alone_may_switch():
    assert read_switching(XV, (), ("v", "x"), ("abs(x)",)).surfaces == ("x",)


def test_a_factor_of_parameters_is_taken_by_its_bounds_or_stays_with_its_surface():
    assert read_switching(XV, ("mu",), ("sign(mu*x)", "0"), (), ((1.0, 2.0),)).fields == {
        "-": ("-1", "0"),
        "+": ("1", "0"),
    }
    assert read_switching(XV, ("mu",), ("sign(mu*x)", "0"), (), ((-2.0, -1.0),)).fields["-"] == ("1", "0")
    assert surfaces("max(mu*x, 0)", "0") == ("mu*x",)


# Refusals -------------------------------------------------------------------------------------------------------------

SEVEN = " + ".join(f"{k + 1}*sign(x - {k})" for k in range(7))


@pytest.mark.parametrize(
    ("f", "words"),
    [
        ("x - v**2", "nothing switches"),
        ("sign(x**2 + 1)", "nothing switches"),
        ("max(1, 2)*x", "nothing switches"),
        ("abs(x)**2", "the laws are the same on both sides of x"),
        ("sign(mu)*abs(x)", "the sign of 'mu' depends on parameters alone, at no surface; give mu bounds"),
        ("sign(mu*x) + sign(x)", "'mu*x' and 'x' are one surface, but may differ in sign; give mu bounds"),
        (
            SEVEN,
            "at most 6 surfaces are possible, but the field switches on x, x - 1, x - 2, x - 3, x - 4, x - 5, x - 6",
        ),
        ("sign(x, v)", "sign takes one argument, not 2"),
        ("abs()", "abs takes one argument, not 0"),
        ("Heaviside(x, 0.5)", "Heaviside takes one argument, not 2: its value at 0 never matters"),
        ("max(x)", "max takes two arguments or more, not 1"),
        ("max(*x)", "max takes two arguments or more"),
        ("max(x, *v)", "'*v' is not allowed"),
        ("sign(u=x)", "is not allowed"),
        ("x*sign", "sign is a function and needs an argument: sign(…)"),
        ("sign(y)", "unknown name 'y'"),
        ("x < 1", "conditions are written in Piecewise("),
        ("Piecewise((1, x > 0 & v > 0), (0, True))", "conditions are written as (x > 0) & (y > 0)"),
        ("Piecewise((1, x == 0), (0, True))", "'x == 0' is not a condition"),
        ("Piecewise((1, x), (0, True))", "'x' is not a condition"),
        ("Piecewise((1, x > 0), 2)", "'2' is not a pair"),
        ("Piecewise((1, x > 0, 3), (0, True))", "is not a pair"),
        ("Piecewise((1, x > 0), (2, x < -1))", "end it with (value, True)"),
        ("Piecewise()", "end it with (value, True)"),
        ("Piecewise((1, True), (x.__class__, True))", "'x.__class__' is not allowed"),
        ("abs(__import__('os'))", "is not allowed"),
        ("sign(x).__class__", "is not allowed"),
        ("Piecewise((1, (lambda: 1)() > 0), (0, True))", "is not allowed"),
        ("abs(" * 41 + "x" + ")" * 41, "nested deeper than 40"),
        ("Piecewise((1, " + "not " * 200 + "x > 0), (0, True))", "nested deeper than 40"),
        ("abs(" * 30 + "x" + " - 1)" * 30, "at most 6 surfaces"),
        ("abs(x)" + " + abs(x)" * 200, "characters long: 1000 at most"),
        ("max(" + "x," * 400 + "v)", "more than 400 operations and names"),
        ("sign(x**64*1e300*1e300 - v)", "f[1]"),
        ("sign(((x**9)**9)**9 - v)", "f[1]"),
    ],
)
def test_what_cannot_be_read_is_refused_at_once_with_its_text_and_a_remedy(f, words):
    with bounded_time(), pytest.raises(ValueError, match=r"^f\[1\]|^nothing") as caught:
        read_switching(XV, ("mu",), ("v", f))
    assert words in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "f",
    [
        *("(x + v + mu + 1)**64 - (x - v)**60", "(x**8 + v**8 - mu)*(x*v - mu*x + 3)*(x + v + mu) + x*v"),
        *("x**64 - v**64", "x**64 - 1.1*x**63 + 3*x**7 - 1/7", "(x + v + mu)**12 - (x - v*mu)**11"),
        " + ".join(f"1/(x + {k})" for k in range(60)),
    ],
)
def test_long_switching_functions_take_no_long_time(f):
    with bounded_time():
        found = read_switching(XV, ("mu",), (f"sign({f})", "0"))
    rng = np.random.default_rng(2)
    check_laws(found, (f"sign({f})", "0"), (), {name: rng.uniform(-2, 2, size=50) for name in ("x", "v", "mu")}, 50)


def test_names_of_these_functions_are_unknown_to_the_ordinary_parser():
    for name in (*SWITCHING, "Abs", "Max", "Min"):
        with pytest.raises(ValueError, match="is not allowed"):
            parse(f"{name}(x)", XV)
