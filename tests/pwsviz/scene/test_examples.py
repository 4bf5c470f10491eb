"""A link to an example is known again."""

import pytest

from pwsviz.scene.examples import example_of
from pwsviz.scene.permalink import adopt, query
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


@pytest.mark.parametrize("key", PRESETS)
def test_the_link_of_an_example_is_known_again_and_that_of_a_changed_one_is_not(key):
    scene, linked, changed = Scene(), Scene(), Scene()
    scene.load(PRESETS[key].settings)
    adopt(linked, query(scene))
    assert example_of(linked) is PRESETS[key]
    adopt(changed, query(scene))
    changed.accept("t_end", 0.5 * changed.t_end)
    assert example_of(changed) is None
