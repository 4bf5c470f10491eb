"""A system whose variables differ in size by powers of ten is seen as a curve, and every number is a true one."""

import numpy as np
import pytest

import core
from pwsviz.export.tables import drawn_table
from pwsviz.figures.style import described
from pwsviz.geometry.phase_plane import ROWS
from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query, read
from pwsviz.scene.scene import Scene

SPEED = 1e4
"""Largest speed of a spring of this angular frequency that starts at 1."""

SPRING = core.PiecewiseSystem(
    name="Fast spring",
    variables=("x", "y"),
    f_minus=("y", f"-{SPEED**2}*x"),
    f_plus=("y", f"-{SPEED**2}*x"),
    g="x - 0.5",
    psi_minus=(f"(y**2 + {SPEED**2}*x**2)/2",),
    psi_plus=(f"(y**2 + {SPEED**2}*x**2)/2",),
    x0=(1.0, 0.0),
)


@pytest.fixture
def spring(explorer):
    explorer.scene.use(SPRING)
    explorer.settle(60)
    return explorer


def test_the_label_of_the_axis_names_the_unit_and_the_curve_is_a_circle(spring):
    figure, (x, y) = spring.portrait_panel.portrait.figure, drawn(spring)
    assert (figure.xaxis[0].axis_label, figure.yaxis[0].axis_label) == ("x", "y / 10⁴")
    assert np.hypot(x, y) == pytest.approx(1.0, abs=1e-3)


def drawn(explorer):
    orbits = explorer.portrait_panel.portrait.orbits.data
    points = np.column_stack([orbits["xs"][0], orbits["ys"][0]])
    return points[np.isfinite(points).all(axis=1)].T


def test_a_click_places_a_start_where_it_is_seen(spring):
    spring.portrait_panel.starts.place(0.25, -0.5)
    spring.settle(60)
    assert spring.scene.starts == ((1.0, 0.0), (0.25, -0.5 * SPEED))
    assert list(spring.portrait_panel.portrait.starts.data["y"]) == [0.0, -0.5]


def test_the_surface_and_the_level_sets_are_drawn_in_the_same_units(spring):
    ground = spring.portrait_panel.portrait.ground
    assert np.nanmax(np.abs(np.asarray(ground.surface.data["x"]) - 0.5)) < 1e-9
    for side, sign in ((-1, -1), (1, 1)):
        x, y, psi = (np.asarray(ground.levels[side].data[name], dtype=float) for name in ("x", "y", "psi"))
        there = np.isfinite(x)
        assert (sign * (x[there] - 0.5) > -1e-6).all()
        assert SPEED**2 * (x[there] ** 2 + y[there] ** 2) / 2 == pytest.approx(psi[there], rel=1e-2)


def test_arrows_are_tangents_of_the_curves_seen(spring):
    ground = spring.portrait_panel.portrait.ground
    lines = [np.asarray(ground.arrows[-1].data[name], dtype=float) for name in ("x", "y")]
    x, y = (line[: len(line) // ROWS * ROWS].reshape(-1, ROWS) for line in lines)
    middle_x, middle_y = (x[:, 0] + x[:, 1]) / 2, (y[:, 0] + y[:, 1]) / 2
    along = (x[:, 1] - x[:, 0]) * middle_x + (y[:, 1] - y[:, 0]) * middle_y
    assert np.abs(along).max() < 1e-6, "they are normal to the radius"


def test_limits_link_and_tables_have_values_of_the_variables(spring):
    panel = spring.portrait_panel
    panel.sight.keep(panel.portrait.frame._replace(y_low=-2.0, y_high=2.0))
    assert spring.scene.window[2:] == (-2.0 * SPEED, 2.0 * SPEED)
    table = drawn_table(panel.shown)["drawn"]()
    assert np.nanmax(table["y"]) == pytest.approx(SPEED, rel=1e-3)
    opened = Explorer(Scene(), Results())
    opened.scene.restore(read(query(spring.scene))[0])
    opened.refresh()
    opened.settle(60)
    assert opened.portrait_panel.portrait.frame[2:] == pytest.approx((-2.0, 2.0))
    opened.close()


def test_words_for_screen_readers_have_values_of_the_variables(spring):
    words = described(spring.portrait_panel.portrait.figure)
    assert "y from −10⁴ to 10⁴" in words
    assert "It meets a surface at (0.5, −8.66×10³) and (0.5, 8.66×10³)" in words


def test_units_do_not_follow_parameters_or_starts(spring):
    spring.portrait_panel.starts.move(0, 0.001, 0.0)
    spring.settle(60)
    assert spring.portrait_panel.portrait.figure.yaxis[0].axis_label == "y / 10⁴"
