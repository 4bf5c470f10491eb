"""Scenes to start from: the figures of the paper, and a few beyond it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

__all__ = ["FIRST_LOOK", "PRESETS", "Preset", "shown_example"]

FIRST_LOOK = "first_look"
"""Key of the scene of a page that is opened without a link."""


@dataclass(frozen=True)
class Preset:
    """A scene to start from, with hints."""

    key: str
    """Its key in PRESETS."""
    title: str
    """As the menu shows it."""
    figure: str
    """Label of the figure in the paper, such as ``fig:CQ_elliptic``; empty for a preset beyond the paper."""
    look: str
    """What to look at, in one line."""
    try_: str
    """What to try, in one line."""
    settings: Mapping[str, object]
    """Values of settings of a `Scene` by name; all others have their defaults."""


_OSCILLATOR = {
    "system": "harmonic_oscillator",
    "values": {"omega2_minus": 3.0, "omega2_plus": 1.0},
    "starts": ((1.0, 1.0),),
}
_CURVE = {
    "system": "elliptic_curve",
    "values": {"a_minus": -3.0, "a_plus": -2.0, "radius": 1.0},
    "starts": ((-1.0, -1.0),),
}
#: End times long enough for the 31 crossings of an order study.
_OSCILLATOR_STUDY = {**_OSCILLATOR, "methods": ["dmm2"], "study_method": "dmm2", "t_end": 80.0}
_CURVE_STUDY = {**_CURVE, "methods": ["dmm2"], "study_method": "dmm2", "t_end": 32.0}


def _first_look() -> tuple[Preset, ...]:
    return (
        Preset(
            FIRST_LOOK, "A first look", "",
            "At τ = 0.08, dmm2 keeps the conserved quantity ψ to round-off; rk2, of order 2 as well, spirals outwards.",
            "Halve τ: |Δψ| of rk2 falls more than eightfold. dmm2 stays on the curve, but errs in time: see Order.",
            # Both have the 20 crossings of the solution up to here, and a sweep beyond would meet no surface.
            {**_CURVE, "tau": 0.08, "t_end": 19.2, "view": "conserved", "sweep_range": (0.1, 1.6)},
        ),
    )  # fmt: skip


def _field_types() -> tuple[Preset, ...]:
    common = {"methods": ["dmm2"], "tau": 0.01, "t_end": 40.0, "view": "conserved"}
    figure = "fig:vftypes"
    below, above = ((-1.0, -2.0), (0.0, -2.0), (1.0, -2.0)), ((-1.0, 2.0), (0.0, 2.0), (1.0, 2.0))
    beside = ((-1.0, 0.1), (1.0, 0.1), (-1.0, -0.1), (1.0, -0.1))
    return (
        Preset(
            "vf_upward", "Field types: transversal, upward", figure,
            "Both fields point up through y = 0: every trajectory from below crosses once, with a kink.",
            "Make the field below faster (v₋): trajectories arrive sooner, and cross all the same.",
            {**common, "system": "type_upward", "starts": below},
        ),
        Preset(
            "vf_downward", "Field types: transversal, downward", figure,
            "The mirror image: both fields point down, and every trajectory from above crosses once.",
            "Click below the line: a trajectory from there never meets it.",
            {**common, "system": "type_downward", "starts": above},
        ),
        Preset(
            "vf_repelling", "Field types: repelling", figure,
            "Both fields point away from y = 0: trajectories beside the line leave it, and none crosses.",
            "Type a start with y = 0: the solution may leave to either side, so the run stops at once and reports it.",
            {**common, "system": "type_repelling", "starts": beside},
        ),
        Preset(
            "vf_sliding", "Field types: sliding", figure,
            "Both fields point to y = 0: every run reaches the line at t = 20 and ends there, where sliding begins.",
            "Tick “Slide along the surface”: all go on to the right, at the speed 0.1 that both fields have there.",
            {**common, "system": "type_sliding", "starts": (*below, *above), "slide": False},
        ),
    )  # fmt: skip


def _portraits() -> tuple[Preset, ...]:
    common = {"methods": ["dmm2"], "tau": 0.01, "t_end": 20.0, "view": "conserved"}
    return (
        Preset(
            "portrait_harmonic", "Portrait: oscillator", "fig:portraits",
            "Circular arcs above y = 0 join elliptic arcs below it: closed curves whose curvature jumps on the line.",
            "Set ω₋² = ω₊²: the jump in curvature disappears.",
            {**common, **_OSCILLATOR, "starts": ((0.5, 0.5), (1.0, 1.0), (1.5, 1.5))},
        ),
        Preset(
            "portrait_elliptic", "Portrait: elliptic curves", "fig:portraits",
            "Arcs of elliptic curves of one family inside the unit circle and of another outside, joined on it.",
            "Start at x = 1.5, y = 2: the curve through this point is unbounded, and the run blows up before t = 1.",
            {**common, **_CURVE, "starts": ((-1.0, -1.0), (-1.0, -0.5), (-1.2, 0.0))},
        ),
    )  # fmt: skip


def _time_errors() -> tuple[Preset, ...]:
    look = (
        "The error of the crossing time has slope 2 at crossings 10, 20 and 30: it grows, but the order stays the same."
    )
    return (
        Preset(
            "harmonic_time", "Crossing time: oscillator", "fig:harmonic_timeError", look,
            "Choose dmm4: slope 4. Do not locate crossings: large, scattered errors that decrease only about as τ.",
            {**_OSCILLATOR_STUDY, "view": "time"},
        ),
        Preset(
            "elliptic_time", "Crossing time: elliptic curve", "fig:elliptic_time", look,
            "Choose rk2: its slope is 2, too, but it does not conserve ψ: see Conserved quantity.",
            {**_CURVE_STUDY, "view": "time"},
        ),
    )  # fmt: skip


def _transitions() -> tuple[Preset, ...]:
    words = {
        1: ("Crossing times are perturbed by τ: the slope is 2 before the first crossing and falls to 1 after it.",
            "Choose p = 2: the order is restored."),
        2: ("Crossing times are perturbed by τ², which is of the order of the method’s own error: the slope stays 2.",
            "Choose p = 1: the order falls to 1."),
        15: ("Crossing times are perturbed by τ¹⁵, which is negligible: the slope is 2 before and after 30 crossings.",
             "Do not locate crossings: after the first crossing the errors scatter, and decrease only about as τ."),
    }  # fmt: skip
    systems = (
        ("harmonic", "oscillator", _OSCILLATOR_STUDY),
        ("elliptic", "elliptic curve", _CURVE_STUDY),
    )
    return tuple(
        Preset(
            f"{key}_transition_{p}", f"Order across the surface: {name}, p = {p}", f"fig:{key}_transition", *words[p],
            {**study, "perturbation_order": p, "view": "order"},
        )
        for key, name, study in systems
        for p in (1, 2, 15)
    )  # fmt: skip


def _conserved() -> tuple[Preset, ...]:
    common = {"methods": ["dmm2", "rk2"], "tau": 1e-3, "t_end": 100.0, "view": "conserved"}
    return (
        Preset(
            "cq_harmonic", "Conserved quantity: oscillator", "fig:CQ_harmonic",
            "dmm2 conserves the energy to 10⁻¹⁵ over 41 crossings; for rk2 max |Δψ| = 2.6×10⁻⁷.",
            "Make τ ten times as large: the error of rk2 grows a thousandfold, that of dmm2 not at all.",
            {**common, **_OSCILLATOR},
        ),
        Preset(
            "cq_elliptic", "Conserved quantity: elliptic curve", "fig:CQ_elliptic",
            "dmm2 conserves ψ to 10⁻¹⁵ over 105 crossings; for rk2 max |Δψ| = 3.2×10⁻⁶.",
            "Add rk8: its error is round-off here only because τ is small. At τ = 0.05 it drifts, and dmm2 does not.",
            {**common, **_CURVE},
        ),
    )  # fmt: skip


def _stopping() -> tuple[Preset, ...]:
    return (
        Preset(
            "grazing", "Touching the surface", "",
            "Three swings of a pendulum: short of α = 0.5, across it, and touching it, where rounding would decide.",
            "Move start 3, or α, by 10⁻⁶: the swing falls short or crosses.",
            {
                "system": "pendulum", "starts": ((-0.35, 0.0), (-0.65, 0.0), (-0.5, 0.0)), "selected": 2,
                "methods": ["dmm2"], "tau": 0.01, "t_end": 20.0, "view": "conserved",
            },
        ),
        Preset(
            "zeno", "A ball comes to rest", "",
            "Bounces follow ever faster and accumulate at t = 1.3553 (Zeno): the run stops there and reports it.",
            "Raise ε to 0.8: the time until it rests, proportional to (1 + ε)/(1 − ε), triples.",
            {"system": "bouncing_ball", "methods": ["dmm2"], "tau": 0.01, "t_end": 5.0, "view": "conserved"},
        ),
        Preset(
            "sticking", "Dry friction sticks", "",
            "Each swing is shorter than the last by 4μ = 1.6. The block sticks at the fourth turning point, y = −0.2.",
            "Less friction: more swings. With μ = 2 the block sticks at the first turning point.",
            {"system": "coulomb_friction", "methods": ["dmm2"], "tau": 0.01, "t_end": 20.0, "view": "conserved"},
        ),
    )  # fmt: skip


def _comparisons() -> tuple[Preset, ...]:
    return (
        Preset(
            "side_by_side", "Four integrators side by side", "",
            "The same curve at τ = 0.01: max |Δψ| = 1.8×10⁻³ for rk2 and 1.4×10⁻⁷ for rk4; dmm2 and prk8 conserve ψ.",
            "Halve τ: the error of rk2 falls to an eighth, that of rk4 to a thirtieth.",
            {**_CURVE, "methods": ["dmm2", "rk2", "rk4", "prk8"], "tau": 0.01, "t_end": 60.0, "view": "conserved"},
        ),
        Preset(
            "kepler", "A planet and a shell of dust", "",
            "Outside the shell, its mass attracts as well; prk8 conserves energy and angular momentum to "
            "within 3×10⁻¹⁵, rk4 does not.",
            "Set μ₊ = μ₋: the shell has no mass, and the planet stays on one Kepler ellipse.",
            {"system": "kepler", "methods": ["rk4", "prk8"], "tau": 0.01, "t_end": 60.0, "view": "conserved"},
        ),
        Preset(
            "taylor", "Taylor series at tolerance 10⁻¹²", "",
            "Order and step follow from the tolerance: 63 crossings in some 250 steps, ψ conserved to 10⁻¹⁵.",
            "Set the tolerance to 10⁻⁶: fewer steps; ψ is still conserved.",
            {**_CURVE, "methods": ["taylor"], "tau": 1.0, "tolerance": 1e-12, "t_end": 60.0, "view": "conserved"},
        ),
        Preset(
            "cost", "What an error costs", "",
            "Higher order is cheaper: prk8 at τ = 0.05 beats dmm2 at τ = 10⁻³ with a tenth of the evaluations.",
            "Choose “error of ψ”: dmm2 and prk8 are at round-off whatever τ.",
            {
                **_CURVE, "methods": ["dmm2", "dmm4", "rk4", "prk8"], "study_method": "dmm2", "tau": 0.01,
                "t_end": 60.0, "view": "cost",
            },
        ),
    )  # fmt: skip


def _several_surfaces() -> tuple[Preset, ...]:
    return (
        Preset(
            "walls", "Between two walls", "",
            "Every impact takes a twentieth of the speed; between impacts dmm2 keeps the energy to round-off, rk2 does "
            "not.",
            "Set ε = 1: the impacts take nothing, and the swing stays as it is.",
            {"system": "two_walls", "methods": ["dmm2", "rk2"], "tau": 0.01, "t_end": 40.0, "view": "conserved"},
        ),
        Preset(
            "chua", "Chua’s double scroll", "",
            "Two surfaces, three regions. The orbit is chaotic: rk4 and taylor differ by 0.1 at t = 44.",
            "Halve τ: they differ by 0.1 about 12 time units later; halve it again: about 14 later still.",
            {
                "system": "chua", "methods": ["rk4", "taylor"], "tau": 0.02, "t_end": 60.0, "view": "state",
                "axes": (0, 2),
            },
        ),
    )  # fmt: skip


def _sections() -> tuple[Preset, ...]:
    settings: dict[str, Any] = {"methods": ["taylor"], "tau": 1.0, "tolerance": 1e-10, "view": "section"}
    return (
        Preset(
            "henon_heiles_section", "Poincaré section of the Hénon–Heiles system", "",
            "At energy 1/8 islands lie in a chaotic sea. The wall changes nothing: the potential is even in x.",
            "Click on the section: orbits of the same energy. Zoom into the edge of an island.",
            {
                **settings, "system": "henon_heiles", "values": {"wall": 0.0}, "t_end": 40.0,
                "starts": tuple(_of_energy(1 / 8, y, v) for y, v in _HENON_HEILES), "section_points": 4000,
            },
        ),
        Preset(
            "vibrating_table", "A ball on a vibrating table", "",
            "Just after each bounce: islands about periodic bounces, as at φ = π/2, v = π, between chaotic bands.",
            "Set ε = 0.97: five orbits end in such a bounce, at φ = 1.38, four at rest. Set a = 0.4: the bands join.",
            {
                **settings, "system": "vibrating_table", "t_end": 12.0,
                "starts": tuple((0.0, y, 0.0) for y in (3.0, 0.5, 1.0, 2.0, 4.0, 5.0, 8.0, 12.0, 16.0)),
                "section_points": 4000,
            },
        ),
    )  # fmt: skip


def _sweeps() -> tuple[Preset, ...]:
    settings: dict[str, Any] = {"methods": ["taylor"], "tau": 1.0, "view": "sweep"}
    return (
        Preset(
            "vibrating_table_sweep", "A bouncing ball: from order to chaos", "",
            "Bounces accumulate, or recur at speed π; at a = 1.527 the period doubles, and near 1.71 chaos begins.",
            "Click at a = 1.3 and 1.72. Behind “more”, continue downwards: one bounce a period lasts down to a = π/3.",
            {
                **settings, "system": "vibrating_table", "values": {"a": 1.3, "restitution": 0.5}, "axes": (1, 2),
                "starts": ((4.2, 6.0, 0.0),), "t_end": 60.0, "sweep_range": (1.0, 1.8), "sweep_coordinate": "v",
                "sweep_discard": 400, "sweep_end": 5000.0,
            },
        ),
        Preset(
            "chua_sweep", "Chua’s circuit: from order to chaos", "",
            "A closed orbit has one point per loop: two from α = 8.175, four from 8.40, then chaos; "
            "beyond 8.8, on both scrolls.",
            "Click at α = 8.1, 8.3 and 8.7. Zoom in by Ctrl and the wheel, and sweep the visible range.",
            {
                **settings, "system": "chua", "values": {"alpha": 8.7}, "axes": (0, 2), "t_end": 100.0,
                "sweep_parameter": "alpha", "sweep_discard": 200, "sweep_end": 3000.0,
            },
        ),
    )  # fmt: skip


_HENON_HEILES = ((-0.1, 0.0), (0.2, 0.0), (0.28, 0.0), (0.36, 0.0), (-0.25, 0.1), (0.05, 0.25), (-0.15, 0.3))
"""Where orbits of Hénon and Heiles meet x = 0, as (y, v)."""


def _of_energy(energy: float, y: float, v: float) -> tuple[float, float, float, float]:
    """Return the state of Hénon and Heiles at x = 0 of some energy, that leaves to the right."""
    return 0.0, y, math.sqrt(2 * energy - y**2 - v**2 + 2 * y**3 / 3), v


def _frozen(preset: Preset) -> Preset:
    settings = MappingProxyType(dict(preset.settings))
    return Preset(preset.key, preset.title, preset.figure, preset.look, preset.try_, settings)


#: Every preset by key, in display order: the paper's figures first.
PRESETS: Mapping[str, Preset] = MappingProxyType({
    preset.key: _frozen(preset)
    for group in (
        _first_look, _conserved, _portraits, _field_types, _time_errors, _transitions, _stopping, _comparisons,
        _several_surfaces, _sections, _sweeps,
    )
    for preset in group()
})  # fmt: skip


def shown_example(scene: object) -> str:
    """Return the title of the example whose settings a scene has; empty if it has those of none."""
    for one in PRESETS.values():
        if all(getattr(scene, key) == value for key, value in one.settings.items()):
            return one.title
    return ""
