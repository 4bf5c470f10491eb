"""The pieces of the surface along which states slide, and those that repel."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import Window, backdrop

WINDOW = Window(-3.0, 3.0, -2.0, 2.0)


def ends(points):
    there = points[np.isfinite(points).all(axis=1)]
    return (there.min(axis=0), there.max(axis=0)) if len(there) else None


def test_a_block_sticks_where_the_spring_is_weaker_than_the_friction():
    found = backdrop(core.CATALOGUE["coulomb_friction"], WINDOW, {})
    low, high = ends(found.attracting)
    assert low == pytest.approx([-0.4, 0.0], abs=1e-9)
    assert high == pytest.approx([0.4, 0.0], abs=1e-9)
    assert ends(found.repelling) is None


def test_a_watershed_repels_along_its_whole_length():
    found = backdrop(core.CATALOGUE["type_repelling"], WINDOW, {})
    low, high = ends(found.repelling)
    assert (low[0], high[0]) == (-3.0, 3.0)
    assert ends(found.attracting) is None


@pytest.mark.parametrize("name", ["bouncing_ball", "moving_interface", "harmonic_oscillator"])
def test_no_piece_is_drawn_where_a_state_jumps_the_surface_moves_or_both_fields_cross_it(name):
    found = backdrop(core.CATALOGUE[name], WINDOW, {})
    assert ends(found.attracting) is ends(found.repelling) is None
