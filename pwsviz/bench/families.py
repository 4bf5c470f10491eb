"""Problems drawn at random from families that nobody tunes to: fields with exp, log, roots and quotients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy

import core
from pwsviz.bench.problems import Problem

__all__ = ["DrawnProblem", "drawn_problems"]

#: In x, the coefficient a that is another number on each side, and numbers b and c to be drawn.
_POTENTIALS = (
    "a*exp(x) + c*exp(-2*x)",
    "a*log(1 + c*x**2)",
    "a*log(cosh(c*x))",
    "a*cosh(x) + c*x**4/4",
    "x**4/4 + x**2/2 + a*tanh(c*x)",
    "a*sqrt(1 + c*x**2)",
    "x**2/8 - a/(1 + c*x**2)",
    "a*(1 - exp(-c*x))**2 + x**2/10",
    "a*(exp(c*x) - c*x)",
    "a*(1 + c*x**2)**0.3 + x**2/8",
    "a*x**2/2",
)
_KINETIC = (
    "y**2/2",
    "sqrt(1 + y**2)",
    "y**2/(2 + b*x**2)",
    "y**2/2*exp(-b*x)",
    "y**2/(2*cosh(b*x))",
)
#: The same for y and −y: orbits close, where others would gain energy or lose it with every turn.
_SURFACES = ("x - s", "x - k*y**2 - s", "x + k*x**2 - s")
#: Where the numbers and the start are drawn from.
_RANGES = {"b": (0.3, 0.8), "c": (0.6, 1.6), "s": (-0.3, 0.3), "k": (-0.2, 0.2), "x": (0.8, 1.6), "y": (-0.3, 0.3)}
_LEVEL = (0.6, 1.6)
_DIGITS = 3  #: of what is drawn
_CROSSINGS = 500  #: to the end, as in `problems.ENDS`
_LATEST = 1e5  #: by when these must have been made
_FINE = 1e-12  #: tolerance by which they are looked for


@dataclass(frozen=True)
class DrawnProblem(Problem):
    """A problem on a system of its own, called after its energy and its surface."""

    drawn: core.PiecewiseSystem

    @cached_property
    def system(self) -> core.PiecewiseSystem:
        """The system drawn."""
        return self.drawn


def drawn_problems(count: int, seed: int) -> Iterator[DrawnProblem]:
    """Draw problems, the same ones for the same seed.

    Parameters
    ----------
    count
        How many. Energies without a crossing are passed over.
    seed
        Of NumPy's generator.
    """
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        system = _drawn_system(rng)
        run = core.integrate(
            system, (0.0, _LATEST), method="taylor", tolerance=_FINE, record="crossings", max_crossings=_CROSSINGS + 1
        )
        if run.crossing_count > _CROSSINGS:
            found += 1
            yield DrawnProblem(system.name, float(np.mean(run.crossings.t[-2:])), system)


def _drawn_system(rng: np.random.Generator) -> core.PiecewiseSystem:
    numbers = {name: _drawn(rng, *bounds) for name, bounds in _RANGES.items()}
    start = (numbers.pop("x"), numbers.pop("y"))
    at = {sympy.Symbol(name): sympy.Float(value) for name, value in numbers.items()}
    potential, kinetic, surface = (str(rng.choice(texts)) for texts in (_POTENTIALS, _KINETIC, _SURFACES))
    energy, g = (sympy.sympify(text).xreplace(at) for text in (f"{kinetic} + {potential}", surface))
    x, y = sympy.symbols("x y")
    psi_minus, psi_plus = (energy.xreplace({sympy.Symbol("a"): sympy.Symbol(f"a_{s}")}) for s in ("minus", "plus"))
    return core.PiecewiseSystem(
        name=f"{energy}; {g}", variables=("x", "y"), g=str(g), x0=start,
        f_minus=(str(psi_minus.diff(y)), str(-psi_minus.diff(x))), psi_minus=(str(psi_minus),),
        f_plus=(str(psi_plus.diff(y)), str(-psi_plus.diff(x))), psi_plus=(str(psi_plus),),
        parameters=tuple(core.Parameter(f"a_{side}", _drawn(rng, *_LEVEL)) for side in ("minus", "plus")),
    )  # fmt: skip


def _drawn(rng: np.random.Generator, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), _DIGITS)
