"""Compiled functions: kept, shared, and never recompiled when a slider moves."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import core
from core.compilation import compiled
from core.integration import beginning
from core.integration.time_loop import compiled_march
from core.interface import being_compiled, compiling
from core.kernels.abi import STEP
from tests.levels import QUICK_METHODS

ELLIPTIC = core.CATALOGUE["elliptic_curve"]

_SECOND_PROCESS = """
import core, numba
from core.integration.time_loop import compiled_march
run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 5.0))
modules = core.compilation.compiled.compile_run(core.CATALOGUE["elliptic_curve"].laws, core.METHODS["dmm2"]).modules
steps = [module.step for module in modules if hasattr(module, "step")]
print(sum(compiled_march().stats.cache_hits.values()), sum(compiled_march().stats.cache_misses.values()))
for step in steps:
    print(step.cache_hits, 1 - step.cache_hits)
"""


def test_changing_parameters_compiles_nothing():
    core.integrate(ELLIPTIC, (0.0, 1.0))
    before = compiled.compile_run.cache_info().misses
    for a in np.linspace(-3, -1, 5):
        core.integrate(ELLIPTIC.with_parameters(a_plus=a, radius=1 + a / 10), (0.0, 1.0), tau=0.01 - a / 1000)
    assert compiled.compile_run.cache_info().misses == before


@pytest.mark.parametrize("methods", [QUICK_METHODS, pytest.param(core.METHODS, marks=pytest.mark.deep)], ids=len)
def test_one_loop_serves_every_system_and_method(methods):
    for name in ("harmonic_oscillator", "rigid_body"):
        system = core.CATALOGUE[name]
        for method in methods:
            core.integrate(system, (0.0, 1.0), method=method)
    assert len(compiled_march().signatures) == 1


def test_a_second_process_loads_instead_of_compiling():
    core.integrate(ELLIPTIC, (0.0, 5.0))
    command = [sys.executable, "-c", _SECOND_PROCESS]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    assert told == ["1", "0"] * 3, "hits and misses of the caches of the loop and of both sides' steps"


def test_only_a_run_with_events_waits_for_the_loop_that_locates_them(monkeypatch):
    asked = []
    monkeypatch.setattr(beginning, "compiled_march", lambda watching: asked.append(watching) or compiled_march())
    system = core.PiecewiseSystem("own", ("x", "y"), ("y", "-1.25*x"), ("y", "-x"), "y")
    core.integrate(system, (0.0, 1.0))
    assert asked == [False]
    core.integrate(system, (0.0, 1.0), events=core.Event("x", 1))
    assert asked == [False, True]
    assert compiled_march() is compiled_march(False) is not compiled_march(True)


def test_the_two_time_loops_have_different_names():
    names = {compiled_march(watching).py_func.__qualname__ for watching in (False, True)}
    assert len(names) == 2, "of one name, compiled by different processes and loaded from the cache, both are the first"


def test_what_is_being_compiled_is_told_while_it_is():
    names = []
    with compiling("the time loop"), compiling("rk2"):
        names.append(being_compiled())
    assert [*names, being_compiled()] == ["the time loop", ""]


def test_sides_of_the_same_law_are_compiled_once():
    system = core.PiecewiseSystem("same", ("x", "y"), ("y", "-x"), ("y", "-x"), "y")
    addresses = compiled.compile_run(system.laws, core.METHODS["rk2"]).addresses
    assert addresses[0, STEP] == addresses[1, STEP]


def test_a_tampered_cache_file_is_not_run(tmp_path, monkeypatch):
    monkeypatch.setenv("PWSVIZ_CACHE", str(tmp_path))
    compiled._folder.cache_clear()
    text = "VALUE = 1\n"
    assert compiled._load(text).VALUE == 1
    (path,) = tmp_path.glob("pws_*.py")
    path.write_text("VALUE = 2\n")
    compiled._load.cache_clear()
    assert compiled._load(text).VALUE == 1
    compiled._folder.cache_clear()


def test_one_who_looks_through_the_modules_meanwhile_finds_none_gone_and_in_the_long_run_few_stay():
    loaded = []
    for number in range(2 * compiled.MAX_REGISTERED):
        before = set(sys.modules)
        loaded.append(compiled._load(f"NUMBER = {number}\n").__name__)
        assert loaded[-1] in set(sys.modules) - before
    assert [name for name in loaded if name in sys.modules] == loaded[-compiled.MAX_REGISTERED :]


def test_a_folder_that_others_may_write_to_is_not_used(tmp_path, monkeypatch):
    tmp_path.chmod(0o777)
    monkeypatch.setenv("PWSVIZ_CACHE", str(tmp_path))
    compiled._folder.cache_clear()
    assert compiled._folder() != tmp_path
    compiled._folder.cache_clear()


def test_the_cache_on_disk_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "MAX_FILES", 3)
    for k in range(6):
        path = tmp_path / f"pws_{k}.py"
        path.write_text("")
        os.utime(path, (k, k))
    compiled._prune(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["pws_3.py", "pws_4.py", "pws_5.py"]


def test_a_cache_that_two_processes_prune_at_once_is_still_pruned(tmp_path, monkeypatch):
    for age in range(5):
        path = tmp_path / f"pws_{age}.py"
        path.touch()
        os.utime(path, (1e9 - age, 1e9 - age))

    def listed_with_one_dropped_meanwhile(_folder, pattern):
        return [*glob(tmp_path, pattern), *([tmp_path / "pws_gone.py"] if pattern == "pws_*.py" else [])]

    glob = type(tmp_path).glob
    monkeypatch.setattr(type(tmp_path), "glob", listed_with_one_dropped_meanwhile)
    monkeypatch.setattr(compiled, "MAX_FILES", 2)
    compiled._prune(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pws_0.py", "pws_1.py"]


def test_a_module_that_another_process_prunes_before_it_is_imported_is_written_anew(tmp_path, monkeypatch):
    lost = iter([True, True, False])

    def pruned_at_first(path):
        if next(lost):
            path.unlink()
        return imported(path)

    imported = compiled._import
    monkeypatch.setattr(compiled, "_folder", lambda: tmp_path)
    monkeypatch.setattr(compiled, "_import", pruned_at_first)
    assert compiled._load.__wrapped__("answer = 42\n").answer == 42
    assert next(lost, None) is None


def test_a_module_in_use_is_the_last_to_be_pruned(tmp_path):
    path = tmp_path / "pws_a.py"
    assert not compiled._touch_if_current(path, "x = 1")
    path.write_text("x = 1")
    os.utime(path, (1, 1))
    assert compiled._touch_if_current(path, "x = 1")
    assert compiled._last_used(path) > 1e9
    assert not compiled._touch_if_current(path, "x = 2")


def test_workers_import_the_core_that_runs_here(monkeypatch):
    asked = []
    monkeypatch.setattr(compiled, "_pool", None)
    monkeypatch.setattr(compiled, "WorkerPool", lambda *given: asked.append(given))
    compiled.compile_beside(1)
    root = Path(asked[0][1]["PYTHONPATH"].split(os.pathsep)[0])
    assert (root / "core" / "compilation" / "compiled.py").samefile(compiled.__file__)
