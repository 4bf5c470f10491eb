"""The paper's second system: motion along elliptic curves that change on a circle."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Elliptic curve",
    variables=("x", "y"),
    f_minus=("2*y", "3*x**2 + a_minus"),
    f_plus=("2*y", "3*x**2 + a_plus"),
    g="x**2 + y**2 - radius**2",
    psi_minus=("y**2 - x**3 - a_minus*x",),
    psi_plus=("y**2 - x**3 - a_plus*x",),
    parameters=(
        Parameter("a_minus", -3.0, (-8.0, 4.0), "coefficient inside the circle"),
        Parameter("a_plus", -2.0, (-8.0, 4.0), "coefficient outside the circle"),
        Parameter("radius", 1.0, (0.1, 4.0), "radius of the circle", "r"),
    ),
    x0=(-1.0, -1.0),
    doc="A point moves along an elliptic curve y² = x³ + ax + ψ whose coefficient a changes on a circle.",
)
