"""Prepare a step of a variable-step method: the Taylor coefficients of the solution, and the length they allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

from sympy import Expr, Symbol

from core.codegen.functions import Names, function_text, level_residual_lines
from core.codegen.printing import assignments
from core.codegen.rounding import rounding_bound
from core.codegen.taylor_series import ALONG, SeriesCode, series_code
from core.kernels.abi import LENGTH, LEVELS_SET, ORDER, PER_UNIT, TOLERANCE, UNIT
from core.kernels.taylor_coefficients import LEAST_ORDER, STRIDE
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode

__all__ = ["coefficient_rows", "prepare_step_text"]

#: Longest step, in units of time of the coefficients: powers of a longer one could overflow.
_LONGEST = 2.0**20
#: Factor of the unit of time where state and height are constant: a long unit needs few steps.
_AT_REST = 2.0**500
#: Shortest step, in units of time: a shorter one needs another unit, since its 24th power could underflow.
_SHORTEST = 2.0**-24
#: Size of state and motion so near underflow that the loss of a coefficient, up to 2⁻¹⁰⁷⁴, may matter: its product with
#: the 24th power of a length up to 2⁵ exceeds 2⁻⁵² of this.
_FAINT = 2.0 ** (-1074 + 24 * 5 + 52)
#: Number of terms of the series that tell how far a coordinate moves: where it turns, the first vanishes.
_TERMS = 3
#: Least extent of a coordinate, relative to the largest of all: its square is far from underflow.
_LEAST_EXTENT = 2.0**-60
#: Largest number of evaluations of the coefficients: one beside the state, others at the state in new units of time.
_ATTEMPTS = 16
#: Most by which a unit of time is made longer at once, where its powers underflow …
_STRETCHED = 2.0**300
#: … which those of a shorter one than this may …
_UNDERFLOWS = 2.0**-40
#: … and in all elsewhere: a solution that grows without bound is followed to where it is too large, step by step.
_STRETCHED_IN_ALL = 2.0**100
#: Displacement of the state beside which the coefficients are evaluated, relative to the state …
_BESIDE = 0.5
#: … times 1 + k/_PRIME for coordinate k (modulo _PRIME), so that coordinates are displaced by different amounts.
_PRIME = 7


@lru_cache(maxsize=64)
def _series(laws: Laws, mode: Mode) -> SeriesCode:
    return series_code(laws, mode)


@lru_cache(maxsize=256)
def coefficient_rows(laws: Laws, modes: tuple[int, ...]) -> int:
    """Number of rows of coefficients that a step of any of these modes, given by their numbers, needs."""
    return max(_series(laws, laws.mode(number).written).rows for number in modes)


def prepare_step_text(laws: Laws, mode: Mode) -> str:
    """Text of `prepare_step`: writes coefficients to scratch, heights from row d on, and the length to w[LENGTH]."""
    code = _series(laws, mode)
    lines = [f"order = int(w[{ORDER}])", f"c = carray(scratch, ({code.rows}, {STRIDE}))"]
    lines += [f"shrink, stretch, away, limit = 1.0, {_LONGEST}, 0.0, math.nan"]
    lines += [f"{ALONG} = 1.0 if h > 0.0 else -1.0"] if mode.slides else []
    lines += [f"for _ in range({_ATTEMPTS}):", *(f"    {line}" for line in _attempt(laws, mode, code))]
    lines += _residual_lines(laws, mode)
    lines += _extent_lines(laws, mode)
    lines += [f"if length == math.inf and is_at_rest(c, {len(laws.x)}, order):", f"    unit *= {_AT_REST}"]
    lines += [f"w[{UNIT}], w[{PER_UNIT}] = unit, 1.0 / unit", "length = limit if limit < length else length"]
    lines += [f"w[{LENGTH}] = unit*({_LONGEST} if length > {_LONGEST} else length)", "return 1"]
    return function_text("prepare_step", lines)


def _attempt(laws: Laws, mode: Mode, code: SeriesCode) -> list[str]:
    """Lines that evaluate the coefficients, and leave the loop around them unless they have to be evaluated again.

    That is necessary in another unit of time: a longer one where a state near the origin makes it so short that
    rounding of the time could hide the step. That may be so by hundreds of powers of ten: each time it is made longer
    by the square. And if high coefficients vanish although the solution is not a polynomial of low degree, as for
    x' = 1, y' = x**30 at x = 0; the step length is then limited by that at a nearby state.
    """
    names, d = Names(laws), len(laws.x)
    rows = range(d, d + len(mode.guards))
    heights = [f"step_length_of_height(c, {row}, order, w[{TOLERANCE}])" for row in rows]
    lines = [*code.lines, f"state, height = step_length(c, {d}, order, w[{TOLERANCE}]), {heights[0]}"]
    for other in heights[1:]:
        lines += [f"other = {other}", "height = min(height, other) if height + other == height + other else math.nan"]
    lines += ["length = min(state, height) if state + height == state + height else math.nan"]
    lines += [f"faint = 0.0 < size + unit*speed < {_FAINT}"]
    if _degree_in_time(laws, mode) > LEAST_ORDER:
        moved = [f"{x} += away*{1 + k % _PRIME / _PRIME}" for k, x in enumerate(names.x)]
        lines[len(names.unpack) : len(names.unpack)] = moved
        lines += ["if away != 0.0:", "    limit, away = length if length == length else 1.0, 0.0", "    continue"]
        lines += ["if limit != limit and max(state, height) == math.inf and not faint:"]
        lines += [f"    away = {_BESIDE}*(size + unit*speed if size + speed > 0.0 else 1.0)", "    continue"]
    lines += _faint_lines()
    lines += [f"short = length > {_LONGEST} and not limit <= {_LONGEST} and unit*{_LONGEST} < abs(h)"]
    lines += [f"short = short and (shrink < {_STRETCHED_IN_ALL} or unit < {_UNDERFLOWS})"]
    lines += [f"if length >= {_SHORTEST} and not short:", "    break"]
    lines += ["if short:", "    shrink, limit = shrink * stretch, limit / stretch"]
    lines += [
        f"    stretch = min(stretch*stretch, {_STRETCHED}) if unit < {_UNDERFLOWS} else {_LONGEST}",
        "    continue",
    ]
    return [*lines, f"shrink, stretch = shrink * correction_of_unit(length, unit, abs(h) / {_SHORTEST}), {_LONGEST}"]


def _faint_lines() -> list[str]:
    """Lines that see to it that a step from a state near underflow is no longer than the unit of time.

    Powers of it then do not enlarge what the coefficients lose. Where all high coefficients vanish they are lost, and
    the solution need not be a polynomial: the step is one unit, in which the state changes by about its size.
    """
    return [
        "if faint and length == math.inf:",
        "    length = 1.0 if speed > 0.0 else math.inf",
        "elif faint and length > 1.0:",
        "    shrink *= 2.0*power_of_two(length)",
        "    continue",
    ]


def _degree_in_time(laws: Laws, mode: Mode) -> float:
    """Bound the degree of the solution, and of the guards along it, as polynomials in time; inf where they are none."""
    degrees: dict[Symbol, float] = {TIME: 1, **dict.fromkeys(laws.x, 0)}
    for _ in range(len(laws.x) + 1):
        found = {v: _degree(f, degrees) + float(f != 0) for v, f in zip(laws.x, mode.field, strict=True)}
        if all(degrees[v] == n for v, n in found.items()):
            return max(*found.values(), *(_degree(guard, degrees) for guard in mode.guards))
        degrees |= found
    return math.inf  # a coordinate depends on itself


def _degree(u: Expr, degrees: Mapping[Symbol, float]) -> float:
    """Bound the degree in time of an expression whose symbols have these degrees."""
    if u.is_Symbol:
        return degrees.get(u, 0)
    parts = [_degree(v, degrees) for v in u.args]
    if not any(parts):
        return 0
    if u.is_Add:
        return max(parts)
    if u.is_Mul:
        return sum(parts)
    return parts[0] * float(u.exp) if u.is_Pow and u.exp.is_Integer and u.exp > 0 else math.inf


def _residual_lines(laws: Laws, mode: Mode) -> list[str]:
    """Lines that write the level residual here to the frame, once for all trial steps from here."""
    names = Names(laws)
    targets = [f"w[{names.frame.level_residual + j}]" for j in range(len(mode.conserved))]
    if not targets:
        return []
    lines = [f"if w[{LEVELS_SET}] == 1.0:", f"    {' = '.join(targets)} = w[{LEVELS_SET}] = 0.0", "else:"]
    lines += [f"    {line}" for line in level_residual_lines(names, mode)]
    return [*lines, *(f"    {target} = r{j}" for j, target in enumerate(targets))]


def _extent_lines(laws: Laws, mode: Mode) -> list[str]:
    """Lines that write to the frame how large each coordinate is and how far it moves: the metric of the projection.

    The error of a coordinate is relative to that. It has the units of the coordinates, so that the projection does not
    depend on these. How far it slides includes what cancels in its rate, a difference of products: near a rest, the
    rounding of that is all its motion, and must not move the other coordinates.
    """
    if not mode.conserved:
        return []
    names = Names(laws)
    extent, d = names.frame.extent, range(len(laws.x))
    lines = [f"part = length if length < {_LONGEST} else 1.0"]
    if mode.slides:
        gross = names.own([rounding_bound(f) for f in mode.written.field])
        lines += assignments([f"gross{k}" for k in d], gross, names.temporaries)
    for k in d:
        series = f"abs(c[{k}, {_TERMS}])"
        for m in range(_TERMS - 1, -1, -1):
            series = f"(abs(c[{k}, {m}]) + part*{series})"
        lines.append(f"extent{k} = {series}" + f" + part*unit*gross{k}" * mode.slides)
    lines.append(f"largest = max({', '.join(f'extent{k}' for k in d)}, 0.0)")
    lines.append("largest = largest if 0.0 < largest < math.inf else 1.0")
    return lines + [f"w[{extent + k}] = max(extent{k}, largest*{_LEAST_EXTENT})" for k in d]
