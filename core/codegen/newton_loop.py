"""The text of Newton's loop: when it has converged, and how a solution is continued from the start of a step."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Symbol

from core.codegen.linear_solve import LEVEL_TOLERANCE, WRITTEN_OUT
from core.kernels import abi

__all__ = ["continuation", "verdict"]

#: Largest number of corrections of Newton's method.
_MAX_CORRECTIONS = 30
#: A correction that no longer shrinks is round-off, and accepted, below this part of the state.
_STAGNATION = 16 * 2.0**-52
#: Convergence is quadratic if a correction is below this part of the increment …
_CLOSE = 0.1
#: … and the next one below this part of the correction.
_CLOSING = 1e-2
#: The solution is the one connected to h = 0 if the second correction is below this part of the first: Kantorovich's
#: theorem requires a quarter.
_CONTRACTION = 0.1
#: A first correction below this part of the increment needs no such proof.
_NEARBY = 1e-3
#: The equations are linear if the second correction is below this part of the first.
_LINEAR = 1e-6
#: A step is divided if the first correction exceeds this part of the increment.
_FAR = 0.05
#: Largest factor by which the determinant of the equations, 1 at h = 0, may change in one part of a step.
_NEAR = 0.6
#: Largest number of parts of a step in which a solution is followed from h = 0.
_MOST_PARTS = 1024


def verdict(n: int, d: int, on_branch: str) -> list[str]:
    """Lines that end Newton's loop, and set `solved` to whether it has converged to the solution connected to h = 0.

    The next correction is predicted as K·size², with K = size/last² from the last two corrections, and with
    K = last/whole² from the two before, since one of these may be small by chance.
    """
    # If the first correction is large, or the determinant changes much, the part is too long, unless linear.
    changed = f" or not {_NEAR} * before < scale < before / {_NEAR}" if on_branch != "True" else ""
    far = [f"if second and size > {_LINEAR} * last and (last > {_FAR} * whole{changed}):", "    break"]
    kept = ""
    check = []
    if n - d > 1:  # a ψ whose multiplier is omitted must be kept all the same
        largest = f"max({', '.join(f's{k}' for k in range(d, n))})" if n <= WRITTEN_OUT else "largest"
        check.append(f"kept = independent or residual <= {LEVEL_TOLERANCE} * {largest} * max(whole, state)")
        kept = "kept and "
    return [
        f"size = max({', '.join(f'abs(r{k})' for k in range(d))}, 0.0)",
        f"whole = max({', '.join(f'abs(d{k})' for k in range(d))}, 0.0)",
        "corrections += 1",
        "if not size < math.inf:",
        "    break",
        f"second = corrections == 2 and last > {_STAGNATION} * max(whole, state)",
        f"if second and size > {_CONTRACTION} * last and last > {_NEARBY} * whole:",
        "    break",
        *far,
        *check,
        f"fast = last <= {_CLOSE} * whole and size <= {_CLOSING} * last",
        "fast = fast and size * size * size < 1e-17 * whole * last * last",
        "fast = fast and size * size * last < 1e-16 * whole * whole * whole",
        f"if {kept}(size == 0.0 or fast):",
        f"    solved = {on_branch}",
        "    break",
        f"exhausted = corrections >= {_MAX_CORRECTIONS}",
        f"if {kept}(size >= last or exhausted) and size <= {_STAGNATION} * max(whole, state):",
        f"    solved = {on_branch}",
        "    break",
        "if exhausted:",
        "    break",
        "last = size",
    ]


def continuation(unknowns: Sequence[Symbol], start: Sequence[str]) -> list[str]:
    """Lines that go on to the next part of the step, or start again with more parts, and end the loop over parts.

    Of several solutions the method's is the one connected to h = 0. Newton's method finds it if Euler's step is close,
    if it converges at once from there (Kantorovich: the second correction is well below the first), and if the
    determinant of the equations is near 1, as at h = 0. Otherwise the solution is continued from a part of the step to
    a larger one, starting from the solution scaled in proportion, in parts so short that these conditions hold.
    """
    further = [f"{u} *= part / (part - 1.0)" for u in unknowns]
    return [
        "if solved:",
        "    if part == parts:",
        "        break",
        "    part, before = part + 1, scale",
        "    h = full * (part / parts)",
        "    t1 = t + h",
        *(f"    {line}" for line in further),
        "else:",
        f"    if parts == {_MOST_PARTS}:",
        f"        return {abi.NO_SOLUTION}",
        "    part, parts, before = 1, 4 * parts, 1.0",
        "    h = full / parts",
        "    t1 = t + h",
        *(f"    {line}" for line in start),
    ]
