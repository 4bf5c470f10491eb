"""Processes that compile beside this one: what they make is there, and nothing waits for ever when they die."""

import os
import random
import time

import pytest

import core
from core.compilation import compiled
from core.compilation.worker_pool import Workshop

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
def workshop():
    opened = Workshop(PROGRAM, {}, 2, idle=600.0)
    assert opened.ready.wait(60)
    yield opened
    opened.close()


def made(workshop, *texts):
    given_out = [workshop.begin(str(text)) for text in texts]
    return [made.result(60) if made else None for made in given_out]


def test_texts_are_made_by_another_process(workshop, tmp_path):
    files = [tmp_path / str(k) for k in range(8)]
    assert made(workshop, *files) == [True] * 8
    assert str(os.getpid()) not in {file.read_text() for file in files}


def test_what_cannot_be_made_is_told_and_the_rest_is_made(workshop, tmp_path):
    assert made(workshop, tmp_path / "no such folder" / "file", tmp_path / "other") == [False, True]
    assert (tmp_path / "other").exists()


@pytest.mark.deep
def test_one_that_dies_is_followed_by_another(workshop, tmp_path):
    assert made(workshop, "die") == [False]
    assert made(workshop, "die", tmp_path / "file") == [False, True]
    assert made(workshop, tmp_path / "other") == [True]


def test_before_anybody_is_ready_nothing_is_given_out(tmp_path):
    workshop = Workshop(PROGRAM, {}, 1, idle=600.0)
    assert made(workshop, tmp_path / "file") == [None]
    workshop.close()
    assert not (tmp_path / "file").exists()


def test_a_program_that_fails_leaves_the_work_to_others(tmp_path, capfd):
    workshop = Workshop("raise SystemExit(3)", {}, 1, idle=600.0)
    assert not workshop.ready.wait(3)
    assert made(workshop, tmp_path / "file") == [None]
    workshop.close()


@pytest.mark.deep
def test_after_a_rest_they_end(tmp_path):
    workshop = Workshop(PROGRAM, {}, 1, idle=0.5)
    workshop.ready.wait(60)
    deadline = time.monotonic() + 30
    while not workshop._free.empty() or not workshop.closed:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert made(workshop, tmp_path / "file") == [None]
    assert not (tmp_path / "file").exists()


def test_a_run_loads_what_was_compiled_beside_it(monkeypatch):
    monkeypatch.setattr(compiled, "_workshop", None)
    core.compile_beside()
    workshop = compiled._workshop
    assert workshop.ready.wait(60)
    new = random.SystemRandom().random()  # never compiled before, whatever the cache holds
    system = core.PiecewiseSystem("new", ("x", "y"), ("y", f"-{new}*x"), ("y", "-x"), "y - 1/4", x0=(1.0, 1.0))
    modules = compiled.compile_run(system.laws, core.METHODS["rk4"]).modules
    steps = [module.step for module in modules if hasattr(module, "step")]
    assert [step.cache_hits for step in steps] == [1, 1]
    core.compile_beside()
    assert compiled._workshop is workshop
    workshop.close()
    core.compile_beside()
    assert compiled._workshop is not workshop
    compiled._workshop.close()
