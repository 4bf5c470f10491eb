"""The external solver on systems with several surfaces, walls, hysteresis and sliding, against exact solutions."""

import numpy as np
import pytest

from core import CATALOGUE, PiecewiseSystem, Region, Transition, reference_solution
from core.reference import external_solution, functions_of


def independent(system, t0=0.0, sliding="stop"):
    """The external solver, even where a closed form is known."""
    return external_solution(functions_of(system), t0, system.x0, slides=sliding == "continue")


def agree(system, t_end, tolerance, sliding="stop"):
    """The number of crossings on which the external and the exact solution agree, up to a time."""
    mine, exact = independent(system, sliding=sliding), reference_solution(system, sliding=sliding)
    assert exact.exact
    count = 0
    while True:
        try:
            t, x = exact.crossing(count + 1)
        except ValueError:  # no further one
            break
        if t > t_end:
            break
        count += 1
        found = mine.crossing(count)
        assert found[0] == pytest.approx(t, abs=tolerance)
        assert found[1] == pytest.approx(x, abs=tolerance)
        assert mine.after(count) == pytest.approx(exact.after(count), abs=tolerance)
        assert mine.entered(count) == exact.entered(count)
    assert mine.state(t_end) == pytest.approx(exact.state(t_end), abs=tolerance)
    return count


@pytest.mark.parametrize(("name", "least"), [("chua", 5), ("two_walls", 6), ("thermostat", 3), ("diode_bridge", 4)])
def test_several_surfaces_walls_and_hysteresis_are_followed_as_exactly_known(name, least):
    assert agree(CATALOGUE[name], 12.0, 1e-10) >= least


def test_sliding_is_followed_to_where_a_field_turns_and_beyond_another_surface():
    # Both fields point to y = 0 while x < 1, so it slides there with x' = 1, over x = 0; from x = 1 on f- leads down.
    upper, lower = ("1", "-1"), ("1", "1 - x")
    system = PiecewiseSystem(
        "slides", ("x", "y"), surfaces=("x", "y"), x0=(-2.0, 1.0),
        regions={k: Region(upper if k[1] == "+" else lower) for k in ("--", "-+", "+-", "++")},
    )  # fmt: skip
    assert agree(system, 3.0, 1e-11, "continue") == 3


def test_two_surfaces_met_at_once_are_a_corner_for_the_external_solver_too():
    system = PiecewiseSystem(
        "corner", ("x", "y"), surfaces=("x", "y"), x0=(-0.3, -0.3),
        regions={k: Region(("1", "1 + 0*x" if k != "+-" else "-1")) for k in ("--", "-+", "+-", "++")},
    )  # fmt: skip
    with pytest.raises(ValueError, match="several surfaces at once"):
        independent(system).crossing(1)


def test_an_independent_reference_can_be_asked_for_of_any_system():
    ring = CATALOGUE["gene_ring"]
    relay = PiecewiseSystem(
        "cubic relay", ("x", "y"), x0=(0.5, 0.0),
        regions={"on": Region(("y", "-x**3 + 1")), "off": Region(("y", "-x**3 - 1"))},
        transitions=(Transition("on", "1 - x", "off"), Transition("off", "x + 1", "on")),
    )  # fmt: skip
    for system in (ring, relay):
        other, mine = reference_solution(system), reference_solution(system, independent=True)
        assert mine.error < 1e-10
        for k in (1, 2, 3):
            (t, x), (s, y) = other.crossing(k), mine.crossing(k)
            assert s == pytest.approx(t, abs=1e-10)
            assert np.abs(y - x).max() < 1e-10
            assert mine.entered(k) == other.entered(k)
