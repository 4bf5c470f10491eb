"""Curves whose turns would touch are thinner, in the view in which they would; bodies are named beside curves."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from pwsviz.figures.framing import extent
from pwsviz.figures.lines import line_of, together
from pwsviz.figures.orbit_lines import THINNEST, alongside_columns, fitted
from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.window import Window
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.permalink import read
from pwsviz.scene.scene import Scene


def drawn(link):
    scene = Scene()
    scene.restore(read(link)[0])
    return scene, Results().pictures(PortraitInputs.of(scene))


def usual(pictures):
    return [line.width for line in together(line_of(orbit.method) for orbit in pictures.orbits)]


@pytest.mark.parametrize("link", ["", "system=bouncing_ball"])
def test_curves_whose_turns_lie_apart_or_on_one_another_have_their_usual_widths(link):
    _, pictures = drawn(link)
    assert fitted(pictures.orbits, extent(pictures))["width"] == usual(pictures)


def test_a_dense_spiral_is_thin_and_wider_where_it_is_zoomed_apart():
    scene, pictures = drawn("system=harmonic_oscillator&perturbation_order=1&t_end=60&tau=0.05")
    view = PortraitView(*[print] * 5)
    view.look_at(extent(pictures))
    view.show_orbits(scene.declaration, pictures, [(1.0, 1.0)], 0)
    thin = list(view.orbits.data["width"])
    assert all(THINNEST <= width < full for width, full in zip(thin, usual(pictures), strict=True))
    paths = list(view.orbits.data["xs"])
    view.look_at(extent(pictures).scaled(0.02))
    assert list(view.orbits.data["width"]) == usual(pictures)
    assert all(one is other for one, other in zip(view.orbits.data["xs"], paths, strict=True)), "no curve is sent anew"


def test_the_dashes_of_a_curve_are_drawn_where_its_turns_lie_apart_alone():
    scene, pictures = drawn("v=2&system=elliptic_curve&tau=0.08&t_end=19.2&methods=dmm2,rk2")
    view = PortraitView(*[print] * 5)
    view.look_at(extent(pictures))
    view.show_orbits(scene.declaration, pictures, [(-1.0, -1.0)], 0)
    dashes = [list(line_of(orbit.method).dash) for orbit in pictures.orbits]
    assert [list(one) for one in view.orbits.data["stroke"]] == [[], []] != dashes
    view.look_at(extent(pictures).scaled(0.02))
    assert [list(one) for one in view.orbits.data["stroke"]] == dashes
    assert [list(one) for one in view.orbits.data["dash"]] == dashes, "by which pictures know the integrator"


def test_each_body_is_named_at_its_start_on_a_side_that_curves_leave_free():
    scene = Scene(system="three_bodies", t_end=2.0)
    system, pictures = scene.declaration, Results().pictures(PortraitInputs.of(scene))
    (start,) = {orbit.start for orbit in pictures.orbits}
    view, away = Window(-3.0, 3.0, -3.0, 3.0), np.linspace(0.0, 0.5, 20)
    for right, above in product((1, -1), repeat=2):
        path = np.column_stack([start[0] + right * away, start[1] + above * 0.3 * away])
        led = replace(pictures, orbits=[replace(orbit, path=path) for orbit in pictures.orbits])
        named = alongside_columns(system, led, view)
        assert named["label"] == ["x₁, y₁", "x₂, y₂", "x₃, y₃"]
        assert (named["x"][0], named["y"][0], named["size"][0]) == (*start, 0), "a star stands there, no disc"
        assert min(named["size"][1:]) > 0
        assert (named["align"][0], named["baseline"][0]) != (
            "left" if right > 0 else "right", "bottom" if above > 0 else "top"
        )  # fmt: skip
    assert not any(alongside_columns(system, replace(pictures, alongside={}), view).values())
