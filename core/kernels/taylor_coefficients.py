"""Taylor coefficients: the unit of time they are in, and the step they allow.

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

#: Outside these orders a step gains less than it costs.
LEAST_ORDER, MAX_ORDER = 8, 24
#: Length of a row, whatever the order: a constant, so that one register points into all rows.
STRIDE = MAX_ORDER + 1

#: What the height may be off by: in powers of two of the tolerance, and of the height at most.
_FREEDOM, _FREEST = 10.0, -14.0

_LOG2_E = math.log2(math.e)
_THIRD = 1.0 / 3.0  #: a product is there sooner than a quotient
#: Of a double: bits of the mantissa, how many they are, bits of the exponent, those of the number 1, and their value.
_MANTISSA, _DIGITS, _EXPONENT, _ONE, _BIAS = 2**52 - 1, 52, 2047 << 52, 1023 << 52, 1023
_NORMAL = 2.0**-1022
#: The unit is multiplied by this where coefficients have left floating point: those of order 24 by most of its range.
_OVERFLOWN = 2.0**-40

#: Of indices known not to be negative, which need no test for counting from the end.
unsigned = np.uint64


@always_inlined
def _norm(c, d, k):
    """Sum of the sizes of the state's coefficients k. A sum, not a maximum: nan stays nan."""
    size = 0.0
    for i in range(d):
        size += abs(c[i, unsigned(k)])
    return size


@always_inlined
def power_of_two(u):
    """The greatest power of two that is not above u; 1 where u is not positive and finite, or below 2⁻¹⁰²²."""
    power = np.int64(np.float64(u).view(np.int64) & _EXPONENT).view(np.float64)
    return power if 0.0 < power < math.inf and u > 0.0 else 1.0


@always_inlined
def power_near(u, v):
    """A power of two within a factor of two of u/v, by their exponents; 1 unless all three are positive and normal."""
    exponents = np.float64(u).view(np.int64) & _EXPONENT, np.float64(v).view(np.int64) & _EXPONENT
    bits = exponents[0] - exponents[1] + _ONE
    usual = _NORMAL <= u < math.inf and _NORMAL <= v < math.inf and 0 < bits < _EXPONENT
    return np.int64(bits).view(np.float64) if usual else 1.0


@always_inlined
def _log2(u):
    """Binary logarithm of a positive number, to within 0.01; 0 counts as 2⁻¹⁰²³.

    A step length is the k-th root of a quotient: no more is needed of it, and `math.log` takes as long as ten terms.
    """
    bits = np.float64(u).view(np.int64)
    mantissa = np.int64((bits & _MANTISSA) | _ONE).view(np.float64)
    return (bits >> _DIGITS) - _BIAS - 5.0 / 3.0 + (2.0 - _THIRD * mantissa) * mantissa


@always_inlined
def _exp2(y):
    """Power of two, to within 0.4 %; beyond 2^±1000 that power."""
    y = min(max(y, -1000.0), 1000.0)
    whole = int(y + _BIAS)
    rest = y + _BIAS - whole
    return np.int64(whole << _DIGITS).view(np.float64) * (1.0 + _THIRD * rest * (2.0 + rest))


@always_inlined
def _log_radius(log_scale, log_before, log_last, order, power):
    """Log of the least ρ with ‖c[:, m]‖ ρᵐ = scale·ρ**power for m = order − 1 and order."""
    last = (log_scale - log_last) * (1.0 / (order - power))  # the quotient is there before the coefficients are
    return min(last, (log_scale - log_before) * (1.0 / (order - 1 - power))) if order - 1 > power else last


@jitted
def _last_nonzero(c, d, order):
    """The last coefficient that is not zero; 0 if all those beyond half the order are."""
    m = order
    while m > order // 2 and _norm(c, d, m) == 0.0:
        m -= 1
    return m if m > order // 2 else 0


@always_inlined
def _first_moving(c, d, order):
    """The first coefficient from 1 on that is not zero, `order` at most."""
    q = 1
    while q < order and _norm(c, d, q) == 0.0:
        q += 1
    return q


@always_inlined
def step_length(c, d, order, tolerance):
    r"""Length of the step that the last two coefficients of the state allow (Jorba, Zou, Exp. Math. 14, 2005).

    h = min ρₘ · tolerance**(1/order) · exp(−0.7 / (order − 1)) over m = order − 1 and order, with
    ρₘ = (scale / ‖c[:, m]‖)**(1/m): the terms left out are then about `tolerance` parts of the scale. (Jorba and Zou
    take the order that makes the second factor e⁻²; here it is ½ at most.) The scale is ‖x‖ or, where that is larger,
    the motion in the step, ‖c[:, q]‖ h**q with the first q ≥ 1 at which the state moves: so units of state or time make
    no difference, and x = 0 may be passed.

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
        Positive; inf where all coefficients beyond half the order vanish (equilibria, and solutions that are
        polynomials of so low a degree), or all but the last; 0 or nan where a coefficient is not finite.
    """
    if _norm(c, d, order) == 0.0 and _norm(c, d, order - 1) == 0.0:
        order = _last_nonzero(c, d, order)
        if order == 0:
            return math.inf
    state, before, last = _norm(c, d, 0), _norm(c, d, order - 1), _norm(c, d, order)
    if not state + before + last < math.inf:
        return math.nan
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
        motion = _log2(_norm(c, d, q)) + shrink * q  # with h = ρ·2**shrink, as the scale
        return max(h, _exp2(_log_radius(motion, before, last, order, q) + factor))
    return h


@always_inlined
def step_length_of_height(c, d, order, tolerance):
    """Length of the step that the last two coefficients of row d allow, the height over the surface.

    A surface may vary faster than the state: a crossing is seen on this polynomial, but located on the scheme itself.
    So it may be off by 2¹⁰ times the tolerance, up to 2⁻¹⁴, or by the tolerance if that is more. The scale is the
    largest of the height, and of its change to first and to second order, in the step: one of them at least is no
    accident of where the step begins. The rest is as in `step_length`.
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
def correction_of_unit(length):
    """What a unit of time has to be multiplied by, a step of which this length came out as too short in it, or nan."""
    return power_of_two(length) if length > 0.0 else _OVERFLOWN


@jitted
def is_at_rest(c, d, order):
    """Whether all coefficients but the first of rows 0 … d vanish: neither the state moves nor the height."""
    for i in range(d + 1):
        for k in range(1, order + 1):
            if c[i, k] != 0.0:
                return False
    return True


def order_of(tolerance: float) -> int:
    """Order with which a step of `step_length` costs least for the time it covers: measured.

    Jorba and Zou's −½ ln(tolerance) + 1 counts the coefficients alone; with what else a step costs, longer steps of
    higher order pay.
    """
    return min(max(LEAST_ORDER, math.ceil(8.0 - 0.55 * math.log(tolerance))), MAX_ORDER)
