"""The house: imports point one way, and the top level holds what it should."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


#: Rooms of each package, a floor a line, the ground floor first: a file may import from its own room and from floors
#: below. What stands loose in a package is a room of its own.
FLOORS = {
    "core": """
        kernels interface
        llvm symbolic transition
        codegen system
        methods systems
        compilation
        integration
        diagnostics reference
        integrate
        ensemble studies
        maps
    """,
    "pwsviz": """
        bench tasks text
        geometry
        scene
        results
        export figures
        report widgets
        editor tabs
        page
        server
        __main__
    """,
}
FLOOR = {f"{package}.{room}": k for package, rooms in FLOORS.items()
         for k, line in enumerate(rooms.strip().splitlines()) for room in line.split()}  # fmt: skip
SOURCES = sorted(path for package in FLOORS for path in ROOT.glob(f"{package}/**/*.py"))


def imported(path: Path) -> set[str]:
    """Modules that a file imports, as dotted names."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, path
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def room_of(name: str) -> str:
    """The room of a module by its dotted name: package and folder, or package and loose file."""
    return ".".join(name.split(".")[:2])


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@pytest.fixture(scope="module")
def loaded_with_core():
    """Modules that a fresh process has loaded once it has imported core and listed the catalogue's names."""
    code = "import core, sys; assert 'pendulum' in list(core.CATALOGUE); print(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    return set(out.split())


def test_importing_core_loads_nothing_of_a_screen(loaded_with_core):
    assert not loaded_with_core & {"panel", "bokeh", "pwsviz", "param", "tornado"}


def test_importing_core_loads_no_more_of_scipy_and_sympy_than_importing_numba_and_sympy_does(loaded_with_core):
    late = {
        "scipy.integrate",
        "scipy.optimize",
        "scipy.special",
        "scipy.linalg",
        "sympy.codegen",
        "sympy.tensor.tensor",
    }
    assert not loaded_with_core & late


def test_importing_core_parses_no_system_and_loads_no_study_no_exact_solution_and_no_table(loaded_with_core):
    late = ("core.systems.", "core.studies", "core.reference", "core.kernels.doubledouble.tables")
    assert not [name for name in loaded_with_core if name.startswith(late)]


@pytest.mark.parametrize("package", FLOORS)
def test_every_room_stands_on_a_floor_and_nothing_is_loose_but_facades(package):
    rooms = {room_of(name_of(path)) for path in SOURCES if path.relative_to(ROOT).parts[0] == package} - {package}
    assert rooms == {room for room in FLOOR if room.startswith(f"{package}.")}
    loose = {path.stem for path in ROOT.glob(f"{package}/*.py")} - {"__init__", "__main__"}
    assert loose <= {"system", "integrate", "ensemble"}


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_imports_lead_down(path):
    own = room_of(name_of(path))
    for name in imported(path):
        room = room_of(name)
        if room not in FLOOR or room == own:
            continue
        assert not own.startswith("core") or room.startswith("core"), "core knows nothing of the page"
        if own in FLOOR and own.split(".")[0] == room.split(".")[0]:
            assert FLOOR[room] < FLOOR[own], f"{name_of(path)} imports {name}, which stands no lower"


@pytest.mark.parametrize("path", [p for p in SOURCES if p.parts[-2] in ("scene", "results", "geometry")], ids=name_of)
def test_what_a_picture_shows_is_worked_out_without_a_page(path):
    assert not {name.split(".")[0] for name in imported(path)} & {"panel", "bokeh", "tornado"}


def public_names(module: str) -> list[str]:
    """What a module of `core` lists in `__all__`."""
    path = ROOT / module.replace(".", "/")
    tree = ast.parse((path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8"))
    listed = [n.value for n in tree.body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "__all__"]
    return [str(name) for names in listed for name in ast.literal_eval(names)]


@pytest.mark.parametrize(
    "path", [p for p in SOURCES if name_of(p).startswith("pwsviz")] + [ROOT / "app.py"], ids=name_of
)
def test_the_page_takes_from_core_what_core_or_a_room_of_it_makes_public(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert not [alias.name for alias in node.names if alias.name.startswith("core.")], "import a room's names"
        elif isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] == "core":
            assert node.module in FLOOR.keys() | {"core"}, f"{node.module} is no room of core"
            assert {alias.name for alias in node.names} <= set(public_names(node.module))


def test_private_names_stay_in_their_file():
    for path in SOURCES:
        private = [
            name for name in imported(path) if name.split(".")[0] in FLOORS and name.rpartition(".")[2].startswith("_")
        ]
        assert not [name for name in private if not name.endswith("__")], path


def test_nothing_evaluates_text_as_code():
    for path in [*SOURCES, ROOT / "app.py"]:
        calls = [n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
        called = {n.func.id for n in calls if isinstance(n.func, ast.Name)}
        assert not called & {"eval", "exec", "compile", "__import__"}, path
        assert not any(isinstance(n.func, ast.Attribute) and n.func.attr == "parse_expr" for n in calls), path


def test_the_top_level_is_the_agreed_one():
    listed = subprocess.run(["git", "ls-files"], check=True, capture_output=True, text=True, cwd=ROOT).stdout.split()
    top = {name.split("/")[0] for name in listed if not name.startswith(".")}
    assert top <= {"pyproject.toml", "pwsviz", "app.py", "core", "tests", "README.md", "LICENSE", "CHANGELOG.md"}
