"""The laws of a declared system: symbols, modes, and vectorised evaluation. Parameters stay symbols."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.symbolic.impacts import stays_on_surface
from core.symbolic.multiplier import DiscreteField, Endpoints

__all__ = ["Laws", "Mode", "coordinates", "derive", "rate_along"]

Vector: TypeAlias = "tuple[Symbol, ...]"
Pair: TypeAlias = "tuple[tuple[Expr, ...], tuple[Expr, ...]]"

#: Powers up to this are written as products: numpy works out x*x*x ten times as fast as x**3.
_LONGEST_PRODUCT = 4

#: Largest integer up to which every integer is a double.
_LARGEST_EXACT = 2**53


@dataclass(frozen=True)
class Mode:
    """The law where g has one sign: its field f, its conserved quantities ψ, and ġ = g_t + ∇g·f."""

    sign: int
    variables: tuple[Symbol, ...]
    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    g_dot: Expr
    taken: frozenset[str]

    @cached_property
    def discrete(self) -> DiscreteField:
        """The Discrete Multiplier Method of this law."""
        return DiscreteField(self.field, self.conserved, Endpoints.of(self.variables, set(self.taken)))

    def rate_of(self, psi: Expr) -> Expr:
        """Time derivative of ψ along the field: zero if ψ is conserved."""
        return rate_along(self.field, self.variables, psi)


class Laws:
    """Everything about a system that does not depend on the values of its parameters.

    Parameters
    ----------
    x, p
        Symbols of the d variables, and of the parameters.
    g
        The switching function.
    fields, quantities
        f (d expressions) and ψ (any number of them) of the sides − and +.
    jump
        d expressions: the state after reaching the surface; None where the state is continuous.
    """

    def __init__(
        self, x: Vector, p: Vector, g: Expr, fields: Pair, quantities: Pair, jump: tuple[Expr, ...] | None
    ) -> None:
        self.x, self.p, self.g, self.jump = x, p, g, jump
        self.gradient = tuple(g.diff(v) for v in x)
        taken = frozenset(map(str, (*x, *p)))
        #: Sign of g -> mode.
        self.modes = {
            sign: Mode(sign, x, field, conserved, rate_along(field, x, g), taken)
            for sign, field, conserved in zip((-1, 1), fields, quantities, strict=True)
        }
        self._functions: dict[object, Callable[..., Floats]] = {}

    @cached_property
    def edged(self) -> bool:
        """Whether a field or a ψ contains a root, a real power or a logarithm, which are not defined everywhere."""
        parts = [e for mode in self.modes.values() for e in (*mode.field, *mode.conserved)]
        return any(e.atoms(sympy.log) or any(not p.exp.is_Integer for p in e.atoms(sympy.Pow)) for e in parts)

    @cached_property
    def jump_stays(self) -> bool:
        """Whether the jump maps the surface into itself."""
        return self.jump is not None and stays_on_surface(self.g, self.x, self.jump)

    def evaluate(self, key: object, expressions: Sequence[Expr], t: ArrayLike, x: ArrayLike, p: Floats) -> Floats:
        """Values of expressions at many states.

        Parameters
        ----------
        key
            Key under which the compiled numpy function is cached.
        t
            (...) times, broadcast against the states.
        x
            (..., d) states.

        Returns
        -------
        (..., len(expressions)); nan or inf where an expression is undefined, without a warning.
        """
        if key not in self._functions:
            names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
            products = [_powers_as_products()(_with_floats(e).xreplace(names)) for e in expressions]
            self._functions[key] = sympy.lambdify(list(names.values()), products, "numpy")
        states = np.asarray(x, dtype=float)
        shape = np.broadcast_shapes(np.shape(t), states.shape[:-1])
        result = np.empty((*shape, len(expressions)))
        with np.errstate(all="ignore"):
            columns = self._functions[key](np.asarray(t, dtype=float), *coordinates(states), *p)
            for k, column in enumerate(columns):
                result[..., k] = column
        return result

    def numbers(self, key: object, expressions: Sequence[Expr], t: float, x: Sequence[float], p: Floats) -> Floats:
        """Values of expressions at one state, as from `evaluate`, but ten times as fast."""
        if ("number", key) not in self._functions:
            names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
            own = [_with_floats(e).xreplace(names) for e in expressions]
            self._functions["number", key] = sympy.lambdify(list(names.values()), own, "math")
        try:
            return np.array(self._functions["number", key](t, *x, *p.tolist()), dtype=float)
        except (ArithmeticError, ValueError, TypeError):  # undefined or complex: nan or inf in numpy
            return self.evaluate(key, expressions, t, x, p)


def coordinates(states: Floats) -> list[Floats]:
    """Return each coordinate (...) of states (..., d); ten times as fast as `numpy.moveaxis`."""
    return [states[..., k] for k in range(states.shape[-1])]


def _with_floats(expression: Expr) -> Expr:
    """Replace long integers and ratios by floats, as numpy has no integers of more than 64 bits."""
    long = [n for n in expression.atoms(sympy.Rational) if max(abs(n.p), n.q) > _LARGEST_EXACT]
    return expression.xreplace({n: sympy.Float(_nearest(n), 17) for n in long})


@cache
def _powers_as_products() -> Callable[[Expr], Expr]:
    """Return what writes small powers as products. It is imported when needed: that takes a tenth of `import core`."""
    from sympy.codegen.rewriting import create_expand_pow_optimization

    return create_expand_pow_optimization(_LONGEST_PRODUCT)  # type: ignore[no-any-return]


def _nearest(number: sympy.Rational) -> float:
    try:
        return float(number.p / number.q)
    except OverflowError:
        return math.copysign(math.inf, number.p)


def rate_along(field: Sequence[Expr], variables: Sequence[Symbol], u: Expr) -> Expr:
    """Time derivative of u along a field: u_t + ∇u·f."""
    return sympy.Add(u.diff(TIME), *(u.diff(v) * f for v, f in zip(variables, field, strict=True)))


#: `Laws`, cached: they are derived once for all parameter values.
derive = lru_cache(maxsize=256)(Laws)
