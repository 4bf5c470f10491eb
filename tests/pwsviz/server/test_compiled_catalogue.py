"""What is compiled beside the server is what a first choice of a system loads."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import core
from pwsviz.server.catalogue import compile_beside_once

ROOT = Path(__file__).parents[3]
COMPILE = "import sys; from pwsviz.server.catalogue import compile_catalogue; compile_catalogue(sys.argv[1:])"
CHOOSE = """
import sys
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene
Results().pictures(PortraitInputs.of(Scene(system=sys.argv[1])))
"""


def run(cache, *command):
    environment = {**os.environ, "PWSVIZ_CACHE": str(cache)}
    subprocess.run([sys.executable, *command], check=True, cwd=ROOT, env=environment, timeout=900)
    return {path for path in cache.rglob("*") if path.is_file()}


@pytest.mark.deep
def test_a_first_choice_compiles_nothing_more(tmp_path):
    systems = ("kepler", "bouncing_ball", "relay_feedback")
    compiled = run(tmp_path, "-c", COMPILE, *systems)
    assert compiled
    for system in systems:
        assert not run(tmp_path, "-c", CHOOSE, system) - compiled


def test_one_process_compiles_however_many_visitors_come():
    first = compile_beside_once()
    assert compile_beside_once() is first
    first.terminate()
    first.wait(30)


def test_a_page_declares_only_the_system_that_it_shows():
    code = "import sys; from pwsviz.page.explorer import Explorer; Explorer(); print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=900, check=True
    )
    declared = set(done.stdout.split()) & {f"core.systems.{name}" for name in core.CATALOGUE}
    assert declared == {"core.systems.elliptic_curve"}
