"""Power series of a solution in time, in any number of digits: a step of the exact reference.

The coefficients are integers, fixed-point numbers in units of 2^−point. A sum of products of integers is exact and fast
in plain Python, so some fifty coefficients to forty digits take about a millisecond. Source: Jorba, Zou, Exp. Math. 14
(2005) 99–117, for order and step size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import mul
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from core.symbolic.program import Constant, Digits, Node, Program

__all__ = ["GUARD", "Field", "Step"]

#: Guard bits of every number, beyond the precision of a solution: they absorb the round-off of all steps.
GUARD = 32
#: Coefficients per bit of precision: a step then goes 0.4 of the way to the nearest singularity.
_ORDER = 0.8
#: Number of last coefficients from which the step size is taken: every other one may vanish.
_LAST = 6
#: Most bits by which a term of the series may exceed the state: larger terms would cancel, and lose digits.
_CANCELLED = 6
#: Every fourth coefficient is tested for that.
_APART = 4
#: Exponent of 2 of the longest step, in units of time: it stands for infinity.
_FAR = 100.0
#: Safety factor on the step at which the last coefficients reach the precision.
_SAFETY = 0.9
#: Exponent of 2 of the largest growth of a step over the one before.
_GROWTH = 4
#: Step, in units of time, below which the series is expanded anew in a shorter unit, as coefficients lose digits.
_TOO_LONG = 2.0**-5
#: Bits of a coefficient that are kept before it is rounded to double: its integer may exceed the range of doubles.
_DOUBLE = 96
#: Least exponent of 2 of a state: near the end of the range of doubles.
_LEAST_EXPONENT = -1000


class Field:
    """A field whose solutions can be expanded: made of sums, products, sines and cosines of the variables.

    Parameters
    ----------
    expressions, variables
        d of each.

    Raises
    ------
    ValueError
        If an expression contains another operation.
    """

    def __init__(self, expressions: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> None:
        self._program = Program(expressions, variables)
        for operation, detail, _ in self._program.nodes:
            whole = operation != "power" or (detail.integer or 0) > 0
            if not whole or (operation == "call" and detail not in ("sin", "cos")):
                raise ValueError(f"no power series for {operation} {detail} in a field")

    def unit(self, digits: Digits, x: NDArray[Any]) -> int:
        """Exponent of 2 of the time in which the state x (d,) changes by its own size; 0 if one of them is 0."""
        size, rate = (max(map(abs, u)) for u in (x, self._program.run(digits, list(x))))
        return int(digits.context.mag(size) - digits.context.mag(rate)) if size and rate else 0

    def step(self, digits: Digits, start: Any, x: NDArray[Any], unit: int) -> Step:
        """Expand the solution from state x (d,) at elapsed time `start`, in units of time of 2^unit or shorter."""
        context = digits.context
        size = max(map(abs, x))
        bits = context.prec - GUARD
        point = context.prec - (min(max(context.mag(size), _LEAST_EXPONENT), 0) if size else 0)
        while True:
            series = self._expand(digits, [int(context.ldexp(v, point)) for v in x], point, int(_ORDER * bits), unit)
            length = _step_length(series, bits)
            if length >= _TOO_LONG:
                return Step(digits, start, series, point, unit, length)
            unit += int(np.floor(np.log2(length)))

    def _expand(self, digits: Digits, x: list[int], point: int, order: int, unit: int) -> list[list[int]]:
        """Coefficients (d, order + 1) of the powers of time / 2^unit."""
        expansion = _Expansion(digits, point, [[v] for v in x])
        series = [expansion.place(node) for node in self._program.nodes]
        fields = [series[k] for k in self._program.outputs]
        for k in range(order):
            for action in expansion.actions:
                action(k)
            for state, rate in zip(expansion.states, fields, strict=True):
                state.append((rate[k] << unit if unit >= 0 else rate[k] >> -unit) // (k + 1))
        return expansion.states


class _Expansion:
    """Series of all nodes of a program, and the actions that append coefficient k to each of them, in order."""

    def __init__(self, digits: Digits, point: int, states: list[list[int]]) -> None:
        self.states = states
        self.actions: list[Callable[[int], None]] = []
        self._digits, self._point = digits, point
        self._placed: list[list[int] | Constant] = []

    def place(self, node: Node) -> list[int]:
        """Series of a node; a constant stays a number for the products in which it stands."""
        operation, detail, arguments = node
        given = [self._placed[k] for k in arguments]
        if operation == "number":
            series = self._constant(detail)
            self._placed.append(detail)
            return series
        if operation == "input":
            series = self.states[detail]
        elif operation == "add":
            series = self._sum([self._series_of(u) for u in given])
        elif operation == "multiply":
            series = self._product(given)
        elif operation == "power":
            series = self._product(given * detail.integer)
        else:
            series = self._wave(self._series_of(given[0]))[detail == "cos"]
        self._placed.append(series)
        return series

    def _series_of(self, value: list[int] | Constant) -> list[int]:
        return value if isinstance(value, list) else self._constant(value)

    def _constant(self, number: Constant) -> list[int]:
        p, q = self._digits.ratio(number)
        series = [(p << self._point) // q]
        self.actions.append(lambda k: series.append(0))
        return series

    def _sum(self, terms: list[list[int]]) -> list[int]:
        series: list[int] = []
        self.actions.append(lambda k: series.append(sum([u[k] for u in terms])))
        return series

    def _product(self, factors: list[list[int] | Constant]) -> list[int]:
        numbers = [u for u in factors if not isinstance(u, list)]
        first, *others = [u for u in factors if isinstance(u, list)]
        for u in others:
            first = self._square(first) if u is first else self._convolution(first, u)
        for number in numbers:
            first = self._multiple(first, number)
        return first

    def _multiple(self, u: list[int], number: Constant) -> list[int]:
        series: list[int] = []
        p, q = self._digits.ratio(number)
        self.actions.append(lambda k: series.append(u[k] * p // q))
        return series

    def _convolution(self, u: list[int], v: list[int]) -> list[int]:
        series: list[int] = []
        point = self._point
        self.actions.append(lambda k: series.append(sum(map(mul, u, v[k::-1])) >> point))
        return series

    def _square(self, u: list[int]) -> list[int]:
        series: list[int] = []
        point = self._point

        def act(k: int) -> None:
            half = (k + 1) // 2
            total = 2 * sum(map(mul, u[:half], u[: k - half : -1]))
            series.append((total if k % 2 else total + u[half] * u[half]) >> point)

        self.actions.append(act)
        return series

    def _wave(self, u: list[int]) -> tuple[list[int], list[int]]:
        """Sine and cosine, from s' = u'c and c' = −u's."""
        sine: list[int] = []
        cosine: list[int] = []
        slope: list[int] = []  # j u_j for j = 1, 2, …
        context, point = self._digits.context, self._point

        def act(k: int) -> None:
            if k == 0:
                angle = context.ldexp(context.mpf(u[0]), -point)
                values = context.cos_sin(angle)
                cosine.append(int(context.ldexp(values[0], point)))
                sine.append(int(context.ldexp(values[1], point)))
                return
            slope.append(k * u[k])
            s = (sum(map(mul, slope, cosine[::-1])) >> point) // k
            c = -(sum(map(mul, slope, sine[::-1])) >> point) // k
            sine.append(s)
            cosine.append(c)

        self.actions.append(act)
        return sine, cosine


def _step_length(series: list[list[int]], bits: int) -> float:
    """Step, in units of time, at which the last terms are below 2^−bits of the state, and no term is large.

    Terms much larger than the state would cancel, as those of exp(−t) do, and lose digits. The size of the state is
    that of its first term that does not vanish: at the origin it grows with the step.
    """
    order = len(series[0]) - 1
    first = next((k for k in range(order + 1) if _largest(series, k)), order)
    size = _log2(_largest(series, first) or 1)
    bounds = [(k, size - bits) for k in range(order - _LAST + 1, order + 1)]
    bounds += [(k, size + _CANCELLED) for k in range(2, order, _APART)]
    sizes = ((k - first, bound, _largest(series, k)) for k, bound in bounds if k > first)
    length = min(((bound - _log2(largest)) / k for k, bound, largest in sizes if largest), default=np.inf)
    return float(_SAFETY * 2.0 ** min(length, _FAR))


def _largest(series: list[list[int]], k: int) -> int:
    """Size of the largest coefficient of order k."""
    return max(abs(u[k]) for u in series)


def _log2(n: int) -> float:
    """Logarithm of a large integer."""
    shift = max(0, n.bit_length() - 64)
    return math.log2(n >> shift) + shift


class Step:
    """The solution over a short time, as a polynomial in time."""

    def __init__(
        self, digits: Digits, start: Any, series: list[list[int]], point: int, unit: int, length: float
    ) -> None:
        self.start, self.unit = start, unit
        self._digits, self._series, self._point = digits, series, point
        self._end = min(length, 1.0)
        self.next_unit = unit + int(np.clip(np.ceil(np.log2(length)), -1000, _GROWTH))
        self.span = digits.context.ldexp(digits.context.mpf(self._end), unit)

    def at(self, elapsed: Any) -> NDArray[np.object_]:
        """State (d,) at an elapsed time."""
        context, point = self._digits.context, self._point
        s = int(context.ldexp(elapsed - self.start, point - self.unit))
        state = np.empty(len(self._series), dtype=object)
        for i, series in enumerate(self._series):
            value = series[-1]
            for c in reversed(series[:-1]):
                value = (value * s >> point) + c
            state[i] = context.ldexp(context.mpf(value), -point)
        return state

    def polynomial(self) -> NDArray[np.float64]:
        """Coefficients (order + 1, d), in doubles, of the powers of the part of the step, from 0 to 1."""
        part, exponent = math.frexp(self._end)
        powers = np.arange(len(self._series[0]))
        shifts = np.array([[max(0, c.bit_length() - _DOUBLE) for c in series] for series in self._series]).T
        rows = [[float(c >> max(0, c.bit_length() - _DOUBLE)) for c in series] for series in self._series]
        whole = shifts - self._point + exponent * powers[:, None]
        coefficients: NDArray[np.float64] = np.ldexp(np.array(rows).T * part ** powers[:, None], whole)
        return coefficients
