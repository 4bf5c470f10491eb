"""A full-wave rectifier: four ideal diodes lead an alternating voltage, whatever its sign, to a capacitor."""

from core.system import Parameter, PiecewiseSystem, Region


def _law(charging: str) -> Region:
    """Source and capacitor, at a given rate of the latter’s voltage."""
    return Region(
        f=("omega*w", charging, "-omega*v"),
        psi=("(v**2 + w**2)/2",),
    )


SYSTEM = PiecewiseSystem(
    name="Diode bridge",
    variables=("v", "u", "w"),  # the first two span the portrait: the plane of both surfaces
    surfaces=("v - u", "v + u"),
    regions={
        "-+": _law("-u/(load*capacitance)"),
        "++": _law("((v - u)/resistance - u/load)/capacitance"),
        "--": _law("((-v - u)/resistance - u/load)/capacitance"),
    },
    parameters=(
        Parameter("omega", 1.0, (0.2, 5.0), "angular frequency of the source", r"\omega"),
        Parameter("resistance", 0.2, (0.05, 1.0), "series resistance of the conducting diodes", "r"),
        Parameter("capacitance", 1.0, (0.2, 5.0), "smoothing capacitance", "C"),
        Parameter("load", 4.0, (1.0, 20.0), "resistance of the load", "R"),
    ),
    x0=(0.0, 0.3, 1.5),
    doc="Four diodes, ideal but for a series resistance, rectify the current of an alternating source of voltage v for "
    "a load and a capacitor of voltage u in parallel: one pair conducts where v > u, the other where v < −u. Otherwise "
    "all four block, and the capacitor discharges through the load.",
)
