"""An oscillator whose spring changes on a line that moves: g depends on time."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Moving interface",
    variables=("x", "y"),
    f_minus=("y", "-omega2_minus*x"),
    f_plus=("y", "-omega2_plus*x"),
    g="y - a*sin(w*t)",
    psi_minus=("(omega2_minus*x**2 + y**2)/2",),
    psi_plus=("(omega2_plus*x**2 + y**2)/2",),
    parameters=(
        Parameter("omega2_minus", 3.0, (0.1, 20.0), "angular frequency squared below the line", r"\omega^2_{-}"),
        Parameter("omega2_plus", 1.0, (0.1, 20.0), "angular frequency squared above the line", r"\omega^2_{+}"),
        Parameter("a", 0.5, (0.0, 1.0), "amplitude of the interface"),
        Parameter("w", 0.7, (0.1, 5.0), "angular frequency of the interface", r"\omega"),
    ),
    x0=(1.5, 1.0),
    doc="A harmonic oscillator whose spring changes on a line that goes up and down: y = a sin(ωt).",
)
