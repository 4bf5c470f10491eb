"""What is declared as conserved is accepted if it is, and refused if it is not somewhere on its side.

The oracle works with the texts alone: mpmath evaluates them as they stand, and differentiates ψ numerically along f.
"""

import mpmath
import pytest
import sympy

import core
from tests.bounds import bounded_time

PARAMETERS = {"k": core.Parameter("k", 1.5, (0.5, 3.0)), "a": core.Parameter("a", 0.7)}


def bounded(function):
    """A function of mpmath that does not fill the memory."""

    def value(u):
        if abs(u) > 1e4:
            raise OverflowError
        return function(u)

    return value


FUNCTIONS = {name: bounded(getattr(mpmath, name)) for name in ("sin", "cos", "tan", "exp", "sinh", "cosh", "tanh")}
FUNCTIONS |= {"log": mpmath.log, "sqrt": mpmath.sqrt}
TERMS = (
    "{u}**2/2", "{u}**4/4", "cos({u})", "sin({u} + {v})", "{u}*{v}", "{u}**2*{v}**2", "k*{u}**2", "a*{u}**3",
    "exp({u}*{v}/4)", "exp(-{u}**2)", "log(1 + {u}**2)", "log({u})", "log({u}**2)", "sqrt(1 + {u}**2)", "sqrt({u}**2)",
    "({u}**2)**(3/4)", "sqrt({u})", "cosh({u}/2)", "sinh({u}*k/2)", "tanh({u} - {v})", "tan({u}/4)", "1/(1 + {u}**2)",
    "{u}**k", "2**{u}", "1/{u}", "1/sqrt({u}**2 + {v}**2)", "{u}**1.5", "exp(a*{u})", "log(2 + cos({u}))",
)  # fmt: skip
#: What tells one part of the state space from the rest by its sign.
PLACES = (
    "{u}", "(-{u})", "({u} - 1)", "({u} + 20)", "({u} - a)", "({u}**2 + {v}**2 - 1)", "({v} - 2*{u})", "t", "(t - 3)",
    "a", "(k - 2)", "({u}*{v})", "(cos({u}) - 0.5)", "({u} - 1e-4)", "(exp({u}) - 1)",
)  # fmt: skip
#: Zero, or next to it, where w is positive; not so where it is negative.
BRANCHES = (
    "(sqrt({w}**2) - {w})", "(({w}**4)**(1/4) - {w})", "(({w}**2)**(3/2) - {w}**3)", "({w}*sqrt({w}**2) - {w}**2)",
    "({w}/sqrt({w}**2) - 1)*{w}**2", "(exp(log({w}**2)/2) - {w})", "(1 - tanh(1000*{w}))",
)  # fmt: skip
#: They change within about 1/k of w = 0 only.
LAYERS = ("(1 - tanh({k}*{w}))", "tanh({k}*{w})", "exp(-({k}*{w})**2)")


def drawn_field(rng, psi, variables):
    """A field that keeps ψ: A ∇ψ with an antisymmetric A, and what ψ gains in time taken back along ∇ψ."""
    names = {name: sympy.Symbol(name) for name in (*variables, *PARAMETERS, "t")}
    expression = sympy.sympify(psi, locals=names, rational=True)
    gradient = [expression.diff(names[v]) for v in variables]
    field = [sympy.Integer(0)] * len(variables)
    for i in range(len(variables)):
        for j in range(i):
            c = rng.choice([0, 1, -2]) if len(variables) > 2 else 1
            field[i] += int(c) * gradient[j]
            field[j] -= int(c) * gradient[i]
    if rng.random() < 0.3:
        factor = sympy.sympify(str(rng.choice(["2", "1 + x**2", "exp(-y)", "k"])), locals=names)
        field = [factor * f for f in field]
    gain = expression.diff(names["t"])
    square = sum(g**2 for g in gradient)
    return tuple(str(f - gain * g / square) for f, g in zip(field, gradient, strict=True))


def drawn_psi(rng, variables):
    terms = []
    for _ in range(rng.integers(2, 5)):
        u, v = rng.choice(variables, size=2, replace=False)
        term = str(rng.choice(TERMS)).format(u=u, v=v)
        terms.append(f"{rng.integers(1, 24) / 8}*{term}" + rng.choice(["", "", "", "*exp(t/3)"]))
    # every variable has its part, so that ∇ψ is nowhere zero for good
    return " + ".join(terms + [f"{v}**2/3" for v in variables])


def drawn_case(rng):
    variables = ("x", "y", "z", "q")[: rng.integers(2, 5)]
    psi = drawn_psi(rng, variables)
    u, v = rng.choice(variables, size=2, replace=False)
    g = str(rng.choice(["{u}", "{u} - {v}", "{u}**2 + {v}**2 - 4", "{u} - cos(t)", "exp({u}) - 2"])).format(u=u, v=v)
    return variables, drawn_field(rng, psi, variables), g, psi


def declared(variables, field, g, psi_minus=(), psi_plus=()):
    given = {"name": "drawn", "variables": variables, "f_minus": field, "f_plus": field, "g": g}
    return core.PiecewiseSystem(
        **given, psi_minus=psi_minus, psi_plus=psi_plus, parameters=PARAMETERS, x0=(0.4,) * len(variables)
    )


def refusal(*given, **quantities):
    """Why a declaration is refused, None if it is not."""
    try:
        declared(*given, **quantities)
    except ValueError as reason:
        return reason
    return None


def value(code, point):
    """A real value, None where there is none."""
    try:
        found = mpmath.mpmathify(eval(code, {"__builtins__": {}}, {**FUNCTIONS, **point}))  # noqa: S307
    except (ArithmeticError, ValueError):
        return None
    return found if isinstance(found, mpmath.mpf) and mpmath.isfinite(found) else None


def rate(psi, field, variables, point, h):
    """Time derivative of ψ along f, and what its size is measured by; None where there is none."""
    speeds = [value(f, point) for f in field]
    if None in speeds:
        return None
    ends = []
    for s in (-h, h):
        moved = {v: point[v] + s * f for v, f in zip(variables, speeds, strict=True)}
        ends.append(value(psi, {**point, **moved, "t": point["t"] + s}))
    if None in ends:
        return None
    return (ends[1] - ends[0]) / (2 * h), 1 + max(map(abs, speeds)) ** 2


def a_point(rng, variables):
    """A point of a random orthant."""
    names = (*variables, "t", "a")
    sizes = rng.uniform(0.05, 3.0, size=len(names)) * rng.choice([1, 1, 1, 8], size=len(names))
    signs = rng.choice([-1.0, 1.0], size=len(names))
    return {n: mpmath.mpf(float(s)) for n, s in zip(names, sizes * signs, strict=True)} | {
        "k": mpmath.mpf(float(rng.uniform(0.5, 3.0)))
    }


def changes_somewhere(rng, psi, field, variables, g, side, points=100):
    """A point on the side where ψ changes, found by looking at many; None if there is none among them."""
    psi, g, *field = (compile(text, "drawn", "eval") for text in (psi, g, *field))
    for _ in range(points):
        point = a_point(rng, variables)
        height = value(g, point)
        if height is not None and side * height > 0.05 and changes_at(psi, field, variables, point):
            return point
    return None


def changes_at(psi, field, variables, point):
    """Whether ψ changes at a point, and by the same in 30 digits as in 90."""
    found = []
    for digits in (30, 90):
        with mpmath.workdps(digits):
            found.append(rate(psi, field, variables, point, mpmath.mpf(10) ** (-digits // 3)))
        if found[-1] is None or abs(found[-1][0]) < 1e-4 * found[-1][1]:
            return False
    return abs(found[0][0] - found[1][0]) < 1e-3 * abs(found[1][0])


def has_value(rng, psi, field, variables, g, side):
    """Whether a place on the side is found where f and ψ have values."""
    codes = [compile(text, "drawn", "eval") for text in (psi, g, *field)]
    for _ in range(400):
        values = [value(code, point) for point in [a_point(rng, variables)] for code in codes]
        if None not in values and side * values[1] > 0:
            return True
    return False


def test_what_is_conserved_is_accepted(draws):
    for rng in draws(24):
        variables, field, g, psi = case = drawn_case(rng)
        given = {
            name: (psi,)
            for side, name in ((-1, "psi_minus"), (1, "psi_plus"))
            if has_value(rng, psi, field, variables, g, side)
        }
        for side in (-1, 1):
            assert changes_somewhere(rng, psi, field, variables, g, side, points=8) is None, f"the oracle: {case}"
        with bounded_time():
            assert refusal(variables, field, g, **given) is None, case


def test_what_changes_in_a_part_of_its_side_is_refused_with_a_place_where_it_does(draws):
    refused = 0
    for rng in draws(24):
        variables, field, g, psi = drawn_case(rng)
        u, v = rng.choice(variables, size=2, replace=False)
        w = str(rng.choice(PLACES)).format(u=u, v=v)
        wrong = f"{psi} + {str(rng.choice(BRANCHES)).format(w=w)}"
        for side, name in ((-1, "psi_minus"), (1, "psi_plus")):
            if changes_somewhere(rng, wrong, field, variables, g, side) is None:
                continue  # it may be right
            case = (variables, field, g, {name: (wrong,)})
            assert "conserved by" in str(refusal(*case[:3], **case[3])), f"not refused: {case}"
            refused += 1
    assert refused


def place_in_layer(rng, w, psi, field, variables, g, side, tries=20):
    """A point on the side where w = 0, found by bisection along a coordinate, and ψ changes; None if none is found."""
    codes = [compile(text, "drawn", "eval") for text in (w, psi, g, *field)]
    names = [n for n in (*variables, "t") if n in codes[0].co_names]
    for _ in range(tries):
        point, name = a_point(rng, variables), str(rng.choice(names))
        near = next(zeros_along(codes[0], point, name), None)
        height = None if near is None else value(codes[2], near)
        if height is not None and side * height > 0.05 and changes_at(codes[1], codes[3:], variables, near):
            return near
    return None


def zeros_along(code, point, name):
    """Points where the code's value is zero, on the line through the point along a coordinate."""
    places = [{**point, name: point[name] + mpmath.mpf(k) / 4} for k in range(-24, 25)]
    values = [value(code, p) for p in places]
    for low, high, a, b in zip(places, places[1:], values, values[1:], strict=False):
        if a is None or b is None or a * b > 0:
            continue
        for _ in range(60):
            middle = {**low, name: (low[name] + high[name]) / 2}
            found = value(code, middle)
            if found is None:
                break
            low, high, a = (low, middle, a) if a * found <= 0 else (middle, high, found)
        else:
            yield high


def test_what_changes_in_a_thin_layer_alone_is_refused(draws):
    refused = 0
    for rng in draws(24):
        variables, field, g, psi = drawn_case(rng)
        u, v = rng.choice(variables, size=2, replace=False)
        w = str(rng.choice([place for place in PLACES if place not in ("a", "(k - 2)")])).format(u=u, v=v)
        steep = float(f"{10 ** rng.uniform(1, 5):.4g}")
        wrong = f"{psi} + {str(rng.choice(LAYERS)).format(w=w, k=steep)}"
        for side, name in ((-1, "psi_minus"), (1, "psi_plus")):
            if place_in_layer(rng, w, wrong, field, variables, g, side) is None:
                continue  # it may be right
            case = (variables, field, g, {name: (wrong,)})
            with bounded_time():
                assert "conserved by" in str(refusal(*case[:3], **case[3])), f"not refused: {case}"
            refused += 1
    assert refused


@pytest.mark.parametrize("side", [-1, 1])
def test_what_changes_only_beyond_the_surface_is_accepted(draws, side):
    for rng in draws(8):
        variables, field, _, psi = drawn_case(rng)
        u, v = rng.choice(variables, size=2, replace=False)
        w = str(rng.choice([p for p in PLACES if "{u}" in p])).format(u=u, v=v)
        extended = f"{psi} + {str(rng.choice(BRANCHES[:6])).format(w=w)}"
        g = w if side > 0 else f"-{w}"
        if not has_value(rng, psi, field, variables, g, side):
            continue  # as y**1.5 has none where y < 0
        case = (variables, field, g, {"psi_plus" if side > 0 else "psi_minus": (extended,)})
        assert refusal(*case[:3], **case[3]) is None, case


@pytest.mark.parametrize(
    ("psi", "says"),
    [
        ("y**2/2 + sqrt(x**2)", "is conserved by f_minus where x > 0 only: at x = -"),
        ("y**2/2 + sqrt((x - 1)**2)", "where x - 1 > 0 only"),
        ("y**2/2 + sqrt((x - a)**2)", "where -a + x > 0 only"),
        ("y**2/2 + x*sqrt(a**2)/a", "where a > 0 only"),
        ("y**2/2 + x + (sqrt(t**2) - t)", "where t > 0 only"),
        ("y**2/2 + x + (sqrt(k**2) - k)", None),  # k has bounds
        ("log(-1 - x**2)", "has no real value"),
        ("y**2/2 + exp(log(x))", None),
    ],
)
def test_where_it_holds_is_said(psi, says):
    given = (("x", "y"), ("y", "-1"), "y - 1", (psi,))
    if says is None:
        declared(*given)
        return
    with pytest.raises(ValueError, match="psi_minus") as refused:
        declared(*given)
    assert says in str(refused.value)


def test_a_part_of_the_side_where_an_exponential_underflows_is_looked_at_too():
    psi = "y**2/2 + x + exp(-x**2) + (sqrt((x + 20)**2) - (x + 20))"  # exp(-400) = 2e-174
    assert "where x + 20 > 0 only" in str(refusal(("x", "y"), ("y", "2*x*exp(-x**2) - 1"), "y - 1", psi_minus=(psi,)))


def test_gradients_that_vanish_in_a_part_of_the_side_are_refused():
    with pytest.raises(ValueError, match="linearly dependent"):
        declared(("x", "y", "z"), ("0", "y", "1"), "z", ("x + sqrt(x**2)",))
    declared(("x", "y", "z"), ("0", "y", "1"), "x", (), ("x + sqrt(x**2)",))


def test_of_a_field_with_a_pole_a_quantity_is_found_that_is_real_on_both_sides_of_it():
    system = core.PiecewiseSystem("pole", ("x", "y"), ("y", "1/x"), ("y", "1/x"), "y", x0=(-1.0, 1.0))
    assert system.psi_plus == ("y**2/2 - log(x**2)/2",)
    right = core.PiecewiseSystem("pole", ("x", "y"), ("y", "1/x"), ("y", "1/x"), "x", x0=(1.0, 1.0))
    assert right.psi_plus == ("y**2/2 - log(x)",)
