"""The signature that all compiled functions have, and the layout of the frame they share.

    function(t, h, p, w, scratch) -> int

is a C function. The loop calls it by its address, so that one compiled loop serves every system and method. p holds
the parameters, w is the frame of a run (`Frame`), and scratch is memory that a variable-step method keeps between
calls. The addresses are in a table with one row for each guard of each mode. Functions of the mode are in the row of
its first guard; `project_to_surface`, `evaluate_switching` and `jump` are those of the row's guard. One row for each
event function in each mode follows, mode after mode, with `prepare_step` and `step` of the mode, and with the event
function in the place of the guard. The columns are `FUNCTIONS`:

prepare_step
    Prepare a step from x. A variable-step method expands the solution in a Taylor series, kept in scratch. It writes
    the unit of time of the coefficients to w[UNIT], its inverse to w[PER_UNIT], the step length to w[LENGTH], and the
    level residual. The residual is zero where w[LEVELS_SET] is 1, because the levels have just been set at this state;
    the function resets w[LEVELS_SET] to 0.
step
    Take one step of length h from x + carry: write its increment to w, and the mode's guards and their rates at the end
    to w[G_END + 2·k], w[RATE_END + 2·k] for guard k.
    h may have any length and either sign, because crossings are located on the scheme itself. Return the number of
    evaluations of the field, or `NO_SOLUTION`: also of a step across a singularity of the field, of which it writes the
    number, from 1, to w[SINGULARITY], and its own start and length to w[SINGULAR_FROM] and w[SINGULAR_LENGTH].
set_levels
    Set the levels to ψ at x + carry, in double-double; set w[LEVELS_SET].
level_residual
    Evaluate ψ at x + carry, less its level.
project_to_surface
    Project x + carry to guard = 0 (and to the levels of ψ, if the method keeps them), in double-double. Write to
    w[DELAY] how much later than x + carry the solution reaches the projected state.
evaluate_switching
    Evaluate the guard at `place` and its rate: of a surface between two regions, both rates ġ = g_t + ∇g·f with their
    fields; of any other guard, twice its rate along the field of the mode. Bound the change of the guard by rounding
    the state alone (w[ROUNDING_OF_STATE]), and by all rounding in its evaluation (w[ROUNDING_OF_G]).
jump
    Write the state after the jump from x to `place`.
event_series
    Expand an event function along Taylor polynomials of the state, the first d rows of scratch, in powers of
    time/w[UNIT] from time t on; the next row takes its coefficients.
"""

# mypy: disable-error-code="no-untyped-call"
# numba's and llvmlite's constructors have no types

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

__all__ = [
    "CALL",
    "DELAY",
    "ENTERED",
    "EVALUATE",
    "FUNCTIONS",
    "GAP",
    "GUARDS",
    "G_END",
    "HEIGHT",
    "JUMP",
    "KEPT",
    "LAST",
    "LAST_CARRY",
    "LEAVING",
    "LENGTH",
    "LEVELS_SET",
    "LEVEL_RESIDUAL",
    "MAX_GUARDS",
    "MAX_VISITS",
    "NO_SOLUTION",
    "ORDER",
    "PER_UNIT",
    "PREPARE",
    "PROJECT",
    "RATE",
    "RATES",
    "RATE_END",
    "ROUNDING_OF_G",
    "ROUNDING_OF_STATE",
    "SERIES",
    "SET_LEVELS",
    "SHRINKING",
    "SIGN",
    "SINGULARITY",
    "SINGULAR_FROM",
    "SINGULAR_LENGTH",
    "STEP",
    "TOLERANCE",
    "UNIT",
    "VECTORS",
    "VISIT",
    "VISITS",
    "Frame",
    "G",
    "call",
]

_POINTER = types.CPointer(types.float64)
CALL = types.int64(types.float64, types.float64, _POINTER, _POINTER, _POINTER)

#: Returned by a step whose equations could not be solved.
NO_SOLUTION = -1

#: The functions of a mode, in the order of the columns of the table of addresses.
FUNCTIONS = (
    "prepare_step",
    "step",
    "set_levels",
    "level_residual",
    "project_to_surface",
    "evaluate_switching",
    "jump",
    "event_series",
)
PREPARE, STEP, SET_LEVELS, LEVEL_RESIDUAL, PROJECT, EVALUATE, JUMP, SERIES = range(len(FUNCTIONS))

#: Largest number of guards of a mode: six surfaces, or, of sliding, two rates and five more surfaces.
MAX_GUARDS = 7

# Scalars at the head of a frame.
G_END = 0  #: first guard at the end of the last trial step; that of guard k follows at a distance of 2·k
RATE_END = 1  #: its rate at the end of the last trial step, with the field of the mode; likewise
G = 2 * MAX_GUARDS  #: guard where switching was evaluated last
RATES = G + 1  #: its rates there: of g, w[RATES] with the field of g < 0, w[RATES + 1] with that of g > 0
ROUNDING_OF_STATE = G + 3  #: bound on the change of g by rounding the state alone, likewise
LENGTH = G + 4  #: length of the step that a variable-step method takes
UNIT = G + 5  #: unit of time of the Taylor coefficients
ORDER = G + 6  #: order of the Taylor polynomial
TOLERANCE = G + 7  #: tolerance of a variable-step method
DELAY = G + 8  #: time from the end of the step to the state projected to the surface
LEVELS_SET = G + 9  #: 1 where the levels of ψ have just been set at the state
PER_UNIT = G + 10  #: 1 / UNIT
ROUNDING_OF_G = G + 11  #: bound on the change of g by rounding its arguments and all operations, likewise
GUARDS = G + 12  #: what the loop keeps of each guard but the one looked at, in parts of `KEPT` numbers:
HEIGHT, RATE, ENTERED, LEAVING, SIGN = range(5)  #: as in `records.RUN`
KEPT = 5  #: how many these are
VISITS = GUARDS + KEPT * MAX_GUARDS  #: of the last crossing of each surface, modulo `MAX_VISITS`, in parts of `VISIT`:
LAST, LAST_CARRY, GAP, SHRINKING = range(4)  #: its time, that since the one before, how many of those shrank in a row
VISIT = 4  #: how many these are
MAX_VISITS = 8  #: how many surfaces are told apart
SINGULARITY = VISITS + VISIT * MAX_VISITS  #: number of the singularity that the last step without solution met; or 0
SINGULAR_FROM = SINGULARITY + 1  #: time at the start of that step
SINGULAR_LENGTH = SINGULARITY + 2  #: its length
_HEAD = SINGULARITY + 3  #: number of scalars
VECTORS = 5  #: number of vectors of d numbers that follow them


class Frame(NamedTuple):
    """Layout of a frame: scalars, then vectors of d numbers, then vectors of m numbers."""

    d: int
    m: int

    @property
    def x(self) -> int:
        """State."""
        return _HEAD

    @property
    def carry(self) -> int:
        """Compensation of the state: what rounding has taken from x."""
        return _HEAD + self.d

    @property
    def increment(self) -> int:
        """Increment of the last trial step."""
        return _HEAD + 2 * self.d

    @property
    def place(self) -> int:
        """A state at which switching is evaluated."""
        return _HEAD + 3 * self.d

    @property
    def extent(self) -> int:
        """Size of each coordinate, and of its motion in a step of a variable-step method; positive."""
        return _HEAD + (VECTORS - 1) * self.d

    @property
    def level(self) -> int:
        """Levels, the values of ψ where the mode was entered: their high parts, then their low parts."""
        return _HEAD + VECTORS * self.d

    @property
    def level_residual(self) -> int:
        """ψ less its levels."""
        return self.level + 2 * self.m

    def empty(self) -> NDArray[np.float64]:
        """A frame of zeros."""
        return np.zeros(self.level_residual + self.m)


def _call(_context: Any, address: Any, t: Any, h: Any, p: Any, w: Any, scratch: Any) -> Any:
    """Call the function at an address with plain pointers: passing array structures costs more than a short step."""
    signature = types.int64(address, t, h, p, w, scratch)

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        arrays = zip(signature.args[3:], arguments[3:], strict=True)
        pointers = [context.make_array(kind)(context, builder, value).data for kind, value in arrays]
        number, whole = ir.DoubleType(), ir.IntType(64)
        function = ir.FunctionType(whole, [number, number, *(pointer.type for pointer in pointers)])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [*arguments[1:3], *pointers])

    return signature, build


call: Any = intrinsic(_call)
