"""Generate lines that solve linear systems: for few unknowns unrolled, without a loop or an allocation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy
from sympy import Expr, Symbol

from core.codegen.printing import assignments

__all__ = [
    "DEPENDENT",
    "FEW",
    "LARGEST",
    "LEVEL_TOLERANCE",
    "NEARLY_DEPENDENT",
    "OMIT_BELOW",
    "SMALLEST",
    "WRITTEN_OUT",
    "by_cofactors",
    "least_change",
    "row_lines",
    "size_line",
    "with_pivots",
]

#: Up to this many variables all common subexpressions are found; up to this many gradients are treated unrolled.
FEW = 4
#: Up to this many unknowns an unrolled solution takes less time than the loops of `linear_solve_loops`.
WRITTEN_OUT = 10

#: A pivot below this part of its value before elimination is round-off.
DEPENDENT = 4 * 2.0**-52
#: A gradient is nearly dependent on others if the square of its sine to their span is below this.
NEARLY_DEPENDENT = 1e-4
#: Gradients are scaled first if one of their products is below this …
SMALLEST = 1e-250
#: … or above this.
LARGEST = 1e250
#: A ψ whose multiplier is omitted counts as kept if it changes by less than this part of gradient times state.
LEVEL_TOLERANCE = 64 * 2.0**-52
#: A multiplier is omitted if its ψ, with the others kept, changes by less than this part of gradient times state.
OMIT_BELOW = 4 * 2.0**-52


def by_cofactors(matrix: sympy.Matrix, temporaries: Iterable[Symbol]) -> list[str]:
    """Lines that solve matrix·e = r for n ≤ 3 and leave e in r0, r1, …: a single division, and short dependency chains.

    Cramer's rule is accurate enough in Newton's method, which evaluates the residual again.
    """
    n = matrix.rows
    r = sympy.Matrix(sympy.symbols(f"r:{n}"))
    scale = Symbol("scale")
    lines = assignments(["scale"], [1 / matrix.det(method="berkowitz")], temporaries)
    solved = matrix.adjugate() * r * scale
    lines += assignments([f"e{k}" for k in range(n)], list(solved), temporaries)
    return [*lines, *(f"r{k} = e{k}" for k in range(n))]


def with_pivots(n: int, d: int) -> list[str]:
    """Lines that solve the n × n system j·e = r by Gaussian elimination, e left in r.

    The unknowns from d on are multipliers of gradients, and the rows from d on state that each ψ is kept. The first d
    unknowns are eliminated with partial pivoting among the first d rows. The Schur complement is close to the Gram
    matrix of the gradients: definite, so that it needs no pivoting, and row k belongs to the multiplier of ψ k. Where a
    pivot is zero its unknown is set to zero: gradients that vanish, as at an equilibrium, impose no condition.

    The pivot of a gradient is proportional to the square of its sine to the gradients before it; where that is small,
    its ψ is kept to that order if theirs are. Newton's method converges slowly to a state where the sine is zero, as on
    a circular orbit, and the multiplier is undetermined there. So where the pivot is small the multiplier is omitted in
    the first correction (`corrections` is 0), which keeps ψ to the order of the method; and later if ψ is kept within
    rounding, relative to the state (`state`), or if the pivot is round-off.
    """
    several = n - d > 1
    lines = ["independent = True"] if several else []
    if several:
        lines += [f"s{k} = max({', '.join(f'abs(j{i}_{k})' for i in range(d))})" for k in range(d, n)]
        lines.append(f"residual = max({', '.join(f'abs(r{k})' for k in range(d, n))})")
    for k in range(n):
        for i in range(k + 1, d):
            row, pivot = ([f"j{m}_{c}" for c in range(k, n)] + [f"r{m}"] for m in (i, k))
            swap = f"{', '.join(row + pivot)} = {', '.join(pivot + row)}"
            lines += [f"if abs(j{i}_{k}) > abs(j{k}_{k}):", f"    {swap}"]
        if k == d and several:
            lines += [f"whole{i} = abs(j{i}_{i})" for i in range(d, n)]
        if several and k >= d:
            lines += [
                f"near = abs(j{k}_{k}) <= {NEARLY_DEPENDENT} * whole{k}",
                "independent = independent and not near",
                f"if near and (corrections == 0 or abs(r{k}) <= {OMIT_BELOW} * s{k} * state "
                f"or abs(j{k}_{k}) <= {DEPENDENT} * whole{k}):",
                f"    j{k}_{k} = math.inf",
            ]
        lines += _elimination(k, n)
    return lines + _back_substitution(n)


def _elimination(k: int, n: int) -> list[str]:
    """Lines that clear column k below its pivot and invert the pivot; one of 0 or inf sets its unknown to zero."""
    lines = [f"j{k}_{k} = 1.0 / j{k}_{k} if j{k}_{k} != 0.0 else 0.0"]
    for i in range(k + 1, n):
        lines.append(f"q = j{i}_{k} * j{k}_{k}")
        lines += [f"j{i}_{c} -= q * j{k}_{c}" for c in range(k + 1, n)]
        lines.append(f"r{i} -= q * r{k}")
    return lines


def _back_substitution(n: int) -> list[str]:
    lines = []
    for k in reversed(range(n)):
        known = "".join(f" - j{k}_{c} * r{c}" for c in range(k + 1, n))
        lines.append(f"r{k} = (r{k}{known}) * j{k}_{k}")
    return lines


def size_line(x: Sequence[Symbol]) -> str:
    """Line that assigns the largest |coordinate| to `state`; nan if one is nan."""
    return f"state = max({', '.join(f'abs({v})' for v in x)}, 0.0)"


def row_lines(rows: Sequence[Sequence[Expr]], temporaries: Iterable[Symbol]) -> tuple[list[list[Symbol]], list[str]]:
    """Names of the entries of the rows for `least_change`, and lines that evaluate them."""
    names = [[Symbol(f"g{j}_{k}") for k in range(len(row))] for j, row in enumerate(rows)]
    thorough = len(rows[0]) <= FEW
    targets, entries = [str(g) for row in names for g in row], [e for row in rows for e in row]
    return names, assignments(targets, entries, temporaries, thorough)


def least_change(
    along: Sequence[Sequence[Symbol]],
    changes: Sequence[Symbol],
    temporaries: Iterable[Symbol],
    slopes: Sequence[Sequence[Expr]] | None = None,
    least: float = DEPENDENT,
) -> list[str]:
    """Lines that assign to `changes` the v in the span of the rows of A with B·v = r: v = Aᵀ(BAᵀ)⁻¹r.

    B is `slopes`, or A; with B = A, v is the smallest solution. The right-hand side r is in r0, r1, … Rows impose no
    condition if they vanish, or if the square of their sine to the rows before them is below `least`; nor if they
    nearly depend on those and r is round-off relative to row and state (`state`), see `with_pivots`. If there are
    several rows, the lines set `independent` to whether none nearly depends on others. The entries of A are named by
    `row_lines`, and overwritten.
    """
    m, d = len(along), len(along[0])
    if m > FEW:
        return _change_in_loops(along, changes, temporaries, slopes, least)
    against = along if slopes is None else [[Symbol(f"b{j}_{k}") for k in range(d)] for j in range(m)]
    lines = []
    if slopes is not None:
        lines += assignments(
            [str(b) for row in against for b in row], [e for row in slopes for e in row], temporaries, d <= FEW
        )
    product = sympy.Matrix(against) * sympy.Matrix(along).T
    places = [(i, k) for i in range(m) for k in range(m)]
    form = assignments([f"j{i}_{k}" for i, k in places], [product[i, k] for i, k in places], temporaries, d <= FEW)
    lines += form
    lines.append(f"if not ({' and '.join(f'{SMALLEST} < abs(j{k}_{k}) < {LARGEST}' for k in range(m))}):")
    lines += [f"    {line}" for line in (*_rescale(along, against, m), *form)]
    lines += [f"s{i} = abs(j{i}_{i})" for i in range(1, m)]
    lines += ["independent = True"] if m > 1 else []
    for k in range(m):
        if k > 0:
            lines += [
                f"near = abs(j{k}_{k}) <= {NEARLY_DEPENDENT} * s{k}",
                "independent = independent and not near",
                f"if near and (abs(r{k}) <= {OMIT_BELOW} * math.sqrt(s{k}) * state "
                f"or abs(j{k}_{k}) <= {least!r} * s{k}):",
                f"    j{k}_{k} = math.inf",
            ]
        lines += _elimination(k, m)
    lines += _back_substitution(m)
    multipliers = sympy.Matrix(sympy.symbols(f"r:{m}"))
    return lines + assignments(
        [str(c) for c in changes], list(sympy.Matrix(along).T * multipliers), temporaries, d <= FEW
    )


def _change_in_loops(
    along: Sequence[Sequence[Symbol]],
    changes: Sequence[Symbol],
    temporaries: Iterable[Symbol],
    slopes: Sequence[Sequence[Expr]] | None,
    least: float,
) -> list[str]:
    m, d = len(along), len(along[0])
    lines = [
        f"rows, slopes, residuals, gram, change = {', '.join(f'stack_array({n})' for n in (m * d, m * d, m, m * m, d))}"
    ]
    entries = [g for row in along for g in row]
    lines += [f"rows[{k}] = {g}" for k, g in enumerate(entries)]
    against = entries if slopes is None else [e for row in slopes for e in row]
    lines += assignments([f"slopes[{k}]" for k in range(m * d)], against, temporaries, thorough=False)
    lines += [f"residuals[{k}] = r{k}" for k in range(m)]
    lines.append(f"independent = change_along(rows, slopes, residuals, gram, change, {m}, {d}, state, {least!r})")
    return lines + [f"{e} = change[{k}]" for k, e in enumerate(changes)]


def _rescale(along: Sequence[Sequence[Symbol]], against: Sequence[Sequence[Symbol]], m: int) -> list[str]:
    """Lines that divide every row, and its r, by its largest entry, lest its square overflow or underflow."""
    lines = []
    for j in range(m):
        lines += [
            f"q = max({', '.join(f'abs({g})' for g in along[j])})",
            "q = 1.0 / q if q > 0.0 else 0.0",
            f"r{j} *= q",
        ]
        lines += [f"{g} *= q" for g in dict.fromkeys((*along[j], *against[j]))]
    return lines
