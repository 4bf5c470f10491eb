"""The mathematics of a declared system: symbols, both sides, and vectorised evaluation. Parameters stay symbols."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy
from numpy.typing import ArrayLike
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME, parse
from core.symbolic.impacts import stays_on_surface
from core.symbolic.multiplier import DiscreteField, Endpoints

__all__ = ["Laws", "Side", "derive"]

#: Powers of a variable to ±this are written as products: numpy works out x*x*x ten times as fast as x**3.
_LONGEST_PRODUCT = 4

_LONGEST = 2**53  #: of a whole number that is a float for certain


@dataclass(frozen=True)
class Side:
    """One side of the switching surface: its field f, its conserved quantities ψ, and ġ = g_t + ∇g·f."""

    sign: int
    variables: tuple[Symbol, ...]
    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    g_dot: Expr
    taken: frozenset[str]

    @cached_property
    def discrete(self) -> DiscreteField:
        """The side's Discrete Multiplier Method."""
        return DiscreteField(self.field, self.conserved, Endpoints.of(self.variables, set(self.taken)))

    def rate_of(self, psi: Expr) -> Expr:
        """Time derivative of ψ along the field: zero if ψ is conserved."""
        change = sum((psi.diff(v) * f for v, f in zip(self.variables, self.field, strict=True)), psi.diff(TIME))
        return sympy.sympify(change)


class Laws:
    """Everything about a system that does not depend on the values of its parameters."""

    def __init__(self, variables: Sequence[str], parameters: Sequence[str], texts: dict[str, Any]) -> None:
        self.x = tuple(Symbol(v) for v in variables)
        self.p = tuple(Symbol(q) for q in parameters)
        names = (*variables, *parameters)
        self.g = parse(texts["g"], names, "g")
        self.gradient = tuple(self.g.diff(v) for v in self.x)
        self.jump = _parse_all(texts["jump"], names, "jump") if texts["jump"] is not None else None
        self.sides = {
            sign: self._side(
                sign,
                _parse_all(texts[f"f_{word}"], names, f"f_{word}"),
                _parse_all(texts[f"psi_{word}"], names, f"psi_{word}"),
            )
            for sign, word in ((-1, "minus"), (1, "plus"))
        }
        #: Bounds of parameters for which a system has checked the surface and the conserved quantities.
        self.verified: set[object] = set()
        self._functions: dict[object, Callable[..., Floats]] = {}

    @cached_property
    def edged(self) -> bool:
        """Whether a field or a ψ has a function that is not defined everywhere: a root, a real power, a logarithm."""
        parts = [e for side in self.sides.values() for e in (*side.field, *side.conserved)]
        return any(e.atoms(sympy.log) or any(not p.exp.is_Integer for p in e.atoms(sympy.Pow)) for e in parts)

    @cached_property
    def jump_stays(self) -> bool:
        """Whether the jump leads from the surface to the surface."""
        return self.jump is not None and stays_on_surface(self.g, self.x, self.jump)

    def _side(self, sign: int, field: tuple[Expr, ...], conserved: tuple[Expr, ...]) -> Side:
        pairs = zip(self.x, field, strict=False)  # lengths are checked by the system, with a better message
        g_dot = sum((self.g.diff(v) * f for v, f in pairs), self.g.diff(TIME))
        taken = frozenset(str(s) for s in (*self.x, *self.p))
        return Side(sign, self.x, field, conserved, sympy.sympify(g_dot), taken)

    def evaluate(self, key: object, expressions: Sequence[Expr], t: ArrayLike, x: ArrayLike, p: Floats) -> Floats:
        """Values of expressions at many states.

        Parameters
        ----------
        key
            Under which the numpy function is kept.
        t
            Times, broadcast against the states.
        x
            (..., d) states.

        Returns
        -------
        (..., len(expressions)); nan or inf where there is no value, without a warning.
        """
        if key not in self._functions:
            names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
            products = [_powers_as_products(_with_floats(e).xreplace(names)) for e in expressions]
            self._functions[key] = sympy.lambdify(list(names.values()), products, "numpy")
        states = np.asarray(x, dtype=float)
        shape = np.broadcast_shapes(np.shape(t), states.shape[:-1])
        result = np.empty((*shape, len(expressions)))
        with np.errstate(all="ignore"):
            columns = self._functions[key](np.asarray(t, dtype=float), *np.moveaxis(states, -1, 0), *p)
            for k, column in enumerate(columns):
                result[..., k] = column
        return result

    def numbers(self, key: object, expressions: Sequence[Expr], t: float, x: Sequence[float], p: Floats) -> Floats:
        """Values of expressions at one state, as `evaluate` gives them, but in a tenth of its time."""
        if ("number", key) not in self._functions:
            names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
            own = [_with_floats(e).xreplace(names) for e in expressions]
            self._functions["number", key] = sympy.lambdify(list(names.values()), own, "math")
        try:
            return np.array(self._functions["number", key](t, *x, *p.tolist()), dtype=float)
        except (ArithmeticError, ValueError, TypeError):  # no value, or a complex one, is nan or inf in numpy
            return self.evaluate(key, expressions, t, x, p)


def _with_floats(expression: Expr) -> Expr:
    """Return an expression whose long numbers are floats, as numpy has no integers of more than 64 bits."""
    long = [n for n in expression.atoms(sympy.Rational) if max(abs(n.p), n.q) > _LONGEST]
    return expression.xreplace({n: sympy.Float(_nearest(n), 17) for n in long})


def _powers_as_products(expression: Expr) -> Expr:
    """Write small whole powers of variables as products."""

    def is_small_power(e: Expr) -> bool:
        return bool(e.is_Pow and e.base.is_Symbol and e.exp.is_Integer and abs(e.exp) <= _LONGEST_PRODUCT)

    def product(power: Expr) -> Expr:
        factors = [power.base] * abs(int(power.exp))
        written = sympy.UnevaluatedExpr(sympy.Mul(*factors, evaluate=False))
        return written if power.exp > 0 else 1 / written

    return expression.replace(is_small_power, product)


def _nearest(number: sympy.Rational) -> float:
    try:
        return float(number.p / number.q)
    except OverflowError:
        return math.copysign(math.inf, number.p)


def _parse_all(texts: Sequence[Any], names: Sequence[str], what: str) -> tuple[Expr, ...]:
    return tuple(parse(text, names, f"{what}[{k}]") for k, text in enumerate(texts))


@lru_cache(maxsize=256)
def derive(
    variables: tuple[str, ...],
    parameters: tuple[str, ...],
    f_minus: tuple[str, ...],
    f_plus: tuple[str, ...],
    g: str,
    psi_minus: tuple[str, ...],
    psi_plus: tuple[str, ...],
    jump: tuple[str, ...] | None,
) -> Laws:
    """The laws of a declaration, derived once however many parameter values it is used with."""
    texts = {
        "f_minus": f_minus, "f_plus": f_plus, "g": g, "psi_minus": psi_minus, "psi_plus": psi_plus, "jump": jump,
    }  # fmt: skip
    return Laws(variables, parameters, texts)
