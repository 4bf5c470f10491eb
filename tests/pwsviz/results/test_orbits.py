"""The steps that a portrait marks are those of the first turns, of closed orbits of any shape and phase."""

import numpy as np
import pytest

from pwsviz.results.orbits import _return

COUNT = 300


def marked(at):
    return _return(at, np.hypot(*np.diff(at, axis=0).T))


@pytest.mark.parametrize("loops", [1, 2])
def test_steps_of_a_closed_orbit_are_marked_for_one_turn_or_two_and_of_an_open_one_for_all(draws, loops):
    for rng in draws(300):
        a_turn = loops * rng.uniform(6.0, 40.0)  # steps, seldom a whole number of them
        phase = 2 * np.pi * np.arange(COUNT) / a_turn + rng.uniform(0, 2 * np.pi)
        wide, high = rng.uniform(0.3, 3.0, 2)
        turn = np.linalg.qr(rng.normal(size=(2, 2)))[0]
        closed = np.column_stack([wide * np.cos(phase), high * np.sin(loops * phase)]) @ turn
        assert marked(closed) <= 2 * a_turn + 3, (
            "where they fall half a step beside the first, those of a second turn, too"
        )
        if loops == 1:  # a narrow figure of eight comes near its own path sooner
            assert marked(closed) >= a_turn - 2
        opened = np.column_stack([np.arange(COUNT), np.cumsum(rng.normal(size=COUNT))]) @ turn
        assert marked(opened) == COUNT
