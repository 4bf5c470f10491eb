"""The time for which a system is run first follows its own scale."""

import numpy as np
import pytest

import core
from core.studies.time_scale import moderate_time


def _oscillator(rate):
    f_minus, f_plus = (("y", f"-{c * rate**2!r}*x") for c in (1.0, 3.0))
    return core.PiecewiseSystem("oscillator", ("x", "y"), f_minus, f_plus, "x - 0.3", x0=(1.0, 0.0))


@pytest.mark.parametrize("power", range(-2, 5))
def test_an_oscillator_is_given_some_turns_whatever_its_rate(power):
    turns = moderate_time(_oscillator(10.0**power), 20.0) * 10.0**power / (2 * np.pi)
    assert 0.9 < turns < 40.0


@pytest.mark.parametrize("name", sorted(set(core.CATALOGUE) - {"bouncing_ball"}))
def test_systems_whose_rates_are_of_the_order_of_one_keep_the_usual_time(name):
    assert moderate_time(core.CATALOGUE[name], 20.0) == 20.0


def test_jumps_that_accumulate_are_reached():
    assert moderate_time(core.CATALOGUE["bouncing_ball"], 20.0) == 2.0  # they do at 4.1


def test_a_rest_on_the_surface_is_not_taken_for_much_that_happens():
    f = ("y", "-x")
    assert moderate_time(core.PiecewiseSystem("rest", ("x", "y"), f, f, "y"), 20.0) == 20.0


@pytest.mark.parametrize("f", [("0", "0"), ("-x", "-y"), ("x**2", "1")], ids=["rest", "decay", "pole"])
def test_a_system_that_comes_to_rest_or_ends_keeps_the_usual_time(f):
    assert moderate_time(core.PiecewiseSystem("s", ("x", "y"), f, f, "y - 5", x0=(1.0, 1.0)), 20.0) == 20.0


def test_time_is_scaled_by_a_power_of_ten_and_not_otherwise():
    rng = np.random.default_rng(0)
    for rate in 10 ** rng.uniform(-2, 4, 12):
        power = np.log10(moderate_time(_oscillator(float(rate)), 20.0) / 20.0)
        assert power == pytest.approx(round(power), abs=1e-9), rate
