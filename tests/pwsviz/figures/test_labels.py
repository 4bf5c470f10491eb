"""Several surfaces are named in the portrait, and a single one is not."""

import core
from pwsviz.figures.labels import surface_labels
from tests.pwsviz.own_systems import RELAY


def test_several_surfaces_are_named_by_their_equations():
    assert surface_labels(core.CATALOGUE["diode_bridge"]) == ["g₁ = v − u = 0", "g₂ = v + u = 0"]
    assert surface_labels(core.CATALOGUE["gene_ring"])[2] == "g₃ = z − θ = 0"


def test_surfaces_of_named_regions_have_no_number_as_no_sign_refers_to_it():
    assert surface_labels(core.CATALOGUE["thermostat"]) == ["δ − T = 0", "T + δ = 0"]
    assert surface_labels(RELAY) == ["top − u = 0", "u − 1/2 = 0"]


def test_a_long_equation_is_left_to_the_scheme():
    long = core.PiecewiseSystem(
        "long", ("x", "y"), surfaces=("x", "y - sin(x)*cos(x)*exp(x + y)"), regions={"--": core.Region(("1", "1"))}
    )
    assert surface_labels(long) == ["g₁ = x = 0", "g₂ = 0"]


def test_a_single_surface_is_named_in_the_legend_alone():
    assert surface_labels(core.CATALOGUE["elliptic_curve"]) == []
