"""The one signature through which compiled functions meet, and the frame they share.

    function(t, h, p, w, scratch) -> int

is a C function: the loop knows it by its address, so that one compiled loop serves every system and method. p are the
parameters, w is the frame of a run (`Frame`), and scratch is room that a variable-step method keeps between calls. A
table holds the addresses, a row for each mode; its columns are `FUNCTIONS`:

prepare_step
    Prepare a step from x. A variable-step method expands the solution in scratch, in a unit of time that it writes to
    w[UNIT], the inverse of which to w[PER_UNIT]; it writes the step length to w[LENGTH], and ψ less its level. That is
    zero where w[LEVELS_SET] is 1, for the levels have just been set at this very state; the function resets it to 0.
step
    One step of length h from x + carry: write the *increment* to w, and g and ġ at its end to w[G_END], w[RATE_END].
    Any h will do, of either sign: crossings are located on the scheme itself. Return how often the field was
    evaluated, or `NO_SOLUTION`.
set_levels
    Take ψ at x + carry for its levels, in double-double; set w[LEVELS_SET].
level_residual
    ψ at x + carry, less its level.
project_to_surface
    Project x + carry to g = 0 (and to the levels of ψ, if the method keeps them), in double-double; w[DELAY] is how
    much later that is reached.
evaluate_switching
    g at `place`, and its rate ġ = g_t + ∇g·f with the fields on both sides; what rounding x alone can do to g
    (w[SLACK]), and what rounding can do to it at most (w[DOUBT]).
jump
    The state after reaching the surface, from x to place.
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
    "DOUBT",
    "EVALUATE",
    "FUNCTIONS",
    "G_END",
    "JUMP",
    "LENGTH",
    "LEVELS_SET",
    "LEVEL_RESIDUAL",
    "NO_SOLUTION",
    "ORDER",
    "PER_UNIT",
    "PREPARE",
    "PROJECT",
    "RATES",
    "RATE_END",
    "SET_LEVELS",
    "SLACK",
    "STEP",
    "TOLERANCE",
    "UNIT",
    "Frame",
    "G",
    "call",
]

_POINTER = types.CPointer(types.float64)
CALL = types.int64(types.float64, types.float64, _POINTER, _POINTER, _POINTER)

#: What a step returns when its equations have no solution that can be found.
NO_SOLUTION = -1

#: The functions of a mode, in the order of their addresses.
FUNCTIONS = (
    "prepare_step",
    "step",
    "set_levels",
    "level_residual",
    "project_to_surface",
    "evaluate_switching",
    "jump",
)
PREPARE, STEP, SET_LEVELS, LEVEL_RESIDUAL, PROJECT, EVALUATE, JUMP = range(len(FUNCTIONS))

# Scalars at the head of a frame.
G_END = 0  #: g at the end of the step tried last
RATE_END = 1  #: ġ there, with the field of the mode
G = 2  #: g at the place where switching was evaluated last
RATES = 3  #: ġ there, with the field where g < 0; in the next place, with the field where g > 0
SLACK = 5  #: how far rounding of the state alone can move g there
LENGTH = 6  #: of the step that a variable-step method takes
UNIT = 7  #: of time, of the Taylor coefficients
ORDER = 8  #: of the Taylor polynomial
TOLERANCE = 9  #: of a variable-step method
DELAY = 10  #: how much later the surface is reached than where the step has ended
LEVELS_SET = 11  #: 1 where the levels of ψ have just been set at the state
PER_UNIT = 12  #: 1 / UNIT
DOUBT = 13  #: how far rounding of everything that g is worked out from, and on the way, can move it
_HEAD = 14


class Frame(NamedTuple):
    """Where the parts of a frame are: scalars, then vectors of d, then of m numbers."""

    d: int
    m: int

    @property
    def x(self) -> int:
        """State."""
        return _HEAD

    @property
    def carry(self) -> int:
        """The part of the state that its digits could not hold."""
        return _HEAD + self.d

    @property
    def increment(self) -> int:
        """Increment of the step tried last."""
        return _HEAD + 2 * self.d

    @property
    def place(self) -> int:
        """A state at which switching is evaluated."""
        return _HEAD + 3 * self.d

    @property
    def level(self) -> int:
        """Levels of ψ where the mode was entered: their high parts, then their low parts."""
        return _HEAD + 4 * self.d

    @property
    def level_residual(self) -> int:
        """ψ less its levels."""
        return self.level + 2 * self.m

    def empty(self) -> NDArray[np.float64]:
        """A frame of zeros."""
        return np.zeros(self.level_residual + self.m)


def _call(_context: Any, address: Any, t: Any, h: Any, p: Any, w: Any, scratch: Any) -> Any:
    """Call the function at an address: four registers, where passing arrays costs more than a short step."""
    signature = types.int64(address, t, h, p, w, scratch)

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        arrays = zip(signature.args[3:], arguments[3:], strict=True)
        pointers = [context.make_array(kind)(context, builder, value).data for kind, value in arrays]
        number, whole = ir.DoubleType(), ir.IntType(64)
        function = ir.FunctionType(whole, [number, number, *(pointer.type for pointer in pointers)])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [*arguments[1:3], *pointers])

    return signature, build


call: Any = intrinsic(_call)
