"""A ball that bounces: the state jumps at the surface, and the bounces accumulate."""

from core.system import Parameter, PiecewiseSystem

_FALL = ("v", "-gravity")
_ENERGY = ("v**2/2 + gravity*y",)

SYSTEM = PiecewiseSystem(
    name="Bouncing ball",
    variables=("y", "v"),
    f_minus=_FALL,
    f_plus=_FALL,
    g="y",
    psi_minus=_ENERGY,
    psi_plus=_ENERGY,
    parameters=(
        Parameter("gravity", 9.8, (0.5, 30.0), "gravitational acceleration", r"\gamma"),
        Parameter("restitution", 0.5, (0.1, 1.0), "coefficient of restitution", r"\epsilon"),
    ),
    x0=(1.0, 0.0),
    jump=("0", "-restitution*v"),
    doc="A ball falls and bounces; each bounce multiplies its speed by ε. If ε < 1, infinitely many bounces "
    "take a finite time, and the run ends where they accumulate.",
)
