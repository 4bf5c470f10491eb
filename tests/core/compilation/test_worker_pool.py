"""Processes that compile beside this one: what they make is there, and nothing waits for ever when they die."""

import os
import random
import time

import pytest

import core
from core.compilation import compiled
from core.compilation.worker_pool import WorkerPool

# Makes a file of the name it is given, with its own number in it.
PROGRAM = """
import os
from pathlib import Path
from core.compilation.worker_pool import serve

def make(text):
    print("a library that prints is not an answer")
    if text == "die":
        os._exit(1)
    Path(text).write_text(str(os.getpid()))

serve(make)
"""


@pytest.fixture
def pool():
    opened = WorkerPool(PROGRAM, {}, 2, idle=600.0)
    assert opened.ready.wait(60)
    yield opened
    opened.close()


def made(pool, *texts):
    submitted = [pool.submit(str(text)) for text in texts]
    return [made.result(60) if made else None for made in submitted]


def test_texts_are_made_by_another_process(pool, tmp_path):
    files = [tmp_path / str(k) for k in range(8)]
    assert made(pool, *files) == [True] * 8
    assert str(os.getpid()) not in {file.read_text() for file in files}


def test_what_cannot_be_made_is_told_and_the_rest_is_made(pool, tmp_path):
    assert made(pool, tmp_path / "no such folder" / "file", tmp_path / "other") == [False, True]
    assert (tmp_path / "other").exists()


@pytest.mark.deep
def test_one_that_dies_is_followed_by_another(pool, tmp_path):
    assert made(pool, "die") == [False]
    assert made(pool, "die", tmp_path / "file") == [False, True]
    assert made(pool, tmp_path / "other") == [True]


def test_before_anybody_is_ready_nothing_is_given_out(tmp_path):
    pool = WorkerPool(PROGRAM, {}, 1, idle=600.0)
    assert made(pool, tmp_path / "file") == [None]
    pool.close()
    assert not (tmp_path / "file").exists()


def test_a_program_that_fails_leaves_the_work_to_others(tmp_path, capfd):
    pool = WorkerPool("raise SystemExit(3)", {}, 1, idle=600.0)
    assert not pool.ready.wait(3)
    assert made(pool, tmp_path / "file") == [None]
    pool.close()


@pytest.mark.deep
def test_after_a_rest_they_end(tmp_path):
    pool = WorkerPool(PROGRAM, {}, 1, idle=0.5)
    pool.ready.wait(60)
    deadline = time.monotonic() + 30
    while not pool._free.empty() or not pool.closed:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert made(pool, tmp_path / "file") == [None]
    assert not (tmp_path / "file").exists()


def test_a_run_loads_what_was_compiled_beside_it(monkeypatch):
    monkeypatch.setattr(compiled, "_pool", None)
    core.compile_beside()
    pool = compiled._pool
    assert pool.ready.wait(60)
    new = random.SystemRandom().random()  # never compiled before, whatever the cache holds
    system = core.PiecewiseSystem("new", ("x", "y"), ("y", f"-{new}*x"), ("y", "-x"), "y - 1/4", x0=(1.0, 1.0))
    modules = compiled.compile_run(system.laws, core.METHODS["rk4"]).modules
    steps = [module.step for module in modules if hasattr(module, "step")]
    assert [step.cache_hits for step in steps] == [1, 1]
    core.compile_beside()
    assert compiled._pool is pool
    pool.close()
    core.compile_beside()
    assert compiled._pool is not pool
    compiled._pool.close()
