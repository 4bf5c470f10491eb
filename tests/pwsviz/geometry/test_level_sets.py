"""Level sets are drawn to where they end."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import Window, backdrop

WINDOW = Window(-0.31, 4.13, -0.52, 4.57)


@pytest.mark.parametrize("nearest", [0.01, 0.02, 0.03])
def test_a_level_set_of_a_logarithm_goes_on_to_where_it_is_not_defined(nearest):
    system = core.CATALOGUE["predator_prey"]
    (psi,) = system.conserved("-", 0.0, (nearest, 1.0))  # the orbit turns at y = a/b = 1, where x is least
    lines = backdrop(system, WINDOW, {0: (float(psi),)}).orbit_levels[-1]
    assert not np.isnan(lines[:-1]).any(), "one piece, from the surface or the edge of the window to the surface"
    assert np.nanmin(lines[:, 0]) == pytest.approx(nearest, abs=0.003), "half a pixel"
