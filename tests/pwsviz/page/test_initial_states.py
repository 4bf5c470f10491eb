"""The list of starts."""

import pytest

from pwsviz.page.initial_states import Trajectories
from pwsviz.scene.checks import MAX_STARTS
from pwsviz.scene.scene import Scene


@pytest.fixture
def listed():
    return Trajectories(Scene())


def test_adding_places_one_beside_and_selects_it(listed):
    listed.more.clicks += 1
    assert listed.scene.starts == ((-1.0, -1.0), (-0.9, -1.0))
    assert listed.numbers.options == [1, 2]
    assert listed.numbers.value == 2
    listed.numbers.value = 1
    assert listed.scene.selected == 0


def test_removing_takes_the_selected_one_but_never_the_last(listed):
    listed.more.clicks += 1
    listed.less.clicks += 1
    assert listed.scene.starts == ((-1.0, -1.0),)
    assert listed.less.disabled


def test_there_is_an_end_to_adding(listed):
    for _ in range(MAX_STARTS + 3):
        listed.more.clicks += 1
    assert len(set(listed.scene.starts)) == MAX_STARTS
    assert listed.more.disabled


def test_a_place_where_nothing_can_start_is_told(listed):
    listed.scene.accept("x0", (1e6, 0.0))
    listed.more.clicks += 1
    assert "between" in listed.message.object
    assert len(listed.scene.starts) == 1
