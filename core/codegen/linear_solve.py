"""Linear systems solved in generated lines: for a few unknowns written out, without a loop or an allocation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy
from sympy import Expr, Symbol

from core.codegen.printing import assignments

__all__ = [
    "DEPENDENT",
    "FEW",
    "KEPT",
    "LEAST",
    "MOST",
    "NEARLY",
    "SPARED",
    "WRITTEN_OUT",
    "by_cofactors",
    "least_change",
    "row_lines",
    "size_line",
    "with_pivots",
]

#: Up to so many variables every expression in common is looked for; and so many gradients are few.
FEW = 4
#: Up to so many unknowns a solution that is written out takes less time than one in `linear_solve_loops`.
WRITTEN_OUT = 10

#: A pivot below this part of what it was before elimination is round-off.
DEPENDENT = 4 * 2.0**-52
#: A gradient is nearly dependent on others where the square of its sine to them is below this.
NEARLY = 1e-4
#: Products of gradients below this are scaled first …
LEAST = 1e-250
#: … and products above this.
MOST = 1e250
#: A ψ whose multiplier is left alone may change by this part of gradient times state.
KEPT = 64 * 2.0**-52
#: A multiplier is left alone where its ψ, with the others kept, changes by less than this part.
SPARED = 4 * 2.0**-52


def by_cofactors(matrix: sympy.Matrix, temporaries: Iterable[Symbol]) -> list[str]:
    """Lines that solve matrix·e = r for n ≤ 3, e left in r0, r1, …: one division, and nothing to wait for.

    Cramer's rule is as good as elimination where, as in Newton's method, the residual is looked at again.
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

    The unknowns from d on are multipliers of gradients, and the rows from d on say that each ψ is kept. The first d
    unknowns are eliminated with partial pivoting among the first d rows. What is left is close to the products of the
    gradients with each other: definite, so that its pivots stay where they are, and row and multiplier of a ψ go
    together. A pivot of zero leaves its unknown alone: gradients that vanish, as at an equilibrium, bind nothing.

    A gradient that depends on those before it has the square of its sine to them as a pivot, and to that order its ψ is
    kept by keeping theirs. Newton's method converges slowly to a state where the sine is zero, as on a circular orbit,
    and the multiplier has no value there. So where the pivot is small it is left alone in the first correction
    (`corrections` is 0), which keeps ψ to the order of the method; and afterwards where ψ is kept but for rounding, in
    parts of the state (`state`), or the pivot is round-off.
    """
    several = n - d > 1
    lines = ["firm = True"] if several else []
    if several:
        lines += [f"s{k} = max({', '.join(f'abs(j{i}_{k})' for i in range(d))})" for k in range(d, n)]
        lines.append(f"excess = max({', '.join(f'abs(r{k})' for k in range(d, n))})")
    for k in range(n):
        for i in range(k + 1, d):
            row, pivot = ([f"j{m}_{c}" for c in range(k, n)] + [f"r{m}"] for m in (i, k))
            swap = f"{', '.join(row + pivot)} = {', '.join(pivot + row)}"
            lines += [f"if abs(j{i}_{k}) > abs(j{k}_{k}):", f"    {swap}"]
        if k == d and several:
            lines += [f"whole{i} = abs(j{i}_{i})" for i in range(d, n)]
        if several and k >= d:
            lines += [
                f"near = abs(j{k}_{k}) <= {NEARLY} * whole{k}",
                "firm = firm and not near",
                f"if near and (corrections == 0 or abs(r{k}) <= {SPARED} * s{k} * state "
                f"or abs(j{k}_{k}) <= {DEPENDENT} * whole{k}):",
                f"    j{k}_{k} = math.inf",
            ]
        lines += _elimination(k, n)
    return lines + _back_substitution(n)


def _elimination(k: int, n: int) -> list[str]:
    """Lines that clear column k below its pivot, which they leave inverted; a pivot of 0 or inf binds nothing."""
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
    """Line that leaves the largest coordinate's size in `state`, nan where one is nan."""
    return f"state = max({', '.join(f'abs({v})' for v in x)}, 0.0)"


def row_lines(rows: Sequence[Sequence[Expr]], temporaries: Iterable[Symbol]) -> tuple[list[list[Symbol]], list[str]]:
    """Names for the entries of `least_change`'s rows, and lines that work them out."""
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
    """Lines that give `changes` the v along the rows A with B·v = r0, r1, …: v = Aᵀ(BAᵀ)⁻¹r, B being `slopes`, or A.

    With B = A the smallest such v. Rows that vanish, or depend on those before them, bind nothing: where the square of
    the sine between them is below `least`;
    nor do those that nearly depend on them where r is rounding beside the row and the state (`state`), see
    `with_pivots`; of several rows `firm` tells whether none nearly depends on others. The entries of A are those of
    `row_lines`, and lost.
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
    lines.append(f"if not ({' and '.join(f'{LEAST} < abs(j{k}_{k}) < {MOST}' for k in range(m))}):")
    lines += [f"    {line}" for line in (*_rescale(along, against, m), *form)]
    lines += [f"s{i} = abs(j{i}_{i})" for i in range(1, m)]
    lines += ["firm = True"] if m > 1 else []
    for k in range(m):
        if k > 0:
            lines += [
                f"near = abs(j{k}_{k}) <= {NEARLY} * s{k}",
                "firm = firm and not near",
                f"if near and (abs(r{k}) <= {SPARED} * math.sqrt(s{k}) * state or abs(j{k}_{k}) <= {least!r} * s{k}):",
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
        f"rows, slopes, excesses, room, change = {', '.join(f'stack_array({n})' for n in (m * d, m * d, m, m * m, d))}"
    ]
    entries = [g for row in along for g in row]
    lines += [f"rows[{k}] = {g}" for k, g in enumerate(entries)]
    against = entries if slopes is None else [e for row in slopes for e in row]
    lines += assignments([f"slopes[{k}]" for k in range(m * d)], against, temporaries, thorough=False)
    lines += [f"excesses[{k}] = r{k}" for k in range(m)]
    lines.append(f"firm = change_along(rows, slopes, excesses, room, change, {m}, {d}, state, {least!r})")
    return lines + [f"{e} = change[{k}]" for k, e in enumerate(changes)]


def _rescale(along: Sequence[Sequence[Symbol]], against: Sequence[Sequence[Symbol]], m: int) -> list[str]:
    """Lines that divide every row, and its r, by its largest entry: their squares may be beyond floating point."""
    lines = []
    for j in range(m):
        lines += [
            f"q = max({', '.join(f'abs({g})' for g in along[j])})",
            "q = 1.0 / q if q > 0.0 else 0.0",
            f"r{j} *= q",
        ]
        lines += [f"{g} *= q" for g in dict.fromkeys((*along[j], *against[j]))]
    return lines
