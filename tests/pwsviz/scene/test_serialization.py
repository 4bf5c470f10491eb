"""A system comes back from its description as it was; what is does not describe is refused in words."""

import json
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.scene.serialization import packed, unpacked
from tests.levels import tries
from tests.pwsviz.own_systems import OWN_SYSTEMS

TINY = {"name": "m", "variables": ["x", "y"], "f_minus": ["1", "0"], "f_plus": ["1", "0"], "g": "x"}

STRIP = {"name": "m", "variables": ["x", "y"], "surfaces": ["x", "x - 1"], "regions": {"--": {"f": ["1", "0"]}}}

NAMED = {
    "name": "m", "variables": ["x", "y"], "regions": {"a": {"f": ["1", "0"]}, "b": {"f": ["-1", "0"]}},
    "transitions": [{"mode": "a", "guard": "1 - x", "to": "b"}, {"mode": "b", "guard": "x", "to": "a"}],
}  # fmt: skip


def changed(base=TINY, **parts):
    return json.dumps({**base, **parts})


SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}


@pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))
def test_every_system_comes_back_with_its_jump_its_invariants_and_its_parameters(system):
    again = unpacked(packed(system))
    assert again == system
    assert list(again.regions) == list(system.regions), "runs begin in the first that suits"
    assert again.law_arguments() == system.law_arguments()
    assert packed(again) == packed(system)


def test_regions_jumps_and_transitions_are_written_as_they_were_declared():
    strips, wall, relay = (json.loads(packed(OWN_SYSTEMS[name])) for name in ("Strips", "Wall", "Relay"))
    assert strips["surfaces"] == ["x + 1", "x - 1"]
    assert strips["regions"]["+-"] == {"f": ["speed", "0"], "psi": ["y"]}
    assert wall["jumps"] == {"0": ["x", "-v*0.9"]}
    assert relay["transitions"] == [
        {"mode": "pre-heat", "guard": "top - u", "to": "off", "jump": ["u", "w/2"]},
        {"mode": "off", "guard": "u - 1/2", "to": "pre-heat"},
    ]
    assert "surfaces" not in relay, "they follow from the guards"
    assert not {"f_minus", "g", "jump", "psi_plus"} & {*strips, *wall, *relay}


@pytest.mark.parametrize("name", ["\ud800</script>", '"\\&=#%\n', "", " ", "-+", "{0}", "__class__", "a" * 999])
def test_a_region_may_have_any_name(name):
    regions = {name: core.Region(("1", "0")), "b": core.Region(("-1", "0"))}
    ways = (core.Transition(name, "1 - x", "b", jump=("x", "-y")), core.Transition("b", "x", name))
    system = core.PiecewiseSystem(name="m", variables=("x", "y"), regions=regions, transitions=ways)
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
    law = {"f": ["1", "0"], "psi": ["y"]}
    assert json.loads(packed(unpacked(changed(STRIP)))) == {**STRIP, "regions": {"--": law}, "x0": [0.0, 0.0]}


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
    (changed(STRIP, regions=[]), "a list is not a list of regions or surfaces by name"),
    (changed(STRIP, regions=None), "is not a list of regions"),
    (changed(STRIP, regions={}), "there are none"),
    (changed(STRIP, regions={"--": ["1", "0"]}), "a list is not a region"),
    (changed(STRIP, regions={"--": {}}), "The region lacks its f"),
    (changed(STRIP, regions={"--": {"f": "10"}}), "is not a list"),
    (changed(STRIP, regions={"--": {"f": [1, 0]}}), "“1” is not a text"),
    (changed(STRIP, regions={"--": {"f": ["1", "0"], "__init__": 1}}), "“__init__” is not part of a region"),
    (changed(STRIP, regions={"--": {"f": ["1"]}}), "regions['--'].f"),
    (changed(STRIP, regions={"--": {"f": ["x", "().__class__"]}}), "not allowed"),
    (changed(STRIP, regions={"--": {"f": ["1", "0"], "psi": ["x"]}}), "not conserved"),
    (changed(STRIP, regions={"-": {"f": ["1", "0"]}}), "'-' is not a region"),
    (changed(STRIP, regions={"-0": {"f": ["1", "0"]}}), "'-0' is not a region"),
    (changed(STRIP, regions={"\u2212\u2212": {"f": ["1", "0"]}}), "is not a region"),
    (changed(STRIP, surfaces="x"), "is not a list"),
    (changed(STRIP, surfaces=[]), "0 surfaces"),
    (changed(STRIP, surfaces=["x"] * 40), "40 surfaces"),
    (changed(STRIP, surfaces=["x", "2*x"]), "is zero where surfaces[0] is"),
    (changed(STRIP, surfaces=["x", "1"]), "names no variable"),
    (changed(STRIP, jumps=[]), "a list is not a list of regions or surfaces by name"),
    (changed(STRIP, jumps={"x": ["x", "y"]}), "“x” is not the number of a surface"),
    (changed(STRIP, jumps={"-1": ["x", "y"]}), "is not the number of a surface"),
    (changed(STRIP, jumps={"9" * 400: ["x", "y"]}), "is not the number of a surface"),
    (changed(STRIP, jumps={"\u0661": ["x", "y"]}), "is not the number of a surface"),
    (changed(STRIP, jumps={"2": ["x", "y"]}), "2 is not a surface"),
    (changed(STRIP, jumps={"0": ["x"]}), "jumps[0]"),
    (changed(STRIP, **{part: TINY[part] for part in ("f_minus", "f_plus", "g")}), "give either"),
    (changed(NAMED, surfaces=["x"]), "give either transitions"),
    (changed(NAMED, transitions={}), "is not a list"),
    (changed(NAMED, transitions=[1]), "is not a transition"),
    (changed(NAMED, transitions=[{"mode": "a", "guard": "x"}]), "The transition lacks its to"),
    (
        changed(NAMED, transitions=[*NAMED["transitions"], {"mode": "c", "guard": "x", "to": "a"}]),
        "'c' is not a region",
    ),
    (changed(NAMED, transitions=NAMED["transitions"][:1]), "has no guard"),
    (changed(NAMED, transitions=[{**NAMED["transitions"][0], "jump": ["x"]}]), "jump"),
    (changed(NAMED, transitions=[{**one, "guard": "open('x')"} for one in NAMED["transitions"]]), "not allowed"),
    (changed(NAMED, transitions=[{**NAMED["transitions"][0], "guard": 1}]), "is not a text"),
]


@pytest.mark.parametrize(("text", "says"), REFUSED, ids=[f"{k}-{text[:40]}" for k, (text, _) in enumerate(REFUSED)])
def test_what_is_no_description_is_refused_in_words(text, says):
    with pytest.raises(ValueError, match=re.escape(says)) as caught:
        unpacked(text)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400


def test_more_regions_than_a_system_may_have_are_refused():
    with pytest.raises(ValueError, match="70 regions: at most 64"):
        unpacked(changed(NAMED, regions={str(k): {"f": ["1", "0"]} for k in range(70)}))


KEYS = st.sampled_from(["f", "psi", "--", "a", "0", "to"])
JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-2, 99), st.floats(), st.sampled_from(["", "x", "--", "a", "0"])),
    lambda part: st.one_of(st.lists(part, max_size=3), st.dictionaries(KEYS, part)),
    max_leaves=8,
)


@tries(150)
@given(st.sampled_from([STRIP, NAMED]), st.dictionaries(
    st.sampled_from(["regions", "surfaces", "jumps", "transitions", "jump", "g"]), JSON, min_size=1))  # fmt: skip
def test_whatever_stands_in_place_of_regions_there_is_a_system_or_a_refusal_in_words(base, parts):
    try:
        system = unpacked(json.dumps({**base, **parts}, allow_nan=True))
    except ValueError as refusal:
        assert str(refusal).isprintable()  # noqa: PT017 - other inputs are accepted
    else:
        assert unpacked(packed(system)) == system
