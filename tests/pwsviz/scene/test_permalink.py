"""A link brings the whole scene back, bit by bit; and whatever else stands in it is told and alone replaced."""

import contextlib
import json
import re
from urllib.parse import quote

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import core
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.checks import MAX_STARTS, OWN
from pwsviz.scene.names import EXTERNAL_SOLVERS, LABELS
from pwsviz.scene.permalink import _SETTINGS, MAX_COMPLAINTS, MAX_LENGTH, adopt, digest, query, read
from pwsviz.scene.scene import PERTURBATION_ORDERS, Scene
from pwsviz.scene.validation import MAX_STEPS, require_few_steps
from pwsviz.scene.views import VIEWS
from pwsviz.tabs import make_tab
from tests.pwsviz.own_systems import OWN_SYSTEMS

# Scenes, as people make them -----------------------------------------------------------------------------------------


def own_system(name="Mine", doc="", k=3.0, tau=0.5, **more):
    """Return a system with a parameter called as a setting is."""
    parameters = (core.Parameter("k", k, (0.1, 10.0), doc, r"\kappa"), core.Parameter("tau", tau))
    return core.PiecewiseSystem(
        name, ("x", "v", "z"), ("v", "-k*x", "tau*sin(t)"), ("v", "-x", "0"), "v - x/4", ("(k*x**2 + v**2)/2",),
        parameters=parameters, x0=(1.0, -0.0, 0.1), doc=doc, **more,
    )  # fmt: skip


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
MODEST = st.one_of(st.floats(-5.0, 5.0), st.sampled_from([0.0, -0.0, 1 / 3, 1e-300, 5e-324, 1e6]))
CHOICES = {
    "system": st.sampled_from([*core.CATALOGUE, OWN]),
    "methods": st.lists(st.sampled_from(list(core.METHODS)), min_size=1, unique=True),
    "tau": st.floats(1e-6, 1.0),
    "t_end": st.floats(1e-3, 1e5),
    "tolerance": st.floats(1e-15, 1e-3),
    "perturbation_scale": st.floats(-10.0, 10.0),
    "perturbation_order": st.sampled_from(PERTURBATION_ORDERS),
    "locate": st.booleans(),
    "slide": st.booleans(),
    "order_all": st.booleans(),
    "view": st.sampled_from(list(VIEWS)),
    "peers": st.lists(st.sampled_from(list(EXTERNAL_SOLVERS)), unique=True),
    "study_method": st.sampled_from(list(core.METHODS)),
    "selected": st.integers(0, MAX_STARTS - 1),
    "axes": st.permutations(range(4)).map(lambda order: tuple(order[:2])),
    "window": st.one_of(st.none(), st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS)),
    "stability_coordinate": st.integers(0, 3),
    "stability_around": st.one_of(st.none(), NUMBERS),
    "section_of": st.sampled_from(["", "x - 1", "2x² - y/3", "sin(t/2)", "u", "nonsense("]),
    "section_direction": st.sampled_from([-1, 0, 1]),
    "section_axes": st.one_of(st.none(), st.permutations(range(4)).map(lambda order: tuple(order[:2]))),
    "section_points": st.integers(0, 2_000_000),
    "section_discard": st.integers(0, 2_000_000),
    "section_map": st.booleans(),
    "sweep_parameter": st.sampled_from(["", *(q.name for one in core.CATALOGUE.values() for q in one.parameters)]),
    "sweep_range": st.one_of(st.none(), st.tuples(MODEST, MODEST)),
    "sweep_coordinate": st.sampled_from(["", "x", "y", "v"]),
    "sweep_of": st.sampled_from(["", "x", "v - y/3", "sin(t)"]),
    "sweep_direction": st.sampled_from([-1, 0, 1]),
    "sweep_continuation": st.sampled_from(["none", "up", "down"]),
    "sweep_values": st.integers(2, 4000),
    "sweep_points": st.integers(1, 5000),
    "sweep_discard": st.none() | st.integers(0, 10**6),
    "sweep_end": st.floats(1e-3, 1e5),
    "x0.0": MODEST,
    "x0.1": MODEST,
    "values": st.tuples(st.integers(0, 5), st.one_of(MODEST, NUMBERS)),
    "place": st.lists(MODEST, min_size=2, max_size=4).map(tuple),
    "use": st.tuples(st.text(max_size=20), st.text(max_size=20), st.floats(0.1, 10.0), NUMBERS),
    "use regions": st.sampled_from(list(OWN_SYSTEMS)),
} | {name: st.sampled_from(Scene.param[name].objects)
     for name in ("cost_across", "cost_up", "stability_part", "stability_shown")}  # fmt: skip
ACTIONS = st.lists(
    st.sampled_from(sorted(CHOICES)).flatmap(lambda name: st.tuples(st.just(name), CHOICES[name])), max_size=14
)


def act(scene, name, value):
    """Do one thing that a person can do on the page."""
    match name:
        case "values":
            names = list(scene.values)
            if names:
                scene.accept(f"values.{names[value[0] % len(names)]}", value[1])
        case "place":
            scene.place(value)
        case "use":
            scene.use(own_system(*value))
        case "use regions":
            scene.use(OWN_SYSTEMS[value])
        case _:
            scene.accept(name, value)


def made(actions):
    scene = Scene()
    for name, value in actions:
        with contextlib.suppress(ValueError):  # refused, as on the page
            act(scene, name, value)
    return scene


def shown_by(scene):
    """Return all that the page shows of a scene depends on: the system, the runs, and what the view asks for."""
    tab = make_tab(scene.view, scene, Results())
    chosen = {*tab.settings, "starts", "selected", "axes", "window", "methods", "tau", "t_end", "slide", "view"}
    return [
        scene.declaration, scene.values, run_inputs(scene), tab.inputs(), tab.program(),
        {name: getattr(scene, name) for name in sorted(chosen)},
    ]  # fmt: skip


def bits(settings):
    """Return settings so that -0.0 differs from 0.0, and every float from its neighbour."""
    return repr(settings)


@given(ACTIONS)
@example([("use", ("\ud800</script>", '"\\&=#%', 0.1 + 0.2, -0.0)), ("values", (1, -1e-320)), ("system", "kepler")])
@example([("methods", ["rk2"]), ("system", "relay_feedback")])
@example([("t_end", 1.5), ("tau", 1e-6), ("system", "type_upward")])
@example([("use regions", "Strips"), ("values", (0, 0.7)), ("place", (0.5, -0.0))])
@example([("use regions", "Relay"), ("x0.0", 1 / 3), ("system", "chua")])
def test_what_every_scene_shows_comes_back_bit_by_bit(actions):
    scene, other = made(actions), Scene()
    link = query(scene)
    found, complaints = read(link)
    other.restore(found)
    assert complaints == []
    assert bits(shown_by(other)) == bits(shown_by(scene))
    assert re.fullmatch(r"[A-Za-z0-9_.~=&%,;:*/()-]*", link)
    assert query(other) == link, "nothing in it is of another view or system"


OF_OTHERS = {
    "view": {
        "study_method": "rk2", "order_all": True, "peers": [], "cost_up": "time", "stability_part": "drift",
        "stability_shown": "slope", "stability_coordinate": 1, "stability_around": 2.0, "section_of": "x",
        "section_map": True, "section_points": 7, "sweep_values": 7, "sweep_of": "x",
    },
    "methods": {"tolerance": 1e-9},
    "perturbation_order": {"perturbation_scale": 2.0},
}  # fmt: skip


def test_a_link_leaves_out_settings_that_nothing_shown_depends_on():
    usual = digest(Scene())
    for setting, others in OF_OTHERS.items():
        for name, value in others.items():
            scene = Scene()
            scene.accept(name, value if name != "stability_shown" else Scene.param[name].objects[-1])
            assert query(scene) == "v=2", (setting, name)
            assert digest(scene) == usual, "files of equal scenes have one name"
    scene = Scene()
    scene.use(own_system())
    scene.accept("system", "elliptic_curve")
    assert "own=" in query(scene), "but one's own system is kept beside another: a reload would lose it"


def test_a_link_holds_every_setting_there_is():
    assert {*_SETTINGS, "values"} == set(Scene().settings())


def test_the_usual_scene_has_the_shortest_link():
    assert query(Scene()) == "v=2"
    assert query(Scene(system="pendulum")) == "v=2&system=pendulum"
    assert query(Scene(system="type_upward")) == "v=2&system=type_upward", "its longer end time is usual"


def test_a_window_is_in_the_link_once_it_is_chosen():
    scene = Scene()
    scene.accept("window", (-2.5, 1.0, -1.0, 0.125))
    assert query(scene) == "v=2&window=-2.5,1.0,-1.0,0.125"
    assert read(query(scene)) == (scene.settings(), [])
    scene.accept("axes", (1, 0))
    assert scene.window is None, "another plane has another window"
    for wrong in ("1,0,0,1", "0,1,0", "0,1,0,inf", "0,0,0,0", "a,b,c,d", "1,1.0000000000000002,0,1", "-1e99,0,0,1"):
        found, complaints = read(f"v=1&window={wrong}")
        assert found["window"] is None
        assert "Used instead: auto." in complaints[0]


def test_a_link_can_be_read_by_people():
    scene = Scene()
    scene.accept("values.a_minus", 0.1)
    scene.accept("methods", ["dmm4", "taylor"])
    scene.place((0.5, -2.0))
    scene.accept("axes", (1, 0))
    scene.accept("locate", False)
    assert query(scene) == (
        "v=2&methods=dmm4,taylor&a_minus=0.1&starts=-1.0,-1.0;0.5,-2.0&selected=1&axes=y,x&locate=off"
    )


def test_an_empty_link_is_the_usual_scene_and_no_reason_to_complain():
    for link in ("", "?", "?v=2", "&&"):
        assert read(link) == (Scene().settings(), [])


def test_a_link_made_when_runs_could_not_slide_still_stops_them():
    found, complaints = read("v=1&system=coulomb_friction")
    assert (found["slide"], complaints) == (False, [])
    assert read("v=1&slide=on")[0]["slide"]
    assert read("v=2&system=coulomb_friction")[0]["slide"]


def test_a_link_may_come_with_its_question_mark_and_without_its_version():
    assert read("?system=kepler")[0]["system"] == "kepler"
    assert read("system=kepler")[1] == []


def test_adopting_a_link_leaves_nothing_of_what_was_before():
    scene = Scene(view="cost", methods=["rk8"])
    scene.place((0.5, 0.5))
    other = Scene(system="rigid_body")
    assert adopt(scene, query(other)) == []
    assert scene.settings() == other.settings()


def test_a_system_that_came_with_values_of_its_own_keeps_them():
    scene = Scene()
    scene.use(own_system().with_parameters(k=0.3, tau=-7.0))
    found, complaints = read(query(scene))
    assert complaints == []
    assert found["own"] == scene.own
    assert found["own"].values["k"] == 0.3


def test_a_link_of_ones_own_system_names_its_times_and_one_that_does_not_is_read_as_when_it_was_written():
    scene = Scene()
    scene.use(own_system())
    assert "&tau=0.01&t_end=20.0" in query(scene), "what a reader would propose may change"
    fast = core.PiecewiseSystem("fast", ("x", "y"), ("y", "-1e8*x"), ("y", "-1e8*x"), "x - 0.3", x0=(1.0, 0.0))
    scene.use(fast)
    assert "&tau=1e-06&t_end=0.002" in query(scene)
    old = re.sub("&(tau|t_end)=[^&]*", "", query(scene))
    found, complaints = read(old)
    assert (found["own"], found["tau"], found["t_end"], complaints) == (fast, 0.01, 20.0, [])


@pytest.mark.parametrize("system", [*core.CATALOGUE.values(), *OWN_SYSTEMS.values()], ids=lambda system: system.name)
def test_every_system_comes_back_as_one_of_ones_own_with_its_regions(system):
    scene = Scene()
    values = {q.name: q.default * 1.01 if q.bounds is None else sum(q.bounds) / 2 for q in system.parameters}
    scene.use(system.with_parameters(**values))
    found, complaints = read(query(scene))
    assert complaints == []
    assert found["own"] == scene.own
    assert found["own"].law_arguments() == system.law_arguments()
    assert read(query(scene))[0]["own"].laws is found["own"].laws, "nothing is derived anew"


def test_a_system_too_long_for_a_link_is_refused_in_words():
    scene = Scene()
    scene.use(own_system(doc="é" * 5000))
    with pytest.raises(ValueError, match=r"too long for a link"):
        query(scene)


@given(st.floats(1e-3, 1e5), st.floats(1e-6, 1.0))
def test_any_possible_pair_of_step_size_and_end_time_is_restored(t_end, tau):
    found, complaints = read(f"tau={tau!r}&t_end={t_end!r}")
    assert found["tau"] == tau
    if t_end / tau <= MAX_STEPS:
        assert (found["t_end"], complaints) == (t_end, [])
    else:
        require_few_steps(found["t_end"], found["tau"])
        assert len(complaints) == 1


# What is broken ------------------------------------------------------------------------------------------------------

OWN_START = "own={%22name%22:%22m%22,%22variables%22:[%22x%22],%22f_plus%22:[%221%22],%22g%22:%22x%22,%22f_minus%22:"


def own_link(**parts):
    """Return a link with a system of one's own that starts where no law is declared, and with these parts of it."""
    system = {"name": "m", "variables": ["x", "y"], "surfaces": ["x", "x + 1"], "regions": {"++": {"f": ["1", "0"]}}}
    return "own=" + quote(json.dumps({**system, "x0": [-2.0, 0.0], **parts}), safe="")


HOSTILE = [
    ("tau=nan", "tau", "Used instead: 0.01."),
    ("tau=-inf", "tau", "Used instead: 0.01."),
    ("t_end=1e999", "t_end", "Used instead: 20."),
    ("tau=1_0e-3", "tau", "not a number"),
    ("tau=%D9%A1", "tau", "not a number"),
    ("tau=０.１", "tau", "not a number"),
    ("tau=0x1p-3", "tau", "not a number"),
    ("tau=" + "1" * 5000, "tau", "characters long"),
    ("tau=1e-6&t_end=soon", "t_end", "Used instead: 2."),
    ("t_end=1e5&tau=small", "tau", "Used instead: 0.05."),
    ("tau=1e-6", "t_end", "Used instead: 2."),
    ("system=../../etc/passwd", "system", "Used instead: Elliptic curve."),
    ("system=own", "system", "There is no system of your own yet"),
    ("system=__class__", "system", "Used instead"),
    ("view=javascript:alert(1)", "view", "Used instead: Conserved quantity."),
    ("view=<script>alert(1)</script>", "view", "Used instead: Conserved quantity."),
    ("view=%00", "view", "Used instead: Conserved quantity."),
    ("locate=maybe", "locate", "Used instead: on."),
    ("perturbation_order=5", "perturbation_order", "Used instead: none."),
    ("methods=dmm2,hack,rk4", "methods", "“hack” is not one of"),
    ("methods=", "methods", "Used instead: dmm2, rk2."),
    ("peers=ode45", "peers", "Used instead: SciPy."),
    ("selected=3", "selected", "Used instead: 0."),
    ("selected=١", "selected", "Used instead: 0."),
    ("axes=x,x", "axes", "Used instead: auto."),
    ("axes=x,__dict__", "axes", "is not a variable"),
    ("a_minus=1e3", "a₋", "Used instead: -3."),
    ("omega2_minus=1", "omega2_minus", "neither a setting of this page nor a parameter of Elliptic curve"),
    ("__init__=1", "__init__", "left out"),
    ("own=1&own=2", "“own”", "first is used"),
    ("tau=0.02&tau=0.03", "“tau”", "The first is used."),
    ("v=3", "version", "It is read as version 2."),
    ("v=1.0", "version", "It is read as version 2."),
    ("nonsense", "nonsense", "has no value"),
    ("starts=1,2;1;3,4", "Start 2", "Used instead: -1, -1."),
    ("starts=1,nan", "Start 1", "not a number"),
    (
        "system=kepler&starts=0.0,0.0,1.0,0.0",
        "Start 1 in the link: (0, 0, 1, 0):",
        "choose another state. Used instead",
    ),
    ("system=nosuch", "System", "is not one of those that can be chosen here. Used instead"),
    ("t_end=1e9", "t_end", "between 0.001 and 100,000"),
    ("starts=1,2,3", "Start 1", "needs 2 numbers"),
    ("starts=", "Start 1", "not a number"),
    ("starts=" + "1,1;" * 1_000_000, "link", "cut"),
    ("starts=" + "1,1;" * 500 + "1,1", "501 starts", "first 12"),
    ("own=[]", "own", "a list is not a system"),
    ("own=" + "[" * 3000, "own", "does not describe a system"),
    (OWN_START + "[%22__import__('os').system('ls')%22]}", "own", "not allowed"),
    (OWN_START + "[%229**9**9**9%22]}", "own", "f_minus"),
    (OWN_START + "[%22x%22],%22x0%22:[1e400]}", "own", "finite"),
    (own_link(), "own", "lies in a region for which no law is declared"),
    (own_link(regions={}), "own", "there are none"),
    (own_link(regions={"__class__": {"f": ["1", "0"]}}), "own", "is not a region"),
    (own_link(regions={"++": {"f": ["__import__('os').system('ls')", "0"]}}), "own", "not allowed"),
    (own_link(regions={"++": {"f": ["1", "0"], "psi": ["x"]}}), "own", "not conserved"),
    (own_link(regions={"++": "[" * 50}), "own", "is not a region"),
    (own_link(surfaces=["x"] * 20), "own", "20 surfaces"),
    (own_link(jumps={"7": ["x", "y"]}), "own", "is not a surface"),
    (own_link(transitions=[{"mode": "++", "guard": "x", "to": "\u202e"}]), "own", "give either transitions"),
]


@pytest.mark.parametrize(("link", "named", "instead"), HOSTILE, ids=[link[:40] for link, *_ in HOSTILE])
def test_what_is_broken_is_named_with_what_there_is_instead(link, named, instead):
    found, complaints = read(link)
    named = LABELS.get(named, named)
    assert any(named in words and instead in words for words in complaints), complaints
    assert all(words.isprintable() and len(words) < 900 for words in complaints)
    Scene().restore(found)


@pytest.mark.parametrize(("link", "named", "instead"), HOSTILE, ids=[link[:40] for link, *_ in HOSTILE])
def test_one_broken_value_takes_no_other_with_it(link, named, instead):
    others = {"tolerance": 1e-9, "perturbation_scale": -0.5, "view": "order"}
    if len(link) > MAX_LENGTH or "view" in link:
        others.pop("view")
    found, _ = read("tolerance=1e-9&perturbation_scale=-0.5&" + ("view=order&" if "view" in others else "") + link)
    assert {name: found[name] for name in others} == others


def test_broken_starts_leave_the_numbers_of_the_others():
    found, complaints = read("starts=1,2;x,1;3,4&selected=2")
    assert found["starts"] == ((1.0, 2.0), (-1.0, -1.0), (3.0, 4.0))
    assert found["selected"] == 2
    assert len(complaints) == 1


def test_where_the_usual_start_is_impossible_too_the_system_stays_as_it_starts():
    scene = Scene()
    scene.use(core.PiecewiseSystem("root", ("x", "y"), *[("sqrt(x - k)", "x")] * 2, "x - 9", parameters={"k": 0.0}))
    found, complaints = read(query(scene) + "&k=2&starts=5,0;1,0")
    assert found["values"] == {"k": 2.0}
    assert found["starts"] == ((0.0, 0.0),)
    assert any("Start 2" in words for words in complaints)


def test_whatever_goes_wrong_with_the_mathematics_is_told_and_logged(monkeypatch, caplog):
    scene = Scene()
    scene.use(own_system())
    link = query(scene)

    def fail(*_args, **_keywords):
        raise TypeError("no such ufunc")

    monkeypatch.setattr(core, "PiecewiseSystem", fail)
    found, complaints = read(link + "&view=order")
    assert (found["own"], found["view"]) == (None, "order")
    assert complaints == [
        "“Your own system” in the link: this system cannot be used (TypeError). Used instead: Elliptic curve."
    ]
    assert "no such ufunc" in caplog.text


def test_a_value_is_not_cut_short_to_another():
    found, complaints = read("view=order&" + "x=" + "1" * (MAX_LENGTH - 21) + "&tau=0.5123")
    assert found["view"] == "order"
    assert found["tau"] == 0.01
    assert "cut" in complaints[0]


def test_nobody_has_to_read_a_thousand_complaints():
    _, complaints = read("&".join(f"k{number}=1" for number in range(3000)))
    assert len(complaints) == MAX_COMPLAINTS + 1
    assert "2,980 more" in complaints[-1]


ANY = st.text(st.characters(exclude_categories=()), max_size=200)
PIECES = st.lists(st.one_of(ANY, st.sampled_from([link[:2000] for link, *_ in HOSTILE])), max_size=6).map("&".join)


@st.composite
def mutated(draw):
    """A link in which something was changed, doubled or lost on its way."""
    link = query(made(draw(ACTIONS)))
    for _ in range(draw(st.integers(1, 3))):
        start, stop = sorted(draw(st.tuples(st.integers(0, len(link)), st.integers(0, len(link)))))
        link = link[:start] + draw(st.one_of(ANY, st.just(link[start:stop] * 2))) + link[stop:]
    return link


@given(st.one_of(ANY, PIECES, mutated(), st.builds(lambda text: text * 5000, ANY)))
def test_no_text_whatever_makes_reading_fail(text):
    found, complaints = read(text)
    assert len(complaints) <= MAX_COMPLAINTS + 1
    assert all(words.isprintable() for words in complaints)
    scene = Scene()
    scene.restore(found)
    assert bits(read(query(scene))) == bits((scene.settings(), []))


def test_integrators_that_the_system_of_a_link_cannot_use_are_told():
    told = read("v=2&methods=dmm2&system=thermostat")[1]
    assert told == ["“Integrators” in the link: dmm2 cannot be used with Thermostat. Used instead: rk2."]
    assert read("v=2&methods=dmm2,rk4&system=thermostat")[1] == []  # rk4 is shown; dmm2 returns with another system
    assert read("v=2&system=thermostat")[1] == []  # these are not of the link
