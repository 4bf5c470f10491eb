"""A Python program that recomputes a scene with `core` alone, as the page does.

What a user typed enters the program only through `repr`, so that it cannot be anything but text there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from textwrap import indent
from typing import Any

import core
from core.studies import OutcomeMap
from pwsviz.export.about import release
from pwsviz.geometry.section_plane import angles
from pwsviz.results.requests import (
    CostInputs,
    Scheme,
    SectionInputs,
    StabilityInputs,
    StudyInputs,
    SweepInputs,
    run_inputs,
    sliding_of,
    transition_of,
)
from pwsviz.results.sections import HORIZON, SectionPoints, section_arguments
from pwsviz.results.studies import BEFORE_THE_END, STUDY_CROSSINGS, STUDY_HORIZON, STUDY_PROBE
from pwsviz.results.sweeps import sweep_arguments
from pwsviz.scene.checks import OWN
from pwsviz.scene.names import as_met, met_at_surfaces
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import MAX_STEPS

MAX_LINE = 100
"""Characters of a call on one line; a longer one has a line for each argument."""

MAX_LAW = 80
"""Characters of a part of the laws on one line, which stands among the arguments of a call, or deeper."""

_USUAL: Mapping[str, object] = {
    "tolerance": 1e-12,
    "transition": "mannshardt",
    "sliding": "stop",
    "perturbation_order": None,
    "perturbation_scale": 1.0,
    "coordinate": 0,
    "peers": ("scipy",),
    "discard": 0,
    "continuation": "none",
    "of": None,
    "direction": 0,
}
"""Defaults of `core` that the program does not repeat."""

_FIGURES = '''\
def show(run):
    """Print a summary of a run."""
    figures = f"{run.steps:,} steps, {run.tally}, {run.seconds * 1e3:.3g} ms"
    print(f"{run.method} from {run.x[0]}: {figures}WORST")
    if run.status is not core.Status.COMPLETED:
        print(run.message)
'''


_JUMPS = "{(jumps := run.tally.crossings + run.tally.jumps):,} jump{'s' * (jumps != 1)}"
"""What a run meets at the surfaces of a system where nothing but jumps is met, on whichever side they lead."""


def snippet(scene: Scene, study: str = "") -> str:
    """Return the program: the system, its run from each start with each integrator, and a study.

    It passes the arguments that the page passes: parameters, starts, steps and integrators always, so that it means the
    same when a default changes, the rest where it is not the default of `core`. It prints the figures that the page
    shows below the portrait.

    Parameters
    ----------
    scene : Scene
        The settings.
    study : str
        Lines of the open view, such as `order_program` returns; empty if it makes no study.
    """
    imports = f"# {scene.declaration.name!r}, by {release()}, which brings core.\nimport numpy as np\n\nimport core"
    paragraphs = [imports, _system(scene), _figures(scene), _runs(scene)]
    if study:
        paragraphs.append(study)
    return "\n\n".join(paragraphs).replace("\n\n\n\n", "\n\n\n") + "\n"


def _system(scene: Scene) -> str:
    declared = scene.declaration
    if scene.system == OWN:
        text = _call("core.PiecewiseSystem", keywords=_declaration(declared))
    else:
        text = f"core.CATALOGUE[{scene.system!r}]"
    values = {name: repr(value) for name, value in scene.values.items()}
    text = f"system = {text}"
    return f"{text}\n{_call('system = system.with_parameters', keywords=values)}" if values else text


def _declaration(system: core.PiecewiseSystem) -> dict[str, str]:
    """Return the arguments that declare a system, with the default values of its parameters."""
    laws = {name: _law(part) for name, part in system.law_arguments().items()}
    given = {"name": repr(system.name), "variables": repr(system.variables), **laws}
    given |= {"doc": repr(system.doc)} if system.doc else {}
    if system.parameters:
        given["parameters"] = "".join(["(\n", *(f"    {_parameter(q)},\n" for q in system.parameters), ")"])
    return given | {"x0": repr(system.x0)}


def _law(part: Any) -> str:
    """Return the laws of a system as Python: regions and transitions by their classes of `core`."""
    if isinstance(part, dict):
        return _bracketed("{", [f"{key!r}: {_law(one)}" for key, one in part.items()], "}", MAX_LAW)
    if isinstance(part, tuple):
        return _bracketed("(", [_law(one) for one in part], ",)" if len(part) == 1 else ")", MAX_LAW)
    if isinstance(part, core.Region):
        given = {"f": part.f} | ({"psi": part.psi} if part.psi else {})
        return _call("core.Region", keywords={name: _law(one) for name, one in given.items()}, most=MAX_LAW)
    if isinstance(part, core.Transition):
        jump = {"jump": _law(part.jump)} if part.jump else {}
        return _call("core.Transition", map(repr, (part.mode, part.guard, part.to)), jump, most=MAX_LAW)
    return repr(part)


def _parameter(parameter: core.Parameter) -> str:
    given = {name: getattr(parameter, name) for name in ("bounds", "doc", "latex")}
    keywords = {name: repr(value) for name, value in given.items() if value not in ("", None)}
    return _call("core.Parameter", (repr(parameter.name), repr(parameter.default)), keywords, most=None)


def _figures(scene: Scene) -> str:
    """Return the function that prints the figures of a run, with the change of ψ if any ψ is known."""
    worst = ", |change of psi| <= {np.fmax.reduce(run.change_of_psi()):.1e}"
    figures = _FIGURES.replace("WORST", worst * (scene.declaration.laws.most_conserved > 0))
    return "\n" + figures.replace("{run.tally}", _JUMPS if _met(scene) == "jumps" else "{run.tally}")


def _met(scene: Scene) -> str:
    """Return what runs meet at the surfaces: crossings, jumps or both."""
    return met_at_surfaces(scene.declaration)


def _runs(scene: Scene) -> str:
    """Return the runs, one for each start and integrator."""
    schemes = {one.scheme.method: _scheme(one.scheme) for one in run_inputs(scene)}
    shared = next(iter(schemes.values()))
    alike = all(settings == shared for settings in schemes.values())
    several = len(scene.starts) > 1
    keywords = {"x0": "x0" if several else repr(scene.x0), "tau": repr(scene.tau)}
    keywords |= {"method": "method"} | (_texts(shared) if alike else {}) | {"max_steps": f"{MAX_STEPS:_}"}
    rest = () if alike else ("**settings",)
    run = f"show({_call('core.integrate', ('system', _span(scene)), keywords, rest)})"
    if alike:
        loop = f"for method in {list(schemes)!r}:\n{indent(run, '    ')}"
    else:
        listed = "".join(f"    {name!r}: {settings!r},\n" for name, settings in schemes.items())
        loop = f"for method, settings in methods.items():\n{indent(run, '    ')}"
    if several:
        starts = "".join(f"    {start!r},\n" for start in scene.starts)
        loop = f"starts = [\n{starts}]\nfor x0 in starts:\n{indent(loop, '    ')}"
    return loop if alike else f"methods = {{\n{listed}}}\n{loop}"


def order_program(scene: Scene, inputs: tuple[StudyInputs, ...]) -> str:
    """Return the lines that repeat the order studies of one integrator or of several."""
    start, scheme, noun = _x0(scene), _texts(_scheme(inputs[0].scheme)), as_met("crossing", _met(scene))
    several = len(inputs) > 1
    method = {"method": "method" if several else repr(inputs[0].scheme.method)}
    looked = _call(
        "run = core.integrate",
        ("system", f"(0.0, {STUDY_HORIZON!r})"),
        start | {"tau": repr(STUDY_PROBE)} | _unusual({"sliding": inputs[0].scheme.sliding}) | method
        | {"record": "'crossings'", "max_crossings": repr(STUDY_CROSSINGS[-1] + 1)},
    )  # fmt: skip
    study = _call(
        "study = core.order_study",
        ("system", "2.0 ** -np.arange(3.0, 13.5, 0.5)"),
        start | scheme | method | {"crossings": "crossings", "until": "until"},
    )
    lines = f"""\
{looked}
last = len(run.crossings.passed) - 1  # the segment after it is studied, too
crossings = {STUDY_CROSSINGS} if last >= {STUDY_CROSSINGS[-1]} else sorted({{-(-last // 3), -(-2 * last // 3), last}})
until = None  # halfway to the next crossing
if last < 1:  # there is none
    until = min({inputs[0].t_end!r}, {BEFORE_THE_END} * float(run.t[-1]))
    crossings = (1,) if (run.crossings.passed.t < until).any() else ()
{study}
print(f"{{study.method}} against {{study.reference}}")
print(f"state, before the first {noun} and after {{study.crossings}}: slopes {{study.state_slope}}")
print(f"times of {noun}s {{study.crossings}}: slopes {{study.time_slope}}")"""
    loop = f"for method in {[one.scheme.method for one in inputs]!r}:\n{indent(lines, '    ')}" if several else lines
    return f"# The order: at {noun}s {STUDY_CROSSINGS}, or at earlier ones if there are fewer.\n{loop}"


def cost_program(scene: Scene, inputs: CostInputs) -> str:
    """Return the lines that repeat a comparison of run times."""
    keywords = _x0(scene) | {"methods": repr(inputs.methods)}
    keywords |= _unusual({"peers": inputs.peers}) | _at_surface(inputs)
    return f"""\
# The cost of accuracy.
{_call("study = core.work_precision", ("system", _span(scene)), keywords)}
print(f"errors against {{study.reference}}")
for curve in study.curves:
    for setting, cost, error in zip(curve.setting, curve.{scene.cost_across}, curve.{scene.cost_up}_error):
        at = f"{{curve.title}}, {{curve.setting_name}} = {{setting:.1e}}"
        print(f"{{at}}: {scene.cost_across} {{cost:.2g}}, {scene.cost_up} error {{error:.1e}}")"""


_FOUND = {
    "map": """\
for method, tau, reason in zip(study.methods, study.largest_tau.tau, study.largest_tau.reason):
    print(f"{method}: the largest step size that works is {tau:.3g}; beyond: {reason or 'none tried'}")
for method, works in zip(study.methods, study.map.works):
    print(f"{method}: {np.mean(works):.0%} of the runs of the map meet and end as the solution does")""",
    "drift": """\
for method, error in zip(study.methods, study.drift.error):
    print(f"{method}: |change of psi| <= {np.fmax.reduce(error):.1e} in {study.drift.steps:,} steps")""",
    "grazing": """\
found = study.grazing
print(f"touches the surface at {study.coordinate_name} = {found.value!r}, t = {found.time:.6g} (nan: nowhere)")
for method, missed, error in zip(study.methods, found.missed, found.error):
    wrong = f"{np.count_nonzero(missed)} of {missed.size} runs miscount crossings"
    print(f"{method}: {wrong}; |change of psi| <= {np.fmax.reduce(error, axis=None, initial=0.0):.1e}")""",
}


def stability_program(scene: Scene, inputs: StabilityInputs, drawn: OutcomeMap | None = None) -> str:
    """Return the lines that repeat a stability study, over the step sizes and starts of the map that is drawn."""
    parts = ("largest_tau", "map") if inputs.part == "map" else (inputs.part,)
    keywords = _x0(scene) | {"methods": repr(inputs.methods)} | _unusual({"coordinate": inputs.coordinate})
    keywords |= {"parts": repr(parts)} | ({} if inputs.tau is None else {"tau": repr(inputs.tau)})
    if inputs.part == "map" and drawn is not None:
        taus, values = ((*column[[0, -1]].tolist(), len(column)) for column in (drawn.taus, drawn.values))
        keywords |= {"taus": f"np.geomspace{taus}", "values": f"np.linspace{values}"}
    keywords |= _at_surface(inputs)
    call = _call("study = core.stability_study", ("system", f"(0.0, {inputs.t_end!r})"), keywords)
    return f"# Stability.\n{call}\n{as_met(_FOUND[inputs.part], _met(scene))}"


_WHOLE = "whole = core.Status.CROSSING_LIMIT, core.Status.EVENT_LIMIT  # of runs that have all their points"


def sweep_program(inputs: SweepInputs) -> str:
    """Return the lines that repeat a bifurcation diagram; none if the system has no parameter."""
    if not inputs.parameter:
        return ""
    values = f"np.linspace({inputs.low!r}, {inputs.high!r}, {inputs.values})"
    given = {"x0": inputs.problem.x0, **sweep_arguments(inputs)}
    texts = _texts({name: one for name, one in given.items() if one is not None and one != _USUAL.get(name)})
    texts |= {"tau": repr(inputs.tau), "max_steps": f"{MAX_STEPS:_}"}
    call = _call(
        "found = core.sweep",
        ("system", f"(0.0, {inputs.t_end!r})", repr(inputs.parameter), values, repr(inputs.coordinate)),
        texts,
    )
    turns = " % (2*np.pi)" if inputs.column in angles(inputs.problem.declaration) else ""
    return f"""\
# The bifurcation diagram: found.points{turns} over found.value.
{call}
print(found)
{_WHOLE}
for status in sorted(set(found.statuses)):
    ended = "all points found" if status in whole else status.reason
    print(f"{{found.statuses.count(status)}} values: {{ended}}")"""


def section_program(scene: Scene, inputs: SectionInputs, found: SectionPoints | None = None) -> str:
    """Return the lines that find the points of a Poincaré section.

    Parameters
    ----------
    scene, inputs
        What to find.
    found
        The points, if they have been found: those of a motion that has come to rest are left out of the program, too.
    """
    rest = {k: found.counts[k] for k in sorted(found.at_rest)} if found and found.inputs == inputs else {}
    at_rest, kept, resting = (
        f"\nat_rest = {rest!r}  # points of a start until its motion has come to rest: the others are round-off",
        "[: at_rest.get(k)]",
        '"the motion has come to rest" if k in at_rest else ',
    ) if rest else ("", "", "")  # fmt: skip
    given = section_arguments(inputs)
    keywords = {name: repr(value) for name, value in given.items() if name not in _USUAL or value != _USUAL[name]}
    keywords["max_steps"] = f"{given['max_steps']:_}"
    start = {"x0": "starts"} if len(scene.starts) > 1 else _x0(scene)
    call = _call("found = core.section", ("system", f"(0.0, {HORIZON!r})"), start | keywords)
    return f"""\
# The Poincaré section.
{call}
{_WHOLE}{at_rest}
for k, status in enumerate(found.ensemble.status):
    points = found.points[found.member == k]{kept}
    ended = {resting}"all points found" if status in whole else core.Status(status).reason
    print(f"start {{k + 1}}: {{len(points)}} points, {{ended}}; the last {{points[-1:]}}")"""


# Pieces of text ------------------------------------------------------------------------------------------------------


def _scheme(scheme: Scheme) -> dict[str, object]:
    """Return the settings of a scheme that differ from their defaults, except its method."""
    names = ("tolerance", "transition", "sliding", "perturbation_order", "perturbation_scale")
    given = {name: getattr(scheme, name) for name in names}
    return {name: value for name, value in given.items() if value is not None and value != _USUAL[name]}


def _at_surface(inputs: CostInputs | StabilityInputs) -> dict[str, str]:
    """Return the arguments that say what happens at the surface."""
    return _unusual({"transition": transition_of(inputs.locate), "sliding": sliding_of(inputs.slide)})


def _x0(scene: Scene) -> dict[str, str]:
    """Return the argument x0: the selected start."""
    return {"x0": repr(scene.x0)}


def _span(scene: Scene) -> str:
    return f"(0.0, {scene.t_end!r})"


def _unusual(given: Mapping[str, object]) -> dict[str, str]:
    """Return the arguments that differ from the defaults of `core`."""
    return _texts({name: value for name, value in given.items() if value != _USUAL[name]})


def _texts(given: Mapping[str, object]) -> dict[str, str]:
    return {name: repr(value) for name, value in given.items()}


def _call(
    name: str,
    positional: Iterable[str] = (),
    keywords: Mapping[str, str] | None = None,
    rest: Iterable[str] = (),
    most: int | None = MAX_LINE,
) -> str:
    """Return a call, on one line if it has at most `most` characters."""
    arguments = [*positional, *(f"{key}={text}" for key, text in (keywords or {}).items()), *rest]
    return _bracketed(f"{name}(", arguments, ")", most)


def _bracketed(opening: str, items: Sequence[str], closing: str, most: int | None) -> str:
    """Return items between brackets, on one line if that has at most `most` characters, else on a line each."""
    line = f"{opening}{', '.join(items)}{closing}"
    if most is None or ("\n" not in line and len(line) <= most):
        return line
    lines = "".join(f"{indent(item, '    ')},\n" for item in items)
    return f"{opening}\n{lines}{closing.removeprefix(',')}"
