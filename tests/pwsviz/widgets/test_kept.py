"""What the server wants of a widget holds, whatever the browser reports."""

import panel_material_ui as pmui

from pwsviz.page.initial_states import Trajectories
from pwsviz.scene.scene import Scene
from pwsviz.widgets.kept import kept


def test_a_setting_that_the_browser_restores_is_set_again():
    full = [True]
    button = pmui.Button(label="Undo")
    settle = kept(button, disabled=lambda: full[0])
    assert button.disabled
    full[0] = False
    settle()
    assert not button.disabled
    button.disabled = True  # as the browser reports, which has handled two changes at once
    assert not button.disabled


def test_the_buttons_of_starts_stay_those_of_the_scene_but_select():
    scene = Scene(starts=((-1.0, -1.0), (0.5, 0.5)))
    starts = Trajectories(scene)
    starts.numbers.value = 2
    assert scene.selected == 1
    scene.remove(1)
    assert (starts.numbers.options, starts.numbers.value, starts.less.disabled) == ([1], 1, True)
    starts.numbers.param.update(options=[1, 2], value=2)
    starts.less.disabled = False
    assert (starts.numbers.options, starts.numbers.value, starts.less.disabled) == ([1], 1, True)
    assert scene.selected == 0
