"""Problems on which integrators are compared: systems of the catalogue, and others drawn at random."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
from sympy import Expr, Symbol

import core

__all__ = ["ENDS", "Problem", "drawn_problems", "named_problem"]

#: System -> end time, after some 500 crossings, at which the state is far from the surface.
ENDS = {"harmonic_oscillator": 1240.0, "elliptic_curve": 473.0, "pendulum": 755.0, "rigid_body": 1989.0, "chua": 540.0}
#: System -> values of its parameters, where they are not its own: at its own, Chua's circuit loses all digits by then.
_VALUES = {"chua": {"beta": 16.0}}

#: Potentials in x; the coefficient a has another value on each side, the numbers b and c are drawn.
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
#: Kinetic energies in y and x.
_KINETIC = (
    "y**2/2",
    "sqrt(1 + y**2)",
    "y**2/(2 + b*x**2)",
    "y**2/2*exp(-b*x)",
    "y**2/(2*cosh(b*x))",
)
#: Surfaces, symmetric in y: on others, orbits would gain or lose energy with every turn, and not close.
_SURFACES = ("x - s", "x - k*y**2 - s", "x + k*x**2 - s")
#: Ranges of the numbers that are drawn, and of the start.
_RANGES = {"b": (0.3, 0.8), "c": (0.6, 1.6), "s": (-0.3, 0.3), "k": (-0.2, 0.2), "x": (0.8, 1.6), "y": (-0.3, 0.3)}
#: Range of the coefficient a.
_LEVEL = (0.6, 1.6)
#: Digits of every number drawn.
_DIGITS = 3
#: Number of crossings to the end of a drawn problem.
_CROSSINGS = 500
#: Time by which a drawn problem must have made them.
_LATEST = 1e5


@dataclass(frozen=True)
class Problem:
    """A system to be integrated from its x0 to a time.

    Where it has two sides, they differ in the value of one coefficient only: two parameters with the name of the
    coefficient and the endings _minus and _plus.
    """

    name: str
    system: core.PiecewiseSystem
    end: float

    @cached_property
    def coefficient(self) -> Symbol:
        """The coefficient that has another value on each side."""
        (stem,) = (n.removesuffix("_minus") for n in self.system.values if n.endswith("_minus"))
        return Symbol(stem)

    @cached_property
    def levels(self) -> dict[int, float]:
        """Value of the coefficient on each side."""
        return {side: self.system.values[f"{self.coefficient}_{word}"] for side, word in ((-1, "minus"), (1, "plus"))}

    @cached_property
    def field(self) -> tuple[Expr, ...]:
        """Right-hand side, d expressions in the variables and the coefficient; all other parameters are numbers.

        Raises
        ------
        ValueError
            If the sides differ in more than the coefficient.
        """
        below, above = (tuple(map(self._in_numbers, self.system.laws.modes[side].field)) for side in (-1, 1))
        if below != above:
            raise ValueError(f"the sides of {self.name!r} differ in more than {self.coefficient}: {below} and {above}")
        return below

    @cached_property
    def surface(self) -> Expr:
        """g in the variables."""
        return self._in_numbers(self.system.laws.g)

    def _in_numbers(self, expression: Expr) -> Expr:
        laws, own = self.system.laws, (f"{self.coefficient}_minus", f"{self.coefficient}_plus")
        values = zip(laws.p, self.system.parameter_array, strict=True)
        numbers = {s: self.coefficient if str(s) in own else sympy.Float(v, 17) for s, v in values}
        # Doubles, as in the compiled code: heyoka accepts no ratio whose denominator is not a power of two.
        ratios = {q: sympy.Float(float(q), 17) for q in expression.atoms(sympy.Rational) if q.q & (q.q - 1)}
        return expression.xreplace(numbers | ratios)


def named_problem(name: str, share: float = 1.0) -> Problem:
    """A system of the catalogue, up to a part of its end time."""
    return Problem(name, core.CATALOGUE[name].with_parameters(**_VALUES.get(name, {})), share * ENDS[name])


def drawn_problems(count: int, seed: int) -> Iterator[Problem]:
    """Draw problems from families to which no method is tuned: fields with exp, log, roots and quotients.

    Parameters
    ----------
    count
        How many. Those with too few crossings are skipped.
    seed
        Seed of NumPy's generator; the same seed draws the same problems.
    """
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        system = _drawn_system(rng)
        run = core.integrate(system, (0.0, _LATEST), method="taylor", record="crossings", max_crossings=_CROSSINGS + 1)
        if run.crossing_count > _CROSSINGS:
            found += 1
            yield Problem(system.name, system, float(np.mean(run.crossings.t[-2:])))


def _drawn_system(rng: np.random.Generator) -> core.PiecewiseSystem:
    """x' = ∂ψ/∂y, y' = −∂ψ/∂x with a drawn energy ψ on each side of a drawn surface."""
    numbers = {name: _drawn(rng, *bounds) for name, bounds in _RANGES.items()}
    start = (numbers.pop("x"), numbers.pop("y"))
    at = {sympy.Symbol(name): sympy.Float(value) for name, value in numbers.items()}
    potential, kinetic, surface = (str(rng.choice(texts)) for texts in (_POTENTIALS, _KINETIC, _SURFACES))
    energy, g = (sympy.sympify(text).xreplace(at) for text in (f"{kinetic} + {potential}", surface))
    x, y = sympy.symbols("x y")
    psi_minus, psi_plus = (energy.xreplace({sympy.Symbol("a"): sympy.Symbol(f"a_{s}")}) for s in ("minus", "plus"))
    return core.PiecewiseSystem(
        name=f"{energy}; {g}",
        variables=("x", "y"),
        f_minus=(str(psi_minus.diff(y)), str(-psi_minus.diff(x))),
        f_plus=(str(psi_plus.diff(y)), str(-psi_plus.diff(x))),
        g=str(g),
        psi_minus=(str(psi_minus),),
        psi_plus=(str(psi_plus),),
        parameters=tuple(core.Parameter(f"a_{side}", _drawn(rng, *_LEVEL)) for side in ("minus", "plus")),
        x0=start,
    )


def _drawn(rng: np.random.Generator, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), _DIGITS)
