"""Lotka-Volterra with a threshold: its conserved quantity has logarithms, and is no energy."""

from core.system import Parameter, PiecewiseSystem

_PREY = "x*(a - b*y)"

SYSTEM = PiecewiseSystem(
    name="Predator and prey",
    variables=("x", "y"),
    f_minus=(_PREY, "y*(c_minus*x - d)"),
    f_plus=(_PREY, "y*(c_plus*x - d)"),
    g="x - threshold",
    psi_minus=("c_minus*x - d*log(x) + b*y - a*log(y)",),
    psi_plus=("c_plus*x - d*log(x) + b*y - a*log(y)",),
    parameters=(
        Parameter("a", 2.0, (0.2, 5.0), "growth rate of the prey"),
        Parameter("b", 2.0, (0.2, 5.0), "predation rate"),
        Parameter("c_minus", 1.0, (0.2, 5.0), "growth of the predators by prey where it is scarce"),
        Parameter("c_plus", 0.6, (0.2, 5.0), "growth of the predators by prey where it is plentiful"),
        Parameter("d", 1.0, (0.2, 5.0), "death rate of the predators"),
        Parameter("threshold", 1.0, (0.2, 4.0), "density above which prey is plentiful", r"\theta"),
    ),
    x0=(0.5, 1.0),
    doc="Predators y live on prey x. Where prey is plentiful, x > θ, they are sated, and the same prey sustains fewer.",
)
