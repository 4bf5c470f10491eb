"""An example stays one however it is looked at; once its scene is another one, its words are those of its opening."""

import pytest

from pwsviz.page.headline import Headline
from pwsviz.page.shown_example import ShownExample
from pwsviz.page.sidebar import Sidebar
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


@pytest.fixture
def page():
    scene = Scene()
    example = ShownExample(scene)
    return scene, example, Sidebar(scene, lambda: None, example=example), Headline(scene, example)


@pytest.mark.parametrize(
    ("key", "setting", "value"),
    [("cost", "cost_across", "evaluations"), ("cost", "cost_up", "invariant"), ("cost", "peers", ["scipy"]),
     ("chua", "axes", (0, 1)), ("elliptic_time", "order_all", True), ("cost", "sweep_points", 20)],
)  # fmt: skip
def test_another_look_at_an_example_is_no_change_of_it(page, key, setting, value):
    scene, example, sidebar, headline = page
    sidebar.presets.value = key
    said = sidebar.preset_note.object, headline.greeting.object
    scene.accept(setting, value)
    assert (example.preset, example.changed) == (PRESETS[key], False)
    assert sidebar.presets.value == key
    assert (sidebar.preset_note.object, headline.greeting.object) == said


def test_a_changed_example_is_told_as_it_was_opened_beside_the_controls_and_above_the_portrait(page):
    scene, example, sidebar, headline = page
    sidebar.presets.value = "first_look"
    look = PRESETS["first_look"].look
    assert look in sidebar.preset_note.object
    assert look in headline.greeting.object
    assert "As opened" not in sidebar.preset_note.object + headline.greeting.object
    scene.place((0.5, 0.5))
    assert example.changed
    for text in (sidebar.preset_note.object, headline.greeting.object):
        assert "(changed)" in text
        assert f"As opened: {look}" in text
    sidebar.presets.value = "first_look"
    assert not example.changed
    assert "(changed)" not in sidebar.preset_note.object + headline.greeting.object


def test_of_an_example_of_another_system_nothing_is_left(page):
    scene, example, sidebar, headline = page
    sidebar.presets.value = "zeno"
    scene.system = "kepler"
    assert (example.preset, sidebar.presets.value, sidebar.preset_note.object) == (None, "", "")
    assert headline.greeting.object == '<p class="greeting"><b>Kepler with a shell</b></p>'


def test_a_fresh_page_keeps_saying_what_it_is_when_its_example_is_changed():
    scene = Scene()
    scene.load(PRESETS["first_look"].settings)
    headline = Headline(scene, ShownExample(scene, PRESETS["first_look"]))
    scene.accept("tau", 0.05)
    assert "Tap in the portrait" in headline.greeting.object
    assert "A first look (changed)." in headline.greeting.object
