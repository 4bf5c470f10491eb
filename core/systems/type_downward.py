"""The paper's fig:vftypes, second picture: transversal, both fields down."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Crossing downward",
    variables=("x", "y"),
    f_minus=("-v_minus*(y + 1)", "-v_minus"),
    f_plus=("v_plus*cos(2*y)", "-v_plus"),
    g="y",
    psi_minus=("x - y**2/2 - y",),
    psi_plus=("x + sin(2*y)/2",),
    parameters=(
        Parameter("v_minus", 0.05, (0.02, 1.0), "downward speed where y < 0"),
        Parameter("v_plus", 0.1, (0.02, 1.0), "downward speed where y > 0"),
    ),
    x0=(0.0, 2.0),
    doc="Both fields point down through y = 0: every trajectory from above crosses once, with a kink.",
)
