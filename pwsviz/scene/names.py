"""Names of settings, of their values and of parameters, as the page shows them."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from decimal import Decimal

import core
from pwsviz.scene.views import VIEWS
from pwsviz.text.math_names import unicode_name, variable_name
from pwsviz.text.numbers import PLAIN, RAISED
from pwsviz.text.words import listed

LABELS: Mapping[str, str] = {
    "system": "System", "own": "Your own system", "values": "Parameters", "starts": "Starts",
    "selected": "Selected start", "axes": "Portrait in the plane of", "window": "Limits of the portrait",
    "methods": "Integrators", "tau": "Step size τ", "tolerance": "Taylor tolerance",
    "t_end": "End time", "locate": "Locate crossings (transition scheme)",
    "slide": "Slide along the surface (Filippov)",
    "perturbation_order": "Perturb crossing times by c·τᵖ; order p", "perturbation_scale": "Factor c",
    "view": "View", "study_method": "Integrator of the view", "peers": "External solvers",
    "cost_across": "Horizontal axis of Cost", "cost_up": "Vertical axis of Cost",
    "stability_part": "Part of Stability", "stability_shown": "Colours of the map",
    "stability_coordinate": "Coordinate of Stability", "stability_around": "Start that the map is drawn around",
    "sweep_parameter": "Parameter",
    "sweep_range": "Range of the parameter", "sweep_coordinate": "Coordinate",
    "sweep_of": "Surface of the diagram: h(t, x) = 0", "sweep_direction": "Direction of crossing",
    "sweep_continuation": "Continuation", "sweep_values": "Values", "sweep_points": "Points per value",
    "sweep_discard": "Transient points discarded", "sweep_end": "Latest end time",
    "section_of": "Surface of the section", "section_direction": "Direction of the section",
    "section_axes": "Coordinates of the section", "section_points": "Points per start",
    "section_discard": "Transient points discarded", "section_map": "Return map",
}  # fmt: skip
"""Label of each setting."""

EXTERNAL_SOLVERS = {"scipy": "SciPy", "heyoka": "heyoka"}
COST_ACROSS = {"seconds": "run time", "evaluations": "evaluations"}
COST_UP = {"state": "state error", "time": "crossing-time error", "invariant": "error of ψ"}
STABILITY_PARTS = {"map": "Map", "drift": "Long run", "grazing": "Near grazing"}
SWEEP_CONTINUATIONS = {"none": "from the start", "up": "continued upwards", "down": "continued downwards"}
STABILITY_SHOWN = {"outcome": "outcome", "error": "|Δψ|"}
SECTION_DIRECTIONS = {0: "both ways", 1: "rising", -1: "falling"}
SWEEP_DIRECTIONS: Mapping[str | int, str] = {"auto": "automatic"} | SECTION_DIRECTIONS

_DIRECTIONS = {str(way): words for way, words in SWEEP_DIRECTIONS.items()}
_CHOICES = {
    "peers": EXTERNAL_SOLVERS, "cost_across": COST_ACROSS, "cost_up": COST_UP, "stability_part": STABILITY_PARTS,
    "stability_shown": STABILITY_SHOWN, "section_of": {"": "the switching surfaces"},
    "section_direction": _DIRECTIONS, "sweep_direction": _DIRECTIONS,
    "sweep_parameter": {"": "the system’s own"}, "sweep_coordinate": {"": "the first that varies on the surface"},
    "sweep_of": {"": "the switching surfaces"},
    "sweep_continuation": SWEEP_CONTINUATIONS, "system": {"own": "your own"},
}  # fmt: skip


def short_name(parameter: core.Parameter) -> str:
    """Return the symbol of a parameter in Unicode (a₋, ω₊²), or its name where Unicode cannot express the symbol."""
    return unicode_name(parameter.symbol, parameter.name)


def met_at_surfaces(system: core.PiecewiseSystem) -> str:
    """Return what runs meet at the surfaces: “crossings”, “jumps”, which stay in their region, or both."""
    laws = system.laws
    jumps = {
        way.jump is not None and (bool(laws.regions[k].sides) or way.to == k)
        for k, ways in enumerate(laws.ways)
        for way in ways
    }
    return " and ".join(word for jump, word in ((False, "crossings"), (True, "jumps")) if jump in (jumps or {False}))


def as_met(words: str, met: str) -> str:
    """Return words on crossings for a system whose runs meet what `met_at_surfaces` gives: jumps, if nothing else."""
    words = words.replace("crossings or jumps", met)
    return re.sub(r"\bcrossing(?=s?\b)", "jump", words).replace("Crossing", "Jump") if met == "jumps" else words


def tally_of(run: core.Trajectory) -> core.Tally:
    """Return how often a run meets surfaces, counted under the names that `met_at_surfaces` gives."""
    return counted_as(run.tally, met_at_surfaces(run.system))


def counted_as(tally: core.Tally, met: str) -> core.Tally:
    """Return a tally under the names of what runs meet: where these are jumps alone, none is called a crossing."""
    return tally._replace(crossings=0, jumps=tally.crossings + tally.jumps) if met == "jumps" else tally


def told(tally: core.Tally, met: str) -> str:
    """Return the same in words, such as “3 crossings, 2 slides”; “0 jumps” where runs meet jumps alone, and none."""
    return as_met(str(counted_as(tally, met)), met)


def named_settings(settings: Collection[str]) -> str:
    """Return in words which settings these are; another system, which brings its own values of the others, alone."""
    if "system" in settings or "own" in settings:
        return LABELS["system"]
    return listed(list(dict.fromkeys(LABELS.get(name, "Settings of the view") for name in settings)))


def choice_name(setting: str, choice: object) -> str:
    """Return one of the choices of a setting as the page shows it."""
    if setting == "view" and choice in VIEWS:
        return VIEWS[str(choice)].title
    if setting == "system" and choice in core.CATALOGUE:
        return core.CATALOGUE[str(choice)].name
    return _CHOICES.get(setting, {}).get(str(choice), str(choice or "none"))


_TENS = re.compile(
    r"(?<![\w.])(?:(?P<factor>\d+\.?\d*|\.\d+)e(?P<power>[+-]?\d+)|(?P<digits>[1-9]\d*?)(?P<zeros>0{6,}))(?![\w.])",
    re.IGNORECASE,
)
"""A number with an exponent, or with final zeros that one has to count."""


def _power_of_ten(found: re.Match[str]) -> str:
    """Return such a number as 4.7·10⁻⁵, in brackets where a division or a power would take a part of it."""
    factor, power = found["factor"] or found["digits"], int(found["power"] or len(found["zeros"]))
    if abs(power) <= PLAIN:
        return f"{Decimal(found[0]):f}"
    ten = f"10{str(power).translate(RAISED)}"
    product = ten if factor == "1" else f"{factor}·{ten}"
    parted = found.string[: found.start()].endswith("/") and factor != "1"
    return f"({product})" if parted or found.string[found.end() :].startswith("**") else product


def readable(text: str, system: core.PiecewiseSystem) -> str:
    """Return an expression as it is printed: powers raised, a dot for products but 2y, names by their symbols.

    Signs of sums have spaces around them. Numbers with an exponent, and those with many final zeros, are printed with a
    power of ten.
    """
    text = _TENS.sub(_power_of_ten, text)
    symbols = {name: variable_name(name) for name in system.variables}
    symbols |= {q.name: short_name(q) for q in system.parameters}
    text = re.sub(r"[A-Za-z_]\w*", lambda name: symbols.get(name[0], name[0]), text)
    text = re.sub(r"\*\*(\d+)(?![\d.])", lambda power: power[1].translate(RAISED), text)
    text = re.sub(r"(?<![\w.^/*)])(?<!\de-)(?<!\*-)(\d+(?:\.\d+)?)\*(?=[^\W\d])(?!e\d)", r"\1", text)
    text = text.replace("**", "^").replace("*", "·").replace("-", "−")
    return re.sub(r"(?<=[\w).]) *([+−]) *(?=[\w(.])", r" \1 ", text)
