"""Systems with conserved quantities of every kind, shared by the tests of the core."""

from core import CATALOGUE, PiecewiseSystem

_KEPLER = {
    "variables": ("x", "y", "u", "v"),
    "f_minus": ("u", "v", "-mu*x/(x**2 + y**2)**1.5", "-mu*y/(x**2 + y**2)**1.5"),
    "f_plus": ("u", "v", "-mu*x/(x**2 + y**2)**1.5", "-mu*y/(x**2 + y**2)**1.5"),
    "g": "y",
    "parameters": {"mu": 1.0},
    "x0": (1.0, 0.2, -0.1, 0.9),
}
_ENERGY = "(u**2 + v**2)/2 - mu/sqrt(x**2 + y**2)"
_MOMENTUM = "x*v - y*u"
_EULER = ("(1/i3 - 1/i2)*y*z", "(1/i1 - 1/i3)*z*x", "(1/i2 - 1/i1)*x*y")
_DAMPED = ("y", "-k*x - c*y")
_DECAY = "exp(c*t)*(y**2 + c*x*y + k*x**2)/2"

HARMONIC = CATALOGUE["harmonic_oscillator"]
ELLIPTIC = CATALOGUE["elliptic_curve"]
#: Two invariants in three dimensions: f = n(∇ψ) up to a constant factor.
RIGID_BODY = PiecewiseSystem(
    name="Rigid body",
    variables=("x", "y", "z"),
    f_minus=_EULER,
    f_plus=_EULER,
    g="x",
    psi_minus=("(x**2 + y**2 + z**2)/2", "(x**2/i1 + y**2/i2 + z**2/i3)/2"),
    psi_plus=("(x**2 + y**2 + z**2)/2", "(x**2/i1 + y**2/i2 + z**2/i3)/2"),
    parameters={"i1": 1.0, "i2": 2.0, "i3": 3.0},
    x0=(0.6, 0.3, 0.7),
)
#: Fewer invariants than fix the orbit: energy alone on one side, and angular momentum too on the other.
KEPLER = PiecewiseSystem(name="Kepler", psi_minus=(_ENERGY,), psi_plus=(_ENERGY, _MOMENTUM), **_KEPLER)
#: An invariant that names t.
DAMPED = PiecewiseSystem(
    name="Damped oscillator",
    variables=("x", "y"),
    f_minus=_DAMPED,
    f_plus=_DAMPED,
    g="y",
    psi_minus=(_DECAY,),
    psi_plus=(_DECAY,),
    parameters={"k": 2.0, "c": 0.3},
    x0=(1.0, 0.5),
)
#: c is no constant here: f = c(x, y) n(∇ψ), and ψ has logarithms.
PREDATORS = PiecewiseSystem(
    name="Lotka-Volterra",
    variables=("x", "y"),
    f_minus=("x*(a - b*y)", "y*(b*x - 1)"),
    f_plus=("x*(a - b*y)", "y*(b*x - 1)"),
    g="x - 1",
    psi_minus=("b*x - log(x) + b*y - a*log(y)",),
    psi_plus=("b*x - log(x) + b*y - a*log(y)",),
    parameters={"a": 1.5, "b": 0.8},
    x0=(1.2, 0.9),
)
PENDULUM = PiecewiseSystem(
    name="Pendulum",
    variables=("q", "p"),
    f_minus=("p", "-sin(q)"),
    f_plus=("tanh(p)", "-sin(q)*exp(cos(q)) - sinh(q)"),
    g="q",
    psi_minus=("p**2/2 - cos(q)",),
    psi_plus=("log(cosh(p)) - exp(cos(q)) + cosh(q)",),
    x0=(0.4, 0.6),
)

ALL = (HARMONIC, ELLIPTIC, RIGID_BODY, KEPLER, DAMPED, PREDATORS, PENDULUM)
