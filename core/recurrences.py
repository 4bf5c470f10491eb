"""Taylor coefficients: the sums their recurrences are made of, and the step they allow.

Row i of c holds the coefficients c[i, 0], c[i, 1], … of one function of time. Every recurrence that `series` writes is
built of three sums over 1 ≤ j ≤ k − 1; the two terms that hold the newest coefficients, j = 0 and j = k, are written
out by `series` with values that are still in registers, so that they are all a coefficient has to wait for.

References: Griewank, Walther, Evaluating Derivatives, ch. 13; Jorba, Zou, Exp. Math. 14 (2005).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

import numpy as np

from core.doubled import fma
from core.jit import always_inlined, jitted

__all__ = ["MAX_ORDER", "convolution", "order_of", "power_sum", "reach", "symmetric"]

#: Outside these orders a step gains less than it costs.
_LEAST_ORDER, MAX_ORDER = 8, 24

#: Indices known not to be negative, which need no test for counting from the end.
_u = np.uint64


@always_inlined
def convolution(c, a, b, k):
    """Σ aⱼ bₖ₋ⱼ over 1 ≤ j ≤ k − 1, of rows a and b.

    From both ends at once: two independent sums, and the loads of one serve as those of the other's mirror image.
    """
    forward, backward = 0.0, 0.0
    i, j = 1, k - 1
    while i < j:
        forward = fma(c[a, _u(i)], c[b, _u(j)], forward)
        backward = fma(c[a, _u(j)], c[b, _u(i)], backward)
        i += 1
        j -= 1
    if i == j:
        forward += c[a, _u(i)] * c[b, _u(i)]
    return forward + backward


@always_inlined
def symmetric(c, a, k):
    """Σ aⱼ aₖ₋ⱼ over 1 ≤ j ≤ k − 1, of row a: each pair once, the middle term apart."""
    half, middle = 0.0, 0.0
    i, j = 1, k - 1
    while i < j:
        half = fma(c[a, _u(i)], c[a, _u(j)], half)
        i += 1
        j -= 1
    if i == j:
        middle = c[a, _u(i)] * c[a, _u(i)]
    return (half + half) + middle


@always_inlined
def power_sum(c, a, b, k, exponent):
    """Σ (j (exponent + 1) − k) aⱼ bₖ₋ⱼ over 1 ≤ j ≤ k − 1: the recurrence of b = a**exponent."""
    forward, backward = 0.0, 0.0
    step = exponent + 1.0
    i, j = 1, k - 1
    while i < j:
        forward += (i * step - k) * (c[a, _u(i)] * c[b, _u(j)])
        backward += (j * step - k) * (c[a, _u(j)] * c[b, _u(i)])
        i += 1
        j -= 1
    if i == j:
        forward += (i * step - k) * (c[a, _u(i)] * c[b, _u(i)])
    return forward + backward


@always_inlined
def _norm(c, d, k):
    """Sum of the sizes of the state's coefficients k. A sum, not a maximum: nan stays nan."""
    size = 0.0
    for i in range(d):
        size += abs(c[i, _u(k)])
    return size


@always_inlined
def _log_radius(log_scale, log_before, log_last, order, power):
    """Log of the least ρ with ‖c[:, m]‖ ρᵐ = scale·ρ**power for m = order − 1 and order; nan stays nan."""
    last = (log_scale - log_last) / (order - power)
    if order - 1 > power:
        before = (log_scale - log_before) / (order - 1 - power)
        if before < last or before != before:
            last = before
    return last


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


@jitted
def reach(c, d, order, tolerance):
    r"""Length of the step that the last two coefficients of the state allow (Jorba, Zou, Exp. Math. 14, 2005).

    h = min ρₘ · tolerance**(1/order) · exp(−0.7 / (order − 1)) over m = order − 1 and order, with
    ρₘ = (scale / ‖c[:, m]‖)**(1/m): the terms left out are then about `tolerance` parts of the scale. (Jorba and Zou
    take the order that makes the second factor e⁻²; here it is e⁻¹ at most.) The scale is ‖x‖ or, where that is larger,
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
    shrink = min(-1.0, math.log(tolerance) / order)
    factor = shrink - 0.7 / (order - 1)
    state = _norm(c, d, 0)
    before, last = math.log(_norm(c, d, order - 1)), math.log(_norm(c, d, order))
    h = 0.0
    if state != 0.0:
        h = math.exp(_log_radius(math.log(state), before, last, order, 0) + factor)
    if _norm(c, d, 1) * h >= state:
        q = _first_moving(c, d, order)
        if q == order:
            return math.inf
        motion = math.log(_norm(c, d, q)) + shrink * q  # with h = ρ·exp(shrink), as the scale
        moving = math.exp(_log_radius(motion, before, last, order, q) + factor)
        if moving > h:
            return moving
    return h


def order_of(tolerance: float) -> int:
    """Order with which a step of `reach` costs least for the time it covers: measured.

    Jorba and Zou's −½ ln(tolerance) + 1 counts the coefficients alone; with what else a step costs, longer steps of
    higher order pay.
    """
    return min(max(_LEAST_ORDER, math.ceil(6.0 - 0.6 * math.log(tolerance))), MAX_ORDER)
