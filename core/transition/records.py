"""The state of a run as the compiled loop keeps it: one record, and the rows it writes."""

import numpy as np

__all__ = ["HIT", "JUMP_ANYWHERE", "JUMP_TO_SURFACE", "NO_JUMP", "ROW", "RUN"]

#: Of a system: the state does not jump; or where the jump leads is read from g there; or it leads to the surface again.
NO_JUMP, JUMP_ANYWHERE, JUMP_TO_SURFACE = 0, 1, 2

#: Everything a run carries from move to move besides its frame (`abi.Frame`).
RUN = np.dtype(
    [
        ("t", np.float64),  # start of the current move, and what its digits could not hold
        ("t_carry", np.float64),
        ("t_start", np.float64),  # of the envelope
        ("t_end", np.float64),
        ("tau", np.float64),  # signed: negative where time runs back; infinite where the method chooses
        ("rest", np.float64),  # of a step that a crossing has cut; 0 at the end of a step
        ("shift", np.float64),  # c·τᵖ added to every crossing time
        ("height", np.float64),  # over the surface, and its rate along the run, at the current state
        ("rate", np.float64),
        ("entered", np.float64),  # rate with which the side was entered
        ("own", np.float64),  # at the surface: rate into the side occupied, and into the other
        ("other", np.float64),
        ("hit", np.float64),  # where in the move the surface is met
        ("longest", np.float64),  # step so far of a method that chooses its steps
        ("probed", np.float64),  # length of the step tried last
        ("met", np.float64),  # when it was met last, and what the digits could not hold
        ("met_carry", np.float64),
        ("gap", np.float64),  # between the last two crossings
        ("shrinking", np.int64),  # how many gaps in a row have shrunk
        ("final", np.int64),  # 1: the step ends at t_end
        ("side", np.int64),  # carried, never read from the sign of g after a crossing; 0 before the first move
        ("first_side", np.int64),
        ("leaving", np.int64),  # 1 while g has not yet taken the sign of the side
        ("follow", np.int64),  # 1: Mannshardt's transition; 0: step over the surface
        ("adaptive", np.int64),  # 1: the method chooses the length of its steps
        ("conservative", np.int64),  # 1: the method holds ψ at its level
        ("watched", np.int64),  # how many ψ have their excess recorded in the envelope
        ("edged", np.int64),  # 1: a field has roots, logarithms or the like, and may have no value beyond the surface
        ("jump", np.int64),  # one of the codes below
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
ROW = np.dtype([("t", np.float64), ("side", np.int64), ("segment", np.int64)], align=True)

#: A crossing, beside its states before and after.
HIT = np.dtype(
    [
        ("t", np.float64),
        ("g", np.float64),
        ("rate_before", np.float64),
        ("rate_after", np.float64),
        ("side", np.int64),
        ("kind", np.int64),
    ],
    align=True,
)
