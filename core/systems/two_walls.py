"""An oscillator between two walls, the regions beyond which are not declared: at either wall it bounces."""

from core.system import Parameter, PiecewiseSystem, Region

_BOUNCE = ("x", "-restitution*v")

SYSTEM = PiecewiseSystem(
    name="Oscillator between walls",
    variables=("x", "v"),
    surfaces=("x + 1", "x - 1"),
    regions={"+-": Region(f=("v", "-stiffness*x"), psi=("(v**2 + stiffness*x**2)/2",))},
    jumps={0: _BOUNCE, 1: _BOUNCE},
    parameters=(
        Parameter("stiffness", 1.0, (0.1, 3.5), "stiffness of the spring, for a unit mass", "k"),
        Parameter("restitution", 0.95, (0.2, 1.0), "coefficient of restitution", r"\epsilon"),
    ),
    x0=(0.0, 2.0),
    doc="A mass on a spring bounces between walls at x = −1 and x = 1; each bounce multiplies its speed by ε, "
    "and between impacts the energy is conserved. If ε < 1, the swings shrink to the one that just reaches the "
    "walls, and the impacts become ever softer.",
)
