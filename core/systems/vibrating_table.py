"""A ball that bounces on a vibrating table: flight is integrable, impacts make it chaotic."""

from core.system import Parameter, PiecewiseSystem

_FLIGHT = ("omega", "v", "-gravity")
_ENERGY = ("v**2/2 + gravity*y",)

SYSTEM = PiecewiseSystem(
    name="Bouncing ball on a vibrating table",
    variables=("phi", "y", "v"),
    f_minus=_FLIGHT,
    f_plus=_FLIGHT,
    g="y - a*sin(phi)",
    psi_minus=_ENERGY,
    psi_plus=_ENERGY,
    parameters=(
        Parameter("a", 0.25, (0.0, 2.0), "amplitude of the table"),
        Parameter("omega", 1.0, (0.2, 5.0), "angular frequency of the table", r"\omega"),
        Parameter("gravity", 1.0, (0.1, 10.0), "gravitational acceleration", r"\gamma"),
        Parameter("restitution", 1.0, (0.3, 1.0), "coefficient of restitution", r"\epsilon"),
    ),
    x0=(0.0, 3.0, 0.0),
    jump=("phi", "a*sin(phi)", "(1 + restitution)*a*omega*cos(phi) - restitution*v"),
    doc="A ball falls on a table at height a sin φ; each bounce multiplies their relative speed by ε. Without "
    "loss (ε = 1) regular and chaotic orbits lie side by side; with loss, bounces recur, accumulate or are chaotic.",
)
