"""Generate the function that corrects the rounding of a state where it meets a surface."""

from __future__ import annotations

import sympy

from core.codegen.functions import Names, function_text, level_residual_lines
from core.codegen.linear_solve import FEW, least_change, row_lines, size_line
from core.codegen.passing import PassingCode
from core.codegen.printing import assignments, named
from core.kernels import abi
from core.symbolic.derivative import derivative
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode

__all__ = ["project_to_surface_text"]

_EPS = 2.0**-52
#: Roundings of the time that are corrected.
_ROUNDINGS = 16.0
#: Largest projection to the surface, relative to the state: it corrects round-off alone.
_FARTHEST = 1e-12
#: The same where gradients of ψ are nearly dependent, and the state is determined to half the digits only.
_FARTHEST_OF_HALF = 1e-6
#: The same for a method that has drifted off the surface while sliding: its drift is of the size of its error.
_FARTHEST_OF_DRIFT = 1e-2
#: A gradient whose squared sine to the others is below this is left out of the projection, which it would enlarge.
_TANGENT = 2.0**-25


def project_to_surface_text(laws: Laws, mode: Mode, conservative: bool, number: int = 0) -> str:
    """Text of `project_to_surface`: one Newton correction of guard = 0 (and ψ = level), residuals in double-double.

    What is to be kept is corrected first, by the least change a of the state, which takes no time. Then the guard is
    corrected along the flow, by s = guard/rate, which takes the time s and keeps the rest: across the flow, the state
    would drift by the rounding of each time at which it meets a surface that moves. Where the surface and the orbit are
    nearly tangent that is ill-conditioned, and is omitted. A method that is not conservative has drifted off the
    surface while sliding; it is put back on it here, where sliding ends.

    What is corrected is rounding: of the state, of the increment that led here (w.increment), and of the time t. Where
    that leads to a singularity of the field, the function returns `NO_SOLUTION`: the solution does not get there.
    """
    names, d = Names(laws), len(laws.x)
    guard, m = mode.guards[number], len(mode.conserved) if conservative else 0
    drifts = mode.surface is not None and d > 1 and not conservative
    kept = mode.conserved if conservative else (mode.surface,) if drifts and mode.surface is not None else ()
    moves, fields = named("a", d), named("f", d)
    lines = [*names.unpack, *(level_residual_lines(names, mode) if conservative else [])]
    zeros = {"r0": kept[0], "s": guard} if drifts else {"s": guard}
    lines += names.doubled(list(zeros), list(zeros.values()))
    lines += [f"{r} += {r}_low" for r in zeros]
    targets, values = [*map(str, fields), "rate"], names.own([*mode.field, mode.rate_of(guard)])
    lines += assignments(targets, values, names.temporaries)
    lines += [f"speed = max({', '.join(f'abs({f})' for f in fields)}, 0.0)", f"w[{abi.DELAY}] = 0.0"]
    passing, moved = PassingCode(names, mode), named("z", d)
    lines += passing.lines_at_start()
    whole = " + ".join(f"abs({f})" for f in fields)  # NaN if any is: beyond its surface a field may be undefined
    farthest = _FARTHEST_OF_DRIFT if drifts else _FARTHEST
    lines += [f"if not 0.0 < {whole} < math.inf:", "    return 0", size_line(names.x)]
    steps = ", ".join(f"abs(w[{names.frame.increment + k}])" for k in range(d))
    lines.append(f"reach = {farthest} * max(state, {steps}) + {_ROUNDINGS * _EPS} * abs(t) * speed")
    if kept:
        entries, worked_out = row_lines([names.own(derivative(u, v) for v in laws.x) for u in kept], names.temporaries)
        lines += [*worked_out, *least_change(entries, moves, names.temporaries, least=_TANGENT)]
        most = str(farthest)
        if 1 < m < FEW:  # steps that keep dependent ψ are known to half the digits only
            most = f"({_FARTHEST} if independent or near else {_FARTHEST_OF_HALF})"
        near = f"max({', '.join(f'abs({a})' for a in moves)}, 0.0) <= {most} * state"
        known = f"{' + '.join(f'abs({a})' for a in moves)} < math.inf"
        lines += [f"if not ({near} and {known}):", "    return 0"]
        gradient = names.own(derivative(guard, v) for v in laws.x)
        change = sympy.Add(*(slope * a for slope, a in zip(gradient, moves, strict=True)))
        lines += [*assignments(["change"], [change], names.temporaries), "s -= change"]
    lines.append("s = s / rate if rate != 0.0 else math.inf")
    lines += passing.lines_at_surface([f"x{k} + (c{k} - s * {f})" for k, f in enumerate(fields)], moved)
    lines += [
        "if not abs(s) * speed <= reach:",
        "    s = 0.0",
    ]
    lines.append(f"w[{abi.DELAY}] = -s")
    for k, f in enumerate(fields):
        x, c = (f"w[{start + k}]" for start in (names.frame.x, names.frame.carry))
        lines.append(f"{x}, {c} = two_sum(x{k}, c{k} - s * {f}{f' - {moves[k]}' * bool(kept)})")
    return function_text("project_to_surface", [*lines, "return 0"])
