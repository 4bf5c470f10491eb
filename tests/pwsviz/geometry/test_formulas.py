"""Trees say what the formulas of a system say, and nothing where that is not known."""

import math

import numpy as np
import pytest

import core
from pwsviz.geometry.formulas import FUNCTIONS, formulas


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


@pytest.mark.parametrize("name", list(core.CATALOGUE))
@pytest.mark.parametrize("axes", [(0, 1), (1, 0)])
def test_trees_have_the_values_of_the_formulas(name, axes):
    system = core.CATALOGUE[name]
    known, t = formulas(system, axes), 0.7
    for x, y in np.random.default_rng(0).uniform(0.2, 0.9, (5, 2)):
        state = np.full(system.dimension, 0.3)
        state[list(axes)] = x, y
        if known["g"] is not None:
            assert value(known["g"], x, y, t) == pytest.approx(float(system.switching(t, state)), rel=1e-12, abs=1e-13)
        for side, tree in zip((-1, 1), known["psi"], strict=True):
            if tree is not None:
                psi = system.conserved(side, t, state)[0]
                assert value(tree, x, y, t) == pytest.approx(psi, rel=1e-12, abs=1e-13)
    assert (known["psi"][0] is not None) == (system.dimension == 2 and bool(system.psi_minus))


def test_a_name_that_is_not_shown_leaves_no_formula():
    assert formulas(core.CATALOGUE["gene_switch"], (0, 1))["g"] is None
    assert formulas(core.CATALOGUE["moving_interface"], (0, 1))["moving"]
