"""Structured arrays of the compiled loop: the record of a run, its guards, and the rows it writes."""

import numpy as np

__all__ = [
    "ANY_SURFACE",
    "EVENT",
    "GUARD",
    "HIT",
    "JUMP_ANYWHERE",
    "JUMP_TO_SURFACE",
    "NO_JUMP",
    "NO_MODE",
    "ROW",
    "RUN",
]

#: Mode of a run that has not entered any yet, or that has stopped at a surface; row where there is no mode.
NO_MODE = -1

#: In place of the number of a surface: any of them.
ANY_SURFACE = -2

#: Jump of a guard: none; to a state whose mode is given by the sign of g there; or to a state on the surface.
NO_JUMP, JUMP_ANYWHERE, JUMP_TO_SURFACE = 0, 1, 2

#: A guard that ends a mode: its height is sign·guard, positive inside; where it is zero, a transition follows. The
#: table has one row for each guard of each mode; a mode is entered by the row of its first guard.
GUARD = np.dtype(
    [
        ("mode", np.int64),  # mode that it ends
        ("count", np.int64),  # number of guards of that mode
        ("sign", np.int64),
        ("to", np.int64),  # row of the mode that follows; NO_MODE where none is declared
        ("back", np.int64),  # guard of that mode that leads back; NO_MODE where the way is one-way
        ("slide", np.int64),  # row of the mode of sliding between both; NO_MODE where there is none
        ("turns", np.int64),  # 1: the sign turns with the direction of time, as of the rates that end sliding
        ("slides", np.int64),  # 1: the mode slides
        ("jump", np.int64),  # one of the codes above
        ("surface", np.int64),  # number of the surface; NO_MODE for a rate
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
        ("height", np.float64),  # height of the guard looked at, at the current state, and its rate along the run
        ("rate", np.float64),
        ("entered", np.float64),  # rate with which the mode was entered there
        ("own", np.float64),  # rate at the surface into the mode occupied; `other`: into the one on the other side
        ("other", np.float64),
        ("hit", np.float64),  # length from the start of the step to the surface
        ("longest", np.float64),  # longest step so far of a variable-step method
        ("tried", np.float64),  # length of the last trial step
        ("last_hit", np.float64),  # time of the last crossing, or of the start, and its compensation
        ("last_hit_carry", np.float64),
        ("cluster", np.float64),  # time of the first of the last crossings that rounding of the time does not separate
        ("cluster_carry", np.float64),
        ("cluster_half", np.float64),  # what the first half of them has taken
        ("clustered", np.int64),  # their number
        ("final", np.int64),  # 1: the step ends at t_end
        ("mode", np.int64),  # carried, never read from the sign of g after a crossing; NO_MODE before the first step
        ("row", np.int64),  # row of its first guard
        ("guards", np.int64),  # number of its guards
        ("sliding", np.int64),  # 1 while the mode slides
        ("guard", np.int64),  # number of the guard looked at, 0 between steps; of the others the frame keeps the same
        ("sign", np.int64),  # sign of that guard of the mode occupied
        ("leaving", np.int64),  # 1 while that guard has not yet taken its sign, since the mode was entered there
        ("first_mode", np.int64),  # in which the run begins; NO_MODE until that is known
        ("follow", np.int64),  # 1: Mannshardt's transition; 0: step over the surface
        ("slides", np.int64),  # 1: where both fields point to the surface, the run slides along it; 0: it stops there
        ("pending", np.int64),  # 1: the mode is to be entered, as soon as it is compiled, before the next step
        ("at", np.int64),  # bits of the guards at whose zeros it is entered
        ("near", np.int64),  # likewise, of those whose signs say nothing after a jump
        ("asked", np.int64),  # number + 1 of a guard at whose zero `Runner` is asked where the field leads, or 0
        ("inward", np.int64),  # its answers, as bits: the field leads into the mode, or out of it, or into it as at a
        ("outward", np.int64),  # fold, where the rate is zero
        ("folded", np.int64),
        ("jumped", np.int64),  # 1: it is entered by a jump, so that it depends on the signs of all guards
        ("past", np.int64),  # number + 1 of a guard beyond whose zero it is entered, which ends it at once; or 0
        ("corner", np.int64),  # bits of the guards that vanish where the run has met several surfaces at once
        ("retracted", np.int64),  # 1: the last crossing written by an earlier call of the loop is none: it was a touch
        ("chain", np.int64),  # number of modes in a row that ended where they were entered
        ("adaptive", np.int64),  # 1: a variable-step method
        ("conservative", np.int64),  # 1: the method holds ψ at its level
        ("monitored", np.int64),  # number of ψ whose level residual is recorded in the envelope
        ("partly_defined", np.int64),  # 1: a field or ψ has a root, real power or logarithm, not defined everywhere
        ("record", np.int64),  # 1: write a row each step
        ("steps", np.int64),
        ("evaluations", np.int64),
        ("crossings", np.int64),
        ("max_crossings", np.int64),
        ("wanted_surface", np.int64),  # number of the surface of which no more than max_wanted crossings are wanted, …
        ("wanted_way", np.int64),  # … and the sign that the rate of its function has there: see `is_wanted`
        ("wanted", np.int64),  # number of such crossings so far
        ("max_wanted", np.int64),
        ("stride", np.int64),  # every stride-th step is sampled
        ("next_sample", np.int64),  # number of the next step to be sampled
        ("samples", np.int64),  # number of samples kept
        ("looks", np.int64),  # number of looks (see `unlike`) in the same segment …
        ("look_segment", np.int64),  # … which began at this crossing
        ("changes", np.int64),  # number of changes of rates seen so far, and how often their parts were doubled
        ("doublings", np.int64),
        ("unlike", np.float64),  # largest change of a rate seen, relative to the largest such rate
        ("passes", np.int64),  # bits of the rows of the table of passes that hold one (see `passes`)
        ("rows", np.int64),  # number of rows written since the last return
        ("hits", np.int64),  # number of crossings written since the last return
        ("taken", np.float64),  # length by which `advance` has moved the state
        ("events", np.int64),  # number of event functions
        ("locating", np.int64),  # 0 in the run itself; in the record by which events are located in a step that has
        # been taken: 1, or 2 once a variable-step method has prepared that step again
        ("watching", np.int64),  # 1: the event functions are known at the state; else it has come there by a jump, or
        # begins there (0), or has entered another mode there (2)
        ("found", np.int64),  # number of events written since the last return
        ("passed", np.int64),  # number of events
        ("max_events", np.int64),
        ("crowded", np.int64),  # 1: one step has more events than can be written
    ],
    align=True,
)

#: A recorded step; its state is kept apart.
ROW = np.dtype([("t", np.float64), ("mode", np.int64), ("segment", np.int64)], align=True)

#: A crossing or an event; its states are kept apart.
HIT = np.dtype(
    [
        ("t", np.float64),
        ("g", np.float64),
        ("rate_before", np.float64),
        ("rate_after", np.float64),
        ("mode", np.int64),  # mode entered; NO_MODE if the run stopped here
        ("kind", np.int64),
        ("surface", np.int64),  # number of the surface met, NO_MODE where sliding ends by itself; or of the event
        ("length", np.float64),  # length of the step that leads there
    ],
    align=True,
)

#: An event function h: what is asked of it, and what is known of it at the current state and at the end of a step.
EVENT = np.dtype(
    [
        ("way", np.int64),  # 1: where h increases with time, −1: where it decreases, 0: both
        ("ends", np.int64),  # 1: the run ends there
        ("side", np.int64),  # sign of h since its last zero; 0 where h is zero and has not taken a sign yet
        ("vanishes", np.int64),  # 1: it was zero along a whole step
        ("undefined", np.int64),  # 1: it had no finite value somewhere
        ("value", np.float64),  # h at the current state, its rate along the run, and a bound on the rounding of h
        ("rate", np.float64),
        ("noise", np.float64),
        ("end_value", np.float64),  # the same at the end of the step
        ("end_rate", np.float64),
        ("end_noise", np.float64),
        ("zero", np.float64),  # length up to the last zero in the piece; nan if there is none
        ("steepness", np.float64),  # size of the rate there, and a bound on the rounding of h
        ("doubt", np.float64),
        ("mark", np.int64),  # number of events written before
    ],
    align=True,
)
