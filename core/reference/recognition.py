"""Which exact flow a declared field has: recognised from its expressions, never from a name."""

from __future__ import annotations

import numpy as np
import sympy

from core.reference.flows import Flow, LinearFlow, PendulumFlow, RigidBodyFlow, WeierstrassFlow

__all__ = ["exact_numbers", "extended_number", "recognise"]

_VANISHING = np.finfo(np.longdouble).eps ** 4  # so small a c moves nothing within round-off


def recognise(field: tuple[sympy.Expr, ...], variables: tuple[sympy.Symbol, ...]) -> Flow | None:
    """Exact flow of x' = field(x), or None if no closed form is known here.

    Parameters
    ----------
    field : tuple of d expressions
        In the variables only, parameter values substituted; a Float stands for its exact binary value.
    variables : tuple of d symbols
    """
    exact = tuple(exact_numbers(u) for u in field)
    if any(u.free_symbols - set(variables) for u in exact):
        return None
    if len(variables) == 2 and (pendulum := _recognise_pendulum(exact, variables)) is not None:
        return pendulum
    if not all(u.is_polynomial(*variables) for u in exact):
        return None
    polynomials = [sympy.Poly(u, *variables) for u in exact]
    if any(not c.is_real for p in polynomials for c in p.coeffs()):
        return None
    if all(p.total_degree() <= 1 for p in polynomials):
        a = [[extended_number(p.coeff_monomial(v)) for v in variables] for p in polynomials]
        b = [extended_number(p.coeff_monomial(1)) for p in polynomials]
        return LinearFlow(np.array(a), np.array(b))
    if len(variables) == 3:
        return _recognise_rigid_body(polynomials, variables)
    return _recognise_weierstrass(polynomials, variables) if len(variables) == 2 else None


def _recognise_weierstrass(
    polynomials: list[sympy.Poly], variables: tuple[sympy.Symbol, ...]
) -> WeierstrassFlow | None:
    """The flow of u' = αv, v' = βu² + γu + δ with (u, v) the variables in either order."""
    for i in (0, 1):
        u, v = variables[i], variables[1 - i]
        alpha = polynomials[i].coeff_monomial(v)
        force = polynomials[1 - i]
        beta = force.coeff_monomial(u**2)
        is_force = force.total_degree() == 2 and v not in force.as_expr().free_symbols
        if alpha != 0 and polynomials[i].as_expr() == alpha * v and is_force:
            gamma, delta = force.coeff_monomial(u), force.coeff_monomial(1)
            a, b, c, d = map(extended_number, (alpha, beta, gamma, delta))
            return WeierstrassFlow(i, a, b, c, d)
    return None


def _recognise_rigid_body(polynomials: list[sympy.Poly], variables: tuple[sympy.Symbol, ...]) -> RigidBodyFlow | None:
    """The flow of x' = (c₁ x₂x₃, c₂ x₃x₁, c₃ x₁x₂) with c of both signs; the third may be 0."""
    product = sympy.prod(variables)
    terms = [product / v for v in variables]
    c = [p.coeff_monomial(term) for p, term in zip(polynomials, terms, strict=True)]
    if any(p.as_expr() != k * term for p, k, term in zip(polynomials, c, terms, strict=True)):
        return None
    values = np.array([extended_number(k) for k in c])
    if not values.min() < 0 < values.max():
        return None  # it escapes, or grows exponentially
    values[values == 0] = _VANISHING * np.abs(values).max()
    return RigidBodyFlow(values)


def _recognise_pendulum(field: tuple[sympy.Expr, ...], variables: tuple[sympy.Symbol, ...]) -> PendulumFlow | None:
    """The flow of u' = αv, v' = κ sin(γu + δ), or cos, with (u, v) the variables in either order."""
    for i in (0, 1):
        u, v = variables[i], variables[1 - i]
        alpha = field[i].coeff(v)
        kappa, wave = field[1 - i].as_independent(u, as_Add=False)
        is_wave = isinstance(wave, sympy.sin | sympy.cos) and wave.args[0].is_polynomial(u)
        if alpha == 0 or field[i] != alpha * v or not is_wave:
            continue
        angle = sympy.Poly(wave.args[0], u)
        gamma, delta = angle.coeff_monomial(u), angle.coeff_monomial(1)
        delta += sympy.pi / 2 if isinstance(wave, sympy.cos) else 0
        numbers = (alpha, kappa, gamma, delta)
        if angle.degree() == 1 and all(k.is_real and not k.free_symbols for k in numbers):
            a, b, c, d = map(extended_number, numbers)
            return PendulumFlow(i, a, b, c, d)
    return None


def exact_numbers(expression: sympy.Expr) -> sympy.Expr:
    """The expression with every Float replaced by the rational number it is."""
    return sympy.sympify(expression).xreplace(
        {c: sympy.Rational(c) for c in sympy.sympify(expression).atoms(sympy.Float)}
    )


def extended_number(number: sympy.Expr) -> np.longdouble:
    """The number correctly rounded to extended precision."""
    return np.longdouble(str(sympy.N(number, 30)))
