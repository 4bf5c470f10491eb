"""Taylor coefficients: their unit of time, and the step length they allow.

Row i of c holds the coefficients c[i, 0], c[i, 1], … of one function of time.

Reference: Jorba, Zou, Exp. Math. 14 (2005).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

import numpy as np

from core.kernels.jit import always_inlined, jitted

__all__ = [
    "LEAST_ORDER", "MAX_ORDER", "STRIDE", "correction_of_unit", "is_at_rest", "order_of", "power_near", "power_of_two",
    "step_length", "step_length_of_height", "unsigned",
]  # fmt: skip

#: Least order: a lower one needs so many more steps that it saves no time.
LEAST_ORDER = 8
#: Largest order: above it a step costs more than its greater length saves.
MAX_ORDER = 24
#: Length of a row for every order: a constant, so that one register points into all rows.
STRIDE = MAX_ORDER + 1

#: The error allowed in the height is 2**_FREEDOM times the tolerance …
_FREEDOM = 10.0
#: … but at most 2**_FREEST of the height, unless the tolerance is larger.
_FREEST = -14.0

#: The error allowed in each coordinate is this many times the tolerance, relative to it …
_OF_EACH = 2.0**10
#: … but at least relative to this part of the largest coordinate.
_LEAST_PART = 2.0**-1000
#: How often a step is shortened for that, at most.
_SHORTENINGS = 8
#: log₂ e.
_LOG2_E = math.log2(math.e)
#: 1/3: multiplying by it takes less time than dividing by 3.
_THIRD = 1.0 / 3.0
#: Number of bits of the mantissa of a double.
_DIGITS = 52
#: Mask of the mantissa of a double.
_MANTISSA = 2**52 - 1
#: Mask of the exponent of a double.
_EXPONENT = 2047 << 52
#: Bits of the double 1.
_ONE = 1023 << 52
#: Biased exponent of the double 1.
_BIAS = 1023
#: Least normal double.
_NORMAL = 2.0**-1022
#: Factor of the unit of time where coefficients overflow: it scales those of order 24 by 2⁻⁹⁶⁰, most of the range.
_OVERFLOWN = 2.0**-40

#: Type of indices known not to be negative: they need no test for counting from the end.
unsigned = np.uint64


@always_inlined
def _norm(c, d, k):
    """Sum over the coordinates of |coefficient k| of the state. A sum, not a maximum, so that nan stays nan."""
    size = 0.0
    for i in range(d):
        size += abs(c[i, unsigned(k)])
    return size


@always_inlined
def power_of_two(u):
    """The greatest power of two that is not above u; 1 if u is not positive and finite, or below 2⁻¹⁰²²."""
    power = np.int64(np.float64(u).view(np.int64) & _EXPONENT).view(np.float64)
    return power if 0.0 < power < math.inf and u > 0.0 else 1.0


@always_inlined
def power_near(u, v):
    """A power of two within a factor of two of u/v; 1 unless u, v and the power are positive, finite and normal."""
    exponents = np.float64(u).view(np.int64) & _EXPONENT, np.float64(v).view(np.int64) & _EXPONENT
    bits = exponents[0] - exponents[1] + _ONE
    usual = _NORMAL <= u < math.inf and _NORMAL <= v < math.inf and 0 < bits < _EXPONENT
    return np.int64(bits).view(np.float64) if usual else 1.0


@always_inlined
def _log2(u):
    """Binary logarithm of a positive number, with an error below 0.01; 0 counts as 2⁻¹⁰²³.

    That is accurate enough for a step length, the k-th root of a quotient; `math.log` takes as long as ten terms.
    """
    bits = np.float64(u).view(np.int64)
    mantissa = np.int64((bits & _MANTISSA) | _ONE).view(np.float64)
    return (bits >> _DIGITS) - _BIAS - 5.0 / 3.0 + (2.0 - _THIRD * mantissa) * mantissa


@always_inlined
def _exp2(y):
    """2ʸ with a relative error below 0.4 %; y is clipped to ±1000."""
    y = min(max(y, -1000.0), 1000.0)
    whole = int(y + _BIAS)
    rest = y + _BIAS - whole
    return np.int64(whole << _DIGITS).view(np.float64) * (1.0 + _THIRD * rest * (2.0 + rest))


@always_inlined
def _log_radius(log_scale, log_before, log_last, order, power):
    """log₂ of the least ρ with ‖c[:, m]‖ ρᵐ = scale·ρ**power for m = order − 1 or m = order."""
    last = (log_scale - log_last) * (1.0 / (order - power))  # the quotient does not wait for the coefficients
    return min(last, (log_scale - log_before) * (1.0 / (order - 1 - power))) if order - 1 > power else last


@jitted
def _last_nonzero(c, d, order):
    """Index of the last coefficient that is not zero; 0 if all beyond half the order are zero."""
    m = order
    while m > order // 2 and _norm(c, d, m) == 0.0:
        m -= 1
    return m if m > order // 2 else 0


@always_inlined
def _first_moving(c, d, order):
    """Index ≥ 1 of the first coefficient that is not zero, at most `order`."""
    q = 1
    while q < order and _norm(c, d, q) == 0.0:
        q += 1
    return q


@always_inlined
def _are_small(c, d, order, state, last):
    """Whether the last coefficient of each coordinate is small beside its value, by the ratio of their norms."""
    large = 0
    for i in range(d):
        large += abs(c[i, unsigned(order)]) * state > _OF_EACH * abs(c[i, 0]) * last
    return large == 0


@jitted
def _largest_term(c, i, order, h):
    """Largest |c[i, q]| h**q of the terms before the last two."""
    largest, power = 0.0, 1.0
    for q in range(order - 1):
        largest = max(largest, abs(c[i, q]) * power)
        power *= h
    return largest


@jitted
def _excess(c, d, order, tolerance, h):
    """The last two terms of the coordinates, by what is allowed to each; the largest quotient."""
    largest, excess = 0.0, 0.0
    for i in range(d):
        largest = max(largest, _largest_term(c, i, order, h))
    for i in range(d):
        left_out = max(abs(c[i, order - 1]), abs(c[i, order]) * h) * h ** (order - 1)
        allowed = _OF_EACH * tolerance * max(_largest_term(c, i, order, h), _LEAST_PART * largest)
        if left_out > excess * allowed:
            excess = left_out / allowed
    return excess


@jitted
def _resolving_each(c, d, order, tolerance, h):
    """A step length, at most h, of which the last two terms are small beside the largest one of each coordinate.

    A small coordinate may grow: x' = x(1 - x) leads from 10⁻¹³ to 1, whatever is larger at first. Beyond the radius of
    convergence the largest term is near the last, so that a shorter length may be too long again.
    """
    for _ in range(_SHORTENINGS):
        excess = _excess(c, d, order, tolerance, h)
        if not 1.0 < excess < math.inf:
            break
        h *= excess ** (-1.0 / (order - 1))
    return h


@always_inlined
def _step_length_of_all(c, d, order, tolerance, state, before, last):
    """The step length by the norms of the state and of its last two coefficients."""
    shrink = min(-1.0, _log2(tolerance) / order)
    factor = shrink - 0.7 * _LOG2_E / (order - 1)
    before, last = _log2(before), _log2(last)
    h = 0.0
    if state != 0.0:
        h = _exp2(_log_radius(_log2(state), before, last, order, 0) + factor)
    if _norm(c, d, 1) * h >= state:
        q = _first_moving(c, d, order)
        if q == order:
            return math.inf
        motion = _log2(_norm(c, d, q)) + shrink * q  # the scale, for h = ρ·2**shrink
        return max(h, _exp2(_log_radius(motion, before, last, order, q) + factor))
    return h


@always_inlined
def step_length(c, d, order, tolerance):
    r"""Length of the step that the last two coefficients of the state allow (Jorba, Zou, Exp. Math. 14, 2005).

    h = min ρₘ · tolerance**(1/order) · exp(−0.7 / (order − 1)) over m = order − 1 and order, with
    ρₘ = (scale / ‖c[:, m]‖)**(1/m): the terms left out are then about `tolerance` times the scale. (Jorba and Zou
    choose the order so that the second factor is e⁻²; here it is at most ½.) The scale is ‖x‖ or, where that is larger,
    the displacement in the step, ‖c[:, q]‖ h**q with the first q ≥ 1 for which c[:, q] ≠ 0. So the step does not depend
    on the units of state and time, and the solution may pass through x = 0. Of each coordinate the terms left out are
    at most 2¹⁰ times the tolerance of its own size.

    Parameters
    ----------
    c
        (rows, > order) coefficients, those of the state in the first d rows.
    d
        Dimension of the state.
    order
        At least 2.
    tolerance
        Relative to the scale.

    Returns
    -------
    float
        In the unit of time of the coefficients, positive; inf where all coefficients beyond half the order vanish
        (equilibria, and solutions that are polynomials of at most that degree), or all but the last; 0 or nan where a
        coefficient is not finite.
    """
    if _norm(c, d, order) == 0.0 and _norm(c, d, order - 1) == 0.0:
        order = _last_nonzero(c, d, order)
        if order == 0:
            return math.inf
    state, before, last = _norm(c, d, 0), _norm(c, d, order - 1), _norm(c, d, order)
    if not state + before + last < math.inf:
        return math.nan
    h = _step_length_of_all(c, d, order, tolerance, state, before, last)
    if _are_small(c, d, order, state, last) and _are_small(c, d, order - 1, state, before):
        return h
    return _resolving_each(c, d, order, tolerance, h)


@always_inlined
def step_length_of_height(c, d, order, tolerance):
    """Length of the step that the last two coefficients of row d, the guard height, allow.

    The height may vary faster than the state. Its polynomial detects a crossing, which is then located on the scheme
    itself; so the polynomial may have a relative error of 2¹⁰ times the tolerance up to 2⁻¹⁴, or of the tolerance if
    that is larger. The scale is the largest of the height and its changes of first and second order in the step: they
    are not all small by accident of where the step begins. Otherwise as in `step_length`.
    """
    highest = order
    while order > highest // 2 and c[d, order] == 0.0 and c[d, order - 1] == 0.0:
        order -= 1
    if order <= highest // 2:
        return math.inf
    before, last = abs(c[d, order - 1]), abs(c[d, order])
    if not abs(c[d, 0]) + before + last < math.inf:
        return math.nan
    shrink = min(-1.0, max(_log2(tolerance), min(_log2(tolerance) + _FREEDOM, _FREEST)) / order)
    before, last = _log2(before), _log2(last)
    h = -math.inf
    for q in range(3):
        if c[d, q] != 0.0:
            h = max(h, _log_radius(_log2(abs(c[d, q])) + shrink * q, before, last, order, q))
    return _exp2(h + shrink - 0.7 * _LOG2_E / (order - 1))


@always_inlined
def correction_of_unit(length, unit, longest):
    """Factor of the unit of time in which a step length came out too small, or nan.

    Where coefficients overflow, the new unit is at most near `longest`, positive: no step needs a longer one. Near an
    equilibrium other than x = 0, the unit |x|/|f| may be too long by most of the range of doubles.
    """
    if length > 0.0:
        return power_of_two(length)
    return min(_OVERFLOWN, power_near(longest, unit))


@jitted
def is_at_rest(c, d, order):
    """Whether all coefficients but the first of rows 0 … d vanish: state and height are constant."""
    for i in range(d + 1):
        for k in range(1, order + 1):
            if c[i, k] != 0.0:
                return False
    return True


def order_of(tolerance: float) -> int:
    """Order for which steps of `step_length` take the least computing time per unit of time, as measured.

    Jorba and Zou's −½ ln(tolerance) + 1 counts the cost of the coefficients alone; a step has other costs too, so that
    longer steps of higher order pay.
    """
    return min(max(LEAST_ORDER, math.ceil(8.0 - 0.55 * math.log(tolerance))), MAX_ORDER)
