"""A scene is valid at all times, and says in plain words why it refused something."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.scene.checks import MAX_STARTS
from pwsviz.scene.history import History
from pwsviz.scene.names import short_name
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import MAX_STEPS, number, require_few_steps
from pwsviz.scene.views import VIEWS, View


def test_starts_with_the_defaults_of_its_system():
    scene = Scene()
    system = core.CATALOGUE[scene.system]
    assert scene.x0 == tuple(system.x0)
    assert scene.values == dict(system.values)


def test_another_system_brings_its_own_parameters_and_start():
    scene = Scene()
    scene.system = next(key for key in core.CATALOGUE if key != scene.system)
    assert scene.x0 == tuple(core.CATALOGUE[scene.system].x0)
    assert scene.build().values == core.CATALOGUE[scene.system].values


def test_settings_given_at_the_start_are_kept():
    assert Scene(starts=((0.5, 0.25),)).x0 == (0.5, 0.25)


@pytest.mark.parametrize(
    ("field", "text", "expected"), [("tau", "1e-3", 1e-3), ("t_end", " 7.5 ", 7.5), ("tolerance", "1e-9", 1e-9)]
)
def test_numbers_may_come_as_text(field, text, expected):
    scene = Scene()
    scene.accept(field, text)
    assert getattr(scene, field) == expected


def test_a_coordinate_and_a_parameter_are_set_by_themselves():
    scene = Scene()
    name = next(iter(scene.values))
    scene.accept("x0.1", "−0.75")
    scene.accept(f"values.{name}", 1.5)
    assert scene.x0[1] == -0.75
    assert scene.build().values[name] == 1.5


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("tau", "abc", "not a number"),
        ("tau", "0", "between"),
        ("tau", "-1", "between"),
        ("tau", "nan", "finite"),
        ("tau", "", "Nothing is typed"),
        ("t_end", "inf", "finite"),
        ("tolerance", "1e-20", "between"),
        ("tolerance", "0.1", "between"),
        ("x0.0", "1e9", "between"),
        ("x0", (1.0,), "needs 2 numbers"),
        ("methods", [], "at least one"),
        ("perturbation_scale", "1e5", "between"),
    ],
)
def test_bad_input_is_refused_in_words_and_changes_nothing(field, value, words):
    scene = Scene()
    before = dict(scene.param.values())
    with pytest.raises(ValueError, match=words):
        scene.accept(field, value)
    assert dict(scene.param.values()) == before


def test_parameters_stay_within_their_bounds():
    scene = Scene()
    parameter = next(p for p in core.CATALOGUE[scene.system].parameters if p.bounds)
    with pytest.raises(ValueError, match=short_name(parameter)):
        scene.accept(f"values.{parameter.name}", parameter.bounds[1] + 1)


def test_a_run_too_long_is_refused_with_what_to_do():
    scene = Scene(tau=1e-4, t_end=100.0)
    with pytest.raises(ValueError, match=r"take τ ≥ .* or an end time ≤"):
        scene.accept("t_end", 1e4)
    with pytest.raises(ValueError, match="more than this page runs"):
        scene.accept("tau", 1e-6)


@given(st.floats(1e-3, 1e5), st.floats(1e-6, 1.0))
def test_the_advice_on_long_runs_is_sound(t_end, tau):
    try:
        require_few_steps(t_end, tau)
    except ValueError as reason:
        advised = float(str(reason).split("τ ≥ ")[1].split(" ")[0])
        require_few_steps(t_end, advised)
    else:
        assert t_end / tau <= MAX_STEPS * 1.001


@given(st.floats(allow_nan=True, allow_infinity=True))
def test_what_number_returns_is_finite_and_in_range(value):
    try:
        result = number(repr(value), "It", -5.0, 5.0)
    except ValueError:
        assert not (math.isfinite(value) and -5 <= value <= 5)
    else:
        assert result == value


def test_methods_keep_the_order_of_the_table():
    scene = Scene()
    scene.accept("methods", ["rk2", "dmm2"])
    assert scene.methods == [name for name in core.METHODS if name in ("rk2", "dmm2")]


def test_the_order_study_follows_when_its_method_is_dropped():
    scene = Scene()
    scene.accept("methods", ["rk4"])
    assert (scene.selected_method, scene.order_methods) == ("rk4", ["rk4"])
    scene.accept("methods", ["dmm2", "rk4"])
    assert scene.order_methods == ["dmm2"], "what the person chose comes back"


def test_integrators_rest_where_they_cannot_be_used_and_come_back():
    scene = Scene(methods=["dmm2", "rk2", "prk8"])
    scene.system = "relay_feedback"
    assert scene.offered == ["rk2", "rk4", "rk8", "gauss4", "taylor"]
    assert scene.used == scene.fixed_step == ["rk2"]
    scene.accept("methods", ["rk4"])
    assert scene.used == ["rk4"]
    scene.system = "pendulum"
    assert scene.used == ["dmm2", "rk4", "prk8"]


def test_there_is_an_integrator_where_none_of_the_chosen_can_be_used():
    scene = Scene(methods=["dmm2"])
    scene.system = "gene_switch"
    assert scene.used == ["rk2"]
    assert scene.selected_method == "rk2"
    scene.system = "kepler"
    assert scene.used == ["dmm2"]


def test_the_order_study_offers_methods_that_have_an_order():
    scene = Scene(methods=["taylor", "rk4"])
    assert scene.fixed_step == ["rk4"]
    scene.accept("methods", ["taylor"])
    assert scene.fixed_step == ["dmm2"]
    assert scene.order_methods == ["dmm2"]
    assert scene.selected_method == "taylor"


def test_a_slow_system_gets_time_to_cross_and_no_more_steps_than_allowed():
    scene = Scene()
    scene.system = "type_upward"
    assert scene.t_end == 40.0
    scene.t_end = 100.0
    scene.system = "type_downward"
    assert scene.t_end == 100.0, "what the person chose stays"
    scene.param.update(tau=1e-6, t_end=1.0)
    scene.system = "type_upward"
    require_few_steps(scene.t_end, scene.tau)


def test_the_end_time_does_not_depend_on_the_systems_chosen_before():
    scene = Scene()
    for system, end in (("type_upward", 40.0), ("pendulum", 20.0), ("type_sliding", 40.0), ("kepler", 20.0)):
        scene.system = system
        assert scene.t_end == end
    scene.system = "type_upward"
    scene.use(core.CATALOGUE["pendulum"])
    assert scene.t_end == 20.0
    other = Scene(system="type_upward")
    scene.restore(other.settings())
    scene.system = "pendulum"
    assert scene.t_end == 20.0
    scene.accept("t_end", "30")
    scene.system = "type_upward"
    assert scene.t_end == 30.0, "what the person chose stays"


def _oscillator(rate):
    f = ("y", f"-{rate**2!r}*x")
    return core.PiecewiseSystem("oscillator", ("x", "y"), f, f, "x - 0.3", x0=(1.0, 0.0))


def test_a_system_of_ones_own_brings_a_step_size_and_an_end_time_of_its_scale_which_do_not_stay():
    scene = Scene()
    scene.use(_oscillator(1e4))
    assert (scene.tau, scene.t_end) == pytest.approx((1e-6, 2e-3))
    scene.accept_times(2e-6, 1e-3)
    scene.use(_oscillator(2e4))
    assert (scene.tau, scene.t_end) == (2e-6, 1e-3), "what the person chose stays while the system is mended"
    scene.system = "pendulum"
    assert (scene.tau, scene.t_end) == (1e-2, 20.0)
    scene.accept_times(5e-3, 30.0)
    scene.use(_oscillator(1.0))
    assert (scene.tau, scene.t_end) == (1e-2, 20.0)


def test_step_size_and_end_time_stay_as_one_edits_the_system_shown():
    scene = Scene(tau=0.08, t_end=19.2)
    damped = (("2*y", "3*x**2 - 3 - 0.1*y"), ("2*y", "3*x**2 - 2"))
    scene.use(core.PiecewiseSystem("Damped curve", ("x", "y"), *damped, "x**2 + y**2 - 1", x0=(-1.0, -1.0)))
    assert (scene.tau, scene.t_end) == (0.08, 19.2)
    other = Scene(tau=0.08, t_end=19.2)
    other.use(_oscillator(1e4))
    assert other.tau < 1e-4, "another system brings its own"


def test_a_system_of_ones_own_and_its_times_are_one_step_to_undo():
    scene = Scene()
    history, before = History(scene), scene.settings()
    scene.use(_oscillator(1e4))
    history.undo()
    assert scene.settings() == before | {"own": scene.own}


def test_the_step_size_that_a_person_chose_stays_with_the_systems_of_the_catalogue():
    scene = Scene()
    scene.accept("tau", 0.1)
    scene.system = "pendulum"
    assert (scene.tau, scene.t_end) == (0.1, 20.0)


def test_trajectories_are_placed_moved_and_removed():
    scene = Scene()
    scene.place((0.5, 0.25))
    assert (len(scene.starts), scene.selected, scene.x0) == (2, 1, (0.5, 0.25))
    scene.move(0, (0.5, -0.25))
    assert (scene.starts, scene.selected) == (((0.5, -0.25), (0.5, 0.25)), 0)
    scene.remove(0)
    assert (scene.starts, scene.selected) == (((0.5, 0.25),), 0)
    with pytest.raises(ValueError, match="has to stay"):
        scene.remove(0)


def test_there_is_room_for_so_many_trajectories_and_no_more():
    scene = Scene()
    for k in range(MAX_STARTS - 1):
        scene.place((0.5, 0.01 * k))
    with pytest.raises(ValueError, match="remove one first"):
        scene.place((0.5, 0.5))
    assert len(scene.starts) == MAX_STARTS


def test_the_selected_trajectory_stays_selected_when_an_earlier_one_goes():
    scene = Scene(starts=((0.1, 0.0), (0.2, 0.0), (0.3, 0.0)), selected=2)
    scene.remove(0)
    assert scene.x0 == (0.3, 0.0)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("system", "pendulm", "is not one of"),
        ("system", "own", "no system of your own"),
        ("methods", ["dmm2", "euler"], "“euler” is not an integrator"),
        ("peers", "scipy", "not a list"),
        ("starts", (), "From 1 to"),
        ("starts", ((1.0,),), "needs 2 numbers"),
        ("selected", 1, "between 0 and 0"),
        ("axes", (0, 0), "not name two of the 2 variables"),
        ("axes", (0, 2), "two different numbers below 2"),
        ("values.zeta", 1.0, "not a parameter"),
        ("view", "energy", "is not one of"),
        ("locate", 1, "neither on nor off"),
        ("perturbation_order", 5, "is not one of"),
        ("perturbation_order", True, "is not one of"),
        ("stability_coordinate", 2, "between 0 and 1"),
        ("stability_around", 1e9, "between"),
        ("colour", "red", "not a setting"),
    ],
)
def test_what_is_no_choice_is_refused_in_words(field, value, words):
    scene = Scene()
    before = scene.settings()
    with pytest.raises(ValueError, match=words):
        scene.accept(field, value)
    assert scene.settings() == before


@pytest.mark.parametrize("key", ["energy", "", None, 1, ["conserved"]])
def test_a_view_that_is_set_directly_is_checked_too(key):
    scene = Scene()
    with pytest.raises(ValueError, match="is not one of Conserved quantity, State,"):
        scene.view = key
    with pytest.raises(ValueError, match="is not one of"):
        scene.param.update(view=key)
    with pytest.raises(ValueError, match="is not one of"):
        Scene(view=key)
    assert scene.view == "conserved"


def test_a_view_can_be_chosen_from_when_it_is_declared(monkeypatch):
    scene = Scene()
    monkeypatch.setitem(VIEWS, "step", View("Step size", "run", "anywhere:Tab"))
    scene.view = "step"
    assert scene.view == "step"


def test_settings_bring_the_very_scene_back():
    scene = Scene()
    scene.load({"system": "kepler", "tau": 1e-3, "axes": (1, 3), "methods": ["rk4"], "view": "scheme"})
    scene.place((1.25, 0.0, 0.0, 1.0))
    other = Scene()
    other.restore(scene.settings())
    assert other.settings() == scene.settings()


def test_loading_begins_anew():
    scene = Scene()
    scene.accept("tau", 0.05)
    scene.load({"system": "pendulum", "t_end": 2000.0, "tau": 1e-3})
    assert (scene.system, scene.t_end, scene.tau) == ("pendulum", 2000.0, 1e-3)
    scene.load({})
    assert scene.settings() == Scene().settings()
    with pytest.raises(ValueError, match="between"):
        scene.load({"system": "pendulum", "tau": -1.0})
    assert scene.settings() == Scene().settings()


def test_a_loaded_scene_has_the_integrators_it_names_and_no_others():
    scene = Scene()
    scene.load({"system": "chua", "methods": ["taylor"]})
    assert scene.methods == ["taylor"]


def test_step_size_and_end_time_are_taken_over_together_or_not_at_all():
    scene = Scene(tau=1e-5, t_end=20.0)
    scene.accept_times(0.5, 50_000.0)  # either alone would ask for too many steps, or leave them
    assert (scene.tau, scene.t_end) == (0.5, 50_000.0)
    with pytest.raises(ValueError, match="steps are more than this page runs"):
        scene.accept_times(1e-5, 50_000.0)
    assert (scene.tau, scene.t_end) == (0.5, 50_000.0)


def test_a_system_of_ones_own_is_like_any_other():
    own = core.PiecewiseSystem(
        "mine", ("u", "v"), ("v", "-k*u"), ("v", "-u"), "v", parameters={"k": 3.0}, x0=(1.0, 1.0)
    )
    scene = Scene()
    scene.use(own)
    scene.accept("values.k", 2.0)
    assert scene.build() == own.with_parameters(k=2.0)
    scene.accept("x0", (2.0, 0.5))
    scene.system = "pendulum"
    scene.system = "own"
    assert (scene.x0, scene.values) == ((1.0, 1.0), {"k": 3.0})


@pytest.mark.parametrize("system", core.CATALOGUE)
def test_a_system_without_psi_is_shown_with_its_state(system):
    scene = Scene()
    assert scene.view == "conserved"
    scene.system = system
    known = any(region.psi for region in core.CATALOGUE[system].regions.values())
    assert scene.view == ("conserved" if known else "state")


def test_the_state_stands_in_for_psi_only_until_a_system_has_one_again_or_a_view_is_chosen():
    scene = Scene()
    for name, view in (("relay_feedback", "state"), ("gene_switch", "state"), ("kepler", "conserved")):
        scene.system = name
        assert scene.view == view
    scene.system = "relay_feedback"
    scene.view = "order"
    scene.view = "state"
    scene.system = "kepler"
    assert scene.view == "state", "chosen by the user"
    scene.view = "conserved"
    law = core.Region(("y", "-x - y"))
    scene.use(
        core.PiecewiseSystem("bare", variables=("x", "y"), surfaces=("x",), regions={"-": law, "+": law}, x0=(1.0, 0.0))
    )
    assert scene.view == "state"
    scene.system = "kepler"
    assert scene.view == "conserved"


@pytest.mark.parametrize(("text", "value"), [("1/4", 0.25), ("sqrt(2)", 2**0.5), ("2pi", 2 * math.pi), ("10^-2", 0.01)])
def test_numbers_may_be_typed_as_formulas(text, value):
    assert number(text, "It", -10.0, 10.0) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["x", "t", "__import__('os')", "nan", "()", "1,2"])
def test_what_is_no_number_is_refused_in_words(text):
    with pytest.raises(ValueError, match="not a") as refused:
        number(text, "It", -10.0, 10.0)
    assert ("decimal point" in str(refused.value)) == (text == "1,2")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1/0", "not a finite real number"), ("sqrt(-1)", "not a finite real number"), ("2**9999", "beyond ±64"),
        ("9**9**9**9", "beyond ±64"), ("2/1e999", "outside 1e"),
    ],
)  # fmt: skip
def test_of_a_number_beyond_the_limits_the_limit_is_told(text, why):
    with pytest.raises(ValueError, match=re.escape(f"“{text}” cannot be used: ") + f".*{why}"):
        number(text, "It", -10.0, 10.0)
    with pytest.raises(ValueError, match="“-1e400” is too large"):
        number("-1e400", "It", -10.0, 10.0)


def test_another_system_comes_with_its_own_times_after_an_example_and_with_those_chosen_by_hand():
    scene = Scene()
    scene.load(PRESETS["first_look"].settings)
    assert (scene.tau, scene.t_end) == (0.08, 19.2)
    scene.system = "type_sliding"
    assert (scene.tau, scene.t_end) == (0.01, 40.0)
    scene.load(PRESETS["first_look"].settings)
    scene.accept("t_end", 33.0)
    scene.system = "type_sliding"
    assert (scene.tau, scene.t_end) == (0.01, 33.0)
