"""The state of a run as the compiled loop keeps it: one record, and the rows it writes."""

import numpy as np

__all__ = ["HIT", "ROW", "RUN"]

#: Everything a run carries from step to step besides the state and its carry.
RUN = np.dtype(
    [
        ("t", np.float64),  # start of the current step, and what its digits could not hold
        ("t_carry", np.float64),
        ("t_end", np.float64),
        ("tau", np.float64),  # signed: negative where time runs back
        ("shift", np.float64),  # c·τᵖ added to every crossing time
        ("rate", np.float64),  # of g, counted away from the surface and along the run, at the current state
        ("own", np.float64),  # at the surface: rate into the side occupied, and into the other
        ("other", np.float64),
        ("hit", np.float64),  # where in the step the surface is met
        ("side", np.int64),  # carried, never read from the sign of g after a crossing
        ("leaving", np.int64),  # 1 while g has not yet taken the sign of the side
        ("follow", np.int64),  # 1: Mannshardt's transition; 0: step over the surface
        ("has_jump", np.int64),
        ("record", np.int64),  # 1: write a row each step
        ("steps", np.int64),
        ("evaluations", np.int64),
        ("crossings", np.int64),
        ("max_crossings", np.int64),
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
