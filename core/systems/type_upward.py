"""The paper's fig:vftypes, first picture: transversal, both fields up."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Crossing upward",
    variables=("x", "y"),
    f_minus=("v_minus*cos(2*y)", "v_minus"),
    f_plus=("v_plus*(y - 1)", "v_plus"),
    g="y",
    psi_minus=("x - sin(2*y)/2",),
    psi_plus=("x - y**2/2 + y",),
    parameters=(
        Parameter("v_minus", 0.1, (0.02, 1.0), "upward speed where y < 0"),
        Parameter("v_plus", 0.05, (0.02, 1.0), "upward speed where y > 0"),
    ),
    x0=(0.0, -2.0),
    doc="Both fields point up through y = 0: every trajectory from below crosses once, with a kink.",
)
