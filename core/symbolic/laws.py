"""The laws of a declared system: symbols, modes, and vectorised evaluation. Parameters stay symbols."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache, cached_property, lru_cache
from typing import TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.symbolic.impacts import stays_on_surface
from core.symbolic.mode import SLIDING, Mode
from core.symbolic.sliding import sliding_mode

__all__ = ["Laws", "coordinates", "derive"]

Vector: TypeAlias = "tuple[Symbol, ...]"
Pair: TypeAlias = "tuple[tuple[Expr, ...], tuple[Expr, ...]]"

#: Powers up to this are written as products: numpy works out x*x*x ten times as fast as x**3.
_LONGEST_PRODUCT = 4

#: Largest integer up to which every integer is a double.
_LARGEST_EXACT = 2**53


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
            sign: Mode(sign, x, field, conserved, (g,), taken)
            for sign, field, conserved in zip((-1, 1), fields, quantities, strict=True)
        }
        self._functions: dict[object, Callable[..., Floats]] = {}

    @cached_property
    def sliding(self) -> Mode:
        """The mode of sliding along the surface; derived when it is first asked for."""
        return sliding_mode(self.modes[-1], self.modes[1])

    def mode(self, side: int) -> Mode:
        """The mode of a side, −1 or +1, or that of sliding, 0."""
        return self.sliding if side == SLIDING else self.modes[side]

    @property
    def most_conserved(self) -> int:
        """The larger number of conserved quantities of the two sides."""
        return max(len(mode.conserved) for mode in self.modes.values())

    @property
    def most_conserved_sliding(self) -> int:
        """Bound on the number of conserved quantities of any mode, sliding included, which keeps g as well."""
        return max(self.most_conserved, min(self.most_conserved + 1, len(self.x) - 1))

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


#: `Laws`, cached: they are derived once for all parameter values.
derive = lru_cache(maxsize=256)(Laws)
