"""Runs near a tangency, of systems with several surfaces, walls and hysteresis; the others are in test_stability."""

import numpy as np
import pytest

import core
from core import stability_study


@pytest.mark.parametrize("number", [0, 1])
def test_a_tangency_is_found_beside_a_surface_that_is_never_met(number):
    # From x = value at rest, the swing of an oscillator just reaches x = 1; y = 9 is out of its reach.
    surfaces = ["y - 9", "y - 9"]
    surfaces[number] = "x - 1"
    law = core.Region(("y", "-x"), ("(x**2 + y**2)/2",))
    wall = core.PiecewiseSystem("two", ("x", "y"), surfaces=tuple(surfaces), x0=(-0.7, 0.0),
                                regions=dict.fromkeys(("--", "-+", "+-", "++"), law))  # fmt: skip
    found = stability_study(wall, (0, 6), methods=("dmm2", "rk4"), values=np.linspace(-1.53, -0.51, 8), tau=0.01,
                            parts="grazing").grazing  # fmt: skip
    assert found.value == pytest.approx(-1.0, abs=4e-16)
    assert found.state == pytest.approx([1.0, 0.0], abs=1e-12)
    assert (found.expected == [[2], [0]]).all()
    assert (found.missed[0, :, :13] == 0).all()
    assert found.missed[1, 0, -1] == 2  # rk4 shrinks


def test_a_wall_is_grazed_where_the_swing_just_reaches_it():
    walls = core.CATALOGUE["two_walls"].with_parameters(restitution=1.0)
    values = np.linspace(0.55, 1.45, 8)
    found = stability_study(walls, (0, 6), (0.0, 0.7), ("dmm2",), coordinate="v", values=values, tau=0.01,
                            parts="grazing").grazing  # fmt: skip
    assert found.value == pytest.approx(1.0, abs=4e-16)
    assert found.time == pytest.approx(np.pi / 2, abs=1e-3)
    assert (found.missed[0, :, :13] == 0).all()


def test_a_relay_with_hysteresis_grazes_the_guard_at_which_it_would_switch():
    # On: x'' = -x, off beyond x = 1: from (value, 0) the swing just reaches x = 1, and then goes elsewhere.
    relay = core.PiecewiseSystem(
        "relay", ("x", "y"), x0=(-0.7, 0.0),
        regions={"on": core.Region(("y", "-x")), "off": core.Region(("y", "-x - 1"))},
        transitions=(core.Transition("on", "1 - x", "off"), core.Transition("off", "x + 9", "on")),
    )  # fmt: skip
    found = stability_study(relay, (0, 6), methods=("rk4",), values=np.linspace(-1.53, -0.51, 8), tau=0.01,
                            parts="grazing").grazing  # fmt: skip
    assert found.value == pytest.approx(-1.0, abs=4e-16)
    assert (found.expected == [[1], [0]]).all()
    assert found.missed[0, 0, -1] == 1


def test_an_instant_is_grazed_from_no_start():
    law = core.CATALOGUE["harmonic_oscillator"]
    wave = core.PiecewiseSystem("wave", law.variables, law.f_minus, law.f_plus, "sin(t)", parameters=law.values,
                                x0=law.x0)  # fmt: skip
    found = stability_study(wave, (0, 6), methods=("rk4",), tau=0.05, parts="grazing").grazing
    assert (found.searched, found.instants, found.found) == (True, True, False)
