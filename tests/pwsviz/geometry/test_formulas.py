"""Trees say what the formulas of a system say, and nothing where that is not known."""

import math

import numpy as np
import pytest

import core
from pwsviz.geometry.formulas import FUNCTIONS, formulas
from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.projection import shows_regions, surfaces_shown
from tests.pwsviz.own_systems import OWN_SYSTEMS, RELAY

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}
T = 0.7

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))
in_both_orders = pytest.mark.parametrize("axes", [(0, 1), (1, 0)])


def of_all_regions(system, axes):
    return formulas(system, Plane(axes), range(len(system.regions)))


def value(tree, x, y, t):
    """What the browser works out."""
    if isinstance(tree, float):
        return tree
    if isinstance(tree, str):
        return {"x": x, "y": y, "t": t}[tree]
    name, *parts = tree
    numbers = [value(part, x, y, t) for part in parts]
    if name in FUNCTIONS:
        return getattr(math, name)(*numbers)
    return {"add": math.fsum, "mul": math.prod, "abs": lambda one: abs(one[0]), "pow": lambda two: two[0] ** two[1]}[
        name
    ](numbers)


def told_region(known, x, y):
    """The entry of the region that the browser finds, or None."""
    signs = [None if g is None else np.sign(value(g, x, y, T)) for g in known["g"]]
    return next((one for one in known["regions"] if all(a == b for a, b in zip(one[0], signs, strict=True))), None)


def states(system, axes, low, high, count):
    """Points of the plane, and states over them whose other coordinates do not matter."""
    for x, y in np.random.default_rng(0).uniform(low, high, (count, 2)):
        state = np.full(system.dimension, 0.3)
        state[list(axes)] = x, y
        yield x, y, state


@every_system
@in_both_orders
def test_trees_have_the_values_of_the_formulas(system, axes):
    known = of_all_regions(system, axes)
    assert [tree is not None for tree in known["g"]] == [
        k in surfaces_shown(system, axes) for k in range(len(system.laws.surfaces))
    ]
    for x, y, state in states(system, axes, 0.2, 0.9, 5):
        for region, ways in enumerate(system.laws.ways):
            for way, height in zip(ways, system.heights(region, T, state), strict=True):
                tree = known["g"][way.surface]
                if tree is not None:
                    assert way.sign * value(tree, x, y, T) == pytest.approx(float(height), rel=1e-12, abs=1e-13)
        for name, (*_, tree) in zip(system.regions, known["regions"], strict=False):
            if tree is not None:
                psi = system.conserved(name, T, state)[0]
                assert value(tree, x, y, T) == pytest.approx(psi, rel=1e-12, abs=1e-13)


@every_system
@in_both_orders
def test_there_is_a_formula_of_psi_for_each_region_of_a_plane_that_has_one(system, axes):
    known = of_all_regions(system, axes)
    assert bool(known["regions"]) == shows_regions(system, axes)
    for law, (*_, tree) in zip(system.regions.values(), known["regions"], strict=False):
        assert (tree is not None) == (system.dimension == 2 and bool(law.psi))


@every_system
@in_both_orders
def test_the_readout_tells_the_region_that_a_point_lies_in_and_none_where_no_law_is_declared(system, axes):
    known = of_all_regions(system, axes)
    for x, y, state in states(system, axes, -2.0, 2.0, 40) if known["regions"] else ():
        inside = [k for k in range(len(system.regions)) if (system.heights(k, T, state) > 0).all()]
        told = told_region(known, x, y)
        assert ([] if told is None else [known["regions"].index(told)]) == inside


def test_of_a_region_in_which_no_state_is_the_readout_knows_nothing():
    for there, names, bare in (((0, 1), ["g < 0", "g > 0"], ""), ((1,), ["g > 0"], "beyond the wall")):
        known = formulas(SYSTEMS["bouncing_ball"], XY, there)
        assert ([one[1] for one in known["regions"]], known["bare"]) == (names, bare)


def test_regions_and_quantities_are_named_by_their_signs():
    assert [tuple(one[:3]) for one in of_all_regions(SYSTEMS["chua"], (0, 1))["regions"]] == [
        ([-1, -1], "region −−", "ψ"), ([1, -1], "region +−", "ψ"), ([1, 1], "region ++", "ψ"),
    ]  # fmt: skip
    assert [tuple(one[:3]) for one in of_all_regions(SYSTEMS["elliptic_curve"], (0, 1))["regions"]] == [
        ([-1], "g < 0", "ψ₋"), ([1], "g > 0", "ψ₊"),
    ]  # fmt: skip


def test_a_name_that_is_not_shown_leaves_no_formula():
    gene = of_all_regions(core.CATALOGUE["gene_switch"], (0, 1))
    assert (gene["g"], gene["regions"]) == ([None], [])
    ring = of_all_regions(core.CATALOGUE["gene_ring"], (0, 1))
    assert [tree is None for tree in ring["g"]] == [False, False, True]
    assert ring["regions"] == [], "its third sign is not known"
    assert of_all_regions(RELAY, (0, 1))["regions"] == [], "a place does not tell a region that has a name"
    assert of_all_regions(core.CATALOGUE["moving_interface"], (0, 1))["moving"]
