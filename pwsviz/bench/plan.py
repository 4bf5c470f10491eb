"""How much is measured: the standard benchmark, the quick one and the long one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import core

__all__ = ["LONG", "QUICK", "STANDARD", "Plan"]


@dataclass(frozen=True)
class Plan:
    """What a benchmark runs."""

    systems: tuple[str, ...]
    """Compared with the rivals."""
    drawn: int
    """Problems drawn at random, compared with heyoka."""
    seeds: tuple[str, ...]
    """Measured by themselves."""
    methods: tuple[str, ...]
    start_methods: tuple[str, ...]
    """Those whose first call is timed in fresh processes."""
    share: float
    """Part of the time of some 500 crossings that the comparison runs to."""
    own_budget: float
    """Longest run of ours in the comparison, in seconds."""
    rival_budget: float
    """Run of SciPy's beyond which no finer tolerance is tried."""
    repeats: int
    repeat_seconds: float
    """How long the repeats of one setting may take; there are a warm-up and one repeat at least."""
    steps: int
    """Of a run whose cost a step, or whose arrays, are measured."""
    step_counts: tuple[int, ...]
    """Numbers of steps to which the cost should be linear."""
    orders: tuple[int | None, ...]
    """Orders of the perturbation in the order study."""
    catalogue: tuple[str, ...]
    """Systems for which the orders of all methods are fitted."""
    in_digits: tuple[str, ...]
    """Those of them for which the order of rk8 is looked at in more digits than a double has."""
    drift_steps: tuple[int, ...]
    """Numbers of steps after which the drift of ψ is looked at."""
    steps_back: int
    """Steps forward, and as many back."""
    larger: tuple[tuple[str, int], ...]
    """Families of larger systems, and dimensions, whose first call is timed in fresh processes."""


STANDARD = Plan(
    systems=("harmonic_oscillator", "elliptic_curve", "pendulum", "rigid_body"),
    drawn=6,
    seeds=("harmonic_oscillator", "elliptic_curve"),
    methods=tuple(core.METHODS),
    start_methods=("dmm2", "dmm8", "prk8", "taylor"),
    share=1.0,
    own_budget=0.3,
    rival_budget=1.0,
    repeats=15,
    repeat_seconds=0.15,
    steps=100_000,
    step_counts=(10**4, 10**5, 10**6, 10**7),
    orders=(None, 1, 2, 3),
    catalogue=("harmonic_oscillator", "elliptic_curve"),
    in_digits=(),
    drift_steps=(10**5, 10**6),
    steps_back=10**5,
    larger=(("springs", 4), ("springs", 16)),
)
LONG = replace(
    STANDARD,
    drawn=40,
    step_counts=(*STANDARD.step_counts, 10**8),
    catalogue=tuple(core.CATALOGUE),
    in_digits=("elliptic_curve", "kepler", "diode_circuit"),
    drift_steps=(10**6, 10**7, 10**8),
    steps_back=10**6,
    larger=(
        *(("springs", d) for d in (2, 4, 8, 12, 16, 24)),
        *(("bodies", d) for d in (8, 12, 16, 24)),
        *(("dense", d) for d in (2, 4, 8, 12, 16, 24)),
        *(("vortices", d) for d in (4, 8, 12)),
        *(("lotka_volterra", d) for d in (2, 4, 8, 12, 16, 24)),
    ),
)
QUICK = Plan(
    systems=("elliptic_curve",),
    drawn=1,
    seeds=("elliptic_curve",),
    methods=("dmm2", "prk8", "taylor"),
    start_methods=("dmm2",),
    share=0.04,
    own_budget=0.02,
    rival_budget=2.0,
    repeats=2,
    repeat_seconds=0.02,
    steps=2000,
    step_counts=(10**3, 10**4),
    orders=(None,),
    catalogue=("elliptic_curve",),
    in_digits=(),
    drift_steps=(10**3,),
    steps_back=10**3,
    larger=(("springs", 6),),
)
