"""The form for a system of one's own, without a browser: checked as one types, used when it is right."""

import re
from threading import current_thread, main_thread

import pytest

import core
from pwsviz.editor.draft import FIELDS, Draft
from pwsviz.editor.examples import EXAMPLES
from pwsviz.editor.form import BLANK, CURRENT, SystemEditor

ELLIPTIC = core.CATALOGUE["elliptic_curve"]


class Desk:
    """Keeps what was used, and where outcomes came from."""

    def __init__(self):
        self.used, self.ready, self.threads = [], [], []
        self.editor = SystemEditor(self.used.append, self.deliver, lambda: ELLIPTIC, self.ready.append)

    def deliver(self, show, outcome):
        """Show at once, and note the thread."""
        self.threads.append(current_thread())
        show(outcome)

    def type(self, **texts):
        """Type into fields, as the browser tells of it: `value` follows only when a field is left."""
        for name, text in texts.items():
            self.editor.texts[name].value_input = text
        assert self.editor.settle(60)


@pytest.fixture
def desk():
    desk = Desk()
    desk.editor.fill(EXAMPLES["Two springs"])
    assert desk.editor.settle(60)
    yield desk
    desk.editor.close()


def errors(editor):
    return {name: text.helper_text for name, text in editor.texts.items() if text.error_state}


def test_nothing_is_checked_before_something_is_filled_in():
    seen = []
    editor = SystemEditor(seen.append, lambda show, outcome: seen.append(outcome))
    assert editor.settle(60)
    assert seen == []
    assert editor.system is None


def test_parameters_on_which_nothing_depends_are_named(desk):
    assert "No law contains" not in desk.editor.maths["parameters"].object
    given = desk.editor.texts["parameters"].value
    desk.type(parameters=f"{given}\nunneeded = 1")
    assert "No law contains “unneeded”." in desk.editor.maths["parameters"].object


def test_one_can_start_from_empty_fields(desk):
    assert BLANK in [item["label"] for item in desk.editor.menu.items]
    desk.editor._choose({"label": BLANK})
    assert desk.editor.settle(60)
    assert desk.editor.draft == Draft()
    assert not any(text.value_input for text in desk.editor.texts.values())
    assert desk.editor.system is None


def test_a_valid_system_is_used_at_a_click(desk):
    assert desk.editor.system is not None
    assert errors(desk.editor) == {}
    desk.editor.use.clicks += 1
    assert [system.name for system in desk.used] == ["My oscillator"]
    assert desk.used[0].values == {"k": 3.0}


def test_a_system_is_told_of_as_soon_as_it_is_one(desk):
    assert [system.name for system in desk.ready] == ["My oscillator"]
    desk.type(g="x +")
    assert len(desk.ready) == 1
    desk.type(g="x + 1")
    assert str(desk.ready[1].g) == "x + 1"


def test_checks_run_off_the_event_loop(desk):
    assert desk.threads
    assert main_thread() not in desk.threads


def test_a_mistake_is_told_at_its_field_and_nothing_can_be_used(desk):
    desk.type(g="x +", x0="1")
    assert set(errors(desk.editor)) == {"g", "x0"}
    assert "not an expression" in errors(desk.editor)["g"]
    assert desk.editor.system is None
    assert 'role="alert"' in desk.editor.status.object
    assert "Switching function g; Start x₀" in desk.editor.status.object
    desk.editor.use.clicks += 1
    assert desk.used == []
    desk.type(g="x + y", x0="1, 2")
    assert errors(desk.editor) == {}
    assert desk.editor.texts["g"].helper_text == "The field changes where g = 0."
    assert desk.editor.system is not None


def test_what_is_not_checked_yet_is_used_once_it_is(desk):
    desk.editor.texts["g"].value_input = "x + 1"
    desk.editor.use.clicks += 1
    assert desk.used == []
    assert desk.editor.settle(60)
    assert [system.g for system in desk.used] == ["x + 1"]


def test_what_is_found_wrong_or_typed_over_is_not_used(desk):
    for text, more in (("x +", ""), ("x + 1", "x + 2")):
        desk.editor.texts["g"].value_input = text
        desk.editor.use.clicks += 1
        if more:
            desk.editor.texts["g"].value_input = more
        assert desk.editor.settle(60)
        assert desk.used == []
        assert (desk.editor.system is None) == (not more)


def test_an_outcome_that_was_overtaken_is_not_shown():
    outcomes, used = [], []
    editor = SystemEditor(used.append, lambda show, outcome: outcomes.append((show, outcome)))
    editor.fill(EXAMPLES["Two springs"])
    assert editor.settle(60)
    editor.texts["g"].value_input = "x +"
    show, outcome = outcomes[0]
    show(outcome)
    editor.use.clicks += 1
    assert used == []
    editor.close()


def test_mathematics_appears_as_one_types(desk):
    assert "<mi>k</mi>" in desk.editor.maths["f_minus"].object
    desk.type(g="x**2 - y")
    assert "<msup><mi>x</mi><mn>2</mn></msup>" in desk.editor.maths["g"].object


def test_what_is_conserved_and_what_is_left_over_is_shown(desk):
    assert "Found automatically" in desk.editor.maths["psi_minus"].object
    desk.type(psi_minus="x**2 + y**2", psi_plus="x**2 + y**2")
    assert "is not conserved" in errors(desk.editor)["psi_minus"]
    assert desk.editor.maths["psi_minus"].object.count("<math") == 2  # ψ, and its time derivative
    assert "is conserved" in desk.editor.maths["psi_plus"].object


@pytest.mark.parametrize("title", EXAMPLES)
def test_every_example_on_the_menu_fills_the_form(desk, title):
    desk.editor._choose({"label": title})
    assert desk.editor.settle(60)
    texts = {name: desk.editor.texts[name].value_input for name in FIELDS}
    assert Draft(**texts) == EXAMPLES[title] == desk.editor.draft
    assert errors(desk.editor) == {}


def test_the_system_on_the_page_can_be_started_from(desk):
    assert desk.editor.menu.items[0] == {"label": CURRENT}
    desk.editor._choose({"label": CURRENT})
    assert desk.editor.settle(60)
    desk.editor.use.clicks += 1
    assert desk.used[0].f_plus == ELLIPTIC.f_plus
    assert desk.used[0].psi_plus == ELLIPTIC.psi_plus


def test_what_was_typed_is_kept_and_said_to_be_where_the_page_shows_another_system(desk):
    shown = [core.CATALOGUE["pendulum"]]
    desk.editor.close()
    desk.editor = editor = SystemEditor(desk.used.append, desk.deliver, lambda: shown[0])
    editor.resume()
    assert (editor.texts["name"].value, editor.settle(60)) == ("Pendulum", True)
    shown[0] = core.CATALOGUE["kepler"]
    editor.resume()
    assert editor.texts["name"].value == "Kepler with a shell"
    assert "A copy of “Kepler with a shell”" in editor.kept.object
    desk.type(g="x - 0.25")
    shown[0] = core.CATALOGUE["pendulum"]
    editor.resume()
    assert editor.texts["g"].value_input == "x - 0.25"
    assert "keep what you typed" in editor.kept.object
    shown[0] = editor.system
    editor.resume()
    assert editor.kept.object == "", "the page shows what was typed"


def test_loading_a_system_takes_away_the_complaints_of_before(desk):
    desk.type(jump="x", variables="x, 2")
    desk.editor.load(core.CATALOGUE["kepler"])
    assert desk.editor.settle(60)
    assert errors(desk.editor) == {}
    assert desk.editor.texts["variables"].value == "x, y, u, v"
    assert desk.editor.texts["jump"].value_input == ""


def test_words_of_a_refusal_are_shown(desk):
    def refuse(_system):
        raise ValueError("Not <now>.")

    desk.editor._on_use = refuse
    desk.editor.use.clicks += 1
    assert "Not &lt;now&gt;." in desk.editor.status.object


def test_text_is_never_taken_for_markup_nor_for_an_icon(desk):
    evil = '<img src=x onerror="alert(1)"> :material/home:'
    desk.type(**dict.fromkeys(FIELDS, evil))
    shown = "".join(pane.object for pane in (*desk.editor.maths.values(), desk.editor.status))
    assert not re.search(r"<(img|script)", shown)
    assert not any(re.search(":material/", words) for words in errors(desk.editor).values())


def test_every_field_has_a_label():
    editor = SystemEditor(lambda _: None)
    assert [text.label for text in editor.texts.values()] == list(FIELDS.values())


@pytest.mark.parametrize("key", ["two_walls", "diode_bridge", "thermostat", "chua", "elliptic_curve"])
def test_every_system_of_the_catalogue_can_be_started_from_and_changed(desk, key):
    system = core.CATALOGUE[key]
    assert {one.name for one in core.CATALOGUE.values()} <= {item["label"] for item in desk.editor.menu.items}
    desk.editor._choose({"label": system.name})
    assert desk.editor.settle(60)
    assert errors(desk.editor) == {}
    assert desk.editor.several.visible == (not system.two_sided)
    desk.type(name="Mine")
    desk.editor.use.clicks += 1
    assert desk.used[-1].regions == system.regions
    assert (desk.used[-1].name, desk.used[-1].transitions) == ("Mine", system.transitions)


def test_fields_that_few_need_are_hidden_behind_more(desk):
    assert not desk.editor.several.visible
    desk.editor.more.clicks += 1
    assert desk.editor.several.visible
    desk.editor.more.clicks += 1
    assert not desk.editor.several.visible


def test_a_system_that_is_changed_is_called_so_unless_it_is_given_a_name(desk):
    desk.editor.load(ELLIPTIC)
    assert desk.editor.settle(60)
    assert desk.editor.texts["name"].value_input == ELLIPTIC.name
    desk.type(g="x + y")
    desk.type(g="x - y")
    desk.editor.use.clicks += 1
    assert [system.name for system in desk.used] == ["Elliptic curve (changed)"]
    desk.editor.load(desk.used[0])
    assert desk.editor.settle(60)
    desk.type(g="x")
    assert desk.editor.texts["name"].value_input == "Elliptic curve (changed)"
    desk.editor.load(ELLIPTIC)
    assert desk.editor.settle(60)
    desk.type(name="Mine")
    desk.type(g="x")
    assert desk.editor.texts["name"].value_input == "Mine"


def test_a_name_that_nobody_typed_follows_the_laws(desk):
    desk.editor.load(ELLIPTIC)
    assert desk.editor.settle(60)
    desk.type(variables="x, v", f_minus="v\n-x + cos(t)", f_plus="v\n-2*x + cos(t)")
    assert desk.editor.texts["name"].value_input == "Elliptic curve (changed)", "its surface is still there"
    desk.type(g="x", psi_minus="", psi_plus="", parameters="", x0="1, 0")
    desk.editor.use.clicks += 1
    assert [system.name for system in desk.used] == ["My system"]
    desk.type(g=Draft.of(ELLIPTIC).g)
    assert desk.editor.texts["name"].value_input == "Elliptic curve (changed)"


def test_an_example_keeps_its_name_while_it_is_changed_in_part_and_empty_fields_get_one(desk):
    desk.type(f_plus="y\n-2*x")
    assert desk.editor.texts["name"].value_input == "My oscillator"
    desk.type(f_plus="y\n-x^3", f_minus="y\n-k*x^3", g="x")
    assert desk.editor.texts["name"].value_input == "My system"
    desk.editor.fill(Draft())
    desk.type(g="x")
    assert desk.editor.texts["name"].value_input == "My system"
    desk.type(name="")
    desk.type(g="y")
    assert desk.editor.texts["name"].value_input == "", "it was emptied by hand"


def test_a_mistake_leaves_the_last_good_system_in_use(desk):
    desk.editor.load(core.CATALOGUE["two_walls"])
    assert desk.editor.settle(60)
    desk.editor.use.clicks += 1
    desk.type(resets="g1 => x")
    assert set(errors(desk.editor)) == {"resets"}
    desk.editor.use.clicks += 1
    assert [system.name for system in desk.used] == ["Oscillator between walls"]


def test_a_system_that_has_no_fields_here_is_told_of_and_nothing_else_happens():
    regions = {"a: b": core.Region(("1", "0")), "off": core.Region(("-1", "0"))}
    ways = (core.Transition("a: b", "1 - x", "off"), core.Transition("off", "x + 1", "a: b"))
    odd = core.PiecewiseSystem("odd", ("x", "y"), regions=regions, transitions=ways)
    editor = SystemEditor(lambda system: None, current=lambda: odd)
    editor.start()
    assert "odd has regions with names that cannot be written here" in editor.status.object
    assert editor.system is None
    editor.close()
