"""The scheme as HTML: the equations of a system, the method derived from them, and the constants of its theory."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from html import escape
from typing import NamedTuple, TypeAlias

import sympy
from sympy import Expr, Symbol

import core
from core.methods import ButcherTableau, Composition, DiscreteMultiplier, Projected
from core.symbolic import TIME, DividedDifference, Laws, Mode
from pwsviz.figures.constants import constants_markup, table
from pwsviz.figures.equation_sheet import EquationSheet
from pwsviz.geometry.shades import region_name
from pwsviz.text.math_names import name_markup, numbered, quantity_name
from pwsviz.text.mathml import Shown, markup, names_of
from pwsviz.text.numbers import printed

__all__ = ["SCHEME_STYLE", "scheme_markup"]

SCHEME_STYLE = """
.scheme h2 { font-size: 1.17em; }
.scheme .formula { overflow-x: auto; overflow-y: hidden; padding: 4px 0; font-size: 1.1em; }
.scheme .formula > math { width: max-content; }
.scheme h3 { font-size: 1em; }
.scheme table { border-collapse: collapse; margin: 8px 0; }
.scheme th, .scheme td { text-align: start; vertical-align: top; padding: 3px 12px 3px 0; font-weight: normal; }
.scheme thead th { border-bottom: 1px solid; font-weight: 600; }
.scheme caption { text-align: start; padding: 4px 0; }
.scheme .number { white-space: nowrap; font-variant-numeric: tabular-nums; }
.scheme .exceeded { font-weight: 600; }
.scheme code { font-size: 0.85em; overflow-wrap: anywhere; }
.scheme pre { overflow-x: auto; }
"""
"""The style sheet of what `scheme_markup` returns."""

_SIDES = {-1: ("-", "Where g < 0"), 1: ("+", "Where g > 0")}
_BOTH = (r"\pm", "The law")
_SLIDING = ("S", "Sliding along g = 0")


def scheme_markup(
    system: core.PiecewiseSystem,
    method: str,
    diagnosis: core.Diagnosis | None = None,
    run: core.Trajectory | None = None,
    *,
    locate: bool = True,
    perturbation_order: int | None = None,
    perturbation_scale: float = 1.0,
) -> str:
    """Return the equations, the scheme, and the constants of the theory for a run.

    Parameters
    ----------
    system
        The system at the values of its parameters.
    method
        A key of `core.METHODS`.
    diagnosis
        The constants of `run`, as from `core.diagnose`; None if they are not known.
    run
        The run along which they are evaluated.
    locate
        Whether crossings are located (Mannshardt), or stepped over.
    perturbation_order, perturbation_scale
        p and c of the perturbation c·τᵖ of crossing times; an order of None for no perturbation.

    Returns
    -------
    str
        HTML without scripts, in which everything a user typed is escaped; `SCHEME_STYLE` is its style sheet.
    """
    slides = run is not None and bool((run.crossings.kind == "sliding").any()) and run.slides
    met = set() if run is None else {int(mode) for mode in run.mode if mode >= len(system.laws.regions)}
    entered = (2,) if slides and system.two_sided else tuple(sorted(met))
    derived = _derived(system.laws, tuple(names_of(system).items()), method, entered)
    transition = EquationSheet({})
    _write_transition(transition, system, locate, perturbation_order, perturbation_scale)
    if slides:
        _write_sliding(transition)
    parts = [
        f"<h2>The system: {escape(system.name)}</h2>",
        derived.system,
        _parameter_table(system),
        f"<h2>The scheme: {escape(method)}</h2>",
        derived.scheme,
        "<h2>The transition</h2>",
        transition.text,
        "<h2>The theory’s constants</h2>",
        constants_markup(method, diagnosis, run),
        _source([*derived.source, *transition.source]),
    ]
    return f'<div class="scheme">{"".join(parts)}</div>'


Group: TypeAlias = "tuple[str, str, Mode]"
"""Index of a mode's symbols, its heading, and the mode."""


# Independent of the values of the parameters -------------------------------------------------------------------------


class _Derived(NamedTuple):
    """What is derived once for a system and a method."""

    system: str
    scheme: str
    source: list[str]


@lru_cache(maxsize=128)
def _derived(laws: Laws, names: tuple[tuple[Symbol, str], ...], method: str, entered: tuple[int, ...]) -> _Derived:
    system, scheme = EquationSheet(dict(names)), EquationSheet(dict(names))
    groups = list(_groups(laws, entered))
    _write_system(system, laws, groups)
    _write_scheme(scheme, method, groups)
    return _Derived(system.text, scheme.text, [*system.source, *scheme.source])


def _groups(laws: Laws, entered: tuple[int, ...]) -> Iterator[Group]:
    """Yield sign, heading and mode of each region, once for both sides if their laws agree; then of sliding.

    Parameters
    ----------
    entered
        Numbers of the modes of sliding that are shown.
    """
    first, last = laws.regions[0], laws.regions[-1]
    if laws.two_sided and (first.field, first.conserved) == (last.field, last.conserved):
        yield (*_BOTH, last)
    elif laws.two_sided:
        yield from ((*_SIDES[side], mode) for side, mode in laws.modes.items())
    else:
        yield from ((_index(laws, k), f"Region {region_name(mode)}", mode) for k, mode in enumerate(laws.regions))
    for number in entered:
        where = laws.pairs[number - len(laws.regions)][2] + 1
        heading = f"Sliding along g{where} = 0 ({laws.name(number).replace('-', '−')})"
        if laws.two_sided:
            yield (*_SLIDING, laws.mode(number))
        else:
            yield _index(laws, number), heading, laws.mode(number)


def _index(laws: Laws, number: int) -> str:
    """Return the name of a mode as an index in LaTeX; its number, from 1, if LaTeX would take the name for commands."""
    name = laws.name(number)
    return name if re.fullmatch(r"[\w |+-]+", name) else f"{number + 1}"


def _write_system(sheet: EquationSheet, laws: Laws, groups: Sequence[Group]) -> None:
    for sign, heading, mode in groups:
        sheet.head(heading)
        sheet.equate(f"f_{{{sign}}}", mode.field)
        for k, psi in enumerate(mode.conserved):
            sheet.equate(quantity_name(sign, k, len(mode.conserved)), psi)
        if not mode.conserved:
            sheet.say("No conserved quantity is known.")
    one = laws.two_sided
    sheet.head("The switching surface is g = 0" if one else "The switching surfaces are the zeros of")
    for k, g in enumerate(laws.surfaces, start=1):
        sheet.equate("g" if one else f"g_{{{k}}}", g)
    jumps = {way.surface + 1: way.jump for ways in laws.ways for way in ways if way.jump is not None}
    for k, jump in jumps.items():
        where = "it" if one else f"{numbered('g', k)} = 0"
        sheet.say(f"On reaching {where}, the state is reset to")
        sheet.equate(r"\hat{x}^{+}", jump)
    if not laws.regions[0].sides:
        for mode, ways in zip(laws.regions, laws.ways, strict=True):
            for way in ways if mode.name else ():
                guard = f"{'−' * (way.sign <= 0)}{numbered('g', way.surface + 1)}"
                to = "" if way.to is None else laws.name(way.to)
                sheet.say(f"“{mode.name}” is followed by “{to}” where {guard} falls to 0.")


def _alone(entries: Sequence[Expr] | sympy.MatrixBase) -> Shown:
    """Return a single entry without brackets."""
    return entries[0] if len(entries) == 1 else entries


def _write_scheme(sheet: EquationSheet, method: str, groups: Sequence[Group]) -> None:
    chosen = core.METHODS[method]
    sheet.say(chosen.doc)
    scheme = chosen.scheme
    if isinstance(scheme, ButcherTableau):
        _write_runge_kutta(sheet, scheme)
        return
    if isinstance(scheme, Composition):
        _write_composition(sheet, [float(weight) for weight in scheme.weights])
    if isinstance(scheme, Composition | DiscreteMultiplier):
        _write_multipliers(sheet, groups, _write_field)
        return
    if isinstance(scheme, Projected):
        sheet.say(f"First an increment Δ from a Runge–Kutta method of {len(scheme.of.rows)} stages:")
        _write_runge_kutta(sheet, scheme.of)
    else:
        sheet.say("First an increment Δ from the Taylor series of the solution, its coefficients by recurrence from f:")
        sheet.formula(r"\Delta = \tau x'_{k} + \tau^{2} x''_{k} / 2! + \cdots + \tau^{n} x^{(n)}_{k} / n !")
        sheet.say("The order n and the step τ are chosen so that the last terms stay within the tolerance.")
    sheet.say("Then it is projected along the discrete gradient onto the level of ψ:")
    change = r"+ \tau s_{t}" if _names_time(groups) else ""
    sheet.formula(rf"\Delta \leftarrow \Delta - \Lambda^{{\tau\top}} \lambda , \Lambda^{{\tau}} \Delta {change} = 0")
    _write_multipliers(sheet, groups, None)


def _write_multipliers(
    sheet: EquationSheet, groups: Sequence[Group], write: Callable[[EquationSheet, str, Mode], None] | None
) -> None:
    """Write Λ^τ of each mode, followed by what `write` adds to it."""
    sheet.say(
        "The multiplier Λ^τ is a discrete gradient of ψ: exact for any two states, and symmetric in them. Index 0 "
        "denotes the start of a step, and 1 its end; see (2.3) of the paper."
    )
    sheet.formula(
        r"\Lambda^{\tau} ( x_{1} - x_{0} ) + s_{t} ( t_{1} - t_{0} ) = \psi ( t_{1} , x_{1} ) - \psi ( t_{0} , x_{0} )"
        if _names_time(groups)
        else r"\Lambda^{\tau} ( x_{1} - x_{0} ) = \psi ( x_{1} ) - \psi ( x_{0} )"
    )
    for sign, heading, mode in groups:
        sheet.head(heading)
        if mode.conserved:
            sheet.equate(rf"\Lambda^{{\tau}}_{{{sign}}}", mode.discrete.gradient)
            if any(mode.discrete.time_slope):
                sheet.equate("s_{t}", _alone(mode.discrete.time_slope))
        else:
            sheet.say("No conserved quantity is known here.")
        if write is not None:
            write(sheet, sign, mode)
    if any(mode.discrete.gradient.has(DividedDifference) for *_, mode in groups):
        sheet.say(
            "Divided differences, such as sinc z = sin z / z, sinhc z = sinh z / z and (log b − log a)/(b − a), have "
            "their limits where the ends are equal, and are evaluated without cancellation."
        )


def _names_time(groups: Sequence[Group]) -> bool:
    """Whether a conserved quantity depends on time."""
    return any(psi.has(TIME) for *_, mode in groups for psi in mode.conserved)


def _write_field(sheet: EquationSheet, sign: str, mode: Mode) -> None:
    """Write the discrete field f^τ of dmm2: explicitly if ψ determines the orbit, else by its construction."""
    discrete = mode.discrete
    if mode.conserved and discrete.factor is None:
        sheet.say("The mean field f̄ is corrected as little as conservation requires (the minimal-norm scheme):")
        sheet.formula(
            r"f^{\tau} = \bar{f} - \Lambda^{\tau\top} ( \Lambda^{\tau} \Lambda^{\tau\top} )^{-1} "
            r"( \Lambda^{\tau} \bar{f} " + (r"+ s_{t} )" if any(discrete.time_slope) else ")")
        )
        sheet.equate(rf"\bar{{f}}_{{{sign}}}", discrete.mean_field)
        return
    if mode.conserved:
        sheet.say(
            "ψ determines the orbit: f^τ is orthogonal to every row of Λ^τ; its length and sign follow from f. "
            "The step is"
        )
    else:
        sheet.say("The step is the implicit midpoint rule:")
    for variable, component in zip(mode.variables, discrete.expression, strict=True):
        sheet.rate(str(variable), component)


def _write_runge_kutta(sheet: EquationSheet, tableau: ButcherTableau) -> None:
    count = len(tableau.rows)
    earlier, between = "j<i" if tableau.explicit else "j", r"\ldots , " * (count > 2)
    sheet.formula(
        rf"k_{{i}} = f ( t_{{k}} + c_{{i}} \tau , x_{{k}} + \tau \sum_{{{earlier}}} a_{{i,j}} k_{{j}} ) , "
        f"i = 1 , {between}{count}"
    )
    sheet.formula(r"\Delta = \tau \sum_{i} b_{i} k_{i}")
    if tableau.source:
        sheet.say(tableau.source)
        return
    rows = [
        [f"{i + 1}", _math(node), *_weights(row, count)]
        for i, (node, row) in enumerate(zip(tableau.nodes, tableau.rows, strict=True))
    ]
    rows.append(["Δ", "", *_weights(tableau.weights, count)])
    columns = [f"<math>{name_markup(f'k_{{{i + 1}}}')}</math>" for i in range(count)]
    sheet.table(["stage", "<math><mi>c</mi></math>", *columns], rows)


def _weights(weights: Sequence[Expr], count: int) -> list[str]:
    row = [_math(weight) if weight != 0 else "" for weight in weights]
    return row + [""] * (count - len(row))


def _math(expression: Expr) -> str:
    return f"<math>{markup(expression)}</math>"


def _write_composition(sheet: EquationSheet, weights: Sequence[float]) -> None:
    count = len(weights)
    sheet.say(f"A step is {count} steps Φ of dmm2 one after another, of lengths γᵢτ:")
    sheet.formula(rf"x_{{k+1}} = ( \Phi_{{{count}}} \circ \cdots \circ \Phi_{{1}} ) ( x_{{k}} )")
    pairs = [(f"{i + 1}, {count - i}", printed(f"{weights[i]:.16g}")) for i in range(count // 2)]
    sheet.table(
        ["i", "<math><msub><mi>γ</mi><mi>i</mi></msub></math>"],
        [*pairs, (f"{count // 2 + 1}", printed(f"{weights[count // 2]:.16g}"))],
    )


# The transition ------------------------------------------------------------------------------------------------------


def _write_transition(
    sheet: EquationSheet, system: core.PiecewiseSystem, locate: bool, order: int | None, scale: float
) -> None:
    one = system.two_sided
    here, beside, g = ("side", "the other side", "g") if one else ("region", "region s′", "a guard g")
    if not locate:
        sheet.say(
            f"None: a step across the surface is completed with the field of the {here} in which it began, and only "
            f"the next one takes that of {beside if one else 'the next region'}. The order falls to one."
        )
        return
    alike = next(_groups(system.laws, ()))[:2] == _BOTH
    before, after = ("", "") if alike else ("_{s}", "_{s'}")
    to = "" if alike else f" from {here} s to {'the other side s′' if one else 'the region s′ that follows'}"
    sheet.say(
        f"Where a step{to} changes the sign of {g}, the time t̂ and the state x̂ of the crossing are located on the "
        "scheme itself, whose mean velocity over a step is f^τ:"
    )
    at = r"\hat{t} , \hat{x}" if any(g.has(TIME) for g in system.laws.surfaces) else r"\hat{x}"
    field = rf"f^{{\tau}}{before} ( t_{{k}} , x_{{k}} , \hat{{t}} , \hat{{x}} )"
    sheet.formula(rf"\hat{{x}} = x_{{k}} + ( \hat{{t}} - t_{{k}} ) {field}")
    sheet.formula(f"g ( {at} ) = 0")
    if order is not None:
        moved = f"by c τᵖ with p = {order} and c = {scale:g}"
        sheet.say(f"Its time is then perturbed on purpose, {moved}, and x̂ is solved for anew there:")
        sheet.formula(rf"\hat{{t}} \leftarrow \hat{{t}} + c \tau^{{{order}}}")
    start = r"\hat{x}"
    if system.laws.jumps:
        completed = "" if alike else " in the region entered"
        sheet.say(f"There the state is reset from x̂ to x̂⁺. From there the step is completed{completed}:")
        start = r"\hat{x}^{+}"
    else:
        sheet.say(f"The step is completed{'' if alike else f' with the field of {beside}'}:")
    field = rf"f^{{\tau}}{after} ( \hat{{t}} , {start} , t_{{k+1}} , x_{{k+1}} )"
    sheet.formula(rf"x_{{k+1}} = {start} + ( t_{{k+1}} - \hat{{t}} ) {field}")
    sheet.say("In the paper: Algorithm 1, Mannshardt’s transition scheme; equations (2.4) to (2.6).")


def _write_sliding(sheet: EquationSheet) -> None:
    sheet.say(
        "Where both fields point towards the surface, the state slides along it, with the combination of both that "
        "keeps g = 0 (Filippov), until ġ₋ or ġ₊ vanishes, the rates of g along f₋ and f₊:"
    )
    names = {Symbol(name): name for name in (r"\dot{g}_{-}", r"\dot{g}_{+}", "f_{-}", "f_{+}")}
    (below, above, minus, plus), sheet.names = names, names
    sheet.equate("f_{S}", (below * plus - above * minus) / (below - above))


# Parts of the page ---------------------------------------------------------------------------------------------------


def _parameter_table(system: core.PiecewiseSystem) -> str:
    names = names_of(system)
    rows = [
        [
            f"<math>{markup(Symbol(p.name), names)}</math>",
            f'<span class="number">{printed(f"{system.values[p.name]:.12g}")}</span>',
            escape(p.doc),
        ]
        for p in system.parameters
    ]
    return table(["parameter", "value", "meaning"], rows) if rows else ""


def _source(lines: Sequence[str]) -> str:
    text = escape("\n".join(lines))
    return f"<details><summary>LaTeX of these equations</summary><pre><code>{text}</code></pre></details>"
