"""PiecewiseSystem and Parameter: what they promise, and every way of declaring one wrongly."""

import copy
import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest
import sympy

from core import CATALOGUE, Parameter, PiecewiseSystem

MINE: dict[str, Any] = {
    "name": "My system",
    "variables": ("x", "y"),
    "f_minus": ("y", "-k*x"),
    "f_plus": ("y", "-x"),
    "g": "y",
    "psi_minus": ("(k*x**2 + y**2)/2",),
    "psi_plus": ("(x**2 + y**2)/2",),
    "parameters": {"k": 3.0},
    "x0": (1.0, 1.0),
    "jump": None,
}
SOLID: dict[str, Any] = {
    "name": "Solid",
    "variables": ("x", "y", "z"),
    "f_minus": ("y*z", "-2*z*x", "x*y"),
    "f_plus": ("y*z", "-2*z*x", "x*y"),
    "g": "x",
}


def system(**changes: Any) -> PiecewiseSystem:
    return PiecewiseSystem(**{**MINE, **changes})


def test_the_contracts_example_is_accepted_and_evaluates() -> None:
    s = system()
    t, x = np.zeros(3), np.array([[1.0, 2.0], [0.0, -1.0], [-2.0, 0.5]])
    np.testing.assert_array_equal(s.field(-1, t, x), [[2, -3], [-1, 0], [0.5, 6]])
    np.testing.assert_array_equal(s.field(1, t, x), [[2, -1], [-1, 0], [0.5, 2]])
    np.testing.assert_array_equal(s.switching(t, x), x[:, 1])
    np.testing.assert_array_equal(s.switching_gradient(t, x), [[0, 1]] * 3)
    np.testing.assert_array_equal(s.switching_rate(-1, t, x), [-3, 0, 6])
    np.testing.assert_array_equal(s.conserved(-1, t, x), [[3.5], [0.5], [6.125]])
    assert s.conserved(1, 0.0, (1.0, 1.0)).shape == (1,)
    assert s.parameters == (Parameter("k", 3.0),)
    assert s.parameter_array.tolist() == [3.0]


def test_sympy_and_text_declare_the_same_system() -> None:
    x, y, k = sympy.symbols("x y k")
    given = system(variables=(x, y), f_minus=(y, -k * x), f_plus=(y, -x), g=y, psi_minus=(k * x**2 / 2 + y**2 / 2,))
    assert given.laws.modes[-1].field == system().laws.modes[-1].field
    assert given.laws.g == system().laws.g


def test_one_field_is_kept_as_given_and_gives_the_regions() -> None:
    given = PiecewiseSystem("Belt", ("x", "v"), f=("v", "-x -  mu*sign(v-1)"), parameters={"mu": 0.5}, x0=(2.0, 0.0))
    assert given.law_arguments() == {"f": ("v", "-x -  mu*sign(v-1)")}
    sides = PiecewiseSystem("Belt", ("x", "v"), ("v", "-x + mu"), ("v", "-x - mu"), "v - 1", parameters={"mu": 0.5})
    assert given.field(-1, 0.0, (2.0, 0.0)).tolist() == sides.field(-1, 0.0, (2.0, 0.0)).tolist() == [0.0, -1.5]
    assert copy.deepcopy(given.with_parameters(mu=0.75)).f == given.f


@pytest.mark.parametrize(
    "other", [{"f": ("v", "-x - 2*sign(v - 1)")}, {"f": ()}, {"psi": ("x",)}, {"jumps": {0: ("x", "v")}}, {"g": "v"}]
)
def test_one_field_beside_other_laws_than_its_own_is_refused(other: dict[str, Any]) -> None:
    system = PiecewiseSystem.from_field(("x", "v"), ("v", "-x - sign(v - 1)"), ("(x + sign(v - 1))**2 + v**2",))
    with pytest.raises(ValueError, match=r"give either|not conserved|there is no f"):
        dataclasses.replace(system, **other)


def test_without_a_start_it_is_the_origin_and_without_invariants_there_are_none() -> None:
    damped = ("y", "-x - y/10")
    s = system(x0=(), f_minus=damped, f_plus=damped, psi_minus=(), psi_plus=())
    assert s.x0 == (0.0, 0.0)
    assert s.conserved(1, 0.0, s.x0).shape == (0,)


def test_an_empty_jump_is_none() -> None:
    assert system(jump=()) == system(jump=None)
    with pytest.raises(ValueError, match="jump = ''"):
        system(jump="")


def test_parameters_are_given_by_value_by_mapping_or_by_sequence() -> None:
    k = Parameter("k", 3.0, (0.1, 20), "spring")
    assert system(parameters={"k": k}) == system(parameters=[k]) == system(parameters=(k,))
    assert k.bounds == (0.1, 20.0)


def test_with_parameters_is_another_system_with_the_same_laws() -> None:
    s = system()
    other = s.with_parameters(k=5.0)
    assert (s.values["k"], other.values["k"]) == (3.0, 5.0)
    assert other.laws is s.laws
    assert other != s
    assert other.with_parameters(k=3.0) == s
    assert other.with_parameters() == other
    curve = CATALOGUE["elliptic_curve"].with_parameters(a_plus=-2.5).with_parameters(radius=2)
    assert dict(curve.values) == {"a_minus": -3.0, "a_plus": -2.5, "radius": 2.0}


def test_systems_are_frozen() -> None:
    s = system()
    with pytest.raises(dataclasses.FrozenInstanceError):
        s.g = "x"  # type: ignore[misc]
    with pytest.raises(TypeError):
        s.values["k"] = 1.0  # type: ignore[index]
    with pytest.raises(ValueError, match="read-only"):
        s.parameter_array[0] = 7.0


def test_equal_systems_have_equal_hashes() -> None:
    assert system() == system()
    assert hash(system()) == hash(system())
    assert len({system(), system(), system(name="Other")}) == 2


@pytest.mark.parametrize("again", [lambda s: pickle.loads(pickle.dumps(s)), copy.deepcopy, copy.copy])  # noqa: S301
@pytest.mark.parametrize("s", [*CATALOGUE.values(), system().with_parameters(k=4.0), system(jump=("x", "-y/2"))])
def test_copies_are_equal(s: PiecewiseSystem, again: Any) -> None:
    assert again(s) == s
    assert hash(again(s)) == hash(s)


def test_latex_uses_the_parameters_own_symbols() -> None:
    text = CATALOGUE["harmonic_oscillator"].latex()
    assert r"\omega^2_{-}" in text["f_minus"]
    assert r"\omega^2_{+}" in text["psi_plus"]
    assert r"a_{-}" in CATALOGUE["elliptic_curve"].latex()["f_minus"]


def test_a_conserved_quantity_may_name_time_and_hold_only_within_the_bounds_of_a_parameter() -> None:
    decay = "exp(c*t)*(y**2 + c*x*y + k*x**2)/2"
    s = system(f_minus=("y", "-k*x - c*y"), psi_minus=(decay,), parameters={"k": 2.0, "c": 0.3})
    assert s.conserved(-1, 1.0, (1.0, 0.0)) == pytest.approx(np.exp(0.3))
    psi = ("sqrt(k**2)*x**2 - y**2",)
    assert system(psi_minus=psi, parameters=[Parameter("k", -2.0, (-3.0, -1.0))]).dimension == 2
    with pytest.raises(ValueError, match="not conserved"):
        system(psi_minus=psi, parameters=[Parameter("k", 2.0, (1.0, 3.0))])


WRONG: list[tuple[dict[str, Any], str, str]] = [
    # what is changed, the offending text, what would do
    ({"f_minus": ("y",)}, "f_minus = ('y',)", "2 needed"),
    ({"f_plus": ("y", "-x", "0")}, "f_plus = ('y', '-x', '0')", "2 needed"),
    ({"f_plus": "y"}, "f_plus = 'y'", "('y', '-x')"),
    ({"jump": ("x",)}, "jump = ('x',)", "2 needed"),
    ({"x0": (1.0,)}, "(1.0,)", "2 needed: one for each of x, y"),
    ({"x0": (1.0, float("nan"))}, "nan", "must be finite"),
    ({"x0": (1.0, "a")}, "'a'", "2 numbers are needed"),
    ({"x0": 3.0}, "3.0", "2 numbers are needed"),
    ({"f_minus": ("y", "-k*z")}, "f_minus[1] = '-k*z'", "known are x, y, k, t, pi, e"),
    ({"g": "y +"}, "g = 'y +'", "is missing after +"),
    ({"g": "k - 1"}, "g = 'k - 1'", "it has to contain one of t, x, y"),
    ({"g": "x**2 + 1"}, "g = 'x**2 + 1'", "is positive everywhere"),
    ({"g": "-2*exp(y) - x**2"}, "g = ", "is negative everywhere"),
    ({"g": "(x**2 + y**2 - 1)**2"}, "g = ", "is nowhere negative, so that nothing switches where it is 0"),
    ({"g": "-x**2 - 2*(y - 1)**4"}, "g = ", "is nowhere positive, so that nothing switches where it is 0"),
    ({"g": "x - x + 1"}, "g = 'x - x + 1'", "it has to contain one of t, x, y"),
    ({"psi_minus": ("x**2 + y**2",)}, "psi_minus[0] = 'x**2 + y**2'", "derivative is"),
    ({"psi_plus": ("1/0",)}, "psi_plus[0] = '1/0'", "finite real"),
    ({"psi_plus": ("3",)}, "psi_plus[0] = '3'", "is constant: remove it"),
    ({"psi_plus": ("x**2 + y**2", "x**4")}, "psi_plus = ('x**2 + y**2', 'x**4')", "1 at most"),
    ({"psi_plus": "x**2 + y**2"}, "psi_plus = 'x**2 + y**2'", "a tuple"),
    ({"variables": ("x", "t")}, "'t'", "choose another"),
    ({"variables": ("x", "sin")}, "'sin'", "choose another"),
    ({"variables": ("x", "y z")}, "'y z'", "a letter followed by"),
    ({"variables": ("x", "x")}, "('x', 'x')", "names must differ"),
    ({"variables": (["x"], "y")}, "['x']", "a letter followed by"),
    ({"variables": ()}, "0 variables", "from 1 to 24"),
    ({"variables": tuple(f"x{k}" for k in range(25))}, "25 variables", "from 1 to 24"),
    ({"variables": "xy"}, "variables = 'xy'", "a tuple"),
    ({"parameters": {"x": 1.0}}, "'x'", "names must differ"),
    ({"parameters": [Parameter("k", 1.0)] * 2}, "'k'", "names must differ"),
    ({"parameters": {"lambda": 1.0}}, "'lambda'", "choose another"),
    ({"parameters": {"k": Parameter("q", 1.0)}}, "'k'", "names must agree"),
    ({"parameters": {"k": float("inf")}}, "k = inf", "finite number"),
    ({"parameters": {"k": "three"}}, "k = 'three'", "not a number"),
    ({"parameters": [3.0]}, "3.0", "Parameter(name, default)"),
    ({"parameters": 3.0}, "3.0", "Parameter"),
    ({"parameters": {"k": None}}, "k = None", "not a number"),
    ({"values": {"q": 1.0}}, "'q'", "known are k"),
]


@pytest.mark.parametrize(("changes", "offending", "remedy"), WRONG, ids=[str(w[0])[:50] for w in WRONG])
def test_mistakes_are_refused_with_what_is_wrong_and_what_would_do(
    changes: dict[str, Any], offending: str, remedy: str
) -> None:
    with pytest.raises(ValueError, match=r"\w") as caught:
        system(**changes)
    assert offending in str(caught.value)
    assert remedy in str(caught.value)


def test_what_is_left_of_a_quantity_that_is_not_conserved_is_shown() -> None:
    with pytest.raises(ValueError, match="psi_minus") as caught:
        system(psi_minus=("x**2 + y**2",))
    left = str(caught.value).split("time derivative is ")[1].split(", not 0")[0]
    x, y, k = sympy.symbols("x y k")
    assert sympy.expand(sympy.sympify(left) - (2 * x * y - 2 * k * x * y)) == 0


def test_what_is_left_over_is_not_shown_where_it_is_long() -> None:
    with pytest.raises(ValueError, match="too long to show") as caught:
        system(psi_minus=("*".join(f"sin(k*x*y + {k})*log(k*x + {k})" for k in range(1, 14)),))
    assert len(str(caught.value)) < 600


@pytest.mark.parametrize(
    "psi",
    [
        ("2*x**2 + y**2", "2*(2*x**2 + y**2) + 1"),
        ("2*x**2 + y**2", "(2*x**2 + y**2)**3"),
        ("2*x**2 + y**2", "sin(2*x**2)*cos(y**2) + cos(2*x**2)*sin(y**2)"),
        ("2*x**2 + y**2", "7"),
    ],
)
def test_dependent_conserved_quantities_are_refused(psi: tuple[str, str]) -> None:
    PiecewiseSystem(**SOLID, psi_plus=("2*x**2 + y**2", "x**2 - z**2"))
    with pytest.raises(ValueError, match=r"remove what follows from the others|is constant: remove it"):
        PiecewiseSystem(**SOLID, psi_plus=psi)


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (("k", 3.0, (4.0, 5.0)), "4 … 5"),
        (("k", 3.0, (5.0, 4.0)), "not below"),
        (("k", 3.0, (3.0, 3.0)), "not below"),
        (("k", 3.0, (0.0, float("inf"))), "finite"),
        (("k", 3.0, (0.0, 1.0, 2.0)), "two"),
        (("k", 3.0, 5.0), "two"),
        (("k", float("nan")), "finite"),
        (("k k", 3.0), "letter"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(arguments: tuple[Any, ...], remedy: str) -> None:
    with pytest.raises(ValueError, match=r"k") as caught:
        Parameter(*arguments)
    assert remedy in str(caught.value)


@pytest.mark.parametrize(
    ("values", "remedy"),
    [({"q": 1.0}, "known are k"), ({"k": 30.0}, "0.1 … 20"), ({"k": float("nan")}, "finite"), ({"k": "a"}, "not a n")],
)
def test_parameter_values_that_make_no_sense_are_refused(values: dict[str, Any], remedy: str) -> None:
    s = system(parameters=[Parameter("k", 3.0, (0.1, 20.0))])
    with pytest.raises(ValueError, match=next(iter(values))) as caught:
        s.with_parameters(**values)
    assert remedy in str(caught.value)


@pytest.mark.parametrize("side", [2, "plus", None])
def test_there_are_two_sides_and_sliding(side: Any) -> None:
    with pytest.raises(ValueError, match=r"-1 where g < 0, \+1 where g > 0, and 0 for sliding"):
        system().field(side, 0.0, (1.0, 1.0))
