"""What a process that compiles begins with: the first function of a kind takes longest, with all that it calls.

Of each kind of system one, in the order in which people are likely to write them.
"""

from __future__ import annotations

from collections.abc import Iterator

from core.symbolic.declaration import Declaration
from core.symbolic.laws import Laws

__all__ = ["examples"]

#: Variables, field, ψ and g, the same on both sides; the parameter is a.
_KINDS = (
    (("x", "y"), ("2*y", "3*x**2 + a/2"), ("y**2 - x**3 - a*x/2",), "x**2 + y**2 - a**2"),
    (("x", "y"), ("y", "-a*sin(x)"), ("y**2/2 - a*cos(x)",), "x - a"),
    (("x", "y"), ("x*(a - y)", "y*(x - 1)"), ("x - log(x) + y - a*log(y)",), "x - a"),
    (("x", "y", "z"), ("y*z", "-x*z", "-a*x*y"), ("x**2 + y**2", "a*x**2 + z**2"), "x - a"),
    (("x", "y"), ("y", "-x - a*y"), ("(y**2 + a*x*y + x**2)*exp(a*t)",), "x"),
    (
        ("x", "y", "u", "v"),
        ("u", "v", "-a*x/(x**2 + y**2)**1.5", "-a*y/(x**2 + y**2)**1.5"),
        ("(u**2 + v**2)/2 - a/sqrt(x**2 + y**2)", "x*v - y*u"),
        "x**2 + y**2 - a**2",
    ),
)


def examples() -> Iterator[Laws]:
    """Laws of one system of each kind."""
    for variables, field, psi, g in _KINDS:
        yield Declaration(variables, ("a",), (None,), field, field, (g,), psi, psi).laws
