"""The state of a run as the compiled loop keeps it: one record, its guards, and the rows it writes."""

import numpy as np

from core.kernels.jit import inlined

__all__ = ["GUARD", "HIT", "JUMP_ANYWHERE", "JUMP_TO_SURFACE", "NO_JUMP", "NO_MODE", "ROW", "RUN", "SIGNS", "mode_of"]

#: Sign of g in each mode. A mode is numbered by the signs of its surfaces: here 1 where g > 0, else 0.
SIGNS = np.array([-1, 1])
#: Mode of a run that has entered none yet.
NO_MODE = -1

#: Of a guard: the state does not jump; or where the jump leads is read from g there; or it leads to the surface again.
NO_JUMP, JUMP_ANYWHERE, JUMP_TO_SURFACE = 0, 1, 2

#: What ends a mode, one for each: its height is sign·g, positive inside; a transition leads on from where it is zero.
GUARD = np.dtype(
    [
        ("sign", np.int64),
        ("to", np.int64),  # mode behind the surface
        ("jump", np.int64),  # one of the codes above
    ],
    align=True,
)

#: Everything a run carries from one call of `advance` to the next besides its frame (`abi.Frame`).
RUN = np.dtype(
    [
        ("t", np.float64),  # start of the current step, and what its digits could not hold
        ("t_carry", np.float64),
        ("t_start", np.float64),  # of the envelope
        ("t_end", np.float64),
        ("tau", np.float64),  # signed: negative where time runs back; infinite where the method chooses
        ("rest", np.float64),  # of a step that a crossing has cut; 0 at the end of a step
        ("shift", np.float64),  # c·τᵖ added to every crossing time
        ("height", np.float64),  # over the surface, and its rate along the run, at the current state
        ("rate", np.float64),
        ("entered", np.float64),  # rate with which the mode was entered
        ("own", np.float64),  # at the surface: rate into the mode occupied, and into the one behind
        ("other", np.float64),
        ("hit", np.float64),  # where in the step the surface is met
        ("longest", np.float64),  # step so far of a method that chooses its steps
        ("tried", np.float64),  # length of the step tried last
        ("met", np.float64),  # when it was met last, and what the digits could not hold
        ("met_carry", np.float64),
        ("gap", np.float64),  # between the last two crossings
        ("shrinking", np.int64),  # how many gaps in a row have shrunk
        ("final", np.int64),  # 1: the step ends at t_end
        ("mode", np.int64),  # carried, never read from the sign of g after a crossing; NO_MODE before the first step
        ("sign", np.int64),  # of its guard
        ("first_mode", np.int64),  # in which the run begins; NO_MODE until that is known
        ("leaving", np.int64),  # 1 while g has not yet taken the sign of the mode
        ("follow", np.int64),  # 1: Mannshardt's transition; 0: step over the surface
        ("adaptive", np.int64),  # 1: the method chooses the length of its steps
        ("conservative", np.int64),  # 1: the method holds ψ at its level
        ("watched", np.int64),  # how many ψ have their level residual recorded in the envelope
        ("edged", np.int64),  # 1: a field has roots, logarithms or the like, and may have no value beyond the surface
        ("record", np.int64),  # 1: write a row each step
        ("steps", np.int64),
        ("evaluations", np.int64),
        ("crossings", np.int64),
        ("max_crossings", np.int64),
        ("stride", np.int64),  # of the steps without a crossing, one of so many has its start kept
        ("next_sample", np.int64),
        ("samples", np.int64),  # kept so far
        ("rows", np.int64),  # written since the last return
        ("hits", np.int64),
    ],
    align=True,
)

#: A recorded step, beside its state.
ROW = np.dtype([("t", np.float64), ("mode", np.int64), ("segment", np.int64)], align=True)

#: A crossing, beside its states before and after.
HIT = np.dtype(
    [
        ("t", np.float64),
        ("g", np.float64),
        ("rate_before", np.float64),
        ("rate_after", np.float64),
        ("passed", np.int64),  # 1: the run went on from here
        ("mode", np.int64),  # in which it did
        ("kind", np.int64),
    ],
    align=True,
)


@inlined
def mode_of(side):  # type: ignore[no-untyped-def]
    """Number of the mode on a side of the surface."""
    return 1 if side > 0 else 0
