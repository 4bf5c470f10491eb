"""A thermostat: a relay with hysteresis heats a room by way of a radiator, which stores heat."""

from core.system import Parameter, PiecewiseSystem, Region, Transition


def _law(radiator: str) -> Region:
    """Temperatures of room and radiator, at a given rate of the latter."""
    return Region(f=("r - T - loss*(T + cold)", radiator))


SYSTEM = PiecewiseSystem(
    name="Thermostat",
    variables=("T", "r"),
    regions={"on": _law("power - storage*(r - T)"), "off": _law("-storage*(r - T)")},
    transitions=(Transition("on", "band - T", "off"), Transition("off", "T + band", "on")),
    parameters=(
        Parameter("band", 1.0, (0.2, 2.0), "half the width of the band between switching on and off", r"\delta"),
        Parameter("power", 4.0, (2.0, 6.0), "power of the heating", "P"),
        Parameter("cold", 10.0, (5.0, 15.0), "set point minus the temperature outside", r"\Delta"),
        Parameter("loss", 0.2, (0.1, 0.3), "loss of heat to the outside", r"\lambda"),
        Parameter("storage", 0.5, (0.1, 1.5), "rate of heat transfer from the radiator to the room", r"\sigma"),
    ),
    x0=(-2.0, 0.0),
    doc="The heating switches on when the room temperature T, measured from the set point, falls to −δ, and off when "
    "it rises to δ; in between it keeps its state (hysteresis). The radiator, of temperature r, stores heat, so the "
    "room temperature overshoots, and approaches a limit cycle.",
)
