"""Points of a section come in portions, which are together what one call of core.section gives, to the last bit."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import core
from core import Status
from pwsviz.figures.section_text import section_text, section_warnings
from pwsviz.results.requests import SectionInputs
from pwsviz.results.results import Results
from pwsviz.results.sections import FIRST, section_arguments, studied_section
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancelled, never, silent


def scene(system, **settings):
    made = Scene(system=system)
    for name, value in settings.items():
        made.accept(name, value)
    return made


@pytest.fixture
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


@pytest.mark.parametrize(
    ("system", "settings"),
    [
        ("elliptic_curve", {"starts": ((-1.0, -1.0), (-1.2, 0.0)), "tau": 0.02}),
        ("moving_interface", {"starts": ((1.5, 1.0), (1.0, 0.2)), "methods": ["rk4"], "section_direction": -1}),
        ("thermostat", {"methods": ["rk4"], "section_discard": 7}),
        ("vibrating_table", {"methods": ["taylor"], "tau": 1.0}),
    ],
)
def test_portions_are_together_the_points_of_core(system, settings, pool):
    inputs = SectionInputs.of_scene(scene(system, section_points=5 * FIRST, **settings))
    told = []
    found = studied_section(inputs, pool, never, lambda *news: told.append(news))
    wanted = core.section(inputs.problem.build(), (0.0, 1e9), inputs.starts, **section_arguments(inputs))
    for k in range(len(inputs.starts)):
        mine, own = found.of_start(k), wanted.member == k
        assert np.array_equal(mine.t, wanted.ensemble.crossings.t[own])
        assert np.array_equal(mine.x, wanted.ensemble.crossings.x_after[own])
    assert found.statuses == (Status.CROSSING_LIMIT,) * len(inputs.starts)
    assert len(found.portions) == 2 * len(inputs.starts) == len(told)
    assert [done for done, *_ in told] == np.cumsum([len(one.t) for one in found.portions]).tolist()
    assert all(one is other for one, other in zip(told[0][2].portions, found.portions, strict=False))


def test_a_run_that_ends_early_is_not_run_again(pool, monkeypatch):
    inputs = SectionInputs.of_scene(scene("bouncing_ball", section_points=50 * FIRST))
    calls, section = [], core.section
    monkeypatch.setattr(core, "section", lambda *args, **more: calls.append(1) or section(*args, **more))
    found = studied_section(inputs, pool, never, silent)
    assert (found.statuses, found.counts) == ((Status.ZENO,), (53,))
    assert len(calls) == 1


def test_neither_the_portrait_nor_the_selected_start_matters_to_the_points():
    made = scene("elliptic_curve", starts=((-1.0, -1.0), (-1.2, 0.0)), section_points=20)
    results = Results()
    first = results.section(SectionInputs.of_scene(made))
    for name, value in {"selected": 1, "t_end": 3.0, "section_axes": (1, 2), "section_map": True}.items():
        made.accept(name, value)
    made.accept("perturbation_order", 2)
    assert results.section(SectionInputs.of_scene(made)) is first
    assert results.computed["section"] == 1


def test_more_points_than_there_is_room_for_are_refused_with_the_number_that_is_possible(pool):
    inputs = SectionInputs.of_scene(scene("henon_heiles", section_points=10**6, starts=((0.2, 0.1, 0.1, 0.35),) * 12))
    with pytest.raises(ValueError, match="take at most 333,333"):
        studied_section(inputs, pool, never, silent)


def test_a_cancelled_section_is_not_kept():
    results, made = Results(), scene("elliptic_curve")
    with pytest.raises(Cancelled):
        results.section(SectionInputs.of_scene(made), cancel=lambda: True)
    assert results.section(SectionInputs.of_scene(made)).counts == (2000,)


@pytest.mark.parametrize(
    ("points", "discard", "rounds"),
    [(100, 0, [100]), (1600, 0, [400, 1600]), (1600, 800, [1600]), (20_000, 800, [500, 4400, 20_000])],
)
def test_rounds_grow_by_what_is_computed_and_not_by_what_is_left_out_alone(points, discard, rounds, pool, monkeypatch):
    asked, section = [], core.section
    monkeypatch.setattr(core, "section", lambda *args, **more: asked.append(more["points"]) or section(*args, **more))
    made = scene("elliptic_curve", methods=["dmm2"], tau=0.1, section_points=points, section_discard=discard)
    studied_section(SectionInputs.of_scene(made), pool, never, silent)
    assert asked == rounds


def test_points_of_a_motion_that_has_decayed_to_round_off_are_left_out_and_the_run_goes_no_further(pool):
    made = scene("damped_oscillator", methods=["rk4"])
    found = studied_section(SectionInputs.of_scene(made), pool, never, silent)
    (count,), one = found.counts, found.of_start(0)
    assert found.at_rest == {0}
    assert 150 < count < 300
    assert found.ends == (one.t[-1],)
    size = np.abs(one.x).max(axis=1)
    assert 1e-16 < size[-1] < 8 * np.finfo(float).eps


def test_a_block_that_sticks_is_at_rest(pool):
    found = studied_section(SectionInputs.of_scene(scene("coulomb_friction", methods=["rk4"])), pool, never, silent)
    assert (found.at_rest, found.counts) == ({0}, (4,))
    assert found.ends == pytest.approx((4 * np.pi,), abs=1e-3)


def test_a_motion_that_comes_to_rest_before_it_meets_the_surface_says_so(pool):
    made = scene("coulomb_friction", methods=["rk4"], section_of="y**2 + 1")
    found = studied_section(SectionInputs.of_scene(made), pool, never, silent)
    assert (found.at_rest, found.counts) == ({0}, (0,))
    assert "h does not change sign on the way; the motion has come to rest" in section_text(found)


def test_a_cycle_and_a_forced_motion_never_rest(pool):
    for system in ("stick_slip", "moving_interface"):
        made = scene(system, methods=["rk4"], section_points=300)
        assert not studied_section(SectionInputs.of_scene(made), pool, never, silent).at_rest


def test_steps_that_are_too_long_are_told_of_each_start(pool):
    starts = ((-1.0, -1.0), (-1.2, 0.0))
    for tau, told in ((0.2, True), (0.01, False)):
        inputs = SectionInputs.of_scene(scene("elliptic_curve", starts=starts, tau=tau, section_points=300))
        warnings = section_warnings(studied_section(inputs, pool, never, silent))
        assert any("too long for this field" in words for words in warnings) is told
        assert all(words.startswith("Start") and "τ" in words for words in warnings)
