"""Chua's circuit: the resistor's characteristic has three straight pieces, and the orbit is chaotic."""

from core.system import Parameter, PiecewiseSystem, Region


def _law(diode: str) -> Region:
    """The law where the current of Chua's diode, with its sign reversed, is a given function of x."""
    return Region(f=(f"alpha*(y - x {diode})", "x - y + z", "-beta*y"))


SYSTEM = PiecewiseSystem(
    name="Chua’s circuit",
    variables=("x", "y", "z"),
    surfaces=("x + 1", "x - 1"),
    regions={"--": _law("- b*x + a - b"), "+-": _law("- a*x"), "++": _law("- b*x - a + b")},
    parameters=(
        Parameter("alpha", 9.0, (8.0, 9.2), "ratio of the capacitances", r"\alpha"),
        Parameter("beta", 100 / 7, (14.0, 20.0), "resistance squared times capacitance over inductance", r"\beta"),
        Parameter("a", -8 / 7, (-1.16, -1.1), "slope of the inner piece of the diode’s characteristic"),
        Parameter("b", -5 / 7, (-0.75, -0.65), "slope of its outer pieces"),
    ),
    x0=(0.1, 0.1, 0.0),
    doc="Two capacitors, an inductor, a resistor and a diode whose characteristic has three straight pieces, of "
    "negative slope. The orbit circles for a while about a point beyond x = 1, or below x = −1, and switches between "
    "the two chaotically: the double scroll.",
)
