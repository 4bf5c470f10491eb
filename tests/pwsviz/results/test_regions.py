"""Results of systems with more regions than two sides: levels by region, shades along the run, jumps between walls."""

import numpy as np
import pytest

import core
from pwsviz.geometry.shades import shades_of
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import OWN_SYSTEMS, STRIPS

SYSTEMS = {**{name: one for name, one in core.CATALOGUE.items() if not one.two_sided}, **OWN_SYSTEMS}

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


@pytest.fixture(scope="module")
def results():
    return Results()


def inputs_of(system, t_end=8.0):
    scene = Scene()
    scene.use(system)
    scene.accept("methods", ["rk4"])
    scene.accept("t_end", t_end)
    return run_inputs(scene)[0]


def test_levels_of_an_orbit_are_the_values_of_psi_in_the_regions_it_passes(results):
    inputs = inputs_of(STRIPS, t_end=5.0)
    run, levels = results.run(inputs), dict(results.orbit(inputs).levels)
    by_hand = (lambda x, y: 2 * x - y, lambda _, y: y, lambda x, y: (x - 2) ** 2 + y**2)
    assert {STRIPS.laws.name(k) for k in run.mode} == {"--", "+-", "++"}
    for region, psi in enumerate(by_hand):
        there = run.mode == region
        assert levels[region] == pytest.approx((psi(*run.x[there].T).mean(),), rel=1e-3)


@every_system
def test_every_crossing_of_a_portrait_lies_on_a_surface(results, system):
    inputs = inputs_of(system)
    run, orbit = results.run(inputs), results.orbit(inputs)
    laws = system.laws
    g = laws.evaluate("all surfaces", laws.surfaces, run.crossings.t, run.crossings.x, system.parameter_array)
    assert np.abs(g).min(axis=1).max(initial=0.0) < 1e-12
    assert (len(orbit.crossings) > 0) == (len(run.crossings.passed) > 0)
    assert (orbit.end is None) == (run.status is core.Status.COMPLETED)


@every_system
def test_the_error_has_the_shade_of_the_mode_occupied_between_crossings(results, system):
    inputs = inputs_of(system)
    run, curve = results.run(inputs), results.error_curve(inputs)
    assert len(curve.sides) == 1 + len(curve.crossings)
    shades = shades_of(system, run.mode)
    bounds = [run.t[0], *curve.crossings, np.inf]
    for shade, start, end in zip(curve.sides, bounds[:-1], bounds[1:], strict=True):
        inner = (run.t > start + 1e-9) & (run.t < end - 1e-9)
        assert (shades[inner] == shade).all()
    known = [bool(system.laws.regions[k].conserved) if k < len(system.laws.regions) else True for k in run.mode]
    assert np.array_equal(np.isfinite(run.change_of_psi()), known)


@pytest.mark.parametrize(("system", "jumps"), [("two_walls", True), ("thermostat", False), ("chua", False)])
def test_a_run_between_walls_jumps_and_others_cross(results, system, jumps):
    inputs = inputs_of(core.CATALOGUE[system], t_end=20.0)
    summary, run = results.summary(inputs), results.run(inputs)
    assert sum(summary.met) == len(run.crossings) > 1
    assert str(summary.met) == f"{len(run.crossings)} {'jumps' if jumps else 'crossings'}"


@every_system
def test_there_are_constants_of_the_theory_for_each_of_them(results, system):
    assert results.diagnosis(inputs_of(system)) is not None
