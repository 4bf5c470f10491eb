"""A planet that passes through a shell of dust: four dimensions, energy and angular momentum."""

from core.system import Parameter, PiecewiseSystem

_MOMENTUM = "x*v - y*u"

SYSTEM = PiecewiseSystem(
    name="Kepler with a shell",
    variables=("x", "y", "u", "v"),
    f_minus=("u", "v", "-mu_minus*x/(x**2 + y**2)**(3/2)", "-mu_minus*y/(x**2 + y**2)**(3/2)"),
    f_plus=("u", "v", "-mu_plus*x/(x**2 + y**2)**(3/2)", "-mu_plus*y/(x**2 + y**2)**(3/2)"),
    g="x**2 + y**2 - radius**2",
    psi_minus=("(u**2 + v**2)/2 - mu_minus/sqrt(x**2 + y**2)", _MOMENTUM),
    psi_plus=("(u**2 + v**2)/2 - mu_plus/sqrt(x**2 + y**2)", _MOMENTUM),
    parameters=(
        Parameter("mu_minus", 3.0, (0.5, 4.0), "mass felt inside the shell: the star’s"),
        Parameter("mu_plus", 4.0, (1.0, 10.0), "mass felt outside: the star’s and the shell’s"),
        Parameter("radius", 1.0, (0.2, 4.0), "radius of the shell", "r"),
    ),
    x0=(1.2, 0.0, 0.0, 1.55),
    doc="A planet at (x, y) with velocity (u, v) passes in and out through a thin shell of dust around its star. "
    "Inside, the shell does not pull, by Newton’s shell theorem.",
)
