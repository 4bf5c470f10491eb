"""A Glass network: a ring of three genes, each of which switches the next one off above a threshold (repressilator)."""

from itertools import product

from core.system import Parameter, PiecewiseSystem, Region

_GENES = ("x", "y", "z")


def _law(signs: tuple[str, ...]) -> Region:
    """Each protein decays, and is made where the one before it in the ring is below the threshold."""
    made = [sign == "-" for sign in (signs[-1], *signs[:-1])]
    return Region(f=tuple(f"supply - {u}" if on else f"-{u}" for u, on in zip(_GENES, made, strict=True)))


SYSTEM = PiecewiseSystem(
    name="Ring of three genes",
    variables=_GENES,
    surfaces=tuple(f"{u} - threshold" for u in _GENES),
    regions={"".join(signs): _law(signs) for signs in product("-+", repeat=3)},
    parameters=(
        Parameter("supply", 2.0, (1.5, 5.0), "level that a protein tends to where its gene is on", r"\kappa"),
        Parameter("threshold", 1.0, (0.3, 1.2), "level above which a protein switches the next gene off", r"\theta"),
    ),
    x0=(0.0, 0.3, 0.6),
    doc="Three proteins x, y and z, each of which, above the threshold θ, represses the gene of the next (z represses "
    "that of x). No gene stays on or off: the levels approach a limit cycle through six of the eight regions.",
)
