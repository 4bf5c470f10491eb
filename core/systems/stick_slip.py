"""Stick-slip: a block on a moving belt, held by a spring, whose friction falls with the sliding speed (Stribeck)."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Stick-slip on a belt",
    variables=("y", "v"),
    f_minus=("v", "-y + kinetic + (static - kinetic)*exp((v - belt)/decay)"),
    f_plus=("v", "-y - kinetic - (static - kinetic)*exp(-(v - belt)/decay)"),
    g="v - belt",
    parameters=(
        Parameter("belt", 0.3, (0.05, 2.0), "speed of the belt", "w"),
        Parameter("static", 1.0, (0.1, 3.0), "coefficient of static friction", r"\mu_s"),
        Parameter("kinetic", 0.4, (0.05, 3.0), "coefficient of friction at high speed", r"\mu_k"),
        Parameter("decay", 0.5, (0.05, 5.0), "scale of the speed over which friction falls", "d"),
    ),
    x0=(0.0, 0.0),
    doc="A block on a belt, held by a spring, sticks and is carried along until the spring pulls it loose; it slips "
    "back, and sticks again: sliding begins and ends in every period.",
)
