"""The paper's fig:vftypes, fourth picture: sliding, both fields to the surface."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Sliding surface",
    variables=("x", "y"),
    f_minus=("v_minus*cos(2*y)", "v_minus"),
    f_plus=("v_plus*cos(2*y)", "-v_plus"),
    g="y",
    psi_minus=("x - sin(2*y)/2",),
    psi_plus=("x + sin(2*y)/2",),
    parameters=(
        Parameter("v_minus", 0.1, (0.02, 1.0), "upward speed where y < 0"),
        Parameter("v_plus", 0.1, (0.02, 1.0), "downward speed where y > 0"),
    ),
    x0=(0.0, 2.0),
    doc="Both fields point to y = 0: a trajectory reaches it from either side, cannot leave it, and slides along it.",
)
