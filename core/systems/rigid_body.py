"""A free rigid body in Jacobi's form: three dimensions and two invariants, which fix the orbit."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Rigid body",
    variables=("y1", "y2", "y3"),
    f_minus=("y2*y3", "-y1*y3", "-m_minus*y1*y2"),
    f_plus=("y2*y3", "-y1*y3", "-m_plus*y1*y2"),
    g="y1 - plane",
    psi_minus=("y1**2 + y2**2", "m_minus*y1**2 + y3**2"),
    psi_plus=("y1**2 + y2**2", "m_plus*y1**2 + y3**2"),
    parameters=(
        Parameter("m_minus", 0.51, (0.05, 2.0), "ratio of moments of inertia below the plane"),
        Parameter("m_plus", 0.9, (0.05, 2.0), "ratio of moments of inertia above the plane"),
        Parameter("plane", 0.6, (-1.2, 1.2), "position of the plane", "c"),
    ),
    x0=(0.0, 1.0, 1.0),
    doc="Euler’s equations of a body that turns freely, scaled to Jacobi’s form: on each side of the plane y₁ = c the "
    "state moves along a curve in which two cylinders meet.",
)
