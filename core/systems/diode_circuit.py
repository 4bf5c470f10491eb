"""An inductor and a diode that stores charge: its capacitance depends on the sign of the charge."""

from core.system import Parameter, PiecewiseSystem

SYSTEM = PiecewiseSystem(
    name="Diode circuit",
    variables=("q", "i"),
    f_minus=("i", "(bias - q/c_minus)/inductance"),
    f_plus=("i", "(bias - q/c_plus)/inductance"),
    g="q",
    psi_minus=("inductance*i**2/2 + q**2/(2*c_minus) - bias*q",),
    psi_plus=("inductance*i**2/2 + q**2/(2*c_plus) - bias*q",),
    parameters=(
        Parameter("c_minus", 0.2, (0.05, 2.0), "capacitance of the blocking diode", "C_{-}"),
        Parameter("c_plus", 2.0, (0.2, 10.0), "capacitance of the conducting diode", "C_{+}"),
        Parameter("inductance", 0.5, (0.1, 5.0), "inductance", "L"),
        Parameter("bias", 0.2, (-1.0, 1.0), "voltage of the battery", "E"),
    ),
    x0=(1.5, 0.0),
    doc="An inductor, a battery and a diode in a loop. A conducting diode (charge q > 0) acts as a large "
    "capacitor, a blocking one as a small capacitor.",
)
