"""Shades tell neighbouring regions apart, one of them is for sliding, and legends name the regions of each."""

from itertools import product

import numpy as np
import pytest

import core
from pwsviz.geometry.shades import (
    REGION_SHADES,
    SHADES,
    SLIDING,
    coloured,
    region_name,
    regions_of,
    shade_names,
    shades_of,
)
from tests.pwsviz.own_systems import OWN_SYSTEMS, RELAY, STRIPS

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


@every_system
def test_regions_between_which_a_run_may_pass_have_different_shades(system):
    shades = shades_of(system, np.arange(len(system.modes)))
    for k, ways in enumerate(system.laws.ways):
        for way in ways:
            assert way.to in (None, k) or 0 != shades[way.to] != shades[k] != 0


@every_system
def test_regions_whose_keys_differ_in_one_sign_have_different_shades(system):
    names = list(system.regions) if system.surfaces else []
    shades = dict(zip(names, shades_of(system, np.arange(len(names))), strict=True))
    for a in names:
        for b in names:
            if sum(p != q for p, q in zip(a, b, strict=True)) == 1:
                assert shades[a] == -shades[b]


@every_system
def test_sliding_and_a_run_that_stopped_at_a_surface_have_a_shade_of_their_own(system):
    count = len(system.laws.regions)
    assert set(shades_of(system, np.arange(count)).tolist()) <= set(REGION_SHADES)
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
def test_the_legend_tells_all_regions_of_each_shade(system):
    if not system.two_sided:
        for shade in set(shades_of(system, np.arange(len(system.regions))).tolist()):
            names = [region_name(system.laws.regions[k]) for k in regions_of(system, shade)]
            told = shade_names(system)[shade]
            assert "…" not in told
            odd = {name.count("−") % 2 == 1 for name in names}
            told_by_signs = {f"an {('even', 'odd')[one]} number of −" in told for one in odd}
            assert all(name in told for name in names) or told_by_signs == {True}


def test_regions_are_told_by_their_signs_and_those_that_do_not_fit_by_what_these_have_in_common():
    genes = core.CATALOGUE["gene_ring"]
    names = {-1: "regions −−−, −++, +−+, ++−", 1: "regions −−+, −+−, +−−, +++", SLIDING: "sliding"}
    assert shade_names(genes) == names
    signs = ["".join(one) for one in product("-+", repeat=4)]
    regions = {name: core.Region(("1", "0")) for name in signs}
    surfaces = tuple(f"x - {k}" for k in range(4))
    many = core.PiecewiseSystem("many", ("x", "y"), surfaces=surfaces, regions=regions)
    words = {shade: f"regions with an {which} number of −" for shade, which in ((-1, "odd"), (1, "even"))}
    assert shade_names(many) == {**words, SLIDING: "sliding"}
    for shade in (-1, 1):
        assert all((signs[k].count("-") % 2 == 1) == (shade < 0) for k in regions_of(many, shade))


def test_of_many_named_regions_those_that_do_not_fit_are_counted():
    names = [f"region number {k}" for k in range(4)]
    hub = [core.Transition("hub", f"x + {k}", name) for k, name in enumerate(names)]
    hub += [core.Transition(name, "3 - x", "hub") for name in names]
    regions = {name: core.Region(("1", "0")) for name in ("hub", *names)}
    star = core.PiecewiseSystem("star", ("x", "y"), regions=regions, transitions=hub, x0=(1.0, 0.0))
    assert shade_names(star)[1] == "regions region number 0 and 3 more"


def test_signs_are_printed_as_minus_signs_and_hyphens_of_names_as_hyphens():
    assert shade_names(STRIPS) == {-1: "region +−", 1: "regions −−, ++", 0: "sliding"}
    assert shade_names(RELAY) == {-1: "region pre-heat", 1: "region off", 0: "sliding"}


def ring(count):
    return [{(k - 1) % count, (k + 1) % count} for k in range(count)]


def test_regions_in_a_ring_have_two_shades_and_a_third_where_their_number_is_odd():
    for count in range(2, 13):
        shades = coloured(ring(count))
        assert all(shades[k] != shades[k - 1] for k in range(count))
        assert len(set(shades)) == 2 + count % 2
        assert shades[:2] == [-1, 1]


def test_two_shades_are_enough_wherever_they_can_be():
    rng = np.random.default_rng(0)
    for _ in range(50):
        side = rng.integers(0, 2, 12)
        pairs = [(a, b) for a in range(12) for b in range(a) if side[a] != side[b] and rng.random() < 0.3]
        around = [{a + b - k for a, b in pairs if k in (a, b)} for k in range(12)]
        shades = coloured(around)
        assert set(shades) <= {-1, 1}
        assert all(shades[a] != shades[b] for a, b in pairs)


def test_four_regions_each_beside_all_others_differ_and_of_more_as_few_as_possible_are_alike():
    for count in (4, 9):
        shades = coloured([set(range(count)) - {k} for k in range(count)])
        assert set(shades) == set(REGION_SHADES)
        assert max(map(shades.count, shades)) == -(-count // 4)


def test_a_cycle_of_three_named_regions_is_told_apart_by_its_shades():
    names = ("a", "b", "c")
    system = core.PiecewiseSystem(
        "Three", ("x", "y"), regions={name: core.Region((f"{k + 1}", "0")) for k, name in enumerate(names)},
        transitions=[core.Transition(names[k - 1], f"{k + 1} - x", names[k], jump=("0", "y")) for k in range(3)],
    )  # fmt: skip
    assert shade_names(system) == {-1: "region a", 1: "region b", 2: "region c", 0: "sliding"}
