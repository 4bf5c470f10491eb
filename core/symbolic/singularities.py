"""Singularities of a field: zeros of an expression, across which a step would leave the solution's domain of existence.

They are zeros of the bases of negative powers, of the cosine in a tangent, and of logarithms' arguments of which only
the size counts, as in log(x**2). Other logarithms and roots have no value beyond the zero of their argument, so that a
step there has none either. A zero at which the field stays bounded, as that of sin(x)/x, is no singularity;
neither is one at which the mode ends anyway, if the field can be integrated up to it, as 1/sqrt(x) can.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import factor_list, together
from core.symbolic.expressions import TIME
from core.symbolic.near_zeros import written_near
from core.symbolic.tape import Floats, Tape, digits

__all__ = ["BESIDE", "Ends", "Singularity", "Zeros", "is_singular", "zeros_of_denominators"]

#: Digits in which zeros are found and the field is evaluated beside them, and the largest argument of exp there.
_ARITHMETIC = 120, 1e3
#: A value below this is zero at a zero found in so many digits.
_ZERO = 1e-100
#: Distances from a zero, along a line through it, at which the sizes of the field are compared …
_NEAR, _NEARER = 1e-6, 1e-18
#: … and their ratio beyond which it is unbounded; that of a logarithm is 3.
_GROWN = 2.0
#: Ratio beyond which its integral towards the zero is unbounded, as that of 1/x and not that of 1/sqrt(x).
_NOT_INTEGRABLE = 0.5 * _NEAR / _NEARER
#: Distance from a zero, relative to time and state, at which a field is evaluated in place of the zero, …
BESIDE = 2.0**-44
#: … and farther distances, at all of which a field keeps its digits, or does not …
_DISTANCES = (BESIDE, *(2.0**-k for k in range(36, 0, -4)))
#: … and the error, relative to the field, that is no loss of digits; that beside the zero may be larger, since the zero
#: of u is known to the 2⁻⁸th part of this distance.
_RIGHT, _RIGHT_BESIDE = 1e-12, 1e-6
#: Number of lines along which zeros are sought, of points on each, and of zeros that are looked at.
_LINES, _PLACES, _ZEROS = 24, 65, 6
#: Half the length of these lines, in units of the direction.
_REACH = 4.0
#: Most corrections of a zero.
_CORRECTIONS = 60
#: Functions whose values lie between −1 and 1, and those that vanish where their argument does, alone.
_BETWEEN_ONES, _LIKE_ARGUMENT = (sympy.sin, sympy.cos, sympy.tanh), (sympy.sinh, sympy.tanh)
#: Number of operations beyond which a denominator is not factored, to save time.
_LONG = 200


class Ends(NamedTuple):
    """Where a mode ends."""

    zeros: tuple[Expr, ...]
    """Expressions that vanish there."""
    before: bool
    """Whether it ends before it comes there, as sliding does, and not at these zeros."""


class Singularity(NamedTuple):
    """Where a field is not bounded."""

    zero: Expr
    """An expression that vanishes there."""
    angle: Expr | None
    """Of a sine or cosine, an expression that passes an integer where it vanishes: a step may pass several."""
    but_zero: bool = False
    """Whether the field is bounded where the angle is 0, as that of x/sin(x)."""


class Zeros(NamedTuple):
    """Where denominators of a field, and arguments of logarithms, vanish."""

    singular: tuple[Singularity, ...]
    """Where the field is not bounded."""
    removable: tuple[Expr, ...]
    """Expressions at whose zeros it is bounded, though it cannot be evaluated there, but beside them."""
    near: tuple[Expr, ...]
    """Expressions near whose zeros it is bounded, but loses its digits unless it is evaluated by a series."""
    noisy: tuple[Expr, ...]
    """The same, where no series is found."""
    rounded: tuple[Expr, ...]
    """Denominators with the factors `removable`, as they are written: they may vanish by rounding alone."""


def zeros_of_denominators(field: Sequence[Expr], variables: Sequence[Symbol], ends: Ends) -> Zeros:
    """Zeros that a solution can pass: where an expression of time or state changes sign.

    Parameters
    ----------
    ends
        Expressions at whose zeros the mode ends.
    """
    moving = {TIME, *variables}
    operations = dict.fromkeys(node for f in field for node in sympy.preorder_traversal(f))
    found = dict.fromkeys(u for node in operations for u in _vanishing(node) if u.zero.free_symbols & moving)
    changing = dict.fromkeys(u for u, _ in found if not (_least(u) >= 0.0 or _least(-u) >= 0.0))
    singular, removable = [], []
    for u in changing:
        there = list(_at_zeros(u, field, ends))
        if not _is_singular(there, ends):
            if not any(growth > _GROWN for growth, _ in there):  # else the mode has ended before
                removable += [v for v in found if v.zero == u]
            continue
        origins = [*_factors(u.args[0], signed=False)] if u.func == sympy.sin else []
        origins = [v for v in origins if v.zero.free_symbols & moving]
        regular = bool(origins) and not any(is_singular(v, field, ends) for v, _ in origins)
        singular.append(Singularity(u, _angle(u), regular))
        removable += origins if regular else []
    return _evaluated(tuple(singular), removable, field)


def _evaluated(singular: tuple[Singularity, ...], removable: Sequence[_Factor], field: Sequence[Expr]) -> Zeros:
    """Tell how a field is evaluated at zeros where it is bounded: beside them, by series near them, or not at all."""
    ways: dict[Expr, list[Expr]] = {}
    for u, written in removable:
        ways.setdefault(u, [u]).append(written)
    poles = {sympy.cos(v.args[0]) for f in field for v in f.atoms(sympy.tan)}  # of which 1/tan(v) makes zeros
    steady = [u for u in ways if u not in poles and _keeps_digits(u, field, field)]
    near: list[Expr] = []
    noisy: list[Expr] = []
    best = tuple(field)
    for u in [u for u in ways if u not in steady]:
        for way in dict.fromkeys(ways[u]):
            new = tuple(written_near(f, [way]) for f in best)
            if _keeps_digits(u, field, new):
                near.append(way)
                best = new
                break
        else:
            (steady if _keeps_digits(u, field, best) else noisy).append(u)
    rounded = dict.fromkeys(way for u in steady for way in ways[u] if way not in steady)
    return Zeros(singular, tuple(steady), tuple(near), tuple(noisy), tuple(rounded))


class _Factor(NamedTuple):
    """A factor of a denominator, or of a logarithm's argument."""

    zero: Expr
    written: Expr
    """What vanishes with it, as it is written: its rounded value may be zero where that of the factor is not."""


def _vanishing(node: Expr) -> Iterator[_Factor]:
    """Expressions at whose zeros an operation is not bounded, though it has values on both sides."""
    if isinstance(node, sympy.tan):
        yield _Factor(sympy.cos(node.args[0]), sympy.cos(node.args[0]))
    elif isinstance(node, sympy.log):
        yield from _factors(node.args[0], signed=True)
    elif node.is_Pow and node.exp.is_number and node.exp < 0:
        yield from _factors(node.base, signed=not node.exp.is_Integer and bool(node.exp > -1))


def _polynomial_factors(u: Expr) -> list[tuple[Expr, Expr]]:
    """Factors of a polynomial and their powers; none of another expression, nor where sympy finds none."""
    try:
        found = factor_list(u)[1] if u.is_polynomial() else []
    except sympy.BasePolynomialError:  # of the number (43/10)**(2*E), or with it
        return []
    return [(v, sympy.Integer(n)) for v, n in found]


def _factors(u: Expr, signed: bool) -> Iterator[_Factor]:
    """Factors of an expression without their powers; where its sign counts, as under a root, those of even powers.

    One that has no factors stays as it is written, so that rounding makes it zero where it makes the denominator zero:
    multiplied out, (t − 1)² + 10⁻¹⁶ vanishes to rounding near t = 1, and 3x + 5y where x/5 + y/3 does not.
    """
    if isinstance(u, _LIKE_ARGUMENT):
        yield from _factors(u.args[0], signed)
        return
    if u.is_Mul and not signed:
        for v in u.args:
            yield from _factors(v, signed)
        return
    numerator, denominator, powers = u, sympy.S.One, []
    if u.count_ops() <= _LONG:
        numerator, denominator = sympy.fraction(together(u.replace(sympy.tan, lambda v: sympy.sin(v) / sympy.cos(v))))
        powers = _polynomial_factors(numerator)
    powers = [(v, n) for v, n in powers or map(Expr.as_base_exp, sympy.Mul.make_args(numerator)) if not v.is_number]
    if denominator.is_number and [n for _, n in powers] == [1]:
        powers = [(u, sympy.S.One)]
    for base, exponent in powers:
        if exponent.is_Integer and exponent > 0 and not (signed and exponent % 2):
            yield _Factor(base, u)
        elif exponent.is_number and exponent > 0 and not exponent.is_Integer:
            yield from _factors(base, signed=True)


def _least(u: Expr) -> float:
    """A lower bound that the form of an expression tells, where it has a value; −∞ if it tells none."""
    if u.is_number:
        return float(u)
    if u.is_Add:
        return sum(map(_least, u.args))
    if u.is_Mul:
        number, rest = u.as_coeff_Mul()
        if isinstance(rest, _BETWEEN_ONES):
            return -abs(float(number))
        return 0.0 if number > 0 and all(_least(v) >= 0.0 for v in sympy.Mul.make_args(rest)) else -math.inf
    if u.is_Pow:
        return 0.0 if not u.exp.is_Integer or u.exp % 2 == 0 or _least(u.base) >= 0.0 else -math.inf
    if isinstance(u, _BETWEEN_ONES):
        return -1.0
    return {sympy.exp: 0.0, sympy.cosh: 1.0}.get(u.func, -math.inf)


def _angle(u: Expr) -> Expr | None:
    if isinstance(u, sympy.sin):
        return u.args[0] / sympy.pi
    return u.args[0] / sympy.pi + sympy.Rational(1, 2) if isinstance(u, sympy.cos) else None


class _Line(NamedTuple):
    """A straight line in the space of all symbols, in many digits."""

    point: Mapping[Symbol, Any]
    direction: Mapping[Symbol, Any]

    def at(self, distance: Any) -> dict[Symbol, Any]:
        """A point of it."""
        return {s: v + distance * self.direction[s] for s, v in self.point.items()}


def is_singular(u: Expr, field: Sequence[Expr], ends: Ends) -> bool:
    """Whether the field is not bounded at one of several zeros of u; or none is found."""
    return _is_singular(list(_at_zeros(u, field, ends)), ends)


def _is_singular(there: Sequence[tuple[float, bool]], ends: Ends) -> bool:
    at_end = math.inf if ends.before else _NOT_INTEGRABLE
    return not there or any(growth > (at_end if over else _GROWN) for growth, over in there)


def _at_zeros(u: Expr, field: Sequence[Expr], ends: Ends) -> Iterator[tuple[float, bool]]:
    """How far the field grows towards each of several zeros of u, and whether the mode ends there."""
    tape = Tape((*field, *ends.zeros))
    for line in islice(_lines_through_zeros(u, tape), _ZEROS):
        yield _growth(line, tape, field), _is_over(line, tape, ends.zeros)


def _keeps_digits(u: Expr, field: Sequence[Expr], written: Sequence[Expr]) -> bool:
    """Whether a field, as it is written for evaluation, is right in floating point near several zeros of u."""
    exactly, tape, many = Tape((*field, u)), Tape(written), digits(*_ARITHMETIC)
    for line in islice(_lines_through_zeros(u, exactly), _ZEROS):
        for distance in _DISTANCES:
            place = {s: float(v) for s, v in line.at(distance).items()}
            try:
                values = exactly.run(many, {s: many.context.mpf(v) for s, v in place.items()})
            except ArithmeticError:
                return False
            with np.errstate(all="ignore"):
                found = tape.run(Floats(), {s: np.array([v]) for s, v in place.items()})
            for f, w in zip(field, written, strict=True):
                right, least = float(values[exactly.place[f]]), _RIGHT_BESIDE if distance == BESIDE else _RIGHT
                if not np.all(np.abs(found[tape.place[w]] - right) <= least * (abs(right) + 1.0)):
                    return False
    return True


def _growth(line: _Line, tape: Tape, field: Sequence[Expr]) -> float:
    """Ratio of the sizes of a field at two distances from the point of a line; infinite where it has no value."""
    many = digits(*_ARITHMETIC)
    try:
        near, nearer = (tape.run(many, line.at(many.context.mpf(s))) for s in (_NEAR, _NEARER))
    except ArithmeticError:
        return math.inf
    pairs = [(abs(near[tape.place[f]]), abs(nearer[tape.place[f]])) for f in field]
    return max(float(b / a) if a else math.inf if b else 0.0 for a, b in pairs)


def _is_over(line: _Line, tape: Tape, ends: Sequence[Expr]) -> bool:
    """Whether a mode ends at the point of a line."""
    many = digits(*_ARITHMETIC)
    try:
        nearer = tape.run(many, line.at(many.context.mpf(_NEARER)))
    except ArithmeticError:
        return False
    return any(abs(nearer[tape.place[u]]) < _NEARER / _NEAR for u in ends)


def _lines_through_zeros(u: Expr, others: Tape) -> Iterator[_Line]:
    """Lines through zeros of u, sought along lines through random points."""
    tape, many = Tape([u]), digits(*_ARITHMETIC)
    symbols = sorted({node for node in (*tape.nodes, *others.nodes) if node.is_Symbol}, key=str)
    rng, along = np.random.default_rng(20261124), np.linspace(-_REACH, _REACH, _PLACES)
    for _ in range(_LINES):
        point, direction = rng.uniform(0.2, 2.0, len(symbols)), rng.normal(size=len(symbols))
        columns = dict(zip(symbols, point[:, None] + direction[:, None] * along, strict=True))
        with np.errstate(all="ignore"):
            signs = np.sign(np.broadcast_to(tape.run(Floats(), columns)[-1], len(along)))
        line = _Line(*(dict(zip(symbols, map(many.context.mpf, v.tolist()), strict=True)) for v in (point, direction)))
        for k in np.flatnonzero(signs[1:] * signs[:-1] < 0):
            zero = _zero(u, tape, line, along[k : k + 2].tolist())
            if zero is not None:
                yield line._replace(point=line.at(zero))


def _zero(u: Expr, tape: Tape, line: _Line, between: list[float]) -> Any:
    """Distance along a line to the zero of u between two others; None where u does not vanish, or has no value."""
    many = digits(*_ARITHMETIC)

    def value(distance: Any) -> Any:
        return tape.run(many, line.at(distance))[tape.place[u]]

    try:
        zero = many.context.findroot(value, between, solver="anderson", tol=_ZERO, maxsteps=_CORRECTIONS, verify=False)
        return zero if abs(value(zero)) < _ZERO else None
    except ArithmeticError:
        return None
