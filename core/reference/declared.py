"""reference_solution(): the solution against which runs of a declared system are measured."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.interface.arguments import checked_sliding, number
from core.interface.cancelling import Cancel, raise_if
from core.reference.continued import ContinuedSolution
from core.reference.exact import exact_solution
from core.reference.external import external_solution, functions_of
from core.reference.laws_in_numbers import laws_in_numbers
from core.reference.solution import ReferenceSolution, Solution
from core.reference.taylor import TaylorSolution
from core.system import PiecewiseSystem, Start
from core.systems import System, system_of

__all__ = ["reference_solution"]


def reference_solution(
    system: System,
    x0: Start | None = None,
    t0: float = 0.0,
    independent: bool = False,
    cancel: Cancel | None = None,
    sliding: str = "stop",
) -> Solution:
    """Exact solution where the fields of all regions have known closed forms, else the Taylor method at two tolerances.

    A closed form is recognised from the declaration: fields linear in the state, fields whose orbits are elliptic
    curves, pendulums and free rigid bodies; regions may be of different kinds, and surfaces may move. Its `name` says
    which. The field of sliding is recognised likewise, as it is on the surface. The solution is computed in as many
    digits as two precisions need to agree to the round-off of a double, and no crossing is missed: bounds on the guards
    of a mode between samples exclude further ones.

    Numbers in the text of a law are the decimals that they are written as, 0.1 one tenth; values of parameters and
    initial values are doubles.

    Parameters
    ----------
    system
        A system, or a key of CATALOGUE.
    x0
        d numbers, or a mapping from the names of the variables; the system's own x0 where not given.
    t0
        Start time.
    independent
        Where there is no closed form, use SciPy's DOP853 at its tightest tolerance: slower and less accurate, but an
        external solver, independent of this package's methods.
    sliding
        As in `integrate`. With "continue" the Taylor method (or the external solver, if asked for) takes over from
        where an exact solution slides by a field without a known closed form.
    cancel
        Called again and again; once it returns True, whatever is asked for raises `core.reference.Cancelled`.

    Returns
    -------
    Solution
        ``.crossing(k)`` -> (t, x) on the surface and ``.after(k)`` -> x after its jump, for k = 1, 2, …; ``.state(t)``,
        ``.side(t)``; computed when first asked for. ``.exact`` tells whether all that was asked for so far is right to
        the round-off of a double, and ``.error`` bounds its error before rounding; where it is not exact, ``.error``
        is an estimate. Where a closed form is known but the highest precision was not enough, ``.name`` says so.

    Raises
    ------
    ValueError
        If the initial state is on a surface and cannot leave it to one side.
    """
    system, t0 = system_of(system), number(t0, "t0")
    start = np.array(system.x0 if x0 is None else system.check_state(x0))
    laws = system.laws
    slides = checked_sliding(sliding)
    by_taylor = partial(TaylorSolution, system, start, t0, cancel, slides)
    by_external = partial(_by_external_solver, system, start, t0, cancel, slides)
    numbers = dict(zip(laws.p, system.parameter_array.tolist(), strict=True))
    try:
        exact = exact_solution(laws_in_numbers(laws, numbers), t0, start, slides=slides, cancel=cancel)
    except ValueError:  # the start has no region to enter, or slides where no closed form is known
        if not slides and laws.two_sided:
            raise
        exact = None
    go_on = by_external if independent else by_taylor
    if exact is not None:
        return ContinuedSolution(exact, go_on) if slides else exact
    return go_on()


def _by_external_solver(
    system: PiecewiseSystem, start: NDArray[np.float64], t0: float, cancel: Cancel | None, slides: bool
) -> ReferenceSolution:
    functions = functions_of(system)

    def field(mode: int, t: float, x: NDArray[np.float64]) -> ArrayLike:
        raise_if(cancel)
        return functions.field(mode, t, x)

    return external_solution(replace(functions, field=field), t0, start, slides=slides)
