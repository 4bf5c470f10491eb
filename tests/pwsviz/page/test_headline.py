"""The head of the page says what it is, then what it shows."""

from pwsviz.page.headline import Headline
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


def test_a_fresh_page_says_what_it_is_and_another_system_has_its_name_there():
    scene = Scene()
    head = Headline(scene)
    assert "Tap in the portrait" in head.greeting.object
    assert head.tagline.object.endswith('<p class="name">Elliptic curve</p>')
    scene.system = "kepler"
    assert head.greeting.object == '<p class="greeting"><b>Kepler with a shell</b></p>'
    assert head.tagline.object.endswith('<p class="name">Kepler with a shell</p>')


def test_an_example_says_what_to_look_at_until_another_system_is_chosen(explorer):
    explorer.sidebar.presets.value = "zeno"
    assert f"<b>{PRESETS['zeno'].title}.</b> {PRESETS['zeno'].look}" in explorer.headline.greeting.object
    explorer.scene.system = "kepler"
    assert "Zeno" not in explorer.headline.greeting.object
