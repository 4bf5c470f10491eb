"""Dry friction: turning points are transversal crossings until the block sticks, where the surface attracts."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Coulomb friction",
    variables=("y", "v"),
    f_minus=("v", "-y + mu"),
    f_plus=("v", "-y - mu"),
    g="v",
    psi_minus=("(v**2 + (y - mu)**2)/2",),
    psi_plus=("(v**2 + (y + mu)**2)/2",),
    parameters=(Parameter("mu", 0.4, (0.01, 2.0), "friction per unit mass"),),
    x0=(3.0, 0.0),
    doc="A block on a spring rubs on a dry table. Each swing is shorter than the one before by 4μ, until the spring "
    "is too weak to move the block and it sticks: the state stays on the surface v = 0.",
)
