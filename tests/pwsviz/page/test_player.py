"""What the player says of the runs that it shows."""

from dataclasses import replace

import core
from pwsviz.figures.lines import line_of, together
from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.plane import XY
from pwsviz.page.player import Player, without_trail
from pwsviz.results.animation import frames


def test_runs_without_a_trail_are_named():
    system = core.CATALOGUE["harmonic_oscillator"]
    short = [frames(core.integrate(system, (0.0, 5.0), method=name), XY) for name in ("dmm2", "rk2")]
    assert without_trail(short) == ""
    long = [replace(one, traced=False) for one in short]
    assert without_trail(long).startswith("No trail of dmm2 and rk2: ")
    assert without_trail([short[0], long[1], long[1]]).startswith("No trail of rk2: ")
    assert without_trail(long[:1]).startswith("No trail: ")


def test_trails_have_the_dashes_and_widths_of_the_curves_and_others_are_thinner_and_paler():
    system, methods = core.CATALOGUE["harmonic_oscillator"], ("dmm2", "rk2")
    runs = [frames(core.integrate(system, (0.0, 1.0), method=name), XY) for name in 2 * methods]
    player = Player(PortraitView(*[lambda *_: None] * 5))
    player.open = True
    player.show(runs, selected=2)
    ways, looks = player.bar.ways, together(map(line_of, methods))
    assert [(way["dash"], way["width"]) for way in ways[:2]] == [(list(look.dash), look.width) for look in looks]
    assert ways[0]["dash"] != ways[1]["dash"]
    assert [way["chosen"] for way in ways] == [True, True, False, False]
    for mine, other in zip(ways[:2], ways[2:], strict=True):
        assert other["dash"] == mine["dash"]
        assert other["width"] < mine["width"]
        assert other["alpha"] < mine["alpha"]
