"""A section says beforehand why it can show little, or what it depends on."""

import pytest

import core
from pwsviz.figures.section_prospects import prospects

FEW, OTHERS = "Few distinct points are to be expected", "other starts may give a different section"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("relay_feedback", {FEW}), ("elliptic_curve", {FEW}), ("kepler", {OTHERS}), ("henon_heiles", {OTHERS}),
        ("coulomb_friction", {FEW}),  # as of the elliptic curve, none is kept across the surface
        ("damped_oscillator", {FEW}),  # its quantities contain time
        ("bouncing_ball", set()), ("two_walls", set()), ("vibrating_table", set()),  # their reset maps change it
        ("moving_interface", set()), ("thermostat", set()), ("chua", set()),
    ],
)  # fmt: skip
def test_flows_in_the_plane_and_conserved_quantities_are_told(key, said):
    words = prospects(core.CATALOGUE[key], "section")
    assert {one for one in (FEW, OTHERS) if one in words} == said


def test_a_ball_that_bounces_without_loss_conserves_its_energy():
    assert OTHERS in prospects(core.CATALOGUE["bouncing_ball"].with_parameters(restitution=1.0), "section")


@pytest.mark.parametrize(("view", "title"), [("section", "Poincaré section of"), ("sweep", "from order to chaos")])
def test_where_little_is_to_be_seen_the_examples_of_the_view_are_named(view, title):
    assert title in prospects(core.CATALOGUE["elliptic_curve"], view)
    assert prospects(core.CATALOGUE["chua"], view) == ""


def test_of_a_stroboscopic_section_of_a_flow_in_the_plane_it_is_not_said_that_few_points_remain():
    system = core.CATALOGUE["elliptic_curve"]
    assert FEW in prospects(system, "section", of="x - 1")
    assert FEW not in prospects(system, "section", of="sin(3*t)")
