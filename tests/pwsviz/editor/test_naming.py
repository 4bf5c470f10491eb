"""The name proposed for a system says what of another system still stands in it."""

from dataclasses import replace

import pytest

import core
from pwsviz.editor.draft import Draft
from pwsviz.editor.naming import CHANGED, MAX_NAME, UNNAMED, proposed_name

SYSTEMS = [core.CATALOGUE[key] for key in ("elliptic_curve", "bouncing_ball", "two_walls", "thermostat")]
LAWS = ("f", "f_minus", "f_plus", "g", "surfaces", "regions", "transitions")


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: system.name)
def test_a_system_of_the_list_is_called_changed_while_one_of_its_laws_stands(system):
    begun, listed = Draft.of(system), {system.name}
    assert proposed_name(begun, begun, listed) == system.name
    changed = system.name + CHANGED
    assert proposed_name(begun, replace(begun, x0="9, 9"), listed) == changed
    held = [name for name in LAWS if getattr(begun, name)]
    for kept in held:
        others = {name: "z" for name in held if name != kept}
        assert proposed_name(begun, replace(begun, **others, x0="9, 9"), listed) == changed
    assert proposed_name(begun, replace(begun, **dict.fromkeys(held, "z")), listed) == UNNAMED


def test_spaces_make_no_other_law():
    begun = Draft(name="Two springs", f_minus="y\n-x", f_plus="y\n-2*x", g="y")
    respaced = replace(begun, f_minus="y,  -x", f_plus="x\ny", g="x")
    assert proposed_name(begun, respaced, ()) == "Two springs"


def test_a_name_is_changed_once_numbered_where_it_is_taken_and_never_too_long():
    begun = Draft(name="Curve (changed)", g="x")
    assert proposed_name(begun, replace(begun, x0="1"), {"Curve (changed)"}) == "Curve (changed)"
    assert proposed_name(begun, replace(begun, g="y"), {UNNAMED, f"{UNNAMED} 2"}) == f"{UNNAMED} 3"
    long = Draft(name="n" * MAX_NAME, g="x")
    assert len(proposed_name(long, replace(long, x0="1"), {long.name})) == MAX_NAME
