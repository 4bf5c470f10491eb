"""The paper's damped oscillator, whose conserved quantity depends on time."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Damped oscillator",
    variables=("x", "v"),
    f_minus=("v", "-(gamma_minus*v + k*x)/m"),
    f_plus=("v", "-(gamma_plus*v + k*x)/m"),
    g="x",
    psi_minus=("exp(gamma_minus*t/m)*(m*v**2 + gamma_minus*x*v + k*x**2)/2",),
    psi_plus=("exp(gamma_plus*t/m)*(m*v**2 + gamma_plus*x*v + k*x**2)/2",),
    parameters=(
        Parameter("gamma_minus", 0.05, (0.0, 1.0), "damping where x < 0"),
        Parameter("gamma_plus", 0.2, (0.0, 1.0), "damping where x > 0"),
        Parameter("k", 2.0, (0.5, 20.0), "stiffness of the spring"),
        Parameter("m", 1.0, (0.2, 5.0), "mass"),
    ),
    x0=(1.0, 0.0),
    doc="A mass on a spring moves in one oil where x < 0 and in another, by default thicker, where x > 0. Energy is "
    "lost, yet a quantity that depends on time is conserved.",
)
