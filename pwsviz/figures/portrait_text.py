"""The phase portrait in words."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

import numpy as np

import core
from pwsviz.figures.marks import ENDS, left_out
from pwsviz.geometry.plane import Axes, Plane
from pwsviz.geometry.projection import (
    PLANE,
    forced,
    is_divided,
    moves_curves,
    planes_alike,
    psi_names_time,
    shows_regions,
    shows_surface,
    surface_texts,
    surfaces_shown,
)
from pwsviz.results.orbits import Orbit
from pwsviz.results.requests import RunInputs
from pwsviz.results.results import Pictures
from pwsviz.scene.equations import equations, indexed
from pwsviz.scene.names import met_at_surfaces, readable, short_name
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import brief, printed, shortest
from pwsviz.text.words import JUMPS_MARKED, as_text, listed, perturbation

__all__ = [
    "SUMMARY", "bodies_text", "figures_of", "law_line", "law_markup", "parted_words", "perturbed_words",
    "portrait_note", "portrait_text", "run_line", "scale_note",
]  # fmt: skip

FIELD = "the field"
"""What is drawn of no projection."""

SUMMARY = "Phase portrait"

ROUNDING = 1e-12
"""Part of the largest coordinate below which a number is 0 but for rounding."""

LARGE, SMALLER = 320, 480
"""Most characters of equations that the header of a lecture has room for, about three lines, and in smaller type."""

LONGEST = 300
"""Characters of equations below the portrait, about three lines; longer ones are in the view Scheme only."""

FEW_PLACES = 4
"""Most places at a surface that are told of a curve."""

UNBROKEN = 40
"""Most characters of an equation that stands on one line, also on a phone."""


def perturbed_words(inputs: RunInputs) -> str:
    """Say by how much crossing times are perturbed, or that crossings are not located; empty where they are."""
    order, scale = inputs.scheme.perturbation_order, inputs.scheme.perturbation_scale
    if not inputs.scheme.locate:
        return "Crossings are not located: the law changes up to a step behind the surface, with an error of order 1."
    if order is None:
        return ""
    shift = scale * inputs.tau**order
    by = f"{perturbation(order, scale)} = {shift:.3g}"
    if abs(shift) < np.spacing(inputs.tau):
        return f"All crossing times are perturbed by {by}: less than rounding, so that nothing changes."
    return f"All crossing times are perturbed on purpose, by {by}: crossings lie off the surface, and change ψ."


def portrait_text(
    system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
) -> str:
    """Return what the portrait shows, in sentences for screen readers."""
    across, up = (variable_name(system.variables[k]) for k in pictures.plane.axes)
    (at,) = pictures.plane.values(np.array([starts[selected]]))
    x, y = (coordinate + 0.0 for coordinate in at.tolist())  # without the sign of −0
    count = len(starts)
    which = "one trajectory, which starts" if count == 1 else f"{count} trajectories; number {selected + 1} starts"
    met = "; ".join(f"{one.method}: {one.course}" for one in pictures.summaries)
    scheme = pictures.inputs.selected[0].scheme
    meets = "It meets a surface" if scheme.locate and scheme.perturbation_order is None else "It changes sides"
    shape = "".join(f" {_shape(orbit, pictures.plane, across, up, meets)}" for orbit in pictures.orbits[:1])
    return f"{SUMMARY} of {system.name}, {up} against {across}: {which} at ({x:.4g}, {y:.4g}). {met}.{shape}"


def _shape(orbit: Orbit, plane: Plane, across: str, up: str, meets: str) -> str:
    """Return how far a curve reaches, and where it meets a surface, or changes sides, in sentences."""
    if not np.isfinite(orbit.reach).all():
        return ""
    ends = plane.values(orbit.reach)
    least = ROUNDING * np.abs(ends).max(axis=0)
    (x_low, y_low), (x_high, y_high) = np.where(np.abs(ends) > least, ends, 0.0).tolist()
    reach = f"{across} from {x_low:.3g} to {x_high:.3g}, {up} from {y_low:.3g} to {y_high:.3g}"
    met = plane.values(orbit.crossings[:FEW_PLACES])
    places = [f"({a:.3g}, {b:.3g})" for a, b in np.where(np.abs(met) > least, met, 0.0).tolist()]
    more = ["elsewhere"] * (len(orbit.crossings) > FEW_PLACES)
    where = f" {meets} at {listed([*places, *more])}." * bool(places)
    return printed(f"The curve of {orbit.method} goes through {reach}.{where}")


def marks_text(pictures: Pictures) -> str:
    """Return whose marks at surfaces are drawn, and where those of jumps stand, for captions; empty if none is."""
    drawn = [*pictures.orbits, *pictures.others]
    kinds = {kind for orbit in drawn for kind in orbit.kinds}
    if not kinds:
        return ""
    what = "jumps" if kinds == {"jump"} else "crossings"  # the legend says of marks that some are left out
    whose = f"The marks of {what} belong to all integrators." * (len(pictures.orbits) > 1)
    return " ".join(filter(None, [whose, JUMPS_MARKED * ("jump" in kinds)]))


def which_start(pictures: Pictures) -> str:
    """Return of which start runs are told, where there are several."""
    count, index = pictures.inputs.start_count, pictures.inputs.index
    return f"Start {index + 1} of {count}." if count > 1 else ""


def figures_of(pictures: Pictures, warnings: Sequence[str] = ()) -> str:
    """Return of which start the figures below the portrait are, what is to be said of others, and what is not marked.

    `warnings` are those of all runs, if they are known: the selected ones, and those of the other starts.
    """
    drawn = [*pictures.orbits, *pictures.others]
    said = (_which_start(pictures), _warned(pictures, warnings), _without_psi(pictures), _beyond_wall(pictures))
    return " ".join(filter(None, (*said, left_out(drawn))))


def parted_words(pictures: Pictures) -> str:
    """Say from when on the selected runs cannot all be right, as those of a chaotic system sooner or later."""
    if pictures.parting is None:
        return ""
    met, agreeing, parted = met_at_surfaces(pictures.system), pictures.parting.agreeing, pictures.parting.parted
    if len(parted) == 1:
        ((other, t),) = parted
        words = f"From t = {t:.4g} on, the {met} of {other} and {agreeing} do not correspond"
        return f"{words}: the two no longer follow the same solution."
    others = listed([f"{other} from t = {t:.4g} on" for other, t in parted])
    return (
        f"The {met} of the others do not correspond to those of {agreeing}: {others}. The two runs of each such pair "
        "no longer follow the same solution."
    )


def _warned(pictures: Pictures, warnings: Sequence[str]) -> str:
    """Say of which starts that are not selected there is a warning; those that stop early are named as such."""
    told_already = {number for number, orbit in pictures.numbered if orbit.end is not None}
    told = {number for (number, _), words in zip(pictures.numbered, warnings, strict=False) if words}
    told -= {pictures.inputs.index + 1, *told_already}
    those = "it" if len(told) == 1 else "one of them"
    return f"There is a warning for {_named(pictures, told)}: select {those} to read it." if told else ""


def _without_psi(pictures: Pictures) -> str:
    """Say at which starts ψ is not defined, so that there is no level set through them."""
    bare = {number for number, orbit in pictures.numbered if orbit.bare}
    through = "them" if len(bare) > 1 else "it"
    told = f"no level set passes through {through}, and no |Δψ| can be told"
    return f"ψ is not defined at {_named(pictures, bare)}: {told}." if bare else ""


def _beyond_wall(pictures: Pictures) -> str:
    """Say which starts lie beyond a wall, where no other run comes."""
    beyond = {number for number, orbit in pictures.numbered if orbit.beyond}
    which = _named(pictures, beyond)
    lies = "lie" if len(beyond) > 1 else "lies"
    return (
        f"{which[:1].upper()}{which[1:]} {lies} beyond the wall: no trajectory from its other side comes there."
        if beyond
        else ""
    )


def _named(pictures: Pictures, numbers: Collection[int]) -> str:
    """Return “the start” if there is but one, else the numbers of some of them."""
    if pictures.inputs.start_count == 1:
        return "the start"
    return f"start{'s' * (len(numbers) > 1)} {listed([str(number) for number in sorted(numbers)])}"


def _which_start(pictures: Pictures) -> str:
    count, index = pictures.inputs.start_count, pictures.inputs.index
    if count == 1:
        return ""
    words: dict[int, list[str]] = {}
    for number, orbit in pictures.numbered:
        if orbit.end is not None and number != index + 1:
            words.setdefault(number, []).append(ENDS[orbit.end.status].word)
    stops: dict[str, list[str]] = {}
    for number, of_methods in sorted(words.items()):
        stops.setdefault(" or ".join(dict.fromkeys(of_methods)), []).append(str(number))
    told = []
    for why, numbers in stops.items():
        which = f"start {numbers[0]} stops" if len(numbers) == 1 else f"starts {listed(numbers)} stop"
        told.append(f"{which} early ({why})")
    others = "; ".join(told)
    return f"Start {index + 1} of {count}." + (f" {others[0].upper()}{others[1:]}." if others else "")


_LETTER = "[A-Za-zΑ-Ωα-ω]"
_NAME = f"(?<!{_LETTER})({_LETTER}[₀-₉₊₋ₐ-ₜ⁰¹²³⁴-⁹]*)"

BY_FUNCTION, BY_NAME = re.compile(f"{_NAME}·(?={_LETTER}{_LETTER})"), re.compile(rf"{_NAME}·(?={_LETTER}|\()")
"""Products of a single letter, with its indices, that need no dot: with a function; with another one or a bracket."""

POWER = re.compile(r"\^\(?([^\s()^]+)\)?")
"""An exponent that no raised character stands for, with its brackets."""


def law_markup(system: core.PiecewiseSystem) -> str:
    """Return the equations of a system as HTML, a line for each law, or where they are if they are long.

    No equation breaks across lines unless it would be too wide for a phone.
    """
    laws = indexed(equations(system))
    if len(laws) > LONGEST:
        return as_text("The equations are in the tab Scheme.", "about")
    return "".join(_with_powers(law, "law") for law in laws.split("; "))


def law_line(system: core.PiecewiseSystem) -> str:
    """Return equations as HTML for the header, with reset maps if these leave the type large.

    Equations for which the header has no room are left out.
    """
    parts = indexed(equations(system)).split("; ")
    if sum(map(len, parts)) > LARGE:
        parts = [one for one in parts if not one.startswith("reset map")]
    length = sum(map(len, parts))
    kind = "law short" if length <= LARGE else "law"
    return "".join(_with_powers(one, kind) for one in parts) if length <= SMALLER else ""


def run_line(scene: Scene) -> str:
    """Return parameters, step size and span of time as HTML for the header, and what is unusual at crossings."""
    numbers = [f"{short_name(q)} {brief(scene.values[q.name])}" for q in scene.declaration.parameters]
    at_crossings = ["crossings not located"] * (not scene.locate)
    if scene.locate and scene.perturbation_order is not None:
        at_crossings = [f"crossings perturbed by {perturbation(scene.perturbation_order, scene.perturbation_scale)}"]
    run = f"τ {brief(scene.tau)}, 0 ≤ t ≤ {shortest(float(scene.t_end))}"
    return _with_powers("; ".join([*filter(None, [", ".join(numbers)]), run, *at_crossings]), "law short")


def _with_powers(law: str, kind: str) -> str:
    """Return a paragraph with equations, their exponents raised."""
    return POWER.sub(r"<sup>\1</sup>", as_text(_kept_together(law), kind))


def _kept_together(law: str) -> str:
    """Return the equations of a law with spaces that do not break within them, and without dots that tell nothing."""
    law = BY_NAME.sub(r"\1", BY_FUNCTION.sub("\\1\N{NARROW NO-BREAK SPACE}", law))
    each = re.split(r"(?<=[,:;]) ", law)
    return " ".join(one.replace(" ", "\N{NO-BREAK SPACE}") if len(one) <= UNBROKEN else one for one in each)


def portrait_note(system: core.PiecewiseSystem, axes: Axes, caption: bool = False) -> str:
    """Return in words what the portrait leaves out or shows at t = 0 only; empty if that is nothing.

    On the page, but not in a `caption`, this tells also how to select the plane, and that the surface moves.
    """
    sentences = []
    if system.dimension > PLANE:
        sentences.append(_projection(system, axes))
        sentences += ["“Portrait in the plane of” selects the plane."] * (not caption)
    elif not system.laws.sides.shape[1]:
        sentences.append("The regions overlap; their fields are therefore not drawn.")
    elif not is_divided(system):
        sentences.append("The regions change with time: their fields and level sets are not drawn.")
    animated = ", and while animated at the time shown" * (not caption)
    if system.laws.instants and shows_regions(system, axes):
        which = " or ".join(f"{readable(surface_texts(system)[k], system)} = 0" for k in sorted(system.laws.instants))
        sentences.append(
            f"At the instants at which {which} {_changes(system)} in the whole plane at once; the regions are shown "
            f"just after t = 0{animated}."
        )
    elif moves_curves(system) and shows_surface(system, axes):
        sentences.append(f"The surface moves with time; it and the regions are shown at t = 0{animated}.")
    elif forced(system) and system.dimension == PLANE:
        sentences.append("The field depends on time: it is drawn at t = 0.")
    if system.dimension == PLANE and psi_names_time(system):
        sentences.append("ψ depends on time, so its level sets move and are not drawn.")
    return " ".join(sentences)


def scale_note(system: core.PiecewiseSystem, plane: Plane) -> str:
    """Return what an axis like “v / 10” shows, and why; empty where both variables are drawn as they are."""
    names = [variable_name(system.variables[k]) for k in plane.axes]
    for name, other, unit in zip(names, reversed(names), plane.units, strict=True):
        if unit != 1.0:
            how = f"divided by {unit:g}" if unit > 1.0 else f"multiplied by {1 / unit:g}"
            more = "more" if unit > 1.0 else "less"
            return f"{name} is drawn {how}, as it varies far {more} than {other} and both axes have one scale."
    return ""


def _changes(system: core.PiecewiseSystem) -> str:
    """Return what happens at instants: the law changes, or all states jump, or both."""
    laws = system.laws
    alike = len({laws.mode(k).field for k in range(len(laws.regions))}) == 1
    words = (*("the law changes",) * (not alike), *("every state jumps",) * laws.jumps)
    return " and ".join(words) or "the law changes"


def _projection(system: core.PiecewiseSystem, axes: Axes) -> str:
    """Return on which plane a system of more variables is projected, and what is not drawn in it."""
    plane = _named_plane(system, axes)
    shown, texts = surfaces_shown(system, axes), surface_texts(system)
    hidden = [f"{readable(g, system)} = 0" for k, g in enumerate(texts) if k not in shown]
    lost = (
        [FIELD]
        + ["the level sets"] * (system.laws.most_conserved > 0)
        + [f"the surface{'s' * (len(hidden) > 1)} {', '.join(hidden)}"] * bool(hidden)
    )
    words = (
        f"Projection onto the plane of {plane}, in which {listed(lost)} {'is' if lost == [FIELD] else 'are'} not drawn."
    )
    return f"{words} {bodies_text(system, axes)}".rstrip()


def bodies_text(system: core.PiecewiseSystem, axes: Axes) -> str:
    """Return how other planes alike, such as those of further bodies, are drawn; empty without any."""
    alike = [_named_plane(system, one) for one in planes_alike(system, axes)]
    if not alike:
        return ""
    marks = f"marks of {met_at_surfaces(system)} refer to {_named_plane(system, axes)}"
    thin = "Thin lines" if len(alike) == 1 else "Successively thinner lines"
    return f"{thin} show {listed([f'({one})' for one in alike])}; discs mark where they start; {marks}."


def _named_plane(system: core.PiecewiseSystem, axes: Axes) -> str:
    return ", ".join(variable_name(system.variables[k]) for k in axes)
