"""Bang-bang control: a relay switches on a line of the portrait, and chatters at the end."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Relay feedback",
    variables=("x", "v"),
    f_minus=("v", "force - drag*v"),
    f_plus=("v", "-force - drag*v"),
    g="x + lead*v",
    parameters=(
        Parameter("force", 1.0, (0.1, 5.0), "force of the motor", "F"),
        Parameter("drag", 0.05, (0.0, 1.0), "coefficient of air drag", "c"),
        Parameter("lead", 0.15, (0.01, 1.0), "lead time of the relay", r"\theta"),
    ),
    x0=(4.0, 0.0),
    doc="A motor pushes a cart back with full force, to the left or to the right by the sign of x + θv. The swings die "
    "down until both fields point towards the line and the relay chatters: in the limit the state slides along it.",
)
