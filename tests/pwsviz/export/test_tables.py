"""The tables of a figure hold every curve that it draws."""

import io
from functools import cache

import numpy as np
import pytest

import core
from pwsviz.export import tables
from pwsviz.export.files import csv_bytes, npz_bytes
from pwsviz.export.tables import DrawnRun, conserved_tables, drawn_runs, drawn_table, portrait_tables
from pwsviz.geometry.plane import XY
from pwsviz.results.requests import other_inputs, run_inputs
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import OWN_SYSTEMS

STARTS = ((-1.0, -1.0), (-1.2, 0.0), (-1.0, -0.5))


@cache
def drawn():
    """The runs of a portrait of three starts, the second of which is selected, by two integrators."""
    scene, results = Scene(starts=STARTS, selected=1, t_end=5.0), Results()
    inputs = PortraitInputs(run_inputs(scene), other_inputs(scene))
    return drawn_runs(inputs, scene.selected, results.run)


def made(given):
    return {name: table() for name, table in given.items()}


def rows_of(table, start, method):
    return (table["start"] == start) & (table["integrator"] == method)


def test_the_portrait_has_every_run_from_every_start():
    found = made(portrait_tables(drawn()))
    for number, start in enumerate(STARTS, 1):
        for method in ("dmm2", "rk2"):
            run = core.integrate("elliptic_curve", (0.0, 5.0), x0=start, method=method)
            rows = rows_of(found["curves"], number, method)
            assert np.array_equal(found["curves"]["t"][rows], run.t)
            assert np.array_equal(np.column_stack([found["curves"][v][rows] for v in "xy"]), run.x)
            met = rows_of(found["crossings"], number, method)
            assert np.array_equal(found["crossings"]["t"][met], run.crossings.t)
            assert np.array_equal(found["crossings"]["x"][met], run.crossings.x[:, 0])
            assert found["crossings"]["number"][met].tolist() == list(range(1, 1 + len(run.crossings)))


def test_the_conserved_quantity_has_the_drift_of_every_integrator_and_no_states():
    found = made(conserved_tables(drawn()))
    assert set(found["curves"]) == {"start", "integrator", "step", "t", "side", "change_of_psi"}
    run = core.integrate("elliptic_curve", (0.0, 5.0), x0=STARTS[1], method="rk2")
    rows = rows_of(found["curves"], 2, "rk2")
    assert np.array_equal(found["curves"]["change_of_psi"][rows], run.change_of_psi())
    assert set(found["crossings"]) == {"start", "integrator", "number", "t", "side_entered", "kind"}


def test_the_curves_are_there_as_drawn_between_long_steps_and_with_gaps_at_jumps():
    scene = Scene(system="bouncing_ball", methods=["rk4", "dmm2"], tau=0.3, t_end=2.0)
    scene.place((0.5, 0.0))
    inputs, results = PortraitInputs.of(scene), Results()
    pictures = results.pictures(inputs)
    found = drawn_table(pictures)["drawn"]()
    variables = scene.declaration.variables
    for number, orbits in ((2, pictures.orbits), (1, pictures.others)):
        for orbit in orbits:
            rows = rows_of(found, number, orbit.method)
            points = np.column_stack([found[v][rows] for v in variables])
            assert np.array_equal(points, pictures.plane.values(orbit.path), equal_nan=True)
            assert np.isnan(points).any(axis=1).sum() >= 2
            assert len(points) > 3 * 2.0 / 0.3
    assert found["start"].tolist() == sorted(found["start"])


def test_each_body_that_is_drawn_has_its_table():
    scene = Scene(system="three_bodies", methods=["dmm2", "rk2"], t_end=3.0)
    scene.place((0.9, 0.0, *scene.starts[0][2:]))
    results = Results()
    pictures = results.pictures(PortraitInputs.of(scene))
    tables = made(drawn_table(pictures))
    assert list(tables) == ["drawn", "drawn x2 y2", "drawn x3 y3"]
    run = core.integrate("three_bodies", (0.0, 3.0), x0=scene.starts[1], method="rk2", tau=scene.tau)
    for body, name in enumerate(tables, 1):
        rows = rows_of(tables[name], 2, "rk2")
        drawn = np.column_stack([tables[name][f"{letter}{body}"][rows] for letter in "xy"])
        states = run.x[:, 2 * body - 2 : 2 * body]
        away = [np.hypot(*(states - place).T).min() for place in drawn]
        assert max(away) < 1e-2, "its vertices are states of the body in this run"
        assert np.array_equal(drawn[0], states[0])
        assert len(drawn) > 20
    frames = results.frames((*pictures.inputs.selected, *pictures.inputs.others), XY)
    starts = [one.places[0].tolist() for one in frames]
    assert starts == [[x[2 * body], x[2 * body + 1]] for body in range(3) for x in scene.starts[::-1] for _ in range(2)]


def test_of_very_many_steps_some_are_kept_and_the_last(monkeypatch):
    monkeypatch.setattr(tables, "MOST_ROWS", 1000)
    found = portrait_tables(drawn())["curves"]()
    rows = rows_of(found, 1, "dmm2")
    assert found["step"][rows][:3].tolist() == [0, 4, 8]
    assert found["step"][rows][-1] == 500
    assert found["t"][rows][-1] == 5.0


def test_a_variable_may_be_called_as_a_column_of_ours():
    names = ("side", "about", "kind")
    system = core.PiecewiseSystem("clash", names, ("1", "1", "1"), ("1", "1", "1"), "side", x0=(-1.0, 2.0, 3.0))
    run = core.integrate(system, (0.0, 2.0), method="rk2")
    found = made(portrait_tables(lambda: [DrawnRun(1, run)]))
    assert found["curves"]["side"].dtype.kind == "i"
    assert found["curves"]["variable_about"][0] == 2.0
    assert found["crossings"]["variable_kind"] == pytest.approx([4.0])
    assert npz_bytes(found)


SEVERAL = {**{name: one for name, one in core.CATALOGUE.items() if not one.two_sided}, **OWN_SYSTEMS}


@pytest.mark.parametrize("system", SEVERAL.values(), ids=list(SEVERAL))
def test_of_several_regions_each_row_names_the_one_occupied_and_each_crossing_the_one_entered(system):
    run = core.integrate(system, (0.0, 8.0), tau=1e-2, method="rk4", sliding="stop")
    names = np.array([mode.name for mode in system.modes] + [""])
    for tables_of in (portrait_tables, conserved_tables):
        found = made(tables_of(lambda: [DrawnRun(1, run)]))
        assert found["curves"]["region"].tolist() == names[run.mode].tolist()
        assert found["crossings"]["region_entered"].tolist() == names[run.crossings.mode].tolist()
        assert not {"side", "side_entered"} & {*found["curves"], *found["crossings"]}
    assert npz_bytes(found)


def test_a_run_that_stops_at_a_surface_enters_no_region_and_one_that_slides_says_where():
    wedge = core.integrate(OWN_SYSTEMS["Wedge"], (0.0, 3.0), x0=(-1.0, -0.5), tau=0.1, method="rk2")
    assert wedge.status is core.Status.UNDECLARED
    assert made(portrait_tables(lambda: [DrawnRun(1, wedge)]))["crossings"]["region_entered"].tolist() == [""]
    strips = core.integrate(OWN_SYSTEMS["Strips"], (0.0, 12.0), tau=1e-2, method="rk4", sliding="continue")
    assert "+0" in made(portrait_tables(lambda: [DrawnRun(1, strips)]))["curves"]["region"]


def test_a_table_of_regions_is_explained_and_names_them_as_a_run_does():
    run = core.integrate(core.CATALOGUE["two_walls"], (0.0, 3.0), tau=0.1, method="rk2")
    table = made(portrait_tables(lambda: [DrawnRun(1, run)]))["curves"]
    text = csv_bytes(table).decode()
    assert "region: region occupied" in text
    assert {line.rpartition(",")[2] for line in text.splitlines()[2:]} == {"+-"}
    assert set(np.load(io.BytesIO(npz_bytes({"": table})))["region"]) == {"+-"}
