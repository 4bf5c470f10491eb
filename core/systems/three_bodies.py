"""Three bodies in the plane that attract each other; two of them are hard discs, which bounce."""

from core.system import Parameter, PiecewiseSystem

_PAIRS = ((1, 2), (1, 3), (2, 3))


def _apart(i: int, j: int) -> str:
    """Square of the distance of two bodies, softened."""
    return f"(x{i} - x{j})**2 + (y{i} - y{j})**2 + soft**2"


def _pull(i: int, along: str) -> str:
    """Force on a body."""
    others = [j for j in (1, 2, 3) if j != i]
    return " + ".join(f"({along}{j} - {along}{i})/({_apart(i, j)})**(3/2)" for j in others)


_FIELD = tuple([f"{w}{i}" for i in (1, 2, 3) for w in "uv"] + [_pull(i, along) for i in (1, 2, 3) for along in "xy"])
_ENERGY = " + ".join(f"(u{i}**2 + v{i}**2)/2" for i in (1, 2, 3)) + "".join(
    f" - 1/sqrt({_apart(i, j)})" for i, j in _PAIRS
)
_CONSERVED = (
    _ENERGY,
    "u1 + u2 + u3",
    "v1 + v2 + v3",
    " + ".join(f"x{i}*v{i} - y{i}*u{i}" for i in (1, 2, 3)),
)

# Elastic collision of equal masses: what their velocities differ by along the line of their centres is exchanged.
_GAP = "((x1 - x2)**2 + (y1 - y2)**2)"
_PUSH = "((u1 - u2)*(x1 - x2) + (v1 - v2)*(y1 - y2))"
_AFTER = (
    *(f"{along}{i}" for i in (1, 2, 3) for along in "xy"),
    *(
        f"{w}{i} {sign} {_PUSH}*({along}1 - {along}2)/{_GAP}"
        for i, sign in ((1, "-"), (2, "+"))
        for w, along in (("u", "x"), ("v", "y"))
    ),
    "u3",
    "v3",
)

SYSTEM = PiecewiseSystem(
    name="Three bodies, two of them hard",
    variables=tuple(f"{name}{i}" for names in ("xy", "uv") for i in (1, 2, 3) for name in names),
    f_minus=_FIELD,
    f_plus=_FIELD,
    g="(x1 - x2)**2 + (y1 - y2)**2 - size**2",
    psi_minus=_CONSERVED,
    psi_plus=_CONSERVED,
    parameters=(
        Parameter("size", 0.6, (0.1, 0.9), "distance of the centres of bodies 1 and 2 at which they touch", "D"),
        Parameter("soft", 0.5, (0.2, 1.0), "softening of the attraction (Plummer)", r"\epsilon"),
    ),
    x0=(0.8, 0.0, -0.8, 0.0, 0.0, 1.3, 0.0, 0.3, 0.0, -0.3, 0.0, 0.0),
    jump=_AFTER,
    doc="Three equal masses attract each other; bodies 1 and 2 are hard discs and bounce off each other. Energy, "
    "momentum and angular momentum are conserved, through every collision.",
)
