"""The laws of a declared system: symbols, modes, and vectorised evaluation. Parameters stay symbols."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic import tape
from core.symbolic.expressions import TIME
from core.symbolic.mode import Mode
from core.symbolic.sliding import sliding_mode

__all__ = ["Laws", "RegionLaw", "Way", "coordinates", "derive"]

Vector: TypeAlias = "tuple[Symbol, ...]"

#: Powers up to this are written as products: numpy works out x*x*x ten times as fast as x**3.
_LONGEST_PRODUCT = 4

#: Largest integer up to which every integer is a double.
_LARGEST_EXACT = 2**53

#: The functions that expressions have when they are written for evaluation: of arrays, and of numbers.
_OF_ARRAYS = {name: tape.Floats.functions[name] for name in ("Choice", "magnitude")}
_OF_NUMBERS = {"Choice": lambda far, near, other: near if far <= 0.0 else other, "magnitude": abs}


class Way(NamedTuple):
    """What follows where a guard of a region vanishes."""

    surface: int
    """Number of the surface: index into `Laws.surfaces`."""
    sign: int
    """Sign of the surface's switching function in the region."""
    to: int | None
    """Number of the region entered; None where no region is declared."""
    back: int | None = None
    """The guard of that region that leads back; None where the way is one-way, as with hysteresis."""
    jump: tuple[Expr, ...] | None = None
    """The state after reaching the surface; None where it is continuous."""
    sliding: int | None = None
    """Number of the mode of sliding between both regions; None where the way is one-way."""


class RegionLaw(NamedTuple):
    """A region as it was declared."""

    name: str
    sides: tuple[int, ...]
    """Signs of the surfaces' switching functions; () where regions have names."""
    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    ways: tuple[Way, ...]
    """What follows at each of its guards, with surface, sign, region entered and jump."""


class Laws:
    """Everything about a system that does not depend on the values of its parameters.

    Its modes are numbered: the regions, then the modes of sliding between two of them.

    Parameters
    ----------
    x, p
        Symbols of the d variables, and of the parameters.
    surfaces
        The switching functions.
    regions
        The regions declared.
    """

    def __init__(self, x: Vector, p: Vector, surfaces: tuple[Expr, ...], regions: tuple[RegionLaw, ...]) -> None:
        self.x, self.p, self.surfaces = x, p, surfaces
        taken = frozenset(map(str, (*x, *p)))
        #: Pairs (number of the region where g < 0, of that where g > 0, number of the surface between).
        self.pairs: tuple[tuple[int, int, int], ...] = ()
        #: For each region, what follows at each of its guards.
        self.ways: tuple[tuple[Way, ...], ...] = self._joined(regions)
        self.regions = tuple(
            Mode(
                law.name, law.sides, x, law.field, law.conserved, tuple(surfaces[way.surface] for way in law.ways),
                tuple(way.sign for way in law.ways), taken,
            )
            for law in regions
        )  # fmt: skip
        self._sliding: dict[int, Mode] = {}
        self._functions: dict[object, Callable[..., Floats]] = {}
        self._of_numbers: dict[object, Callable[..., list[Any]]] = {}

    def _joined(self, regions: tuple[RegionLaw, ...]) -> tuple[tuple[Way, ...], ...]:
        """The ways of all regions, each with the way back and the mode of sliding, where there are any."""
        pairs: dict[tuple[int, int, int], int] = {}
        joined = []
        for a, law in enumerate(regions):
            ways = []
            for way in law.ways:
                back = None if way.to is None else _leading_back(regions[way.to], a, way)
                if way.to is not None and back is not None:
                    pair = (a, way.to, way.surface) if way.sign < 0 else (way.to, a, way.surface)
                    number = pairs.setdefault(pair, len(regions) + len(pairs))
                    way = way._replace(back=back, sliding=number)
                ways.append(way)
            joined.append(tuple(ways))
        self.pairs = tuple(pairs)
        return tuple(joined)

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.regions) + len(self.pairs)

    def mode(self, number: int) -> Mode:
        """A mode by its number; one of sliding is derived when it is first asked for."""
        if number < len(self.regions):
            return self.regions[number]
        if number not in self._sliding:
            low, high, surface = self.pairs[number - len(self.regions)]
            minus, plus = self.regions[low], self.regions[high]
            self._sliding[number] = sliding_mode(minus, plus, self.surfaces[surface], self.name(number))
        return self._sliding[number]

    def name(self, number: int) -> str:
        """Name of a mode: its key among the regions, as “-+”; with 0 for the surface along which it slides."""
        if number < len(self.regions):
            return self.regions[number].name
        low, high, surface = self.pairs[number - len(self.regions)]
        name = self.regions[low].name
        return f"{name[:surface]}0{name[surface + 1 :]}" if self.regions[low].sides else f"{name}|{self.name(high)}"

    def ways_from(self, number: int) -> tuple[Way, ...]:
        """What follows at each guard of a mode, in the order of its guards.

        Sliding ends where a field turns, in the region of that field; where it reaches another surface, at a corner,
        nothing follows by itself.
        """
        if number < len(self.regions):
            return self.ways[number]
        low, high, surface = self.pairs[number - len(self.regions)]
        turning = []
        for region, sign in ((low, 1), (high, -1)):
            back = next(k for k, way in enumerate(self.ways[region]) if way.surface == surface)
            turning.append(Way(surface, sign, region, back))
        ways = (*self.ways[low], *self.ways[high])
        others = {way.surface: way.sign for way in ways if way.surface != surface}
        return (*turning, *(Way(other, sign, None) for other, sign in others.items()))

    def number_of_sliding(self, low: int, high: int, surface: int) -> int:
        """Number of the mode of sliding between a region where g < 0 and one where g > 0."""
        return len(self.regions) + self.pairs.index((low, high, surface))

    @cached_property
    def regions_by_sides(self) -> Mapping[tuple[int, ...], int]:
        """Signs of the surfaces' switching functions -> number of the region."""
        return {mode.sides: k for k, mode in enumerate(self.regions)}

    def named_region(self, mode: int) -> str | None:
        """Return the name of a mode, by its number, if it is a region of those that have names; else None."""
        return self.regions[mode].name if 0 <= mode < len(self.regions) and not self.regions[mode].sides else None

    @cached_property
    def numbers_of_modes(self) -> Mapping[str, int]:
        """Name -> number of each mode."""
        return {self.name(k): k for k in range(self.count)}

    @cached_property
    def sides(self) -> NDArray[np.int64]:
        """(modes + 1, surfaces) sign of each switching function in each mode, 0 where it slides along its surface.

        The last row, that of a run which stopped on a surface, is 0. Where regions have names, there are no columns.
        """
        signs = [list(mode.sides) for mode in self.regions]
        for low, high, _ in self.pairs:
            signs.append([a if a == b else 0 for a, b in zip(signs[low], signs[high], strict=True)])
        return np.array([*signs, [0] * len(signs[0])], dtype=np.int64).reshape(len(signs) + 1, -1)

    def label(self, mode: int) -> int:
        """What tells a mode apart: of one surface the side, −1, +1 or 0 for sliding; else its number."""
        return int(self.sides[mode, 0]) if self.sides.shape[1] == 1 else mode

    def labelled(self, label: int) -> int:
        """Number of the mode with a label."""
        return next(k for k in range(self.count) if self.label(k) == label)

    # Systems with one surface ----------------------------------------------------------------------------------------

    @cached_property
    def two_sided(self) -> bool:
        """Whether there is one surface, with a region on either side."""
        return len(self.regions) == 2 and self.regions[0].sides == (-1,)

    @property
    def g(self) -> Expr:
        """The only switching function."""
        self._require_two_sides()
        return self.surfaces[0]

    @property
    def gradient(self) -> tuple[Expr, ...]:
        """∇g of the only switching function."""
        self._require_two_sides()
        return self.gradients[0]

    @property
    def modes(self) -> Mapping[int, Mode]:
        """Sign of the only switching function -> mode."""
        self._require_two_sides()
        return {-1: self.regions[0], 1: self.regions[1]}

    def of_side(self, side: int) -> Mode:
        """The mode of a side of the only surface, −1 or +1, or that of sliding, 0."""
        return self.modes[side] if side else self.sliding

    @property
    def sliding(self) -> Mode:
        """The mode of sliding along the only surface."""
        self._require_two_sides()
        return self.mode(2)

    @property
    def jump(self) -> tuple[Expr, ...] | None:
        """The state after reaching the only surface; None where it is continuous."""
        self._require_two_sides()
        return self.ways[0][0].jump

    def _require_two_sides(self) -> None:
        if not self.two_sided:
            names = ", ".join(map(repr, (mode.name for mode in self.regions)))
            raise ValueError(
                f"this needs a system with one surface and a region on either side; it has regions {names}"
            )

    # All modes -------------------------------------------------------------------------------------------------------

    @cached_property
    def jumps(self) -> bool:
        """Whether the state jumps at a surface."""
        return any(way.jump is not None for ways in self.ways for way in ways)

    @cached_property
    def names_time(self) -> bool:
        """Whether it matters when the state is at a point: a field, a switching function or a jump names time."""
        fields = [rate for region in self.regions for rate in region.field]
        jumps = [part for ways in self.ways for way in ways for part in way.jump or ()]
        return any(TIME in one.free_symbols for one in (*self.surfaces, *fields, *jumps))

    @cached_property
    def instants(self) -> frozenset[int]:
        """Numbers of the surfaces that are instants: their g names no variable, so that it vanishes at all states."""
        return frozenset(k for k, g in enumerate(self.surfaces) if not g.has(*self.x))

    @cached_property
    def gradients(self) -> tuple[tuple[Expr, ...], ...]:
        """∇g of each surface."""
        return tuple(tuple(g.diff(v) for v in self.x) for g in self.surfaces)

    @cached_property
    def at_start(self) -> tuple[Expr, ...]:
        """What an initial state is checked with: each g, then each (g_t, ∇g), then the field of each region."""
        slopes = (g.diff(v) for g in self.surfaces for v in (TIME, *self.x))
        return (*self.surfaces, *slopes, *(f for mode in self.regions for f in mode.written.field))

    @cached_property
    def most_conserved(self) -> int:
        """The largest number of conserved quantities of a region."""
        return max(len(mode.conserved) for mode in self.regions)

    @cached_property
    def most_conserved_sliding(self) -> int:
        """Bound on the number of conserved quantities of any mode, sliding included, which keeps g as well."""
        return max(self.most_conserved, min(self.most_conserved + 1, len(self.x) - 1))

    @cached_property
    def edged(self) -> bool:
        """Whether a field or a ψ contains a root, a real power or a logarithm, which are not defined everywhere."""
        parts = [e for mode in self.regions for e in (*mode.field, *mode.conserved)]
        return any(e.atoms(sympy.log) or any(not p.exp.is_Integer for p in e.atoms(sympy.Pow)) for e in parts)

    def evaluate(self, key: object, expressions: Sequence[Expr], t: ArrayLike, x: ArrayLike, p: Floats) -> Floats:
        """Values of expressions at many states.

        Parameters
        ----------
        key
            Key under which the compiled numpy function is cached.
        t
            (...) times, broadcast against the states.
        x
            (..., d) states; of `numpy.longdouble` for values in extended precision.

        Returns
        -------
        (..., len(expressions)); nan or inf where an expression is undefined, without a warning.
        """
        if key not in self._functions:
            names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
            products = [_powers_as_products()(_with_floats(e).xreplace(names)) for e in expressions]
            self._functions[key] = sympy.lambdify(list(names.values()), products, [_OF_ARRAYS, "numpy"])
        precision = np.result_type(float, np.asarray(x))
        states = np.asarray(x, dtype=precision)
        shape = np.broadcast_shapes(np.shape(t), states.shape[:-1])
        result = np.empty((*shape, len(expressions)), dtype=precision)
        with np.errstate(all="ignore"):
            columns = self._functions[key](np.asarray(t, dtype=precision), *coordinates(states), *p)
            for k, column in enumerate(columns):
                result[..., k] = column
        return result

    def numbers(self, key: object, expressions: Sequence[Expr], t: float, x: Sequence[float], p: Floats) -> list[float]:
        """Values of expressions at one state, as from `evaluate`, but ten times as fast."""
        function = self._of_numbers.get(key) or self._compiled_for_numbers(key, expressions)
        try:
            return list(map(float, function(t, *x, *p.tolist())))
        except (ArithmeticError, ValueError, TypeError):  # undefined or complex: nan or inf in numpy
            values: list[float] = self.evaluate(key, expressions, t, x, p).tolist()
            return values

    def _compiled_for_numbers(self, key: object, expressions: Sequence[Expr]) -> Callable[..., list[Any]]:
        names = {s: Symbol(f"u{k}") for k, s in enumerate((TIME, *self.x, *self.p))}
        own = [_with_floats(e).xreplace(names) for e in expressions]
        self._of_numbers[key] = sympy.lambdify(list(names.values()), own, [_OF_NUMBERS, "math"])
        return self._of_numbers[key]


def _leading_back(region: RegionLaw, to: int, way: Way) -> int | None:
    """Index of the guard of a region that leads back through the surface of a way."""
    for k, other in enumerate(region.ways):
        if (other.surface, other.sign, other.to) == (way.surface, -way.sign, to):
            return k
    return None


def coordinates(states: Floats) -> list[Floats]:
    """Return each coordinate (...) of states (..., d); ten times as fast as `numpy.moveaxis`."""
    return [states[..., k] for k in range(states.shape[-1])]


def _with_floats(expression: Expr) -> Expr:
    """Replace long integers and ratios by floats, as numpy has no integers of more than 64 bits; all is real."""
    long = [n for n in expression.atoms(sympy.Rational) if max(abs(n.p), n.q) > _LARGEST_EXACT]
    if expression.has(sympy.re, sympy.im):  # sympy takes variables for complex, and writes |exp(x)| as exp(re(x))
        expression = expression.replace(sympy.re, lambda part: part).replace(sympy.im, lambda _: sympy.S.Zero)
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
