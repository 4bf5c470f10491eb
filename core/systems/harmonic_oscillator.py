"""The paper's first system: an oscillator whose spring changes where the velocity changes sign."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Harmonic oscillator",
    variables=("x", "y"),
    f_minus=("y", "-omega2_minus*x"),
    f_plus=("y", "-omega2_plus*x"),
    g="y",
    psi_minus=("(omega2_minus*x**2 + y**2)/2",),
    psi_plus=("(omega2_plus*x**2 + y**2)/2",),
    parameters=(
        Parameter("omega2_minus", 3.0, (0.1, 20.0), "angular frequency squared where y < 0", r"\omega^2_{-}"),
        Parameter("omega2_plus", 1.0, (0.1, 20.0), "angular frequency squared where y > 0", r"\omega^2_{+}"),
    ),
    x0=(1.0, 1.0),
    doc="An oscillator with one spring where y > 0 and another where y < 0. Each side conserves its own energy.",
)
