"""The paper's fig:vftypes, third picture: unstable, both fields away from the surface."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Repelling surface",
    variables=("x", "y"),
    f_minus=("v_minus*cos(2*y)", "-v_minus"),
    f_plus=("v_plus*cos(2*y)", "v_plus"),
    g="y",
    psi_minus=("x + sin(2*y)/2",),
    psi_plus=("x - sin(2*y)/2",),
    parameters=(
        Parameter("v_minus", 0.05, (0.02, 1.0), "downward speed where y < 0"),
        Parameter("v_plus", 0.05, (0.02, 1.0), "upward speed where y > 0"),
    ),
    x0=(0.0, 0.1),
    doc="Both fields point away from y = 0. A trajectory beside it leaves; from a point on it, the solution may leave "
    "to either side, so a run that starts there stops at once.",
)
