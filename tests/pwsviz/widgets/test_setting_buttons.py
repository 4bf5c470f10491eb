"""A row of buttons and a setting of the scene agree."""

from pwsviz.scene.names import COST_UP
from pwsviz.scene.scene import Scene
from pwsviz.widgets.setting_buttons import choice


def test_buttons_and_setting_follow_each_other():
    scene = Scene()
    buttons = choice(scene, "cost_up", lambda: {words: key for key, words in COST_UP.items()})
    assert buttons.value == "state"
    buttons.value = "invariant"
    assert scene.cost_up == "invariant"
    scene.cost_up = "time"
    assert buttons.value == "time"


def test_what_is_offered_follows_the_scene_and_the_setting_stays():
    scene = Scene(methods=["dmm2", "dmm4", "rk2"], study_method="dmm4")
    buttons = choice(scene, "study_method", lambda: {name: name for name in scene.used}, ("system", "methods"))
    scene.system = "relay_feedback"
    assert (buttons.options, buttons.value) == ({"rk2": "rk2"}, "rk2")
    scene.system = "elliptic_curve"
    assert (list(buttons.options), buttons.value) == (["dmm2", "dmm4", "rk2"], "dmm4")
