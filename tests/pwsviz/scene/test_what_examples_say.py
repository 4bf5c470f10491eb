"""Numbers that the texts of examples state, against a computation that shares no code with ours."""

import re

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from pwsviz.scene.presets import PRESETS

BETA, INNER, OUTER = 100 / 7, -8 / 7, -5 / 7


def returned(alpha, y, z, loops):
    """Where an orbit of Chua's circuit that enters x > 1 at (1, y, z) does so again: affine flows, exactly."""
    matrices = [np.array([[-alpha * (1 + s), alpha, 0], [1, -1, 1], [0, -BETA, 0]]) for s in (OUTER, INNER)]
    rests = [np.linalg.solve(matrices[0], [alpha * (INNER - OUTER), 0, 0]), np.zeros(3)]
    x = np.array([1.0, y, z])
    for _ in range(loops):
        for matrix, rest in zip(matrices, rests, strict=True):

            def at(t, matrix=matrix, rest=rest, x=x):
                return rest + expm(matrix * t) @ (x - rest)

            t = 1e-6
            while (at(t)[0] > 1) == (at(t + 0.02)[0] > 1):
                t += 0.02
            x = at(brentq(lambda t: at(t)[0] - 1, t, t + 0.02, xtol=1e-15))
    return x[1:]


def multiplier(alpha, place, loops):
    """Largest Floquet multiplier of a closed orbit, sought near a place by Newton's method."""
    for _ in range(20):
        sides = [(returned(alpha, *(place + e), loops), returned(alpha, *(place - e), loops)) for e in 1e-6 * np.eye(2)]
        slopes = np.array([(a - b) / 2e-6 for a, b in sides]).T
        left = returned(alpha, *place, loops) - place
        place = place - np.linalg.solve(slopes - np.eye(2), left)
        if np.abs(left).max() < 1e-11:
            break
    return max(np.linalg.eigvals(slopes).real, key=abs)


@pytest.mark.parametrize(
    ("loops", "place", "which"), [(1, (0.2466, -0.2192), 0), (2, (0.1490, -0.0833), 1)], ids=["two", "four"]
)
def test_periods_of_chuas_circuit_double_where_it_is_said(loops, place, which):
    said = re.findall(r"8\.\d+", PRESETS["chua_sweep"].look)[which]
    unit = 10.0 ** -len(said.split(".")[1])
    below, above = (multiplier(float(said) + s * unit, np.array(place), loops) for s in (-0.6, 0.6))
    assert above < -1 < below
