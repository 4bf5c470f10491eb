"""The one signature through which compiled functions meet, and the frame they share.

    function(t, h, p, w, memo) -> int

is a C function: the loop knows it by its address, so that one compiled loop serves every system and method. p are the
parameters, w is the frame of a run (`Frame`), memo is scratch that a variable-step method keeps between calls. The
functions of a system and method, in the order of `FUNCTIONS`:

reach (one a side)
    Prepares a step from x: variable-step methods expand the solution in memo, in a unit of time that they write to
    w[UNIT], its inverse to w[PER_UNIT], and write the step length to w[LENGTH], and what ψ is above its level.
    w[SETTLED] is 1 where that is nothing, for the levels have just been settled at this very state; it is reset.
step (one a side)
    One step of length h from x + carry: writes the *increment* to w, and g and ġ at its end to w[G_END], w[RATE_END].
    Any h will do, of either sign: crossings are located on the scheme itself. Returns how often the field was
    evaluated, or `NO_SOLUTION`.
settle (one a side)
    The levels of ψ at x + carry, in double-double; sets w[SETTLED].
excess (one a side)
    ψ at x + carry, less its level.
polish (one a side)
    Moves x + carry onto g = 0 (and the levels of ψ, if the method keeps them), in double-double; w[DELAY] is how much
    later that is reached.
look
    g, and ġ = g_t + ∇g·f with the field of either side, at `place`; what rounding x alone can do to g (w[SLACK]), and
    what rounding can do to it at most (w[DOUBT]).
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
    "EXCESS",
    "FUNCTIONS",
    "G_END",
    "JUMP",
    "LENGTH",
    "LOOK",
    "NO_SOLUTION",
    "ORDER",
    "PER_UNIT",
    "POLISH",
    "RATES",
    "RATE_END",
    "REACH",
    "SETTLE",
    "SETTLED",
    "SLACK",
    "STEP",
    "TOLERANCE",
    "UNIT",
    "Frame",
    "G",
    "call",
]  # fmt: skip

_POINTER = types.CPointer(types.float64)
CALL = types.int64(types.float64, types.float64, _POINTER, _POINTER, _POINTER)

#: What a step returns when its equations have no solution that can be found.
NO_SOLUTION = -1

#: The functions of a run, in the order of their addresses; those of the plus side follow those of the minus side.
FUNCTIONS = (
    "reach",
    "reach",
    "step",
    "step",
    "settle",
    "settle",
    "excess",
    "excess",
    "polish",
    "polish",
    "look",
    "jump",
)
REACH, STEP, SETTLE, EXCESS, POLISH, LOOK, JUMP = (FUNCTIONS.index(f) for f in dict.fromkeys(FUNCTIONS))

#: Scalars at the head of a frame. RATES: ġ with the field of the minus side, then of the plus side.
G_END, RATE_END, G, RATES, SLACK, LENGTH, UNIT, ORDER, TOLERANCE, DELAY, SETTLED = 0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11
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
        """A state to look at."""
        return _HEAD + 3 * self.d

    @property
    def level(self) -> int:
        """Levels of ψ where the side occupied was entered: their high parts, then their low parts."""
        return _HEAD + 4 * self.d

    @property
    def excess(self) -> int:
        """ψ less its levels."""
        return self.level + 2 * self.m

    def empty(self) -> NDArray[np.float64]:
        """A frame of zeros."""
        return np.zeros(self.excess + self.m)


def _call(_context: Any, address: Any, t: Any, h: Any, p: Any, w: Any, memo: Any) -> Any:
    """Call the function at an address: four registers, where passing arrays costs more than a short step."""
    signature = types.int64(address, t, h, p, w, memo)

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        arrays = zip(signature.args[3:], arguments[3:], strict=True)
        pointers = [context.make_array(kind)(context, builder, value).data for kind, value in arrays]
        number, whole = ir.DoubleType(), ir.IntType(64)
        function = ir.FunctionType(whole, [number, number, *(pointer.type for pointer in pointers)])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [*arguments[1:3], *pointers])

    return signature, build


call: Any = intrinsic(_call)
