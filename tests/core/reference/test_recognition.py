"""Which fields are known to have solutions in closed form."""

import pytest
import sympy

from core.reference.recognition import closed_form

X, Y, Z, T = sympy.symbols("x y z t")


@pytest.mark.parametrize(
    ("field", "name"),
    [
        ((Y, -3 * X), "linear flow"),
        ((sympy.Integer(0), sympy.Integer(1)), "linear flow"),
        ((X - Y + sympy.pi, X * sympy.sqrt(2), Z), "linear flow"),
        ((Y, sympy.I * X), None),
        ((2 * Y, 3 * X**2 - 2), "Weierstrass ℘"),
        ((sympy.Float(0.1) * Y, sympy.Float(3.7) * X**2.0 - sympy.sqrt(2) * X), "Weierstrass ℘"),
        (((X + 1) * Y * 2 - 2 * X * Y, (X + 1) ** 2), "Weierstrass ℘"),
        ((3 * Y**2 + Y - 2, 2 * X), "Weierstrass ℘"),
        ((2 * Y, 3 * X**2 + T), None),
        ((2 * Y, 3 * X**2 + Y), None),
        ((2 * Y + X, 3 * X**2), None),
        ((2 * Y + 1, 3 * X**2), None),
        ((sympy.I * Y, 3 * X**2), None),
        ((Y, X**3), None),
        ((Y, 1 / X), None),
        ((Y, X**2, Z), None),
        ((Y, -sympy.sin(X)), "Jacobi am"),
        ((3 * sympy.cos(1 - 2 * Y), -X / 2), "Jacobi am"),
        ((Y, -sympy.sin(X) - Y), None),
        ((Y, -sympy.sin(X) + 1), None),
        ((Y, -Y * sympy.sin(X)), None),
        ((Y, -sympy.I * sympy.sin(X)), None),
        ((Y, -sympy.sin(X**2)), None),
        ((Y, -sympy.sin(X + Y)), None),
        ((Y, -sympy.sin(X + T)), None),
        ((Y, -sympy.tan(X)), None),
        ((Y * Z, -Z * X, -X * Y / 2), "Jacobi sn, cn, dn"),
        ((Y * Z, -Z * X, sympy.Integer(0)), "Jacobi sn, cn, dn"),
        ((Y * Z, Z * X, X * Y), None),
        ((Y * Z, Z * X, sympy.Integer(0)), None),
        ((Y * Z, -Z * X, -X * Y / 2 + 1), None),
        ((Y * Z, -Z * X, -(X**2)), None),
        ((Y * Z, -Z * X, -sympy.sin(X)), None),
    ],
)
def test_fields_are_recognised_by_their_form_and_no_others(field: tuple[sympy.Expr, ...], name: str | None) -> None:
    assert closed_form(field, (X, Y, Z)[: len(field)]) == name
