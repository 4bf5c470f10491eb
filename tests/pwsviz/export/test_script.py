"""The program that is exported is what the page ran, to the bit; and nothing they typed gets out of its quotes."""

import ast
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import core
from pwsviz.export.script import section_program, snippet
from pwsviz.results.requests import SectionInputs, SweepInputs, other_inputs, run_inputs, study_inputs
from pwsviz.results.results import Results
from pwsviz.scene import names
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS
from pwsviz.tabs import make_tab
from tests.pwsviz.own_systems import OWN_SYSTEMS

HOSTILE = (
    "'", '"', '"""', "'''", "\\", "\n", "\r", "\0", "{1/0}", "%s", "\u202e", "\ud800", "\u2028", "#", "</script>", "🙂",
    "__import__('os')", "'); raise SystemExit('out') #", "\nraise SystemExit\n", '"""\nraise SystemExit\n"""',
)  # fmt: skip


def program_of(scene):
    """Return the program of a scene, as the dialog shows it."""
    return snippet(scene, make_tab(scene.view, scene, Results()).program())


def executed(scene, monkeypatch, *functions):
    """Run the program of a scene, and return what these functions of `core` gave it, in turn."""
    given = {name: [] for name in functions}

    def recorder(name):
        function = getattr(core, name)

        def recorded(*args, **keywords):
            given[name].append(function(*args, **keywords))
            return given[name][-1]

        return recorded

    with monkeypatch.context() as patched:
        for name in functions:
            patched.setattr(core, name, recorder(name))
        exec(compile(program_of(scene), "snippet", "exec"), {"__name__": "__main__"})  # noqa: S102  (the claim is that it runs)
    return [given[name] for name in functions]


def assert_same(run, other):
    for name in ("t", "x", "mode", "side", "segment", "entered_t", "entered_x"):
        assert np.array_equal(getattr(run, name), getattr(other, name), equal_nan=True), name
    for name in ("t", "x", "mode", "side", "kind"):
        assert np.array_equal(getattr(run.crossings, name), getattr(other.crossings, name)), name
    assert (run.status, run.steps, run.tau) == (other.status, other.steps, other.tau)
    assert run.system == other.system


def page_runs(scene):
    """Return the page's own runs, in the order of the program: start by start."""
    results, runs = Results(), {}
    for one in (*run_inputs(scene), *other_inputs(scene)):
        runs[repr(one.problem.x0), one.scheme.method] = results.run(one)
    return [runs[repr(tuple(start)), method] for start in scene.starts for method in scene.used]


def assert_program_is_the_page(scene, monkeypatch):
    (runs,) = executed(scene, monkeypatch, "integrate")
    wanted = page_runs(scene)
    assert len(runs) == len(wanted)
    for run, page in zip(runs, wanted, strict=True):
        assert_same(run, page)


@pytest.mark.parametrize("key", core.CATALOGUE)
def test_the_program_runs_what_the_page_runs(key, monkeypatch, capsys):
    scene = Scene(system=key)
    scene.accept("t_end", 5.0)
    name = next(iter(scene.values))
    scene.accept(f"values.{name}", scene.values[name] * 1.01)
    assert_program_is_the_page(scene, monkeypatch)
    said = capsys.readouterr().out
    for run in page_runs(scene):
        assert f"{run.method} from " in said
        assert f"{run.steps:,} steps, {names.told(run.tally, names.met_at_surfaces(run.system))}, " in said
        if any(region.psi for region in scene.declaration.regions.values()):
            told = float(re.search(rf"{run.method} from .*<= (\S+)", said)[1])
            # Where round-off is all that is lost: numpy's powers of one number and of many differ by an ulp.
            assert told == pytest.approx(np.fmax.reduce(run.change_of_psi()), rel=0.05, abs=4e-15)


@pytest.mark.parametrize("locate", [True, False])
@pytest.mark.parametrize("methods", [["rk2"], ["rk2", "rk4"], ["rk2", "taylor"], ["taylor"]])
def test_every_setting_of_the_integrators_reaches_the_program(locate, methods, monkeypatch):
    scene = Scene()
    settings = {"methods": methods, "tau": 1 / 300, "t_end": 4.5, "tolerance": 1e-7, "perturbation_order": 2,
                "perturbation_scale": -0.3, "locate": locate, "values.a_plus": -1 / 3}  # fmt: skip
    for name, value in settings.items():
        scene.accept(name, value)
    scene.place((0.5, -1.5))
    scene.accept("selected", 0)
    assert_program_is_the_page(scene, monkeypatch)


def test_changes_of_psi_are_added_up_as_on_the_page(monkeypatch, capsys):
    scene = Scene(system="bouncing_ball", methods=["rk2"], perturbation_order=1)  # jumps, and crossings moved
    for scene.system in ("bouncing_ball", "harmonic_oscillator", "kepler"):
        executed(scene, monkeypatch)
        assert f"<= {np.fmax.reduce(page_runs(scene)[0].change_of_psi()):.1e}\n" in capsys.readouterr().out


def test_the_program_names_its_settings_and_of_the_rest_what_is_unusual():
    program = program_of(Scene())
    assert "system = core.CATALOGUE['elliptic_curve']\n" in program
    assert "system.with_parameters(a_minus=-3.0, a_plus=-2.0, radius=1.0)\n" in program
    for setting in ("x0=(-1.0, -1.0)", "tau=0.01", "method=method", "sliding='continue'"):
        assert setting in program
    assert not any(word in program for word in ("transition", "tolerance", "perturbation"))
    assert "sliding" not in program_of(Scene(slide=False))
    assert "sliding" not in program_of(Scene(system="bouncing_ball")), "a system with a jump does not slide"


def test_the_program_says_of_what_and_by_which_release_it_is():
    first = program_of(Scene()).splitlines()[0]
    assert first.startswith("# 'Elliptic curve', by pwsviz ")


def test_the_program_uses_core_and_numpy_alone():
    for view in VIEWS:
        tree = ast.parse(program_of(Scene(view=view)))
        imported = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
        assert imported == {"core", "numpy"}
        assert not [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]


@pytest.mark.parametrize(
    "settings",
    [
        {"system": "elliptic_curve", "starts": ((-1.0, -1.0), (-1.2, 0.0)), "section_direction": -1},
        {"system": "vibrating_table", "methods": ["taylor"], "tau": 0.7, "tolerance": 1e-9, "section_discard": 3},
        {"system": "stick_slip", "methods": ["rk4"], "section_of": "y - 9/10"},
    ],
    ids=lambda settings: settings["system"],
)
def test_the_section_is_that_of_the_page(settings, monkeypatch, capsys):
    scene = Scene()
    scene.load({"view": "section", "section_points": 30, "t_end": 1.0, **settings})
    ((found,),) = executed(scene, monkeypatch, "section")
    page = Results().section(SectionInputs.of_scene(scene))
    for k in range(len(scene.starts)):
        assert np.array_equal(found.points[found.member == k], page.of_start(k).x)
    said = capsys.readouterr().out
    assert f"start {len(scene.starts)}: 30 points, all points found; " in said
    assert f"the last [{page.of_start(len(scene.starts) - 1).x[-1]}]" in said


def test_the_program_of_a_section_leaves_out_the_points_of_a_motion_at_rest_as_the_page_does(capsys):
    scene = Scene()
    scene.load({"system": "damped_oscillator", "methods": ["rk4"], "view": "section", "section_points": 2000})
    inputs = SectionInputs.of_scene(scene)
    page = Results().section(inputs)
    (count,) = page.counts
    program = f"import core\nsystem = core.CATALOGUE['damped_oscillator']\n{section_program(scene, inputs, page)}"
    exec(compile(program, "program", "exec"), {})  # noqa: S102  (the claim is what it says)
    said = capsys.readouterr().out
    assert said == f"start 1: {count} points, the motion has come to rest; the last {page.of_start(0).x[-1:]}\n"
    assert "at_rest" not in section_program(scene, replace(inputs, points=5), page), "it is of other points"


def test_the_order_study_is_that_of_the_page(monkeypatch, capsys):
    for key in ("elliptic_curve", "type_upward", "pendulum", "type_repelling"):  # two of them cross less than twice
        scene = Scene(system=key, view="order", methods=["rk2"], perturbation_order=1)
        scene.accept("t_end", 1.0)
        (studies,) = executed(scene, monkeypatch, "order_study")
        (page,) = Results().studies(study_inputs(scene))
        for name in ("taus", "times", "time_error", "state_error", "time_slope", "state_slope"):
            assert np.array_equal(getattr(studies[0], name), getattr(page, name), equal_nan=True), name
        assert (studies[0].crossings, studies[0].method) == (page.crossings, page.method)
        assert page.reference in capsys.readouterr().out


def test_the_order_studies_of_several_integrators_are_those_of_the_page(monkeypatch):
    scene = Scene(view="order", methods=["dmm2", "rk2"], order_all=True)
    scene.accept("t_end", 1.0)
    (studies,) = executed(scene, monkeypatch, "order_study")
    for one, page in zip(studies, Results().studies(study_inputs(scene)), strict=True):
        assert one.method == page.method
        assert np.array_equal(one.state_error, page.state_error, equal_nan=True)


def own_system(name="mine", doc="", unit="", **more):
    parameters = (core.Parameter("k", 3.0, (0.1, 10.0), unit, unit or None), core.Parameter("method", 0.1))
    return core.PiecewiseSystem(
        name, ("x", "start"), ("start", "-k*x"), ("start", "-x*10*method"), "start", ("(k*x**2 + start**2)/2",),
        parameters=parameters, x0=(1.0, -0.0), doc=doc, **more,
    )  # fmt: skip


def test_an_own_system_is_declared_in_full(monkeypatch):
    scene = Scene()
    scene.use(own_system(jump=("x", "start")).with_parameters(k=2.5))
    scene.accept("values.k", 1 / 3)
    scene.accept("t_end", 3.0)
    scene.place((0.25, 1e-9))
    assert_program_is_the_page(scene, monkeypatch)


SEVERAL = {**{name: one for name, one in core.CATALOGUE.items() if not one.two_sided}, **OWN_SYSTEMS}


def own_scene(system, t_end=4.0):
    scene = Scene()
    scene.use(system)
    scene.accept("methods", ["rk4"])
    scene.accept("t_end", t_end)
    for q in system.parameters[:1]:
        scene.accept(f"values.{q.name}", q.default * 1.01)
    return scene


@pytest.mark.parametrize("system", SEVERAL.values(), ids=list(SEVERAL))
def test_an_own_system_of_several_regions_is_declared_in_full(system, monkeypatch):
    scene = own_scene(system)
    program = program_of(scene)
    assert all((f"{key!r}: core.Region(" in program) != bool(system.f) for key in system.regions)
    assert all(repr(law) in program for law in system.f)
    assert program.count("core.Transition(") == len(system.transitions)
    assert_program_is_the_page(scene, monkeypatch)


@pytest.mark.parametrize("system", SEVERAL.values(), ids=list(SEVERAL))
def test_regions_and_transitions_stand_on_lines_of_their_own(system):
    lines = program_of(own_scene(system)).splitlines()
    laws = [line for line in lines if re.match(r" +(f|psi|surfaces|regions|jumps|transitions)=| +'|[ })]+,$", line)]
    assert max(map(len, laws)) <= 100
    assert max(line.count("core.Region(") + line.count("core.Transition(") for line in lines) <= 1
    assert any(line == "    regions={" for line in lines) == (len(system.regions) > 1 and not system.f)


#: Runs programs, and prints the end state of every run that they make.
WATCHED = """
import json, runpy, sys
import core

integrate = core.integrate

def watched(*args, **keywords):
    run = integrate(*args, **keywords)
    print("END", json.dumps([run.status.name, run.t[-1], *run.x[-1]]))
    return run

core.integrate = watched
for path in sys.argv[1:]:
    runpy.run_path(path)
"""


def test_programs_of_several_regions_end_elsewhere_where_core_ends_here(tmp_path):
    scenes = [*map(own_scene, SEVERAL.values()), *(Scene(system=name, t_end=4.0) for name in SEVERAL if name.islower())]
    paths, wanted = [], []
    for k, scene in enumerate(scenes):
        paths.append(tmp_path / f"program{k}.py")
        paths[-1].write_text(program_of(scene), encoding="utf-8")
        for one in run_inputs(scene):
            run = core.integrate(
                scene.build(), (0.0, 4.0), x0=scene.x0, tau=scene.tau, method=one.scheme.method,
                sliding="continue" if scene.slides else "stop",
            )  # fmt: skip
            wanted.append([run.status.name, run.t[-1], *run.x[-1]])
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, *paths], capture_output=True, text=True, env=environment, timeout=300
    )
    assert done.returncode == 0, done.stderr
    found = [json.loads(line.removeprefix("END ")) for line in done.stdout.splitlines() if line.startswith("END ")]
    assert found == wanted


@pytest.mark.parametrize("text", [*HOSTILE, "".join(HOSTILE)], ids=range(1 + len(HOSTILE)))
def test_no_name_of_a_region_gets_out_of_its_quotes(text):
    def named(name):
        regions = {name: core.Region(("1", "0")), "off": core.Region(("-1", "0"))}
        ways = (core.Transition(name, "1 - x", "off", ("x", "-y")), core.Transition("off", "x + 1", name))
        return core.PiecewiseSystem(name="m", variables=("x", "y"), regions=regions, transitions=ways)

    program = program_of(own_scene(named(text)))
    program.encode()
    assert all(c.isprintable() or c == "\n" for c in program)
    assert shape(program) == shape(program_of(own_scene(named("on"))))
    declared = {}
    exec(program.partition("\n\n\n")[0], declared)  # noqa: S102  (the claim is that it declares the system)
    assert declared["system"] == named(text)


@pytest.mark.parametrize("text", [*HOSTILE, "".join(HOSTILE)], ids=range(1 + len(HOSTILE)))
def test_no_text_gets_out_of_its_quotes(text, monkeypatch):
    scene = Scene(methods=["rk2"])
    scene.use(own_system(text, text, text))
    scene.accept("t_end", 0.1)
    program = program_of(scene)
    program.encode()
    assert all(c.isprintable() or c == "\n" for c in program)
    innocent = Scene(methods=["rk2"])
    innocent.use(own_system("a", "a", "a"))
    innocent.accept("t_end", 0.1)
    assert shape(program) == shape(program_of(innocent))
    assert_program_is_the_page(scene, monkeypatch)


def shape(program):
    """Return a program's syntax without its texts."""
    tree = ast.parse(program)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = ""
    return ast.dump(tree)


class Asked(Exception):  # noqa: N818  (no error)
    """Raised in place of a study that would take long."""


@pytest.mark.parametrize(
    ("settings", "function", "expected"),
    [
        ({"view": "cost"}, "work_precision", {"methods": ("dmm2", "rk2")}),
        ({"view": "cost", "peers": []}, "work_precision", {"methods": ("dmm2", "rk2"), "peers": ()}),
        ({"view": "cost", "locate": False}, "work_precision", {"methods": ("dmm2", "rk2"), "transition": "none"}),
        (
            {"view": "stability", "stability_part": "map", "locate": False},
            "stability_study",
            {"methods": ("dmm2", "rk2"), "parts": ("largest_tau", "map"), "transition": "none"},
        ),
        ({"view": "stability"}, "stability_study", {"methods": ("dmm2", "rk2"), "parts": ("largest_tau", "map")}),
        (
            {"view": "stability", "stability_part": "grazing", "stability_coordinate": 1},
            "stability_study",
            {"methods": ("dmm2", "rk2"), "parts": ("grazing",), "coordinate": 1, "tau": 0.01},
        ),
    ],
)
def test_the_long_studies_are_asked_for_as_the_page_does(settings, function, expected, monkeypatch):
    scene = Scene(**settings)
    scene.accept("t_end", 2.5)
    scene.accept("starts", ((0.5, 0.25),))
    asked = {}

    def catch(*args, **keywords):
        asked.update(args=args, keywords=keywords)
        raise Asked

    monkeypatch.setattr(core, function, catch)
    with pytest.raises(Asked):
        executed(scene, monkeypatch)
    assert asked["args"] == (scene.build(), (0.0, 2.5))
    assert asked["keywords"] == {"x0": (0.5, 0.25), "sliding": "continue", **expected}


def test_what_the_long_studies_find_is_printed(monkeypatch, capsys):
    few = {
        "work_precision": {"settings": {"dmm2": (0.1,), "rk2": (0.1,), "scipy": (1e-3,)}, "repeats": 1},
        "stability_study": {"taus": (0.05, 0.1), "values": (-1.0, -0.9), "steps": 1000},
    }
    for name, keywords in few.items():
        whole = getattr(core, name)
        monkeypatch.setattr(core, name, lambda *a, whole=whole, less=keywords, **k: whole(*a, **k, **less))
    for settings in (
        {"view": "cost"},
        *({"view": "stability", "stability_part": part} for part in Scene.param["stability_part"].objects),
    ):
        scene = Scene(**settings)
        scene.accept("t_end", 5.0)
        executed(scene, monkeypatch)
        assert len(capsys.readouterr().out.splitlines()) >= 3


@pytest.mark.parametrize("continuation", ["none", "down"])
def test_a_bifurcation_diagram_is_that_of_the_page(continuation, monkeypatch, capsys):
    scene = Scene(view="sweep", system="stick_slip", methods=["rk4"], sweep_values=9, sweep_points=5, sweep_end=40.0)
    for name, value in {
        "sweep_discard": 2,
        "sweep_of": "2y - 1",
        "sweep_direction": 0,
        "sweep_continuation": continuation,
    }.items():
        scene.accept(name, value)
    scene.accept("starts", ((0.5, 0.25),))
    (found,) = executed(scene, monkeypatch, "sweep")
    page = Results().sweep(SweepInputs.of_scene(scene))
    value, x = page.sorted_points()
    order = np.argsort(found[0].value, kind="stable")
    assert len(x) > 9
    assert np.array_equal(found[0].value[order], value)
    assert np.array_equal(found[0].points[order], x)
    said = capsys.readouterr().out
    assert "Sweep: " in said
    assert "values: all points found" in said
    assert "limit of" not in said
