"""The README: what it tells people to type works, and what it says is so."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_example_runs_and_prints_what_is_shown():
    code, shown = re.search(r"```python\n(.*?)```\n\n```\n(.*?)```", README, re.DOTALL).groups()
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    number = r"\d+\.\d+(?:e-?\d+)?"
    numbers = [[float(n) for n in re.findall(number, text)] for text in (out, shown)]
    words, stated_words = (re.sub(number, "", text).split() for text in (out, shown))
    assert words == stated_words, "warnings are printed, too"
    for printed, stated in zip(*numbers, strict=True):
        assert abs(printed - stated) < 1e-6


def test_the_example_is_about_ten_lines():
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL).group(1)
    assert len([line for line in code.splitlines() if line.strip()]) <= 10


@pytest.mark.deep
def test_many_runs_and_a_system_of_several_surfaces_do_what_is_said():
    blocks = [code for code in re.findall(r"```py\n(.*?)```", README, re.DOTALL) if "scheduler:" not in code]
    said = (
        "assert set(stops.regions) == {'--', '-+', '++'} and all(region.psi for region in stops.regions.values())",
        "assert set(many.outcomes) == {core.Status.COMPLETED} and len(many) == 10_000",
        "assert points.shape == (1000, 4) and abs(points[:, 1]).max() < 1e-12",
        "assert len(diagram) == 100 * 50",
    )
    code = "\n".join(["import core", "import numpy as np", *blocks, *said])
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_files_that_it_names_exist():
    for name in re.findall(r"`((?:core|pwsviz)/[\w/]+\.py)`|\]\(([\w./]+)\)", README):
        assert (ROOT / (name[0] or name[1])).exists(), name


def test_ci_runs_the_command_that_people_are_told():
    assert "<!-- tests:" in README
    assert "README.md" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
