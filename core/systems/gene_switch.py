"""A Glass network: a loop of two genes, one of which is switched off above a threshold."""

from core.system import Parameter, PiecewiseSystem

_LOOP = ("decay*(x - y)", "decay*(y - z)")

SYSTEM = PiecewiseSystem(
    name="Gene switch",
    variables=("x", "y", "z"),
    f_minus=("decay*(supply - x)", *_LOOP),
    f_plus=("-decay*x", *_LOOP),
    g="z - threshold",
    parameters=(
        Parameter("supply", 2.0, (0.5, 5.0), "level that the first protein tends to", r"\kappa"),
        Parameter("threshold", 0.8, (0.1, 2.0), "level of repressor that switches the gene off", r"\theta"),
        Parameter("decay", 1.5, (0.2, 5.0), "rate of decay", r"\gamma"),
    ),
    x0=(0.0, 0.0, 0.0),
    doc="The protein x of one gene turns on a second gene, which makes the repressor z by way of its messenger y. "
    "Above the threshold θ the repressor switches the first gene off: for θ < κ the levels oscillate for ever.",
)
