"""The fixed signatures through which compiled functions meet. One compiled loop serves every system and method.

step(t, h, x, carry, p, dx) -> int
    One step of length h from x + carry: writes the *increment* to dx and returns how often the field was evaluated,
    or `NO_SOLUTION`. Any h will do, of either sign: crossings are located on the scheme itself.
switching(t, x, p) -> float
    g.
rate(side, t, x, p) -> float
    ġ = g_t + ∇g·f with the field of a side.
jump(t, x, p, after) -> None
    The state after reaching the surface.

t is time, x the state (d,), carry the part of it that its digits could not hold (d,), p the parameters.
"""

from numba import types
from numba.core.types import FunctionType, float64, int64, void

__all__ = ["JUMP", "NO_SOLUTION", "RATE", "STEP", "SWITCHING", "FunctionType", "vector"]

vector = types.Array(float64, 1, "C")

STEP = int64(float64, float64, vector, vector, vector, vector)
SWITCHING = float64(float64, vector, vector)
RATE = float64(int64, float64, vector, vector)
JUMP = void(float64, vector, vector, vector)

#: What a step returns when its equations have no solution that Newton's method can find.
NO_SOLUTION = -1
