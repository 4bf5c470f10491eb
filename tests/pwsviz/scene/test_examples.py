"""A link to an example is known again."""

import pytest

from pwsviz.scene.examples import example_of, settings_of
from pwsviz.scene.permalink import adopt, query
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import LOOKS, VIEWS


@pytest.mark.parametrize("key", PRESETS)
def test_the_link_of_an_example_is_known_again_and_that_of_a_changed_one_is_not(key):
    scene, linked, changed = Scene(), Scene(), Scene()
    scene.load(PRESETS[key].settings)
    adopt(linked, query(scene))
    assert example_of(linked) is PRESETS[key]
    adopt(changed, query(scene))
    changed.accept("t_end", 0.5 * changed.t_end)
    assert example_of(changed) is None


def test_the_link_of_an_example_with_other_axes_is_known_again():
    scene, linked = Scene(), Scene()
    scene.load(PRESETS["cost"].settings)
    scene.accept("cost_across", "evaluations")
    scene.accept("peers", ["scipy"])
    adopt(linked, query(scene))
    assert linked.cost_across == "evaluations"
    assert example_of(linked) is PRESETS["cost"]


def test_an_example_is_about_its_runs_and_what_its_own_view_computes():
    scene = Scene()
    studied = {name for view in VIEWS.values() for name in view.settings}
    for preset in PRESETS.values():
        scene.load(preset.settings)
        held, own = set(settings_of(scene, preset)), set(VIEWS[scene.view].settings)
        assert held & LOOKS == set()
        assert held & studied == own - LOOKS
        assert set(scene.settings()) - studied - LOOKS <= held
    assert set(scene.settings()) >= LOOKS, "they are settings of a scene"
