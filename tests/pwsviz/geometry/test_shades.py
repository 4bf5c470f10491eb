"""Two shades tell neighbouring regions apart, a third one is for sliding, and legends name the regions of each."""

import numpy as np
import pytest

import core
from pwsviz.geometry.shades import MOST_NAMES, SHADES, SLIDING, region_name, regions_of, shade_names, shades_of
from tests.pwsviz.own_systems import OWN_SYSTEMS, RELAY, STRIPS

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


@every_system
def test_regions_between_which_a_run_may_pass_have_different_shades(system):
    shades = shades_of(system, np.arange(len(system.modes)))
    for k, ways in enumerate(system.laws.ways):
        for way in ways:
            assert way.to in (None, k) or shades[way.to] == -shades[k] != 0


@every_system
def test_regions_whose_keys_differ_in_one_sign_have_different_shades(system):
    names = list(system.regions) if system.surfaces else []
    shades = dict(zip(names, shades_of(system, np.arange(len(names))), strict=True))
    for a in names:
        for b in names:
            if sum(p != q for p, q in zip(a, b, strict=True)) == 1:
                assert shades[a] == -shades[b]


@every_system
def test_sliding_and_a_run_that_stopped_at_a_surface_have_the_third_shade(system):
    count = len(system.laws.regions)
    assert set(shades_of(system, np.arange(count)).tolist()) <= {-1, 1}
    assert set(shades_of(system, np.array([-1, *range(count, len(system.modes))])).tolist()) == {SLIDING}


@every_system
def test_every_region_has_one_shade_by_which_it_is_found(system):
    found = [k for shade in SHADES for k in regions_of(system, shade)]
    assert sorted(found) == list(range(len(system.regions)))
    assert regions_of(system, SLIDING) == []


@pytest.mark.parametrize("name", [name for name, one in core.CATALOGUE.items() if one.two_sided])
def test_of_two_sides_the_shade_is_the_sign_of_g(name):
    system = core.CATALOGUE[name]
    assert shades_of(system, np.arange(3)).tolist() == [-1, 1, 0]
    assert shade_names(system) == {-1: "g < 0", 1: "g > 0", SLIDING: "sliding"}


@every_system
def test_the_legend_names_the_regions_of_each_shade_or_counts_on(system):
    if not system.two_sided:
        for shade in (-1, 1):
            names = [region_name(system.laws.regions[k]) for k in regions_of(system, shade)]
            told = shade_names(system)[shade]
            assert all(name in told for name in names[: MOST_NAMES if len(names) <= MOST_NAMES else 1])
            assert told.endswith("…") == (len(names) > MOST_NAMES)


def test_signs_are_printed_as_minus_signs_and_hyphens_of_names_as_hyphens():
    assert shade_names(STRIPS) == {-1: "region +−", 1: "regions −−, ++", 0: "sliding"}
    assert shade_names(RELAY) == {-1: "region pre-heat", 1: "region off", 0: "sliding"}
