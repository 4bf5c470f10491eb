"""Generate the text of one step, which a scheme writes in terms of symbols."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property, partial
from itertools import zip_longest

import sympy
from sympy import Expr, Symbol

from core.codegen.beside import lines_beside
from core.codegen.derivatives import jacobian
from core.codegen.functions import Names, function_text, level_residual_lines
from core.codegen.linear_solve import (
    FEW,
    WRITTEN_OUT,
    by_cofactors,
    least_change,
    row_lines,
    size_line,
    with_pivots,
)
from core.codegen.newton_loop import continuation, verdict
from core.codegen.passing import PassingCode
from core.codegen.printing import assignments, magnitude, named, printed
from core.codegen.rounding import rounding_bound
from core.kernels import abi
from core.kernels.taylor_coefficients import STRIDE
from core.symbolic.derivative import derivative
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode

__all__ = ["StepCode"]

#: A projection to the levels below this part of the increment is the last: the error it leaves is its square.
_SETTLED = 1e-8
#: Largest number of projections of a step to the levels.
_MAX_PROJECTIONS = 8
#: A variable step is too long if the projection moves it by more than this part of the state …
_ASTRAY = 2.0**-40
#: … or by this part if the gradients are nearly dependent, and ψ determines the state to half the digits only …
_LOST = 2.0**-20
#: … and by more than this many times the tolerance.
_FREEDOM = 2.0**10
#: A correction below 4 eps of the state is round-off.
_NOTHING = 4 * 2.0**-52
#: The least normal double: what is smaller has no relative accuracy, so that a correction below it is round-off.
_NORMAL = 2.0**-1022
#: Bound, relative to the increment, on the correction for the round-off that one step adds to ψ.
_ROUNDING = 1e-6
#: Largest number of unknowns of linear systems that are solved by cofactors.
_SMALL = 3
#: A quotient is lost in round-off where the bound on its rounding exceeds this part of it.
_NOISE = 2.0**-30
#: That is asked where the sum that vanishes is less than this part of its terms: elsewhere the field passes zero.
_NEAR = 2.0**-6
#: A field whose text has more characters is compiled as a separate function: the time of the call is negligible.
_LONG = 2500


class StepCode:
    """The text of one step, written by `Scheme.write`.

    Attributes
    ----------
    t, h
        Start and length of the step.
    x
        The d coordinates of the state at its start.
    """

    def __init__(self, laws: Laws, mode: Mode) -> None:
        self._names = Names(laws)
        self._laws, self._mode = laws, mode
        self._temporaries = self._names.temporaries
        self._few = len(self._names.x) <= FEW
        self._called = ""
        self._passing = PassingCode(self._names, mode)
        self._lines = [*self._names.unpack, *self._beside(Symbol("t"), self._names.x), *self._passing.start]
        self._evaluations: list[str] = []
        self.t, self.h = Symbol("t"), Symbol("h")
        self.x = self._names.x

    def _beside(self, t: Symbol, x: Sequence[Symbol]) -> list[str]:
        """Lines that move a place where the field is 0/0; the step ends where it would take round-off for the field."""
        lines = lines_beside(self._names.symbols, self._temporaries, [self._mode], t, x)
        place = {**self._names.symbols, **dict(zip(self._mode.variables, x, strict=True)), TIME: t}
        noisy = self._mode.zeros.noisy
        if not noisy:
            return lines
        lines += [f"near = {not all(u.is_Add for u in noisy)}"]
        for u in noisy:
            lines += self._assign(["zero", "size"], [v.xreplace(place) for v in (u, _size(u))])
            lines += [f"near = near or not abs(zero) > size * {_NEAR}"]
        lines += ["if near:"]
        for f in self._mode.field:
            noise = rounding_bound(f, of_symbols=False) * sympy.Float(2.0**-52)
            checked = self._assign(["noise", "size"], [v.xreplace(place) for v in (noise, _size(f))])
            checked += [f"if not noise <= size * {_NOISE}:", f"    return {abi.NO_SOLUTION}"]
            lines += [f"    {line}" for line in checked]
        return lines

    def _move_end(self) -> list[str]:
        """Lines that move the end of a step so that neither it nor the middle is where the field is 0/0."""
        move = partial(lines_beside, self._names.symbols, self._temporaries, [self._mode], Symbol("t1"), self.end)
        return move() + move(start=(self.t, self.x))

    def let(self, expressions: Sequence[Expr]) -> list[Symbol]:
        """Append lines that evaluate expressions; returns the names of their values."""
        names = [next(self._temporaries) for _ in expressions]
        self._lines += self._assign([str(n) for n in names], expressions)
        return names

    def _assign(self, targets: Sequence[str], expressions: Sequence[Expr]) -> list[str]:
        return assignments(targets, expressions, self._temporaries, thorough=self._few)

    def field(self, t: Expr, increment: Sequence[Expr] | None = None) -> list[Symbol]:
        """Append lines that evaluate f at time t, at the start of the step plus an increment; returns its d values."""
        x = self.x
        if increment is not None:
            x = tuple(next(self._temporaries) for _ in x)
            moved = self._assign([f"{y}_moved" for y in x], increment)
            ends = zip(x, self.x, self._names.carry, strict=True)
            self._lines += moved + [f"{y} = {a} + ({c} + {y}_moved)" for y, a, c in ends]
            self._lines += self._passing.lines(t, x)
            if self._mode.zeros.removable or self._mode.zeros.noisy:
                (t,) = self.let([t])
                self._lines += self._beside(t, x)
        self._evaluations.append("1")
        if self._apart:
            return self._field_apart(t, x)
        at = {**self._names.symbols, **dict(zip(self._mode.variables, x, strict=True)), TIME: t}
        return self.let([f.xreplace(at) for f in self._mode.field])

    @cached_property
    def _apart(self) -> str:
        """Text of f as a separate function, for a step that needs it at several stages; empty if f is short."""
        d, names = len(self.x), self._names
        if self._few:
            return ""
        lines = [f"{x} = place[{k}]" for k, x in enumerate(self.x)] + names.unpack_parameters
        lines += self._assign([f"f[{k}]" for k in range(d)], names.own(self._mode.field))
        body = "\n".join(f"    {line}" for line in lines)
        return f"def field(t, place, p, f):\n{body}\n\n\n" if len(body) > _LONG else ""

    def _field_apart(self, t: Expr, x: Sequence[Symbol]) -> list[Symbol]:
        values = [next(self._temporaries) for _ in x]
        if not self._called:
            self._called = self._apart
            self._lines.append(f"place, rates = stack_array({len(x)}), stack_array({len(x)})")
        self._lines += [f"place[{k}] = {y}" for k, y in enumerate(x)]
        self._lines.append(f"field({printed(t)}, place, p, rates)")
        self._lines += [f"{value} = rates[{k}]" for k, value in enumerate(values)]
        return values

    def at_ends(self, expressions: Iterable[Expr]) -> list[Expr]:
        """Rewrite discrete expressions in this step's symbols: x at its start, y = x + increment at its end."""
        ends = self._mode.discrete.ends
        names = {**dict(zip(ends.start, self.x, strict=True)), **dict(zip(ends.end, self.end, strict=True))}
        names |= {**self._names.parameters, ends.times[0]: self.t, ends.times[1]: Symbol("t1")}
        return [e.xreplace(names) for e in expressions]

    @property
    def end(self) -> tuple[Symbol, ...]:
        """The state at the end of the step; in `solve`, that of the current increment."""
        return named("y", len(self.x))

    @property
    def increment(self) -> tuple[Symbol, ...]:
        """The unknown increment of `solve`."""
        return named("d", len(self.x))

    @property
    def _arrive(self) -> list[str]:
        """Lines that add the increment to the state: y = x + d."""
        return [f"y{k} = x{k} + (c{k} + d{k})" for k in range(len(self.x))]

    def field_at(self, t: Expr, increment: Sequence[Expr]) -> list[Expr]:
        """Expressions of f at time t, at the start of the step plus an increment of unknowns: for `solve`."""
        moved = [x + (c + u) for x, c, u in zip(self.x, self._names.carry, increment, strict=True)]
        at = {**self._names.symbols, **dict(zip(self._mode.variables, moved, strict=True)), TIME: t}
        return [f.xreplace(at) for f in self._mode.field]

    def solve(self, residuals: Sequence[Expr], multipliers: Sequence[Symbol] = (), stages: int = 1) -> list[Symbol]:
        """Find the increment (and multipliers) at which the residuals vanish, by Newton's method from Euler's step.

        The unknowns d0, d1, … are the increments of the first stage, then of the second, and so on. Iterating
        increments keeps round-off small. The last correction is the one after which quadratic convergence leaves an
        error below half an ulp, or the one that no longer shrinks.
        """
        d = stages * len(self.x)
        unknowns = [*named("d", d), *multipliers]
        newton = self._newton if self._few else self._newton_of_many
        inner = self._arrive + (self._move_end() if stages == 1 else []) + newton(residuals, unknowns, d)
        inner += [f"{u} -= r{k}" for k, u in enumerate(unknowns)]
        slopes = self.field(self.t)
        start = [f"{u} = h*{f}" for u, f in zip(unknowns, stages * slopes, strict=False)]
        start += [f"{u} = 0.0" for u in multipliers]
        inner += verdict(len(unknowns), d, "scale > 0.0" if self._few and len(unknowns) == d <= _SMALL else "True")
        self._lines += ["full, parts, part, scale, before = h, 1, 1, 1.0, 1.0", "t1 = t + h", *start]
        self._lines.append(size_line(self.x))
        self._lines += ["while True:", "    last, corrections, solved = math.inf, 0, False"]
        self._lines += ["    while True:", *(f"        {line}" for line in inner)]
        self._lines += [f"    {line}" for line in continuation(unknowns, start)]
        self._evaluations.append("corrections")
        return list(self.increment)

    def _newton_of_many(self, residuals: Sequence[Expr], unknowns: Sequence[Symbol], d: int) -> list[str]:
        """Lines that write the next correction to r0, r1 and so on, for many unknowns by way of arrays."""
        n = len(residuals)
        moves = dict(zip(self.end, unknowns, strict=False))
        lines, values, entries = jacobian(residuals, unknowns, moves, self._temporaries)
        if n <= WRITTEN_OUT:
            lines += [f"j{i}_{k} = {entries.get((i, k), '0.0')}" for i in range(n) for k in range(n)]
            return [*lines, *(f"r{i} = {value}" for i, value in enumerate(values)), *with_pivots(n, d)]
        lines = [f"matrix, right, sizes = stack_array({n * n}), stack_array({n}), stack_array({n})", *lines]
        lines += [f"right[{i}] = {value}" for i, value in enumerate(values)]
        lines += [f"for entry in range({n * n}):", "    matrix[entry] = 0.0"]
        lines += [f"matrix[{i * n + k}] = {entry}" for (i, k), entry in entries.items()]
        state = "state" if n - d > 1 else "0.0"
        lines.append(
            "independent, residual, largest = "
            f"solve_with_pivots(matrix, right, sizes, {n}, {d}, corrections == 0, {state})"
        )
        return lines + [f"r{k} = right[{k}]" for k in range(n)]

    def _newton(self, residuals: Sequence[Expr], unknowns: Sequence[Symbol], d: int) -> list[str]:
        """Lines that write the next correction to r0, r1 and so on."""
        # The end of the step depends on the increment: y = x + d.
        jacobian = [
            [derivative(r, u) + (derivative(r, y) if y else 0) for u, y in zip_longest(unknowns, self.end)]
            for r in residuals
        ]
        n = len(residuals)
        targets = [f"r{i}" for i in range(n)]
        if n == d <= _SMALL:
            entries = {(i, k): e for i, row in enumerate(jacobian) for k, e in enumerate(row) if not e.is_number}
            names = [f"j{i}_{k}" for i, k in entries]
            matrix = sympy.Matrix(n, n, lambda i, k: Symbol(f"j{i}_{k}") if (i, k) in entries else jacobian[i][k])
            lines = assignments([*targets, *names], [*residuals, *entries.values()], self._temporaries)
            return lines + by_cofactors(matrix, self._temporaries)
        names = [f"j{i}_{k}" for i in range(n) for k in range(n)]
        values = [*residuals, *(e for row in jacobian for e in row)]
        return assignments([*targets, *names], values, self._temporaries) + with_pivots(n, d)

    def compose(self, weights: Sequence[float], build: Callable[[], Sequence[Expr]]) -> list[Symbol]:
        """Compose steps of length weight·h, in a loop of the compiled step; returns the total increment.

        Between the steps, state and increment are added up by compensated summation.
        """
        d, frame = range(len(self.x)), self._names.frame
        outer, self._lines, self._evaluations = self._lines, [], []
        part = build()
        inner = ["h = whole_h * weight", "t = whole_t + whole_h * passed", "passed += weight"]
        inner += [f"x{k}, c{k} = two_sum(w[{frame.x + k}], w[{frame.carry + k}] + (w{k} + z{k}))" for k in d]
        inner += self._beside(Symbol("t"), self.x) + self._lines + self._assign([f"a{k}" for k in d], part)
        for k in d:
            inner += [f"w{k}, q = two_sum(w{k}, a{k})", f"z{k} += q"]
        inner.append(f"count += {' + '.join(self._evaluations)}")
        self._lines = [*outer, "whole_t, whole_h, passed, count = t, h, 0.0, 0", *(f"w{k} = z{k} = 0.0" for k in d)]
        self._lines += [f"for weight in {tuple(weights)!r}:", *(f"    {line}" for line in inner)]
        self._lines += ["t, h = whole_t, whole_h", *self._names.unpack]
        self._evaluations = ["count"]
        return self.let([Symbol(f"w{k}") + Symbol(f"z{k}") for k in d])

    def polynomial(self) -> list[Symbol]:
        """The increment at h of the Taylor polynomial whose coefficients `prepare_step` has written to scratch.

        Even and odd powers are summed apart: two independent chains of half the length (Horner in h²) for each row.
        """
        d = range(len(self.x))
        inner = [
            line
            for k in d
            for line in (f"d{k} = fma(d{k}, square, c[{k}, j])", f"z{k} = fma(z{k}, square, c[{k}, j + 1])")
        ]
        self._lines += [f"order = int(w[{abi.ORDER}])", f"c = carray(scratch, ({len(d)}, {STRIDE}))"]
        self._lines += [f"part = h * w[{abi.PER_UNIT}]", "square = part*part", "top = order - 1 + order % 2"]
        self._lines += [f"d{k}, z{k} = c[{k}, top], 0.0 if top == order else c[{k}, order]" for k in d]
        self._lines += ["for j in range(top - 2, 0, -2):", *(f"    {line}" for line in inner)]
        self._lines += [f"d{k} = d{k}*part + z{k}*square" for k in d]
        return list(self.increment)

    def restore_levels(self, increments: Sequence[Expr]) -> list[Expr]:
        """Correct an increment by the level residual at the start of the step, evaluated in double-double.

        So the round-off of a conservative method does not accumulate: the error of ψ stays bounded.
        """
        m = len(self._mode.conserved)
        if m == 0:
            return list(increments)
        changes = named("e", len(self.x))
        given = self.let(increments)
        self._lines += level_residual_lines(self._names, self._mode)
        # The correction is along ∇ψ at the end of the step, y, as Newton's method has left it.
        gradients, lines = row_lines(self._gradients_at_end(), self._temporaries)
        self._lines += [*lines, size_line(self.x), *least_change(gradients, changes, self._temporaries)]
        size = f"max({', '.join(f'abs({e})' for e in changes)})"
        whole = f"max({', '.join(f'abs({d})' for d in given)}, 0.0)"
        bound = f"{_ROUNDING} * {whole}"
        if m > 1:  # if gradients are nearly dependent, ψ determines the state to half the digits only
            bound = f"({bound} if independent else {_ROUNDING} * max({whole}, state))"
        self._lines.append(f"if not {size} <= {bound}:")
        self._lines.append(f"    {' = '.join(map(str, changes))} = 0.0")
        return [d - e for d, e in zip(given, changes, strict=True)]

    def _gradients_at_end(self) -> list[list[Expr]]:
        """∇ψ at the end of the step."""
        at = {**self._names.symbols, **dict(zip(self._laws.x, self.end, strict=True)), TIME: Symbol("t1")}
        return [[derivative(psi, v).xreplace(at) for v in self._laws.x] for psi in self._mode.conserved]

    def project_to_levels(self, increments: Sequence[Expr], prepared: bool = False) -> list[Expr]:
        """Project an increment along the discrete gradient to the levels of ψ: Λᵗ Δ + h s_t = −(level residual).

        With this projection any one-step method is a discrete multiplier method (Wan, Bihlo, Nave 2017). The level
        residual is evaluated here, or, if `prepared`, has been by `prepare_step`. This also tells how large
        each coordinate is and moves: in that metric, a projection does not depend on the units of the coordinates.
        """
        mode, d = self._mode, len(self.x)
        m = len(mode.conserved)
        if m == 0:
            return list(increments)
        lines = [*self._assign([f"d{k}" for k in range(d)], increments), "t1 = t + h", size_line(self.x)]
        if prepared:
            frame = self._names.frame
            lines += [f"o{j} = w[{frame.level_residual + j}]" for j in range(m)]
            lines += [f"extent{k} = w[{frame.extent + k}]" for k in range(d)]
            lines += [f"largest = max({', '.join(f'extent{k}' for k in range(d))})"]
            lines += [f"weight{k} = (extent{k} / largest)**2" for k in range(d)]
        else:
            lines += [*level_residual_lines(self._names, mode), *(f"o{j} = r{j}" for j in range(m))]
        gradient = sympy.Matrix(m, d, self.at_ends(mode.discrete.gradient))
        rows, inner = row_lines(gradient.tolist(), self._temporaries)
        slope = sympy.Matrix(self.at_ends(mode.discrete.time_slope))
        left = sympy.Matrix(rows) * sympy.Matrix(self.increment) + self.h * slope + sympy.Matrix(named("o", m))
        changes = named("e", d)
        slopes = self._gradients_at_end()
        inner = [*self._arrive, *inner, *self._assign([f"r{j}" for j in range(m)], list(left))]
        if prepared:  # near the origin a state is off the levels by more than its own rounding: no fault of the series
            inner.append(f"adds = {' or '.join(f'not abs(r{j} - o{j}) <= abs(o{j})' for j in range(m))}")
            inner += [f"{row[k]} *= weight{k}" for row in rows for k in range(d)]
        inner += least_change(rows, changes, self._temporaries, slopes)
        inner += [f"d{k} -= e{k}" for k in range(d)]
        inner.append(f"size = max({', '.join(f'abs({e})' for e in changes)})")
        whole = f"max({', '.join(f'abs(d{k})' for k in range(d))}, 0.0)"
        # ψ may depend on a coordinate that is far smaller than others, for example on its logarithm.
        each = " and ".join(f"abs(e{k}) <= {_SETTLED} * max(abs(d{k}), abs(x{k}))" for k in range(d))
        if prepared:  # so far off the levels, the series has not resolved the solution
            least = f"({_ASTRAY} if independent else {_LOST})" if m > 1 else str(_ASTRAY)
            allowed = f"max({_FREEDOM} * w[{abi.TOLERANCE}], {least}) * max({whole}, state)"
            inner.append(f"if adds and size > max({allowed}, {_NORMAL}):")
            inner.append(f"    return {abi.NO_SOLUTION}")
        inner.append(f"if (size <= {_SETTLED} * {whole} or size <= {_NOTHING} * state) and {each}:")
        inner.append("    break")
        self._lines += [*lines, f"for _ in range({_MAX_PROJECTIONS}):", *(f"    {line}" for line in inner)]
        # Near an equilibrium, where ψ hardly varies, a projection may be large relative to Δ but negligible to x.
        self._lines += [
            "else:",
            f"    if not size <= max({_SETTLED} * state, {_NORMAL}):",
            f"        return {abi.NO_SOLUTION}",
        ]
        return list(self.increment)

    def text(self, increments: Sequence[Expr]) -> str:
        """Text of the function with these increments; it also evaluates the guards and their rates at the end."""
        names, d = self._names, len(self.x)
        lines = self._lines + self._assign([f"i{k}" for k in range(d)], increments)
        lines += [f"w[{names.frame.increment + k}] = i{k}" for k in range(d)]
        lines += [f"y{k} = x{k} + (c{k} + i{k})" for k in range(d)]
        lines += self._passing.lines_at_end(self.end)
        at_end = {**names.symbols, **dict(zip(self._laws.x, self.end, strict=True)), TIME: Symbol("t1")}
        ends = zip(self._mode.guards, self._mode.guard_rates, strict=True)
        values = [e.xreplace(at_end) for pair in ends for e in pair]
        targets = [f"w[{abi.G_END + k}]" for k in range(len(values))]
        lines += ["t1 = t + h", *self._beside(Symbol("t1"), self.end), *self._assign(targets, values)]
        lines.append(f"return {' + '.join(self._evaluations) or '0'}")
        return self._called + function_text("step", lines)


def _size(u: Expr) -> Expr:
    """Sum of the sizes of the terms of an expression."""
    return sympy.Add(*map(magnitude, sympy.Add.make_args(u)))
