"""The head of the page says what it is, then what it shows."""

from pwsviz.page.headline import Headline
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


def test_a_fresh_page_says_what_it_is_and_another_system_has_its_name_there():
    scene = Scene()
    head = Headline(scene)
    assert "Tap in the portrait" in head.greeting.object
    assert "Bouncing ball" in Headline(Scene(system="bouncing_ball")).greeting.object, "as opened by a link"
    assert head.tagline.object.endswith("<b>Elliptic curve</b></div>")
    scene.system = "kepler"
    assert head.greeting.object == '<p class="greeting"><b>Kepler with a shell</b></p>'
    assert head.tagline.object.endswith("<b>Kepler with a shell</b></div>")


def test_a_lecture_tells_the_laws_and_the_parameters_as_they_change():
    scene = Scene()
    head = Headline(scene)
    head.give_lecture(begun=True)
    assert "g\xa0&lt;\xa00: x′\xa0=\xa02y" in head.tagline.object
    assert "a₋\xa0=\xa0−3" in head.tagline.object
    scene.values = {**scene.values, "a_minus": -2.5}
    assert "a₋\xa0=\xa0−2.5" in head.tagline.object
    scene.system = "three_bodies"
    assert "x₁′" not in head.tagline.object, "the header has no room for its laws"
    assert "ε\xa0=\xa00.5" in head.tagline.object, "but for its parameters"
    assert "τ\xa0=\xa00.01" in head.tagline.object
    scene.locate = False
    assert "τ = 0.01, 0 ≤ t ≤ 20; crossings not located" in head.tagline.object.replace("\xa0", " ")
    scene.locate, scene.perturbation_order = True, 3
    assert "crossings perturbed by τ³" in head.tagline.object.replace("\xa0", " ")
    scene.system = "elliptic_curve"
    head.give_lecture(begun=False)
    scene.values = {**scene.values, "a_minus": -2.0}
    assert head.tagline.object.endswith("<b>Elliptic curve</b></div>")


def test_an_example_says_what_to_look_at_until_another_system_is_chosen(explorer):
    explorer.sidebar.presets.value = "zeno"
    assert f"<b>{PRESETS['zeno'].title}.</b> {PRESETS['zeno'].look}" in explorer.headline.greeting.object
    explorer.scene.system = "kepler"
    assert "Zeno" not in explorer.headline.greeting.object
