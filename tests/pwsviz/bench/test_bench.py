"""The benchmark: every section is there, its figures are right where they are no times, and heyoka may be missing."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import core
from pwsviz.bench import QUICK, Table, sections
from pwsviz.bench.comparison import drawn, named, time_to_error
from pwsviz.bench.costs import first_calls
from pwsviz.bench.heyoka import HeyokaBatches, HeyokaByRegion, HeyokaEnsemble, HeyokaRun
from pwsviz.bench.machine import machine_lines
from pwsviz.bench.prange import ends_by_prange
from pwsviz.bench.problems import ENDS, Problem, drawn_problems, named_problem
from pwsviz.bench.table import milliseconds

TINY = replace(QUICK, share=0.02, repeats=1)


#: A fresh process with empty caches compiles everything: only the deep level waits for that.
NO_FIRST_CALLS = replace(QUICK, first_calls=(), budget=0.2)


@pytest.fixture(scope="module")
def quick() -> dict[str, Table]:
    return {table.title: table for table in sections(NO_FIRST_CALLS)}


@pytest.fixture
def without_heyoka(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)  # as if it was not installed


def test_every_section_has_figures(quick):
    assert list(quick) == [
        "Time to a state error", "Problems drawn at random", "Ensembles", "Cost of a step", "Cost of a call",
        "First call", "Moved slider", "Conservation", "Drift", "Orders",
    ]  # fmt: skip
    for title, table in quick.items():
        assert table.rows or title in ("Problems drawn at random", "First call")
        assert {len(row) for row in table.rows} <= {len(table.header)}, title


def test_versions_and_processor_are_told():
    first, second = machine_lines()
    for name in ("Python", "numpy", "numba", "scipy", "heyoka"):
        assert f"{name} " in first
    assert " cores" in second


def test_times_of_ours_and_of_scipy_are_stated_for_each_error(quick):
    columns = quick["Time to a state error"].columns
    assert list(columns["error"]) == ["1e-03", "1e-06", "1e-09", "1e-12"]
    for name in ("taylor", "SciPy", "/ SciPy"):
        assert all(float(cell) > 0.0 for cell in columns[name]), name


def test_orders_and_conserved_quantities_are_those_of_the_methods(quick):
    orders = quick["Orders"].columns
    for method, slopes in zip(orders["method"], orders["crossing time"], strict=True):
        wanted = core.METHODS[method].order
        assert all(abs(float(slope) - wanted) < (0.3 if method != "rk8" else 3.0) for slope in slopes.split()), method
    assert all(float(cell) < 4e-15 for cell in quick["Conservation"].columns["side +1"])
    assert all(float(cell) < 4e-15 for cell in quick["Drift"].columns["end"])


def test_drawn_problems_are_the_same_for_the_same_seed_and_cross_five_hundred_times():
    first, again = (list(drawn_problems(3, 7)) for _ in range(2))
    assert first == again
    for problem in first:
        run = core.integrate(problem.system, (0.0, problem.end), method="taylor", record="end")
        assert (run.status, run.crossing_count) == (core.Status.COMPLETED, 500), problem


def test_without_heyoka_its_columns_are_empty_and_nothing_is_drawn(without_heyoka):
    assert drawn(TINY).rows == []
    columns = named(TINY).columns
    assert set(columns["heyoka"]) == set(columns["/ fast_math"]) == {""}
    assert "" not in columns["/ SciPy"]


@pytest.mark.parametrize("name", ENDS)
def test_the_end_is_after_some_500_crossings(name):
    problem = named_problem(name)
    run = core.integrate(problem.system, (0.0, problem.end), method="taylor", record="end")
    assert run.status is core.Status.COMPLETED
    assert 480 <= run.crossing_count <= 520


def test_heyoka_with_one_event_finds_the_state():
    pytest.importorskip("heyoka")
    problem = Problem("elliptic_curve", core.CATALOGUE["elliptic_curve"], 0.02 * ENDS["elliptic_curve"])
    other = HeyokaRun(problem, 2.0**-52)
    for _ in range(2):
        other.reset()
        other.run()
        exact = core.reference_solution(problem.system).state(problem.end)
        assert np.abs(other.state - exact).max() < 1e-13  # ten crossings, some eps each


def test_an_ensemble_of_heyoka_comes_to_the_same_states():
    pytest.importorskip("heyoka")
    problem = named_problem("elliptic_curve")
    x0 = np.array(problem.system.x0) + np.array([[0.0, 0.0], [0.02, 0.01], [-0.03, 0.02]])
    exact = [core.reference_solution(problem.system, tuple(x)).state(20.0) for x in x0]
    assert np.abs(HeyokaEnsemble(problem, 1e-14).ends(x0, 20.0) - exact).max() < 1e-11
    assert np.abs(HeyokaBatches(problem, 1e-14).ends(x0, 20.0) - exact).max() < 1e-11


@pytest.mark.deep
def test_a_prange_over_the_time_loop_brings_members_where_an_ensemble_brings_them():
    system = core.CATALOGUE["elliptic_curve"]
    x0 = np.array(system.x0) + np.random.default_rng(0).uniform(-0.05, 0.05, (100, 2))
    there = core.ensemble(system, (0.0, 20.0), x0, method="taylor", tolerance=1e-9).x
    assert (ends_by_prange(system, x0, 1e-9, 20.0) == there).all()


def test_a_problem_whose_sides_differ_in_more_than_a_coefficient_is_refused():
    with pytest.raises(ValueError, match="differ in more than"):
        _ = Problem("type_upward", core.CATALOGUE["type_upward"], 1.0).field


def reached(*points: tuple[float, float], target: float = 1e-3) -> float:
    errors, seconds = np.array(points).T
    return float(time_to_error(errors, seconds, [target])[0])


def test_time_to_an_error_is_interpolated_between_logarithms():
    assert reached((1e-2, 1.0), (1e-4, 4.0)) == pytest.approx(2.0)


def test_an_error_that_is_not_reached_has_no_time():
    assert np.isnan(reached((1e-2, 1.0), (1e-4, 4.0), target=1e-5))
    assert np.isnan(reached((np.nan, 1.0)))


def test_a_small_error_by_luck_does_not_count():
    assert reached((1e-8, 1.0), (1e-2, 2.0), (1e-4, 8.0), (1e-9, 9.0)) == pytest.approx(4.0)


def test_a_finer_setting_that_is_faster_takes_precedence():
    assert reached((1e-4, 3.0), (1e-6, 2.0)) == pytest.approx(2.0)


def test_tables_are_aligned_and_times_have_three_digits():
    table = Table("Title", "what it is", ("name", "ms"), [("a", "1.25"), ("longer", "12")])
    assert table.text.splitlines() == ["Title: what it is", "  name       ms", "  a        1.25", "  longer     12"]
    assert [milliseconds(s) for s in (np.nan, 1e-4, 1.234e-3, 0.5)] == ["-", "0.100", "1.23", "500"]


def test_what_has_no_value_is_empty_in_a_column():
    table = Table("Title", "what it is", ("name", "ms"), [("a", "-"), ("b", "12")])
    assert {name: list(cells) for name, cells in table.columns.items()} == {"name": ["a", "b"], "ms": ["", "12"]}


def test_quick_and_long_exclude_each_other():
    command = [sys.executable, "-m", "pwsviz", "bench", "--quick", "--long"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "not allowed with" in done.stderr


def test_a_first_call_is_timed_in_two_processes_that_share_a_folder_which_is_empty_at_first(monkeypatch):
    """What they do is tested in tests/core/compilation; with empty caches it takes half a minute."""
    seen = []

    def run(command, env, **_):
        folder = Path(env["PWSVIZ_CACHE"])
        seen.append((folder, sorted(folder.iterdir()), command[-1]))
        (folder / "compiled").touch()
        return subprocess.CompletedProcess(command, 0, stdout=f"0.5 {5.0 - 4.0 * (len(seen) - 1)}\n")

    monkeypatch.setattr("pwsviz.bench.costs.subprocess.run", run)
    columns = first_calls(QUICK).columns
    assert [float(columns[name][0]) for name in ("import", "compiles", "loads")] == [0.5, 5.0, 1.0]
    (folder, before, method), (same, after, again) = seen
    assert folder == same
    assert (len(before), len(after)) == (0, 1)
    assert method == again == "dmm2"


def test_heyoka_changes_between_the_regions_of_chuas_circuit_as_we_do():
    pytest.importorskip("heyoka")
    problem = named_problem("chua", 0.1)
    other = HeyokaByRegion(problem, 2.0**-52)
    run = core.integrate(problem.system, (0.0, problem.end), method="taylor", record="end")
    for _ in range(2):
        other.reset()
        other.run()
        assert run.crossing_count > 40
        assert np.abs(other.state - run.x[-1]).max() < 1e-12
