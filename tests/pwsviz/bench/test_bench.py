"""The benchmark: every section is there, its figures are right where they are no times, and heyoka may be missing."""

import io
import re
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import core
from pwsviz.bench import QUICK, report
from pwsviz.bench.clock import timed
from pwsviz.bench.curves import Curve, Point
from pwsviz.bench.drawn import drawn
from pwsviz.bench.families import drawn_problems
from pwsviz.bench.own import own_curve
from pwsviz.bench.problems import ENDS, problem_named
from pwsviz.bench.reference import reference_of
from pwsviz.bench.rivals import Comparison, comparison, ratio_lines
from pwsviz.bench.scipy_rivals import scipy_curves
from pwsviz.bench.tables import aligned, milliseconds

EPS = 2.0**-52
TINY = replace(QUICK, methods=("prk8",), share=0.02, repeats=1)


#: A fresh process with empty caches compiles everything: only the deep level waits for that.
NO_FIRST_CALLS = replace(QUICK, start_methods=(), larger=(), rival_budget=0.2)


@pytest.fixture(
    scope="module",
    params=[pytest.param(NO_FIRST_CALLS, id="warm"), pytest.param(QUICK, id="cold", marks=pytest.mark.deep)],
)
def quick(request) -> str:
    out = io.StringIO()
    report(out, request.param)
    return out.getvalue()


@pytest.fixture
def without_heyoka(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)  # importing it raises ImportError


def test_quick_prints_every_section_and_opens_it_with_a_sentence(quick):
    sections = [
        "Cost in proportion to steps", "Time to a state error", "Ratios", "Problems drawn", "Cost of a step",
        "First call", "Moved slider", "Conservation", "Drift", "Order of dmm2", "Orders across",
    ]  # fmt: skip
    places = [quick.index(f"\n{section}") for section in sections]
    assert places == sorted(places)


def test_versions_and_processor_stand_at_the_top(quick):
    first, second = quick.splitlines()[:2]
    for name in ("Python", "numpy", "numba", "scipy", "heyoka"):
        assert re.search(rf"{name} (\d|not installed)", first), name
    assert re.search(r"\d+ cores", second)


def test_every_method_and_rival_has_a_row(quick):
    table = quick[quick.index("Time to") : quick.index("Ratios")]
    for name in (*QUICK.methods, "heyoka", "SciPy DOP853, events", "SciPy LSODA, events", "SciPy DOP853, if"):
        assert re.search(rf"^  {name}  ", table, re.MULTILINE), name


def test_ratios_to_scipy_are_stated_for_each_error(quick):
    table = quick[quick.index("Ratios") : quick.index("Cost of a step")]
    for error in ("1e-03", "1e-06", "1e-09", "1e-12"):
        assert re.search(rf"elliptic_curve +{error} .*SciPy \w+.* [\d.e-]+ +(met|missed)$", table, re.MULTILINE), error


def test_drawn_problems_are_the_same_for_the_same_seed_and_cross_five_hundred_times():
    first, again = (list(drawn_problems(3, 7)) for _ in range(2))
    assert first == again
    for problem in first:
        run = core.integrate(problem.system, (0.0, problem.end), method="taylor", record="end")
        assert (run.status, run.crossing_count) == (core.Status.COMPLETED, 500), problem


def test_without_heyoka_nothing_is_drawn(without_heyoka):
    assert "not installed" in "\n".join(drawn(TINY))


def test_without_heyoka_its_column_says_so(without_heyoka):
    text = "\n".join(comparison(TINY))
    assert re.search(r"^  heyoka +not installed", text, re.MULTILINE)
    ratios = text[text.index("Ratios") :]
    assert ratios.count("not installed") == 4
    assert re.search(r"SciPy \w+.* [\d.e-]+ +(met|missed)$", ratios, re.MULTILINE)


def test_without_heyoka_the_reference_is_still_there(without_heyoka):
    assert reference_of(problem_named("elliptic_curve", 0.02)).crossings == 10


def test_without_a_closed_form_heyoka_in_extended_precision_is_the_reference(monkeypatch):
    hy = pytest.importorskip("heyoka")
    if not hasattr(hy, "taylor_adaptive_ldbl"):
        pytest.skip("heyoka has no extended precision here")
    problem = problem_named("pendulum", 0.02)
    exact = reference_of(problem)
    monkeypatch.setattr(core, "reference_solution", lambda system: SimpleNamespace(name="SciPy"))
    other = reference_of(problem)
    assert exact.name.startswith("exact")
    assert other.name.startswith("heyoka in extended precision")
    assert other.crossings == exact.crossings
    assert np.abs(other.state - exact.state).max() < 20 * EPS  # each is rounded once; the exact one sums ten arcs


@pytest.mark.parametrize("name", ENDS)
def test_the_end_is_after_some_500_crossings(name):
    run = core.integrate(core.CATALOGUE[name], (0.0, ENDS[name]), method="taylor", record="end")
    assert run.status is core.Status.COMPLETED
    assert 480 <= run.crossing_count <= 520


def test_scipy_restarted_at_events_finds_the_crossings_and_the_state():
    problem = problem_named("elliptic_curve", 0.02)
    exact = reference_of(problem)
    events, _, blind = scipy_curves(problem, exact.state, exact.crossings, replace(QUICK, rival_budget=10.0))
    assert all(point.crossings == exact.crossings for point in events.points)
    assert events.finest.error < 1e-11  # tolerance 2.3e-14, over ten restarts
    assert blind.finest.error < 1e-6  # its order is lost at the surface


def test_heyoka_with_one_event_finds_the_crossings_and_the_state():
    pytest.importorskip("heyoka")
    from pwsviz.bench.heyoka_rival import heyoka_curves

    problem = problem_named("elliptic_curve", 0.02)
    exact = reference_of(problem)
    for curve in heyoka_curves(problem, exact.state, exact.crossings, QUICK):
        assert curve.finest.crossings == exact.crossings == 10
        assert curve.finest.error < 1e-13  # ten crossings, some eps each


def test_our_end_states_converge_to_the_reference():
    problem = problem_named("elliptic_curve", 0.02)
    exact = reference_of(problem)
    curve = own_curve(problem, core.METHODS["prk8"], exact.state, exact.crossings, TINY)
    assert curve.finest.error < 1e-12
    assert all(point.crossings == 10 for point in curve.points)


def test_a_problem_whose_sides_differ_in_more_than_a_coefficient_is_refused():
    from pwsviz.bench.problems import Problem

    with pytest.raises(ValueError, match="differ in more than"):
        _ = Problem("type_upward", 1.0).field


def curve(*points: tuple[float, float], name: str = "some method") -> Curve:
    return Curve(name, [Point(0.0, error, seconds, seconds / 2) for error, seconds in points], 0.0)


def test_time_to_an_error_is_interpolated_between_logarithms():
    wall, loop = curve((1e-2, 1.0), (1e-4, 4.0)).reach(1e-3)
    assert wall == pytest.approx(2.0)
    assert loop == pytest.approx(1.0)


def test_an_error_that_is_not_reached_has_no_time():
    assert curve((1e-2, 1.0), (1e-4, 4.0)).reach(1e-5) == (None, None)
    assert curve((np.inf, 1.0)).reach(1e-3) == (None, None)


def test_a_small_error_by_luck_does_not_count():
    wall, _ = curve((1e-8, 1.0), (1e-2, 2.0), (1e-4, 8.0), (1e-9, 9.0)).reach(1e-3)
    assert wall == pytest.approx(4.0)


def test_a_finer_setting_that_is_faster_takes_precedence():
    wall, _ = curve((1e-4, 3.0), (1e-6, 2.0)).reach(1e-3)
    assert wall == 2.0


def test_ratios_compare_the_fastest_of_each_kind_by_the_aims():
    errors = [1e-2, 1e-13]
    own = [curve(*((e, 1.0) for e in errors)), curve(*((e, 0.6) for e in errors), name="fast")]
    one = Comparison("s", own, [curve(*((e, 1.0) for e in errors))], [curve(*((e, 50.0) for e in errors))])
    rows = [line.split() for line in ratio_lines([one]) if line.startswith("  s ")]
    assert [row[3] for row in rows] == ["fast"] * 4
    assert [row[row.index("0.60") + 1] for row in rows] == ["missed", "missed", "missed", "met"]
    assert [row[-2:] for row in rows] == [["0.012", "missed"]] * 4


def test_a_rival_that_does_not_get_there_bounds_the_ratio():
    own, rival = [curve((1e-2, 1.0), (1e-13, 1.0))], [curve((1e-2, 100.0), (1e-5, 400.0))]
    rows = [line.split() for line in ratio_lines([Comparison("s", own, own, rival)]) if line.startswith("  s ")]
    assert [row[-3:] for row in rows[2:]] == [["<", "0.0025", "met"]] * 2


def test_clock_throws_the_warm_up_away_and_prepares_every_call():
    calls: list[str] = []
    runs = timed(lambda: calls.append("run"), 3, 10.0, before=lambda: calls.append("reset"))
    assert len(runs) == 3
    assert calls == ["reset", "run"] * 4


def test_tables_are_aligned_and_times_have_three_digits():
    lines = list(aligned(("name", "ms"), [("a", "1.25"), ("longer", "12")]))
    assert lines == ["  name       ms", "  a        1.25", "  longer     12"]
    assert [milliseconds(s) for s in (None, 1e-4, 1.234e-3, 0.5)] == ["-", "0.100", "1.23", "500"]


def test_quick_and_long_exclude_each_other():
    command = [sys.executable, "-m", "pwsviz", "bench", "--quick", "--long"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "not allowed with" in done.stderr
