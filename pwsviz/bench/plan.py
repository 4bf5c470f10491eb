"""How much is measured: the standard benchmark, the quick one and the long one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import core

__all__ = ["LONG", "QUICK", "STANDARD", "Plan"]


@dataclass(frozen=True)
class Plan:
    """What a benchmark runs."""

    compared: tuple[str, ...]
    """Systems on which the Taylor method is compared with external solvers."""
    drawn: int
    """Number of problems drawn at random on which it is compared, too."""
    share: float
    """End time of the comparisons, as part of the time of some 500 crossings."""
    budget: float
    """Seconds that one run of SciPy may take."""
    repeats: int
    """Number of runs of each that is timed; the fastest counts."""
    seeds: tuple[str, ...]
    """Systems whose steps, sliders and conserved quantities are measured."""
    methods: tuple[str, ...]
    """Methods with which these are measured."""
    first_calls: tuple[str, ...]
    """Methods whose first call is timed in a new process."""
    steps: int
    """Number of steps of a run whose cost, arrays or conserved quantities are measured."""
    drift_steps: tuple[int, ...]
    """Numbers of steps after which the drift of ψ is measured."""
    perturbation_orders: tuple[int, ...]
    """Orders p of the perturbations τᵖ of crossing times."""
    orders: tuple[str, ...]
    """Systems for which the orders of all methods are fitted."""
    ensembles: tuple[str, ...]
    """Systems of which many members are integrated at once."""
    drawn_ensembles: int
    """Number of problems drawn at random of which many members are integrated, too."""
    members: int
    """Number of members of each."""
    prange: bool
    """Whether they are also integrated by a prange of numba, which takes some tens of seconds to compile once."""


STANDARD = Plan(
    compared=("harmonic_oscillator", "elliptic_curve", "pendulum", "rigid_body", "chua"),
    drawn=6,
    share=1.0,
    budget=2.0,
    repeats=15,
    seeds=("harmonic_oscillator", "elliptic_curve"),
    methods=tuple(core.METHODS),
    first_calls=("dmm2", "dmm8", "prk8", "taylor"),
    steps=100_000,
    drift_steps=(10**5, 10**6),
    perturbation_orders=(1, 2, 3),
    orders=("harmonic_oscillator", "elliptic_curve"),
    ensembles=("elliptic_curve", "pendulum"),
    drawn_ensembles=2,
    members=100_000,
    prange=True,
)
LONG = replace(STANDARD, drawn=40, drift_steps=(10**6, 10**7, 10**8), orders=tuple(core.CATALOGUE))
QUICK = Plan(
    compared=("elliptic_curve",),
    drawn=1,
    share=0.04,
    budget=60.0,  # it takes a fraction of a second where nothing else is at work, and is tested where much is
    repeats=2,
    seeds=("elliptic_curve",),
    methods=("dmm2", "prk8", "taylor"),
    first_calls=("dmm2",),
    steps=2000,
    drift_steps=(10**3,),
    perturbation_orders=(),
    orders=("elliptic_curve",),
    ensembles=("elliptic_curve",),
    drawn_ensembles=0,
    members=100,
    prange=False,
)
