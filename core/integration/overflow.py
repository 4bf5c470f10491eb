"""Terms of a law that are too large for a floating-point number, or whose squares are, where a run ends."""

from __future__ import annotations

import numpy as np
import sympy

from core.integration.recorded import Point
from core.symbolic.source_text import to_text
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["overflowing"]

#: Argument from which on the square of an exponential function is beyond the largest double, e⁷⁰⁹.
_LARGE = 350.0


def overflowing(system: PiecewiseSystem, last: Point, keeps_psi: bool) -> str:
    """Text of an exponential or hyperbolic function of the law, or of ψ if that is kept, that overflows; '' if none."""
    if last.mode == NO_MODE:
        return ""
    mode = system.laws.mode(last.mode)
    law = (*mode.field, *mode.conserved) if keeps_psi else mode.field
    found = sorted({term for u in law for term in u.atoms(sympy.exp, sympy.cosh, sympy.sinh)}, key=str)
    arguments = tuple(u if isinstance(term, sympy.exp) else sympy.Abs(u) for term in found for u in term.args)
    values = system.laws.evaluate(
        ("arguments", last.mode, keeps_psi), arguments, [last.t], [last.x], system.parameter_array
    )[0]
    large = np.flatnonzero(values > _LARGE)
    return to_text(found[large[0]]) if large.size else ""
