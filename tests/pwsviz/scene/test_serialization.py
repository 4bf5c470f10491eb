"""A system comes back from its description as it was; what is does not describe is refused in words."""

import json
import re

import pytest

import core
from pwsviz.scene.serialization import packed, unpacked

TINY = {"name": "m", "variables": ["x", "y"], "f_minus": ["1", "0"], "f_plus": ["1", "0"], "g": "x"}


def changed(**parts):
    return json.dumps({**TINY, **parts})


@pytest.mark.parametrize("system", core.CATALOGUE.values(), ids=list(core.CATALOGUE))
def test_every_system_comes_back_with_its_jump_its_invariants_and_its_parameters(system):
    assert unpacked(packed(system)) == system


def test_values_come_back_to_the_last_bit_and_minus_zero_as_such():
    parameters = (core.Parameter("k", 0.0), core.Parameter("q", 0.1 + 0.2, (0.1, 1.0), "a doc", r"\kappa"))
    system = core.PiecewiseSystem(
        "m", ("x", "y"), ("y", "-k*x"), ("q", "0"), "x", parameters=parameters, x0=(-0.0, 1 / 3)
    )
    again = unpacked(packed(system.with_parameters(k=-0.0)))
    assert repr((again.x0, dict(again.values))) == "((-0.0, 0.3333333333333333), {'k': -0.0, 'q': 0.30000000000000004})"
    assert again.parameters == parameters


def test_what_goes_without_saying_is_not_written():
    assert json.loads(packed(unpacked(changed()))) == {**TINY, "psi_minus": ["y"], "psi_plus": ["y"], "x0": [0.0, 0.0]}


def test_any_text_may_stand_in_a_description():
    hostile = '\ud800</script>"\\&=#%\n'
    assert unpacked(packed(unpacked(changed(name=hostile)))).name == hostile


REFUSED = [
    ("{}", "lacks its name"),
    ("[]", "a list is not a system"),
    ("null", "is not a system"),
    ("", "does not describe"),
    ("[" * 3000, "does not describe"),
    ("[" * 900 + "]" * 900, "a list is not a system"),
    ('{"name":NaN}', "does not describe"),
    ('{"name":' + "[" * 900 + "]" * 900 + ',"variables":[],"f_minus":[],"f_plus":[],"g":"x"}', "a list is not a text"),
    (changed(variables=["x"], f_minus=["1"], f_plus=["1"]), "two variables"),
    (changed(variables="x"), "is not a list"),
    (changed(variables=[1]), "“1” is not a text"),
    (changed(laws=1), "“laws” is not part of a system"),
    (changed(f_minus=["().__class__", "0"]), "not allowed"),
    (changed()[:-1] + ',"x0":[1e400,0]}', "finite"),
    (changed()[:-1] + ',"x0":[1' + "0" * 400 + ",0]}", "too large"),
    (changed(x0=[True, 0]), "is not a number"),
    (changed(parameters=[{"name": "__class__", "default": 1}]), "not usable"),
    (changed(parameters=[{"name": "k"}]), "The parameter lacks its default"),
    (changed(parameters=[{"name": "k", "default": 1, "__init__": 1}]), "is not part of a parameter"),
    (changed(values={"k": 1}), "unknown parameter"),
    (changed(values=[]), "is not a list of values"),
]


@pytest.mark.parametrize(("text", "says"), REFUSED, ids=[text[:40] for text, _ in REFUSED])
def test_what_is_no_description_is_refused_in_words(text, says):
    with pytest.raises(ValueError, match=re.escape(says)) as caught:
        unpacked(text)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400
