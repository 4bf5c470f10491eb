"""Clicks on the stability map: what they choose, and what stays on the page."""

import numpy as np
import pytest

import core
from core.studies import default_taus
from pwsviz.export.script import stability_program
from pwsviz.figures.stability_outcomes import LIKEWISE, OUTCOMES
from pwsviz.results.requests import StabilityInputs
from pwsviz.results.results import Results
from pwsviz.results.studies import LIMITS_OF_TAU
from pwsviz.scene.permalink import adopt, query
from pwsviz.scene.scene import Scene
from pwsviz.tabs.stability import StabilityTab


def shown(results=None, **settings):
    """Return the tab of a scene with its map drawn."""
    scene = Scene(view="stability", methods=["rk2"], **settings)
    tab = StabilityTab(scene, results or Results())
    tab.build()
    tab.built = True
    compute(tab)
    return tab


def compute(tab):
    inputs = tab.inputs()
    tab.present(inputs, tab.results.stability(inputs))


@pytest.fixture(scope="module")
def tab():
    return shown(t_end=40.0)


def test_the_map_and_the_search_end_at_the_largest_step_size_that_the_page_takes(tab):
    study = tab.outcome
    for taus in (study.map.taus, study.largest_tau.taus):
        assert taus[[0, -1]] == pytest.approx([40.0 / 20_000, 1.0], rel=1e-15)
    tab.scene.accept("tau", float(study.map.taus[-1]))
    short = Results().stability(StabilityInputs.of(Scene(methods=["rk2"], t_end=1.0)))
    assert short.map.taus == pytest.approx(np.geomspace(1 / 20_000, 0.1, 25))


def test_for_every_end_time_of_the_page_step_sizes_increase_over_a_decade_at_least(draws):
    ends = np.log(Scene.param["t_end"].bounds)
    for rng in draws(50):
        t_end = float(np.exp(rng.uniform(*ends)))
        taus = default_taus(t_end, *LIMITS_OF_TAU)
        assert (np.diff(taus) > 0).all()
        assert taus[-1] >= 9.99 * taus[0], t_end
        assert t_end > 2000.0 or LIMITS_OF_TAU[0] <= taus[0] < taus[-1] <= LIMITS_OF_TAU[1]


def test_a_map_of_the_longest_run_of_the_page_is_drawn():
    tab = shown(t_end=1e5)
    assert tab.outcome.map.outcome.shape[1:] == (25, 25)
    assert "<table" in tab.words.object


def test_a_refused_click_is_told_above_the_tables_which_stay(tab):
    before = tab.words.object
    for _ in range(2):
        tab._go(2.0, float(tab.outcome.map.values[3]))
        assert tab.words.object.endswith(before)
        assert tab.words.object.count("The step size must lie between") == 1
    assert "<table" in before


def test_the_program_repeats_the_map_that_is_drawn(tab):
    lines, found = stability_program(tab.scene, tab.inputs(), tab.outcome.map), tab.outcome.map
    for name, column, make in (("taus", found.taus, np.geomspace), ("values", found.values, np.linspace)):
        first, last, count = column[0].item(), column[-1].item(), len(column)
        assert f"{name}=np.{make.__name__}({first!r}, {last!r}, {count})" in lines
        assert np.array_equal(make(first, last, count), column)


def test_the_program_counts_as_correct_what_the_page_does(capsys):
    tab = shown(values={"a_minus": -3.0, "a_plus": -2.0, "radius": 1.0})
    rows = tab.numbers(tab.outcome)[1].rows
    found = tab.outcome.map
    assert (found.works[0] & (found.outcome[0] != core.Status.COMPLETED)).any(), "some end as the solution does"
    lines = stability_program(tab.scene, tab.inputs(), found)
    exec(lines, {"core": core, "np": np, "system": tab.scene.build()})  # noqa: S102  (our own program)
    assert f"{found.works[0].mean():.0%} of the runs of the map" in capsys.readouterr().out
    shares = [
        int(row[1].removesuffix("%"))
        for row in rows
        if row[0] in (OUTCOMES[LIKEWISE].words, "correct sequence of crossings")
    ]
    assert len(shares) == 2
    assert sum(shares) == pytest.approx(100 * found.works[0].mean(), abs=1.0)


def test_a_click_leaves_the_map_as_it_is_and_computes_the_limits_of_its_start():
    tab = shown()
    scene, before = tab.scene, tab.outcome
    for k in (3, 20):
        start = scene.x0
        tab._go(0.1234, float(before.map.values[k]))
        assert scene.x0 != start
        compute(tab)
        assert tab.outcome.map is before.map, "it is not computed again"
        assert (tab.outcome.x0, scene.tau) == (scene.x0, 0.123)
        assert tab.view._of("map").place.data["y"] == [scene.x0[0]]
    alone = core.stability_study(
        scene.build(), (0.0, scene.t_end), scene.x0, ["rk2"], before.map.taus, parts=["largest_tau"], sliding="continue"
    )
    assert np.array_equal(tab.outcome.largest_tau.tau, alone.largest_tau.tau)
    assert not np.array_equal(alone.largest_tau.tau, before.largest_tau.tau)


@pytest.mark.parametrize(
    ("field", "value"),
    [("x0", (1.5, 0.0)), ("stability_coordinate", 1), ("system", "pendulum")],
)
def test_a_map_chosen_in_is_drawn_around_what_else_is_chosen(field, value):
    scene = Scene()
    around = scene.x0[0]
    scene.choose_on_map(0.1, 0.75)
    assert scene.stability_around == around
    assert StabilityInputs.of(scene).of_map().problem.x0[0] == around
    scene.accept(field, value)
    assert scene.stability_around is None


def test_a_link_brings_the_map_that_was_clicked_in():
    scene, copy = Scene(view="stability"), Scene()
    scene.choose_on_map(0.1, 0.75)
    assert adopt(copy, query(scene)) == []
    assert StabilityInputs.of(copy) == StabilityInputs.of(scene)


def test_progress_of_map_and_limits_is_one():
    told = []
    scene = Scene(view="stability", methods=["rk2", "dmm2"], t_end=2.0)
    Results().stability(StabilityInputs.of(scene), report=lambda done, total, partial: told.append((done, total)))
    assert told == [(k, 52) for k in range(1, 53)]
