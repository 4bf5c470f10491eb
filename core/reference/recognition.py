"""Recognise fields whose solutions have a closed form, from their expressions, never from a name.

No closed form is evaluated: the power series of `powers` gives these solutions in any number of digits. It is not used
for other fields, because a chaotic solution loses more and more digits and would take a hundred times as long as the
Taylor method; a solution in closed form loses few.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import sympy

__all__ = ["closed_form", "exact_numbers"]


def closed_form(field: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> str | None:
    """Name of the functions that solve x' = field(x); None if no closed form is known here.

    Parameters
    ----------
    field : d expressions
        In the variables only, parameter values substituted; a Float stands for its exact binary value.
    variables : d symbols
    """
    exact = [exact_numbers(u) for u in field]
    if any(u.free_symbols - set(variables) for u in exact):
        return None
    polynomials = [_real_polynomial(u, variables) for u in exact]
    if all(p is not None and p.total_degree() <= 1 for p in polynomials):
        return "linear flow"
    if len(variables) == 3:
        return "Jacobi sn, cn, dn" if _is_rigid_body(polynomials, variables) else None
    return _motion_in_a_potential(exact, variables) if len(variables) == 2 else None


def _is_rigid_body(polynomials: Sequence[sympy.Poly | None], variables: Sequence[sympy.Symbol]) -> bool:
    """Whether x' = (c₁ x₂x₃, c₂ x₃x₁, c₃ x₁x₂) with c of both signs, so that no solution grows without bound."""
    product = sympy.Mul(*variables)
    signs = set()
    for p, v in zip(polynomials, variables, strict=True):
        if p is None or p != p.coeff_monomial(product / v) * sympy.Poly(product / v, *variables):
            return False
        signs.add(sympy.sign(p.coeff_monomial(product / v)))
    return signs >= {-1, 1}


def _motion_in_a_potential(field: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> str | None:
    """Name for u' = αv, v' = F(u), α ≠ 0, with F quadratic or a wave, (u, v) being the variables in either order."""
    for (u, rate), (v, force) in permutations(zip(variables, field, strict=True)):
        speed = _real_polynomial(rate, (u, v))
        if speed is None or speed.monoms() != [(0, 1)]:
            continue
        if (attraction := _real_polynomial(force, (u,))) is not None and attraction.degree() == 2:
            return "Weierstrass ℘"
        if _is_wave(force, u):
            return "Jacobi am"
    return None


def _is_wave(force: sympy.Expr, u: sympy.Symbol) -> bool:
    """Whether the force is κ sin(γu + δ) or κ cos(γu + δ)."""
    factor, wave = force.as_independent(u, as_Add=False)
    if not isinstance(wave, sympy.sin | sympy.cos) or not factor.is_real or factor.free_symbols:
        return False
    angle = _real_polynomial(wave.args[0], (u,))
    return angle is not None and angle.degree() == 1


def _real_polynomial(e: sympy.Expr, variables: Sequence[sympy.Symbol]) -> sympy.Poly | None:
    """The expression as a polynomial with real coefficients, or None."""
    if not e.is_polynomial(*variables):
        return None
    polynomial = sympy.Poly(e, *variables)
    return polynomial if all(c.is_real and not c.free_symbols for c in polynomial.coeffs()) else None


def exact_numbers(expression: sympy.Expr) -> sympy.Expr:
    """The expression with every Float replaced by the rational number it is."""
    return sympy.sympify(expression).xreplace(
        {c: sympy.Rational(c) for c in sympy.sympify(expression).atoms(sympy.Float)}
    )
