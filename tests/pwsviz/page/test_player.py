"""What the player says of the runs that it shows."""

from dataclasses import replace

import core
from pwsviz.page.player import without_trail
from pwsviz.results.animation import frames


def test_runs_without_a_trail_are_named():
    system = core.CATALOGUE["harmonic_oscillator"]
    short = [frames(core.integrate(system, (0.0, 5.0), method=name), (0, 1)) for name in ("dmm2", "rk2")]
    assert without_trail(short) == ""
    long = [replace(one, traced=False) for one in short]
    assert without_trail(long).startswith("No trail of dmm2 and rk2: ")
    assert without_trail([short[0], long[1], long[1]]).startswith("No trail of rk2: ")
    assert without_trail(long[:1]).startswith("No trail: ")
