"""Undo goes back gesture by gesture."""

import pytest

import core
from pwsviz.scene.history import MAX_STEPS_BACK, History
from pwsviz.scene.names import named_settings
from pwsviz.scene.scene import Scene


class Clock:
    """A clock that is set by hand."""

    now = 100.0

    def __call__(self):
        """Return what it was set to."""
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def history(clock):
    return History(Scene(), clock)


def test_every_gesture_is_undone_by_itself(history, clock):
    scene, states = history.scene, []
    for change in (("tau", 0.02), ("x0", (0.5, 0.5)), ("system", "kepler"), ("methods", ["rk4"])):
        states.append(scene.settings())
        clock.now += 5
        scene.accept(*change)
    for state in reversed(states):
        assert history.can_undo
        history.undo()
        assert scene.settings() == state
    assert not history.can_undo
    history.undo()
    assert scene.settings() == states[0]


def test_all_that_is_dragged_at_once_is_undone_at_once_however_late_the_places_come(history, clock):
    scene, states = history.scene, []
    for _ in range(2):  # one drag right after another
        states.append(scene.settings())
        history.hold(True)
        for x in (0.1, 0.2, 0.3):
            scene.move(0, (x, scene.x0[1] + 0.5))
            history.hold(True)
            clock.now += 3
        history.hold(False)
        clock.now -= 8.9
    for state in reversed(states):
        history.undo()
        assert scene.settings() == state
    assert not history.can_undo


def test_what_is_undone_while_it_is_held_is_held_no_longer(history, clock):
    scene = history.scene
    history.hold(True)
    scene.place((0.1, 0.2))
    history.undo()  # the start that is dragged is gone: nobody tells that it is dropped
    for tau in (0.02, 0.03):
        clock.now += 3
        scene.tau = tau
    history.undo()
    assert scene.tau == 0.02


def test_what_was_undone_is_done_again_until_something_else_is_done(history, clock):
    scene, states = history.scene, [history.scene.settings()]
    for change in (("tau", 0.02), ("system", "kepler"), ("methods", ["rk4"])):
        clock.now += 5
        scene.accept(*change)
        states.append(scene.settings())
    for _ in states[1:]:
        history.undo()
    for state in states[1:]:
        assert history.can_redo
        history.redo()
        assert scene.settings() == state
    assert not history.can_redo
    history.redo()
    assert scene.settings() == states[-1]
    history.undo()
    clock.now += 5
    scene.accept("tau", 0.03)
    assert not history.can_redo
    history.undo()
    assert scene.settings() == states[-2]


def test_a_dragged_slider_is_one_step(history, clock):
    for k in range(1, 50):
        clock.now += 0.1
        history.scene.accept("tau", 0.01 + 1e-3 * k)
    history.undo()
    assert history.scene.tau == 0.01


def test_looking_at_another_view_is_no_change_and_is_kept(history):
    history.scene.accept("tau", 0.02)
    history.scene.view = "scheme"
    history.undo()
    assert (history.scene.tau, history.scene.view) == (0.01, "scheme")


def test_a_system_of_ones_own_comes_back(history, clock):
    own = core.PiecewiseSystem("mine", ("u", "v"), ("v", "-3*u"), ("v", "-u"), "v", x0=(1.0, 1.0))
    history.scene.use(own)
    clock.now += 5
    history.scene.system = "pendulum"
    history.undo()
    assert history.scene.build() == own


def test_memory_is_bounded(history, clock):
    for k in range(MAX_STEPS_BACK + 20):
        clock.now += 5
        history.scene.accept("tau", 0.01 + 1e-4 * (k + 1))
    assert len(history._past) == MAX_STEPS_BACK


def test_a_gesture_that_takes_itself_back_leaves_no_entry_and_what_was_undone_stays(history, clock):
    scene, first = history.scene, history.scene.settings()
    scene.accept("tau", 0.02)
    clock.now += 5
    scene.accept("tau", 0.03)
    history.undo()
    clock.now += 5
    before = {"starts": scene.starts, "selected": scene.selected}
    scene.place((0.5, 0.5))
    assert not history.can_redo
    clock.now += 0.3
    scene.param.update(**before)
    assert (history.can_undo, history.can_redo) == (True, True)
    history.redo()
    assert scene.tau == 0.03
    history.undo()
    history.undo()
    assert scene.settings() == first
    assert not history.can_undo


def test_what_follows_a_gesture_that_took_itself_back_is_a_gesture_of_its_own(history, clock):
    scene = history.scene
    scene.accept("tau", 0.02)
    clock.now += 5
    scene.place((0.5, 0.5))
    scene.param.update(starts=scene.starts[:1], selected=0)
    scene.accept("t_end", 3.0)
    history.undo()
    assert (scene.tau, scene.t_end == 3.0) == (0.02, False)


def test_it_tells_which_settings_go_back(history, clock):
    scene = history.scene
    for name, value, words in (
        ("tau", 0.02, "Step size τ"),
        ("x0", (0.5, 0.5), "Starts"),
        ("system", "kepler", "System"),
    ):
        clock.now += 5
        scene.accept(name, value)
        assert named_settings(history.undo()) == words
        assert named_settings(history.redo()) == words
    assert history.redo() == []
