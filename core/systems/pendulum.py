"""A pendulum under two gravities: the textbook nonlinear oscillator, switched on a vertical line of its portrait."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Pendulum",
    variables=("q", "p"),
    f_minus=("p", "-k_minus*sin(q)"),
    f_plus=("p", "-k_plus*sin(q)"),
    g="q - angle",
    psi_minus=("p**2/2 - k_minus*cos(q)",),
    psi_plus=("p**2/2 - k_plus*cos(q)",),
    parameters=(
        Parameter("k_minus", 3.7, (0.1, 30.0), "gravity over length below the angle"),
        Parameter("k_plus", 9.8, (0.1, 30.0), "gravity over length above the angle"),
        Parameter("angle", 0.5, (-1.5, 1.5), "where gravity changes, in radians", r"\alpha"),
    ),
    x0=(-1.57, 0.0),
    doc="A pendulum of length one metre swings under one gravity for q < α, by default that of Mars, and under another "
    "for q > α, by default that of the Earth.",
)
