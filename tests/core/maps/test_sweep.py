"""Sweeps: what runs leave on a surface for each value of a parameter."""

import numpy as np
import pytest

import core
from core import Status

#: x' = x (a + 2 r² − r⁴) and so on with r² = x² + y²: for −1 < a < 0 the origin and a cycle r² = 1 + √(1 + a) attract.
BOTH = core.PiecewiseSystem(
    "Subcritical", ("x", "y"), g="x - 40",
    f_minus=("x*(a + 2*(x**2 + y**2) - (x**2 + y**2)**2) - y", "y*(a + 2*(x**2 + y**2) - (x**2 + y**2)**2) + x"),
    f_plus=("-x", "-y"), parameters={"a": -0.5}, x0=(0.01, 0.0),
)  # fmt: skip
VALUES = np.array([-1.2, -0.6, 0.3, 0.6])
SETTINGS = {"of": "y", "direction": 1, "points": 3, "discard": 12, "method": "taylor", "tolerance": 1e-12}


def test_each_value_has_the_points_of_its_own_section():
    found = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", **SETTINGS)
    assert found.statuses == (Status.CROSSING_LIMIT,) * 4
    for a in VALUES:
        alone = core.section(BOTH, (0.0, 1e3), None, {"a": a}, coordinates=("x",), **SETTINGS)
        assert np.array_equal(found.points[found.value == a], alone.points[:, 0])


def test_a_continuation_stays_on_its_branch_which_depends_on_the_way():
    """Upwards the run stays at the origin until a = 0; downwards on the cycle until a = −1."""
    up = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="up", **SETTINGS)
    down = core.sweep(BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="down", **SETTINGS)
    cycle = {a: np.sqrt(1 + np.sqrt(1 + a)) for a in VALUES if a > -1}
    assert np.abs(up.points[up.value < 0]).max() < 1e-3
    for a, radius in cycle.items():
        assert down.points[down.value == a] == pytest.approx(radius, abs=1e-6)
    assert np.abs(down.points[down.value == -1.2]).max() < 1e-2


def test_a_cancelled_sweep_has_the_points_of_the_values_that_are_done():
    heard = []
    found = core.sweep(
        BOTH, (0.0, 1e3), "a", VALUES, "x", continuation="up", progress=heard.append,
        cancel=lambda: len(heard) == 2, **SETTINGS,
    )  # fmt: skip
    assert heard == [0.25, 0.5]
    assert found.statuses[2:] == (Status.CANCELLED,) * 2
    assert set(found.value) == {-1.2, -0.6}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"parameter": "b"}, "unknown parameter 'b'"),
        ({"values": [[1.0]]}, "values has shape"),
        ({"values": [np.inf]}, "finite"),
        ({"coordinate": "z"}, "'z' is no variable"),
        ({"continuation": "sideways"}, "choose from none, up, down"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_what_makes_no_sense_is_refused(arguments, words):
    given = {"system": BOTH, "t_span": (0.0, 1.0), "parameter": "a", "values": [1.0], "coordinate": "x"}
    with pytest.raises(ValueError, match=words):
        core.sweep(**{**given, **SETTINGS, **arguments})
