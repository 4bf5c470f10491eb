"""Systems of one's own with more regions than two sides, as a user may declare them."""

import core
from core import PiecewiseSystem, Region, Transition

#: Three strips, of which the middle one has straight level sets.
STRIPS = PiecewiseSystem(
    name="Strips", variables=("x", "y"), surfaces=("x + 1", "x - 1"),
    regions={
        "--": Region(("1", "2"), ("2*x - y",)),
        "+-": Region(("speed", "0"), ("y",)),
        "++": Region(("y", "2 - x"), ("(x - 2)**2 + y**2",)),
    },
    parameters=(core.Parameter("speed", 1.5, (0.5, 3.0), "speed in the middle", r"\sigma"),), x0=(-1.5, -0.5),
)  # fmt: skip

#: Two lines that cross; where x > y and x < −y no law is declared.
WEDGE = PiecewiseSystem(
    name="Wedge", variables=("x", "y"), surfaces=("x - y", "x + y"),
    regions={
        "-+": Region(("1", "-0.25"), ("x + 4*y",)),
        "++": Region(("1", "1/2"), ("x - 2*y",)),
        "--": Region(("2", "-1"), ("x + 2*y",)),
    },
    x0=(0.5, 1.0),
)  # fmt: skip

#: One surface, at which the state jumps, and no law beyond it.
WALL = PiecewiseSystem(
    name="Wall", variables=("x", "v"), surfaces=("x",), regions={"+": Region(("v", "-1"), ("v**2/2 + x",))},
    jumps={0: ("x", "-v*0.9")}, x0=(1.0, 0.0),
)  # fmt: skip

#: Named regions: a charge that is reset in part when a threshold switches it off.
RELAY = PiecewiseSystem(
    name="Relay", variables=("u", "w"),
    regions={"pre-heat": Region(("1", "-w"), ("w*exp(u)",)), "off": Region(("-u", "u - w"))},
    transitions=(Transition("pre-heat", "top - u", "off", ("u", "w/2")), Transition("off", "u - 1/2", "pre-heat")),
    parameters={"top": 2.0}, x0=(0.0, 1.0),
)  # fmt: skip

#: Two surfaces that move, and depend on a parameter.
GATE = PiecewiseSystem(
    name="Gate", variables=("x", "y"), surfaces=("x - sin(t)/4", "y - level"),
    regions={
        "--": Region(("1", "1")), "-+": Region(("1", "-0.5")), "+-": Region(("0.5", "1")), "++": Region(("1", "0")),
    },
    parameters={"level": 0.5}, x0=(-1.0, -1.0),
)  # fmt: skip

#: One field, in the order of whose terms its surfaces are found, with a quantity that switches as it does.
BELT = PiecewiseSystem.from_field(
    ("x", "v"), ("v", "-x  - mu*sign(v-1) - max(x - 2, 0)"), ("v**2/2 + x**2/2 + mu*x*sign(v-1) + max(x - 2, 0)**2/2",),
    {"mu": 0.5}, (0.5, 2.0), "Belt",
)  # fmt: skip

#: A law that changes at instants, wherever the state is.
SQUARE_WAVE = PiecewiseSystem.from_field(
    ("x", "v"), ("v", "-x + sign(sin(3*t))/2"), x0=(1.0, 0.0), name="Square wave"
)  # fmt: skip

#: One law, and a state that jumps at instants.
KICKED = PiecewiseSystem(
    name="Kicked", variables=("x", "p"), f_minus=("p", "0"), f_plus=("p", "0"), g="sin(pi*t)",
    jump=("x", "p + sin(x)"), x0=(1.0, 2.0),
)  # fmt: skip

OWN_SYSTEMS = {system.name: system for system in (STRIPS, WEDGE, WALL, RELAY, GATE, BELT)}
