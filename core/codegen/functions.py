"""Generate the text of the compiled functions, which all have one signature and work on a frame (`abi`)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, cached_property

import sympy
from sympy import Expr, Symbol

from core.codegen import linear_solve_loops
from core.codegen.beside import lines_beside
from core.codegen.printing import assignments, doubled_assignments, magnitude, named
from core.codegen.rounding import rounding_bound
from core.kernels import abi, divided_differences, stack_array, taylor_coefficients
from core.kernels.doubledouble import arithmetic, error_free
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode

__all__ = [
    "Names", "evaluate_switching_text", "function_text", "jump_text", "level_residual_lines", "levels_texts",
    "module_text",
]  # fmt: skip

_EPS = 2.0**-52
#: A value of g is round-off below this many times the first-order bound on its rounding, as in `transition.surface`.
_ROUNDINGS = 16.0


@cache
def _homes() -> dict[str, str]:
    """Module of each jitted function and table that generated text uses."""
    from core.kernels.doubledouble import elementary  # makes tables of numbers, which `import core` need not await

    modules = (
        abi, arithmetic, divided_differences, elementary, error_free, linear_solve_loops, stack_array,
        taylor_coefficients,
    )  # fmt: skip
    return {name: module.__name__ for module in modules for name in getattr(module, "__all__", ())}


def function_text(name: str, lines: Sequence[str]) -> str:
    """Text of one compiled function, whose machine code is kept on disk."""
    body = "\n".join(f"    {line}" for line in lines)
    return f"@native\ndef {name}(t, h, p, w, scratch):\n{body}\n"


def module_text(functions: Iterable[str]) -> str:
    """Text of a module of such functions, with the imports that they need."""
    body = "\n\n".join(functions)
    homes = _homes()
    called = sorted(set(re.findall(r"\b[A-Za-z]\w*\b", body)) & set(homes))
    imports = [f"from {homes[name]} import {name}" for name in called]
    return "\n".join(
        [
            "import math",
            "",
            "from numba import carray",
            "",
            "from core.llvm.native import native",
            *imports,
            "",
            "",
            body,
        ]
    )


class Names:
    """Names in generated text of a system's symbols (state x0, x1, …; parameters p0, p1, …; time t), and its frame."""

    def __init__(self, laws: Laws) -> None:
        d, m = len(laws.x), laws.most_conserved_sliding
        self.frame = abi.Frame(d, m)
        self.x, self.carry, self.p = named("x", d), named("c", d), named("p", len(laws.p))
        self.parameters = dict(zip(laws.p, self.p, strict=True))
        self.symbols = {**dict(zip(laws.x, self.x, strict=True)), **self.parameters, TIME: Symbol("t")}
        self.temporaries = sympy.numbered_symbols("v")
        self.unpack_parameters = [f"{q} = p[{k}]" for k, q in enumerate(self.p)]

    @cached_property
    def unpack(self) -> list[str]:
        """Lines that read state, carry and parameters."""
        lines = [f"{v} = w[{self.frame.x + k}]" for k, v in enumerate(self.x)]
        lines += [f"{c} = w[{self.frame.carry + k}]" for k, c in enumerate(self.carry)]
        return lines + self.unpack_parameters

    def own(self, expressions: Iterable[Expr]) -> list[Expr]:
        """Rewrite a system's expressions in these names."""
        return [e.xreplace(self.symbols) for e in expressions]

    def doubled(self, targets: Sequence[str], expressions: Iterable[Expr]) -> list[str]:
        """Lines that evaluate a system's expressions in double-double, at state + carry."""
        known = {x: (str(x), str(c)) for x, c in zip(self.x, self.carry, strict=True)}
        exact = {s: (str(s), None) for s in (*self.p, Symbol("t"))}
        return doubled_assignments(targets, self.own(expressions), {**known, **exact}, self.temporaries)


def evaluate_switching_text(laws: Laws, guard: Expr, modes: Sequence[Mode]) -> str:
    """Text of `evaluate_switching`: a guard, its rates in the first and the last of some modes, and its rounding.

    All are evaluated at `place`.
    """
    names = Names(laws)
    lines = [f"{v} = w[{names.frame.place + k}]" for k, v in enumerate(names.x)] + names.unpack_parameters
    slack = sympy.Add(*(magnitude(guard.diff(v) * v) for v in laws.x)) * sympy.Float(_EPS)
    doubt = rounding_bound(guard) * sympy.Float(_EPS)
    of_g = {abi.G: guard, abi.ROUNDING_OF_STATE: slack, abi.ROUNDING_OF_G: doubt}
    rates = {abi.RATES: modes[0].rate_of(guard), abi.RATES + 1: modes[-1].rate_of(guard)}

    def written(values: Mapping[int, Expr]) -> list[str]:
        targets = [f"w[{place}]" for place in values]
        return assignments(targets, names.own(values.values()), names.temporaries)

    if beside := lines_beside(names.symbols, names.temporaries, (modes[0], modes[-1]), Symbol("t"), names.x):
        lines += [*written(of_g), *beside, *written(rates)]  # only the rates are those of a place beside it
    else:
        lines += written({**of_g, **rates})
    return function_text("evaluate_switching", [*lines, "return 0"])


def jump_text(laws: Laws, jump: Sequence[Expr]) -> str:
    """Text of `jump`."""
    names = Names(laws)
    targets = [f"w[{names.frame.place + k}]" for k in range(len(jump))]
    return function_text("jump", [*names.unpack, *assignments(targets, names.own(jump), names.temporaries), "return 0"])


def level_residual_lines(names: Names, mode: Mode) -> list[str]:
    """Lines that write the level residual at state + carry, evaluated in double-double, to r0, r1 and so on."""
    m, level = len(mode.conserved), names.frame.level
    lines = names.doubled([f"u{j}" for j in range(m)], mode.conserved)
    for j in range(m):
        lines.append(f"r{j}, q = pair_add(u{j}, u{j}_low, -w[{level + j}], -w[{level + names.frame.m + j}])")
        lines.append(f"r{j} += q")
    return lines


def levels_texts(laws: Laws, mode: Mode) -> list[str]:
    """Texts of `set_levels` and `level_residual` of a mode.

    Sliding keeps g = 0. Where g is within rounding of zero its level is zero, not the round-off of where the surface
    was met: a state that decays along the surface becomes smaller than that, and would come to rest beside it.
    """
    names = Names(laws)
    m, level = len(mode.conserved), names.frame.level
    levels = [*names.unpack, *names.doubled([f"u{j}" for j in range(m)], mode.conserved)]
    for j in range(m):
        if mode.conserved[j] == mode.surface:
            rounding = names.own([rounding_bound(mode.surface) * sympy.Float(_ROUNDINGS * _EPS)])
            levels += assignments(["noise"], rounding, names.temporaries)
            levels += [f"if abs(u{j}) <= noise:", f"    u{j} = u{j}_low = 0.0"]
        levels += [f"w[{level + j}] = u{j}", f"w[{level + names.frame.m + j}] = u{j}_low"]
    levels.append(f"w[{abi.LEVELS_SET}] = 1.0")
    residual = [*names.unpack, *level_residual_lines(names, mode)]
    residual += [
        f"w[{names.frame.level_residual + j}] = {f'r{j}' if j < m else 'math.nan'}" for j in range(names.frame.m)
    ]
    functions = (("set_levels", levels), ("level_residual", residual))
    return [function_text(name, [*lines, "return 0"]) for name, lines in functions]
