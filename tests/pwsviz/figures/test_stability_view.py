"""Figures, words and columns of a stability study say what its arrays say."""

from dataclasses import replace

import numpy as np
import pytest
from bokeh.core.properties import value
from bokeh.events import Tap
from bokeh.models.glyphs import Text

import core
from core.studies.stability import NO_START, NOT_YET, UNCERTAIN, WENT_ON, WRONG_CROSSINGS
from pwsviz.figures.conserved import FLOOR
from pwsviz.figures.stability import StabilityView, stability_numbers, stability_tables, stability_text
from pwsviz.figures.stability_map import NO_VALUE
from pwsviz.figures.stability_outcomes import LIKEWISE, OUTCOMES, UNJUDGED
from pwsviz.figures.stability_text import map_text, runs_drawn
from pwsviz.scene.validation import value_of
from pwsviz.text.numbers import printed

ELLIPTIC = core.CATALOGUE["elliptic_curve"]
METHODS = ("dmm2", "rk2")


@pytest.fixture(scope="module")
def study():
    return core.stability_study(
        ELLIPTIC, methods=METHODS, taus=np.geomspace(0.02, 1.0, 6), values=np.linspace(-1.6, -0.8, 5), steps=20_000
    )


@pytest.fixture(scope="module")
def without():
    """A study of a system without a conserved quantity."""
    gene = core.CATALOGUE["gene_switch"]
    return core.stability_study(gene, methods=("rk4",), steps=2000, parts=("drift", "grazing", "largest_tau"))


def empty(study):
    return replace(study, largest_tau=None, map=None, drift=None, grazing=None)


def test_figures_are_made_when_first_asked_for_and_then_kept():
    view = StabilityView(lambda *place: None)
    assert not view._made
    assert view.figure("drift") is view.figure("drift")
    assert list(view._made) == ["drift"]


@pytest.mark.parametrize("part", ["map", "drift", "grazing"])
def test_a_study_of_which_nothing_is_there_yet_is_an_empty_figure(study, part):
    view = StabilityView(lambda *place: None)
    view.show(study, part, "dmm2")
    view.show(empty(study), part, "dmm2")
    drawn = view._made[part]
    for source in (drawn.cells, drawn.limits) if part == "map" else (drawn.curves,):
        assert all(len(column) == 0 for column in source.data.values())
    assert stability_text(empty(study), part) == "Nothing is computed yet."
    assert stability_tables(empty(study), part) == {}


# The map -------------------------------------------------------------------------------------------------------------


def test_cells_of_the_map_tile_the_range_and_lie_about_their_runs(study):
    view = StabilityView(lambda *place: None)
    view.show(study, "map", "rk2")
    data = view._made["map"].cells.data
    assert len(data["left"]) == 6 * 5
    area = np.log(np.array(data["right"]) / data["left"]) * (np.array(data["top"]) - data["bottom"])
    whole = np.log(max(data["right"]) / min(data["left"])) * (max(data["top"]) - min(data["bottom"]))
    assert area.sum() == pytest.approx(whole)
    for left, right, tau in zip(data["left"], data["right"], data["tau"], strict=True):
        assert left * 0.99 < float(tau) < right * 1.01


@pytest.mark.parametrize("computed", [[0], [0, 4], [1, 2, 4]])
def test_the_starts_computed_so_far_fill_the_range(study, computed):
    there = np.isin(np.arange(5), computed)
    view = StabilityView(lambda *place: None)
    view.show(replace(study, map=replace(study.map, outcome=np.where(there, study.map.outcome, NOT_YET))), "map", "rk2")
    drawn = view._made["map"]
    data, low, high = drawn.cells.data, *drawn.corners.data["y"]
    assert len(data["left"]) == 6 * len(computed)
    bottom, top = (np.unique(data[name]) for name in ("bottom", "top"))
    assert (bottom[0], top[-1]) == (low, high)
    assert np.array_equal(bottom[1:], top[:-1])
    assert (bottom <= study.map.values[computed]).all()
    assert (study.map.values[computed] <= top).all()


def test_cells_have_the_colour_and_the_words_of_their_outcome(study):
    view, found = StabilityView(lambda *place: None), study.map
    view.show(study, "map", "rk2")
    data = view._made["map"].cells.data
    row, column = np.nonzero(found.outcome[1] != NOT_YET)
    for n, (i, j) in enumerate(zip(row, column, strict=True)):
        good = found.works[1, i, j]
        whole = found.expected[j] == core.Status.COMPLETED
        code = (core.Status.COMPLETED if whole else LIKEWISE) if good else found.outcome[1, i, j]
        assert data["colour"][n] == OUTCOMES[code].colour
        assert (data["words"][n] == "correct sequence of crossings") == (good and whole)
    assert len(set(data["colour"])) == len(set(data["words"])) > 1


def test_a_solution_that_runs_away_is_no_failure_of_the_run_that_does_too(study):
    view, found = StabilityView(lambda *place: None), study.map
    gone = np.flatnonzero(found.expected == core.Status.ESCAPED)
    assert len(gone)
    view.show(study, "map", "dmm2")
    assert found.outcome[0, 0, gone[0]] == core.Status.ESCAPED
    assert view._made["map"].cells.data["words"][gone[0]] == "ends early, as the solution does"


def lasting(found, k):
    return found.works[k] | np.isin(found.outcome[k], (core.Status.COMPLETED, WRONG_CROSSINGS, WENT_ON))


def test_the_error_map_has_a_colour_bar_and_the_outcome_map_a_legend(study):
    view = StabilityView(lambda *place: None)
    values = int((np.isfinite(study.map.error[0]) & lasting(study.map, 0)).sum())
    for what, heat, cells in (("error", values, 0), ("outcome", 0, 30)):
        view.show(study, "map", "dmm2", what)
        drawn = view._made["map"]
        assert len(drawn.heat.data["left"]) == heat
        assert len(drawn.cells.data["left"]) == cells
        assert drawn.bar.visible == (what == "error")
        assert [item.visible for item in drawn.figure.legend[0].items[:2]] == [what == "outcome", what == "error"]


def test_cells_without_a_value_are_grey_and_the_legend_says_why(study):
    view = StabilityView(lambda *place: None)
    for error, visible in ((study.map.error, True), (np.zeros_like(study.map.error), False)):
        view.show(replace(study, map=replace(study.map, error=error)), "map", "rk2", "error")
        drawn = view._made["map"]
        assert len(drawn.blank.data["left"]) == (np.isnan(error[1]) & lasting(study.map, 1)).sum()
        entry = drawn.figure.legend[0].items[1]
        assert (entry.visible, entry.label["value"]) == (visible, NO_VALUE)


def test_the_error_map_shows_runs_that_end_early_as_they_end_and_not_by_their_small_error(study):
    outcome = study.map.outcome.copy()
    outcome[0, :, 1] = core.Status.NO_CONVERGENCE
    error = np.full_like(study.map.error, 1e-16)
    found = replace(study.map, outcome=outcome, error=error)
    view = StabilityView(lambda *place: None)
    view.show(replace(study, map=found), "map", "dmm2", "error")
    drawn = view._made["map"]
    ended, of_scale = drawn.ended.data, drawn.heat.data
    there = ended["words"] == OUTCOMES[core.Status.NO_CONVERGENCE].words
    value = printed(f"{study.map.values[1]:.4g}")
    assert set(ended["value"][there]) == {value}
    assert there.sum() == len(study.map.taus)
    assert set(ended["colour"][there]) == {OUTCOMES[core.Status.NO_CONVERGENCE].colour}
    assert value not in of_scale["value"]
    assert len(of_scale["left"]) + len(ended["left"]) == 30
    assert drawn.figure.legend[0].items[2].visible
    view.show(replace(study, map=found), "map", "dmm2", "outcome")
    assert len(drawn.ended.data["left"]) == 0
    assert not drawn.figure.legend[0].items[2].visible


def test_a_reference_that_gives_up_has_a_colour_of_its_own(study):
    expected = study.map.expected.copy()
    expected[2] = core.Status.STEP_LIMIT
    view = StabilityView(lambda *place: None)
    view.show(replace(study, map=replace(study.map, expected=expected)), "map", "dmm2")
    data = view._made["map"].cells.data
    row = data["value"] == printed(f"{study.map.values[2]:.4g}")
    assert set(data["words"][row]) == {OUTCOMES[UNJUDGED].words}
    assert set(data["colour"][row]) == {OUTCOMES[UNJUDGED].colour}
    assert OUTCOMES[UNJUDGED].words not in data["words"][~row]


def test_a_click_on_the_map_chooses_its_place_and_a_cross_marks_the_present_one(study):
    chosen = []
    view = StabilityView(lambda *place: chosen.append(place))
    view.show(study, "map", "dmm2")
    view.mark(0.1, -1.2)
    plot = view.figure("map")
    (heard,) = plot._event_callbacks["tap"]
    heard(Tap(plot, sx=1, sy=1, x=0.25, y=-1.0))
    assert chosen == [(0.25, -1.0)]
    assert (view._made["map"].place.data["x"], view._made["map"].place.data["y"]) == ([0.1], [-1.2])


def test_heights_of_the_error_map_are_the_errors_raised_to_the_floor(study):
    view = StabilityView(lambda *place: None)
    view.show(study, "map", "rk2", "error")
    shown, errors = np.array(view._made["map"].heat.data["height"]), study.map.error[1][lasting(study.map, 1)]
    known = errors[np.isfinite(errors)]
    assert len(shown) == len(known)
    assert np.allclose(shown[known > 1e-12], known[known > 1e-12], rtol=1e-15)


def test_the_largest_step_size_of_the_integrator_of_a_map_is_marked_at_its_start(study):
    view = StabilityView(lambda *place: None)
    for k, name in enumerate(METHODS):
        view.show(study, "map", name)
        data = view._made["map"].limits.data
        assert (list(data["x"]), list(data["y"])) == ([study.largest_tau.tau[k]], [study.x0[study.coordinate]])


def test_no_label_covers_cells_of_the_map_as_the_legend_names_its_marks(study):
    view = StabilityView(lambda *place: None)
    drawn = view.figure("map")
    view.show(study, "map", "dmm2")
    assert not any(isinstance(renderer.glyph, Text) for renderer in drawn.renderers)
    assert drawn.legend.items[3].label == value("largest successful τ")
    assert drawn.legend.items[3].visible


def test_the_cross_has_an_entry_in_the_legend_once_it_is_there(study):
    view = StabilityView(lambda *place: None)
    entry = view.figure("map").legend.items[4]
    assert not entry.visible
    view.mark(0.1, -1.0)
    assert entry.visible
    assert entry.label.value == "chosen τ and start"


def test_every_outcome_has_words_and_different_words_differ_in_colour():
    never = (core.Status.RUNNING, core.Status.CANCELLED, core.Status.EVENT, core.Status.EVENT_LIMIT)
    codes = [s for s in core.Status if s not in never]  # a study asks for no events
    assert {*codes, WRONG_CROSSINGS, WENT_ON, NO_START, UNJUDGED, LIKEWISE} == set(OUTCOMES)
    limits = (core.Status.STEP_LIMIT, core.Status.CROSSING_LIMIT)
    colours = [outcome.colour for code, outcome in OUTCOMES.items() if code not in limits[1:]]
    assert len(set(colours)) == len(colours)


def test_in_grey_the_correct_runs_are_lighter_than_all_that_fail():
    def grey(colour):
        return sum(share * int(colour[k : k + 2], 16) for share, k in ((0.299, 1), (0.587, 3), (0.114, 5)))

    correct, unjudged = grey(OUTCOMES[core.Status.COMPLETED].colour), OUTCOMES[UNJUDGED]
    fails = [one for code, one in OUTCOMES.items() if code not in (core.Status.COMPLETED, LIKEWISE, UNJUDGED)]
    assert all(correct - grey(one.colour) > 60 for one in fails)
    assert all(correct - 20 > grey(OUTCOMES[LIKEWISE].colour) > grey(one.colour) + 30 for one in fails)
    assert [one for one in OUTCOMES.values() if grey(one.colour) > correct] == [unjudged]


# Drift and tangency --------------------------------------------------------------------------------------------------


def test_drift_is_a_curve_for_each_integrator(study):
    view = StabilityView(lambda *place: None)
    view.show(study, "drift", "dmm2")
    data = view._made["drift"].curves.data
    assert data["method"] == list(METHODS)
    assert np.allclose(data["ys"][1], study.drift.error[1])
    assert np.min(data["ys"][0]) >= FLOOR


def test_a_run_that_stops_is_marked_where_it_does(study):
    error = study.drift.error.copy()
    error[1, 10:] = np.nan
    stopped = replace(study.drift, error=error, message=("", "t = 5: it <stops>"))
    view = StabilityView(lambda *place: None)
    view.show(replace(study, drift=stopped), "drift", "dmm2")
    stops = view._made["drift"].stops.data
    assert stops["x"] == [stopped.t[9]]
    assert stops["method"] == ["rk2"]
    assert stops["message"] == ["t = 5: it <stops>"]


def test_rings_mark_the_runs_with_a_wrong_number_of_crossings(study):
    view, grazing = StabilityView(lambda *place: None), study.grazing
    view.show(study, "grazing", "dmm2")
    drawn = view._made["grazing"]
    assert grazing.found
    assert len(drawn.wrong.data["x"]) == np.count_nonzero(grazing.missed) > 0
    assert [len(source.data["x"]) for source in drawn.points] == [2 * 14, 2 * 14]
    assert len(drawn.curves.data["xs"]) == 4
    assert "marker" not in drawn.curves.data, "in print each mark is a run, none tells an integrator"
    assert drawn._entries[0].label["value"].startswith("x < −1.55")


def test_without_a_conserved_quantity_and_without_a_tangency_there_are_words(without):
    view = StabilityView(lambda *place: None)
    view.show(without, "drift", "rk4")
    view.show(without, "grazing", "rk4")
    assert len(view._made["grazing"].curves.data["xs"]) == 0
    assert np.isnan(view._made["drift"].curves.data["ys"][0]).all()
    assert "No conserved quantity is known" in stability_text(without, "drift")
    assert "No tangency" in stability_text(without, "grazing")
    instants = replace(without, grazing=replace(without.grazing, instants=True))
    assert "There is no tangency: the law changes at instants only" in stability_text(instants, "grazing")


# Words and columns ---------------------------------------------------------------------------------------------------


def test_tables_of_the_map_tell_limits_and_shares(study):
    limits, shares = stability_numbers(study, "map", "rk2")
    largest = study.largest_tau
    for k, name in enumerate(METHODS):
        _, works, fails, reason = limits.rows[k]
        assert limits.rows[k][0] == name
        assert largest.tau[k] * 0.99 < float(works) <= largest.tau[k]
        assert largest.beyond[k] <= float(fails) < largest.beyond[k] * 1.01
        assert reason == largest.reason[k]
    assert shares.caption == "Map of rk2, 30 runs"
    share = dict(row[:2] for row in shares.rows)["correct sequence of crossings"]
    completed = study.map.expected == core.Status.COMPLETED
    assert share == f"{(study.map.works[1] & completed).mean():.0%}"
    assert "Taylor method at tolerance 1e-15" in stability_text(study, "map")


@pytest.mark.parametrize(
    ("system", "end", "told"),
    [
        ("elliptic_curve", 19.0, " to t = 19"),
        (
            "elliptic_curve",
            20.0,
            " to t = 20.07 (t = 20 is too close to a crossing)",
        ),
        (
            core.PiecewiseSystem(
                "Lorenz",
                ("x", "y", "z"),
                ("10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3 + 1"),
                ("10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3"),
                "x",
                x0=(1.0, 1.0, 20.0),
            ),
            70.0,
            ", from which rounding decides the crossings of the reference before t = 70: no run is judged",
        ),
        ("type_sliding", 20.0, ", from which the solution itself ends before t = 20: a run has to end likewise"),
    ],
)
def test_a_study_that_counts_crossings_to_another_time_than_the_end_says_why(system, end, told):
    found = core.stability_study(system, (0.0, end), methods=("rk2",), parts=("largest_tau",))
    assert stability_numbers(found, "map", "rk2")[0].caption.endswith(f"start{told}")


def test_a_map_of_solutions_that_end_early_says_so(study):
    ends = np.array([core.Status.ESCAPED, core.Status.ESCAPED, core.Status.SLIDING, NO_START, core.Status.COMPLETED])
    early = replace(study, map=replace(study.map, expected=ends))
    told = (
        "For 3 of the 5 initial states the solution itself ends (blow-up: 2, sliding: 1) before t = 20; a run that does"
    )
    assert told in map_text(early)
    gone = np.where(ends == core.Status.SLIDING, core.Status.ESCAPED, ends)
    blown = map_text(replace(study, map=replace(study.map, expected=gone)))
    assert "For 3 of the 5 initial states the solution itself blows up before t = 20; a run" in blown
    limited = np.where(ends == core.Status.ESCAPED, core.Status.STEP_LIMIT, core.Status.COMPLETED)
    given_up = map_text(replace(study, map=replace(study.map, expected=limited)))
    assert "For 2 of the 5 initial states the reference ends early (step limit: 2); these are not judged." in given_up
    assert "the solution itself" not in given_up
    chaotic = np.where(ends == NO_START, UNCERTAIN, core.Status.COMPLETED)
    lost = "For 1 of the 5 initial states rounding decides the crossings of the reference before t = 20; these are not"
    assert lost in map_text(replace(study, map=replace(study.map, expected=chaotic)))
    completed = replace(study, map=replace(study.map, expected=np.full(5, core.Status.COMPLETED)))
    assert "the solution itself" not in map_text(completed)


def test_starts_from_which_the_solution_meets_no_surface_are_counted():
    swings = core.stability_study(
        core.CATALOGUE["pendulum"], methods=("rk4",), taus=np.array([0.01, 0.1]), values=np.array([-1.0, -0.3, 0.2]),
        t_span=(0.0, 5.0), parts=("map",),
    )  # fmt: skip
    told = (
        "For 2 of the 3 initial states the solution has no crossings to t = 5, and a run without any counts as correct."
    )
    assert told in map_text(swings), "swings of less than 0.5 do not reach the surface q = 0.5"


def test_the_text_gives_the_grid_and_for_which_start_the_lines_hold(study):
    told = stability_text(study, "map")
    assert told.startswith("6 × 5 values: τ from ")
    assert f" (logarithmically spaced), initial {study.coordinate_name} from " in told
    assert ". “Largest successful τ” refers only to runs from the chosen start to t = " in told


def test_an_integrator_that_works_with_every_step_size_is_said_to_do_so_up_to_the_last_one(study):
    for last, told in ((0.5, "successful up to τ = 0.5"), (1.0, "successful up to τ = 1, the largest tried")):
        largest = replace(study.largest_tau, taus=np.array([0.1, last]), reason=("", ""))
        row = stability_numbers(replace(study, largest_tau=largest), "map", "rk2")[0].rows[0]
        assert row[3] == told
        assert row[1].startswith("≥ ")


def test_the_map_ends_at_the_outermost_runs(study):
    view = StabilityView(lambda *place: None)
    view.show(study, "map", "rk2")
    corners = view._made["map"].corners.data
    assert list(corners["x"]) == pytest.approx(study.map.taus[[0, -1]])
    assert list(corners["y"]) == list(study.map.values[[0, -1]])


def test_a_small_share_is_not_said_to_be_none(study):
    outcome = np.full((2, 25, 25), core.Status.COMPLETED)
    outcome[0, 0, 0] = WRONG_CROSSINGS
    found = replace(
        study.map, outcome=outcome, error=np.zeros((2, 25, 25)), expected=np.full(25, core.Status.COMPLETED)
    )
    _, shares = stability_numbers(replace(study, map=found), "map", "dmm2")
    assert [row[1] for row in shares.rows] == ["over 99%", "under 1%"]


def test_the_tangency_is_told_and_who_misses_it(study):
    assert "x = -1.5513915128" in stability_text(study, "grazing")
    (table,) = stability_numbers(study, "grazing", "dmm2")
    assert [row[0] for row in table.rows] == list(METHODS)
    assert table.rows[0][1:3] == ("0 of 14 distances", "–")
    wrong = study.grazing.missed[1].any(axis=0)
    assert table.rows[1][1:3] == (f"{wrong.sum()} of 14 distances", f"{study.grazing.delta[wrong].max():.0e}")


def test_nobody_is_judged_where_the_solution_stops(study):
    stopped = replace(study, grazing=replace(study.grazing, expected_met=np.full((2, 14, 4), -1)))
    assert {row[1] for row in stability_numbers(stopped, "grazing", "dmm2")[0].rows} == {"–"}
    assert "the reference ends early" in stability_text(stopped, "grazing")


def test_a_run_that_stops_above_the_plot_range_is_marked_at_the_top_in_these_words(study):
    error = study.drift.error.copy()
    named = {}
    for last in (1e-3, 1e16):
        error[1, 5], error[1, 6:] = last, np.nan
        view = StabilityView(lambda *place: None)
        view.show(replace(study, drift=replace(study.drift, error=error, message=("", "it stops"))), "drift", "dmm2")
        named[last] = view._made["drift"]._stopping.label["value"]
    assert named == {1e-3: "the run stops", 1e16: "the run stops (at the top: above plot range)"}


def test_drift_bounds_each_integrator(study):
    assert "20,000 steps of size τ = 0.02" in stability_text(study, "drift")
    (table,) = stability_numbers(study, "drift", "dmm2")
    assert [(row[0], row[3]) for row in table.rows] == [(name, "reaches the end") for name in METHODS]
    assert value_of(table.rows[1][1]) >= study.drift.error[1].max()


@pytest.mark.parametrize(("part", "rows"), [("largest_tau", 2), ("map", 60), ("drift", None), ("grazing", 56)])
def test_columns_are_of_one_length_and_hold_every_run(study, part, rows):
    table = stability_tables(study, part)[part]()
    lengths = {len(column) for column in table.values()}
    assert lengths == {rows or 2 * len(study.drift.t)}
    assert set(table["integrator"]) == set(METHODS)


def test_rows_of_the_map_are_its_cells(study):
    table = stability_tables(study, "map")["map"]()
    for n in (0, 17, 59):
        k = METHODS.index(table["integrator"][n])
        i, j = (
            int(np.argmin(np.abs(a - b[n])))
            for a, b in ((study.map.taus, table["tau"]), (study.map.values, table["x"]))
        )
        assert table["crossings"][n] == study.map.crossings[k, i, j]
        assert table["as_the_solution"][n] == study.map.works[k, i, j]


def test_captions_name_the_runs_of_a_part_and_when_these_end(study):
    """The long run has a time of its own, the map one integrator."""
    assert runs_drawn(study, "drift", "rk2") == (
        f"integrated by dmm2 and rk2 with step size τ = {study.drift.tau:.6g} to t = {20_000 * study.drift.tau:,.6g}"
    )
    assert runs_drawn(study, "map", "rk2").startswith("each cell is one run of rk2 to t = ")
    start = f"{study.coordinate_name} = {study.x0[study.coordinate]:.6g}".replace("-", "−")
    assert f"; the diamond is for {start} and runs to t = " in runs_drawn(study, "map", "rk2")
    limits = replace(study.largest_tau, beyond=np.array([np.nan, np.nan]))
    none = runs_drawn(replace(study, largest_tau=limits), "map", "rk2")
    assert "diamond" not in none, "all step sizes work: there is no limit to draw"
    assert runs_drawn(study, "grazing", "rk2") == "integrated by dmm2 and rk2"
