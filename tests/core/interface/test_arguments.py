"""What is taken for a number, and what is not."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy

import core
from core.interface.arguments import count, listed, number, numbers, plain_numbers

SYSTEM = core.CATALOGUE["harmonic_oscillator"]


@pytest.mark.parametrize(
    "value",
    [1, 1.0, np.float32(1), np.int8(1), np.array(1.0), np.longdouble(1), Fraction(1), Decimal(1), sympy.Integer(1)],
)
def test_numbers_of_every_kind_are_taken(value):
    assert number(value, "n") == 1.0
    assert type(number(value, "n")) is float


@pytest.mark.parametrize(
    "value", [None, "1", b"1", True, np.True_, 1 + 0j, np.complex128(1), [1.0], np.ones(1), {}, object]
)
def test_what_is_no_number_is_refused_by_its_name(value):
    with pytest.raises(ValueError, match=r"tau = .* is not a number"):
        number(value, "tau")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 10**400, np.float64("-inf")])
def test_what_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="a finite number is needed"):
        number(value, "tau")


@pytest.mark.parametrize("value", [0, -1, 1.5, 11])
def test_counts_are_whole_and_within_bounds(value):
    assert count(np.int64(10), "n", 10) == 10
    with pytest.raises(ValueError, match="a whole number from 1 to 10"):
        count(value, "n", 10)


def test_what_has_no_order_is_no_sequence():
    assert listed(range(2), "x", "…") == (0, 1)
    assert listed("one", "x", "…", str) == ("one",)
    for value in ("12", b"12", {1, 2}, {"a": 1}, 3, None, np.array(1.0)):
        with pytest.raises(ValueError, match="two of them"):
            listed(value, "x", "two of them")


def test_arrays_keep_their_shape():
    assert numbers([[1, 2], [3, 4]], "t").tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert numbers([Fraction(1, 2), 1], "t").tolist() == [0.5, 1.0]


def test_a_text_is_no_state():
    for x0 in ("12", b"12", {1.0, 2.0}, ["1", "2"], (True, False)):
        with pytest.raises(ValueError, match="2 numbers are needed"):
            core.integrate(SYSTEM, (0.0, 1.0), x0=x0)


def test_a_state_may_be_given_by_the_names_of_the_variables():
    run = core.integrate(SYSTEM, (0.0, 1.0), x0={"y": 2, "x": 1})
    assert run.x[0].tolist() == [1.0, 2.0]
    assert core.order_study(SYSTEM, (0.1, 0.05), {"y": 1, "x": 1}, crossings=(1,)).crossings == (1,)
    for x0, words in (({"x": 1}, "'y' is missing"), ({"x": 1, "y": 2, "z": 3}, "'z' is not a variable")):
        with pytest.raises(ValueError, match=words):
            core.integrate(SYSTEM, (0.0, 1.0), x0=x0)


def test_a_system_may_be_given_by_its_key():
    assert core.integrate("harmonic_oscillator", (0.0, 1.0)).system is SYSTEM
    assert core.reference_solution("harmonic_oscillator").name == core.reference_solution(SYSTEM).name
    assert core.order_study("harmonic_oscillator", (0.1, 0.05), crossings=(1,)).method == "dmm2"
    assert core.work_precision("harmonic_oscillator", methods="rk2", settings={"rk2": (0.1,)}, peers=()).complete
    study = core.stability_study("harmonic_oscillator", methods="rk2", taus=(0.1, 0.2), parts="largest_tau")
    assert study.system == SYSTEM.name
    for system in ("harmonic", None, 3):
        with pytest.raises(ValueError, match=r"a key of CATALOGUE, which are harmonic_oscillator, elliptic_curve"):
            core.integrate(system, (0.0, 1.0))


def test_a_method_may_be_given_itself():
    method = core.METHODS["rk4"]
    assert core.integrate(SYSTEM, (0.0, 1.0), method=method).method == "rk4"
    assert core.order_study(SYSTEM, (0.1, 0.05), method=method, crossings=(1,)).method == "rk4"
    study = core.stability_study(SYSTEM, methods=[method], taus=(0.1, 0.2), parts="largest_tau")
    assert study.methods == ("rk4",)
    assert core.work_precision(SYSTEM, methods=[method], settings={"rk4": (0.1,)}, peers=()).curves[0].name == "rk4"


@pytest.mark.parametrize("values", [(1, 2.0), [1.0, 2], np.array([1, 2]), (np.float64(1), 2), np.array([1.0, 2.0])])
def test_plain_numbers_are_taken_as_they_are(values):
    found = plain_numbers(values, 2)
    assert found == (1.0, 2.0)
    assert {type(value) for value in found} == {float}


@pytest.mark.parametrize(
    "values",
    [(1, 2, 3), (1, True), np.array([True, False]), (1, "2"), (1, np.nan), (1, 10**400), (1e308, 1e308), {1, 2}, 1.0,
     np.array(1.0), np.ones((2, 2)), np.ones(2, dtype=complex), {"x": 1, "y": 2}, (1, np.float32(2)), None],
)  # fmt: skip
def test_all_others_need_a_closer_look(values):
    assert plain_numbers(values, 2) is None
