"""Hénon–Heiles with a wall: a star in the potential of a galaxy, reflected by a line."""

from core.system import Parameter, PiecewiseSystem

_FIELD = ("u", "v", "-x - 2*x*y", "-y - x**2 + y**2")
_ENERGY = "(u**2 + v**2 + x**2 + y**2)/2 + x**2*y - y**3/3"

SYSTEM = PiecewiseSystem(
    name="Hénon–Heiles with a wall",
    variables=("x", "y", "u", "v"),
    f_minus=_FIELD,
    f_plus=_FIELD,
    g="x + wall",
    psi_minus=(_ENERGY,),
    psi_plus=(_ENERGY,),
    parameters=(Parameter("wall", 0.1, (-0.4, 0.6), "distance of the wall x = −c from the y-axis", "c"),),
    x0=(0.2, 0.1, 0.1, 0.35),
    jump=("x", "y", "-u", "v"),
    doc="In the potential of Hénon and Heiles (1964), orbits in the central well with an energy below 1/6 are bounded, "
    "and regular or chaotic; an elastic wall at x = −c reflects them and conserves the energy.",
)
