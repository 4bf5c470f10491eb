"""The house: imports point one way, and the top level holds what it should."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def imported(path: Path) -> set[str]:
    """Modules that a file imports, as dotted names."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def test_importing_core_loads_nothing_of_a_screen():
    code = "import core, sys; print([m for m in ('panel', 'bokeh', 'pwsviz', 'param', 'tornado') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    assert out.strip() == "[]"


@pytest.mark.parametrize(
    ("module", "barred"),
    [
        ("core/crossing.py", ["core.march", "core.runner", "core.integrate", "core.studies"]),
        ("core/surface.py", ["core.crossing", "core.locating", "core.march", "core.trajectory"]),
        ("core/approach.py", ["core.crossing", "core.march", "core.trajectory"]),
        ("core/status.py", ["core"]),
        ("core/locating.py", ["core.crossing", "core.march", "core.runner"]),
        ("core/printing.py", ["core.codegen", "core.stepcode", "core.methods"]),
        ("core/stepcode.py", ["core.compiled", "core.methods", "core.march"]),
        ("core/trajectory.py", ["core.diagnostics", "core.integrate", "core.runner"]),
        ("core/march.py", ["core.runner", "core.integrate", "core.system", "core.methods"]),
        ("core/multiplier.py", ["core.system", "core.laws", "core.codegen"]),
        ("core/methods.py", ["core.compiled", "core.march", "core.integrate"]),
        ("core/system.py", ["core.systems", "core.integrate", "core.methods"]),
        ("core/reference/solution.py", ["core.march", "core.integrate", "core.methods", "core.compiled"]),
        ("core/reference/flows.py", ["core.march", "core.integrate", "core.methods", "core.compiled"]),
        ("core/studies/cost.py", ["pwsviz"]),
        ("core/dense.py", ["core.march", "core.runner", "core.integrate", "core.trajectory"]),
        ("core/recording.py", ["core.march", "core.integrate"]),
        ("core/excess.py", ["core.march", "core.runner", "core.integrate", "core.trajectory"]),
        ("pwsviz/scene.py", ["panel", "bokeh", "pwsviz.views", "pwsviz.explorer"]),
        ("pwsviz/link.py", ["panel", "bokeh", "pwsviz.views", "pwsviz.explorer"]),
        ("pwsviz/draft.py", ["panel", "bokeh", "pwsviz.views", "pwsviz.explorer"]),
        ("pwsviz/snippet.py", ["panel", "bokeh", "pwsviz.views", "pwsviz.explorer"]),
        ("pwsviz/desk.py", ["pwsviz.views", "pwsviz.tabs", "pwsviz.explorer"]),
        ("pwsviz/tabs/base.py", ["pwsviz.explorer", "pwsviz.stage", "pwsviz.views"]),
        ("pwsviz/results.py", ["panel", "bokeh", "pwsviz.views", "pwsviz.explorer"]),
    ],
)
def test_imports_point_one_way(module, barred):
    names = imported(ROOT / module)
    wrong = [n for n in names for b in barred if n == b or n.startswith(b + ".")]
    assert wrong == []


def test_nothing_evaluates_text_as_code():
    for path in [*ROOT.glob("core/**/*.py"), *ROOT.glob("pwsviz/**/*.py"), ROOT / "app.py"]:
        calls = [n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
        called = {n.func.id for n in calls if isinstance(n.func, ast.Name)}
        assert not called & {"eval", "exec", "compile", "__import__"}, path
        assert not any(isinstance(n.func, ast.Attribute) and n.func.attr == "parse_expr" for n in calls), path


def test_the_top_level_is_the_agreed_one():
    listed = subprocess.run(["git", "ls-files"], check=True, capture_output=True, text=True, cwd=ROOT).stdout.split()
    top = {name.split("/")[0] for name in listed if not name.startswith(".")}
    assert top <= {"pyproject.toml", "pwsviz", "app.py", "core", "tests", "README.md", "LICENSE", "CHANGELOG.md"}
