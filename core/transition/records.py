"""Structured arrays of the compiled loop: the record of a run, its guards, and the rows it writes."""

import numpy as np

from core.kernels.jit import inlined

__all__ = [
    "GUARD", "HIT", "JUMP_ANYWHERE", "JUMP_TO_SURFACE", "NO_JUMP", "NO_MODE", "ROW", "RUN", "SIDES_OF_MODES",
    "SLIDING_MODE", "mode_of",
]  # fmt: skip

#: Side of each mode: 0 has g < 0, 1 has g > 0, 2 slides along g = 0. The last is that of `NO_MODE`, −1, too.
SIDES_OF_MODES = np.array([-1, 1, 0])
#: Number of the mode of sliding.
SLIDING_MODE = 2
#: Mode of a run that has not entered any yet, or that has stopped at the surface.
NO_MODE = -1

#: Jump of a guard: none; to a state whose mode is given by the sign of g there; or to a state on the surface.
NO_JUMP, JUMP_ANYWHERE, JUMP_TO_SURFACE = 0, 1, 2

#: The guard that ends a mode: its height is sign·guard, positive inside; where it is zero, a transition follows.
GUARD = np.dtype(
    [
        ("sign", np.int64),
        ("to", np.int64),  # mode on the other side of the surface, or to which sliding leaves
        ("jump", np.int64),  # one of the codes above
    ],
    align=True,
)

#: All that a run keeps between calls of `advance`, besides its frame (`abi.Frame`).
RUN = np.dtype(
    [
        ("t", np.float64),  # start of the current step; t_carry is its compensation, what rounding has taken from it
        ("t_carry", np.float64),
        ("t_start", np.float64),  # start and end of the envelope; t_end also ends the run
        ("t_end", np.float64),
        ("tau", np.float64),  # step size, negative where time runs back; infinite where the method chooses its steps
        ("rest", np.float64),  # length left of a step that a crossing has cut; 0 at the end of a step
        ("shift", np.float64),  # c·τᵖ added to every crossing time
        ("height", np.float64),  # height of that guard at the current state, and its rate along the run
        ("rate", np.float64),
        ("entered", np.float64),  # rate with which the mode was entered
        ("own", np.float64),  # rate at the surface into the mode occupied; `other`: into the one on the other side
        ("other", np.float64),
        ("hit", np.float64),  # length from the start of the step to the surface
        ("longest", np.float64),  # longest step so far of a variable-step method
        ("tried", np.float64),  # length of the last trial step
        ("last_hit", np.float64),  # time of the last crossing, or of the start, and its compensation
        ("last_hit_carry", np.float64),
        ("gap", np.float64),  # time between the last two crossings
        ("shrinking", np.int64),  # how many gaps in a row have shrunk
        ("final", np.int64),  # 1: the step ends at t_end
        ("beside_height", np.float64),  # height and rate of the second guard of sliding
        ("beside_rate", np.float64),
        ("mode", np.int64),  # carried, never read from the sign of g after a crossing; NO_MODE before the first step
        ("guard", np.int64),  # number of the guard looked at: 1 while the second guard of sliding is, else 0
        ("sign", np.int64),  # sign of that guard of the mode occupied
        ("first_mode", np.int64),  # in which the run begins; NO_MODE until that is known
        ("leaving", np.int64),  # 1 while g has not yet taken the sign of the mode
        ("follow", np.int64),  # 1: Mannshardt's transition; 0: step over the surface
        ("slides", np.int64),  # 1: where both fields point to the surface, the run slides along it; 0: it stops there
        ("pending", np.int64),  # 1: the mode of sliding is to be entered before the next step
        ("adaptive", np.int64),  # 1: a variable-step method
        ("conservative", np.int64),  # 1: the method holds ψ at its level
        ("monitored", np.int64),  # number of ψ whose level residual is recorded in the envelope
        ("partly_defined", np.int64),  # 1: a field or ψ has a root, real power or logarithm, not defined everywhere
        ("record", np.int64),  # 1: write a row each step
        ("steps", np.int64),
        ("evaluations", np.int64),
        ("crossings", np.int64),
        ("max_crossings", np.int64),
        ("stride", np.int64),  # every stride-th step is sampled
        ("next_sample", np.int64),  # number of the next step to be sampled
        ("samples", np.int64),  # number of samples kept
        ("rows", np.int64),  # number of rows written since the last return
        ("hits", np.int64),  # number of crossings written since the last return
    ],
    align=True,
)

#: A recorded step; its state is kept apart.
ROW = np.dtype([("t", np.float64), ("mode", np.int64), ("segment", np.int64)], align=True)

#: A crossing; its states are kept apart.
HIT = np.dtype(
    [
        ("t", np.float64),
        ("g", np.float64),
        ("rate_before", np.float64),
        ("rate_after", np.float64),
        ("mode", np.int64),  # mode entered; NO_MODE if the run stopped here
        ("kind", np.int64),
    ],
    align=True,
)


@inlined
def mode_of(side):  # type: ignore[no-untyped-def]
    """Number of the mode on a side of the surface."""
    return 1 if side > 0 else 0
