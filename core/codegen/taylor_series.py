"""Generate text that evaluates the Taylor coefficients in time of the solutions of a field, by recurrences.

Every quantity u(t, x) has coefficients u₀, u₁, … along the solution: u(t + s, x(t + s)) = Σ uₖ sᵏ. The expressions are
split into operations (`taylor_operations`), each of which gives its coefficient k from those of its operands up to k
and its own up to k − 1; then x' = f gives xₖ₊₁ = fₖ / (k + 1). One loop over k serves every order.

References: Griewank, Walther, Evaluating Derivatives, ch. 13; Jorba, Zou, Exp. Math. 14 (2005).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import sympy
from sympy import Expr, Integer, Symbol

from core.codegen.functions import Names, function_text
from core.codegen.printing import printed
from core.codegen.taylor_operations import Bag, Linear, Operations, single
from core.kernels.abi import ORDER, UNIT
from core.kernels.taylor_coefficients import STRIDE
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode
from core.symbolic.near_zeros import Choice

__all__ = ["ALONG", "SeriesCode", "event_series_text", "series_code", "series_rows"]

#: 1 or −1, the direction of time: backward, the guards of sliding have other signs.
ALONG = Symbol("along")


@dataclass(frozen=True)
class SeriesCode:
    """Lines that read the frame and the parameters, and use t, order, c, `shrink`, a power of two, and `ALONG`.

    They write `unit`, the unit of time, and c[i, k], k ≤ order: for i < d the coefficients of the state in powers of
    time/unit, from i = d on those of the heights of the guards, then scratch. The unit is chosen such that the
    coefficients do not overflow.
    """

    lines: list[str]
    rows: int
    """Number of rows that c needs."""


def series_code(laws: Laws, mode: Mode) -> SeriesCode:
    """Generate the recurrences of one mode's field, and of the heights of its guards along its solution.

    Parameters
    ----------
    laws, mode
        The system, and the mode whose field is expanded.

    Raises
    ------
    ValueError
        For a function without a recurrence.
    """
    names = Names(laws)
    plain = _recurrences(names, mode.written)
    if mode.expanded is mode.written:
        return plain
    series, shared = _recurrences(names, mode.expanded), len(names.unpack)
    choices = {v for u in (*mode.expanded.field, *mode.expanded.heights) for v in u.atoms(Choice)}
    if not choices:
        return series
    near = sorted({f"{printed(v.args[0].xreplace(names.symbols))} <= 0.0" for v in choices})
    parts = [[f"    {line}" for line in code.lines[shared:]] for code in (series, plain)]
    lines = [*names.unpack, f"if {' or '.join(near)}:", *parts[0], "else:", *parts[1]]
    return SeriesCode(lines, max(series.rows, plain.rows))


def _recurrences(names: Names, mode: Mode) -> SeriesCode:
    heights = [(ALONG if mode.turns(k) else Integer(1)) * u for k, u in enumerate(mode.heights)]
    given = [e.xreplace(names.symbols) for e in (*mode.field, *heights)]
    writer = _Writer(names, len(heights))
    given = [writer.with_named_choices(u) for u in given]
    shared, final = sympy.cse(given, symbols=sympy.numbered_symbols("s"), order="none")
    for symbol, value in shared:
        writer.share(symbol, value)
    series = [writer.of(e) for e in final]
    return writer.code(series[: writer.d], series[writer.d :])


def _event_series(laws: Laws, function: Expr) -> SeriesCode:
    """Generate the recurrences of an event function along a solution whose coefficients are known."""
    names = Names(laws)
    writer = _Writer(names, 1)
    writer.unpack = [*names.unpack_parameters, *(f"x{i} = c[{i}, 0]" for i in range(writer.d))]
    return writer.code_along(writer.of(function.xreplace(names.symbols)))


def series_rows(laws: Laws, functions: Iterable[Expr]) -> int:
    """Number of rows of coefficients that any of these event functions needs."""
    return max((_event_series(laws, function).rows for function in functions), default=1)


def event_series_text(laws: Laws, function: Expr) -> str:
    """Text of `event_series`, which expands an event function."""
    code = _event_series(laws, function)
    lines = [f"order, unit = int(w[{ORDER}]), w[{UNIT}]", f"c = carray(scratch, ({code.rows}, {STRIDE}))"]
    return function_text("event_series", [*lines, *code.lines, "return 0"])


class _Writer(Operations):
    """Splits expressions into operations."""

    def __init__(self, names: Names, guards: int) -> None:
        super().__init__(len(names.x), guards)
        self.unpack = names.unpack
        self.series = {v: single(i) for i, v in enumerate(names.x)}  # symbol -> its series
        self.inverted: dict[Expr, Expr] = {}  # symbols that stand for powers with a negative exponent
        self.fixed: dict[Symbol, Expr] = {}  # symbols that stand for constants

    def with_named_choices(self, u: Expr) -> Expr:
        """An expression with a name in place of each condition of a choice, which is evaluated once, at the start."""

        def named(*parts: Expr) -> Expr:
            return Choice(Symbol(self.constants.setdefault(parts[0], f"a{len(self.constants)}")), *parts[1:])

        return u.replace(Choice, named)

    # Expressions → sums of nodes -------------------------------------------------------------------------------------

    def share(self, symbol: Symbol, value: Expr) -> None:
        """Define the symbol of an expression that is used more than once."""
        if _base_and_exponent(value)[1] < 0 and not self.is_constant(value):  # a quotient costs as much as a product
            self.inverted[symbol] = value
            return
        series = self.of(value)
        if not series.terms:
            self.fixed[symbol] = series.constant
        elif len(series.terms) == 1:
            self.series[symbol] = series
        else:  # summed once, in a node of its own
            self.series[symbol] = Linear({self.node(series): Integer(1)})

    def of(self, u: Expr) -> Linear:
        """An expression as a linear combination of nodes; nonlinear operations become nodes."""
        if self.is_constant(u):
            return Linear({}, u.xreplace(self.fixed))
        if u == TIME:
            return Linear({self.time(): Integer(1)})
        if u in self.inverted:
            return self.product_of([u])
        if u.is_Symbol:
            return self.series[u]
        if u.is_Add:
            total = Linear({})
            for term in u.args:
                total = total.plus(self.of(term))
            return total
        if u.is_Mul:
            return self.product_of(u.args)
        if u.is_Pow:
            return self.power_of(u.base, u.exp)
        return self.choice_of(u) if isinstance(u, Choice) else self.function_of(u)

    def is_constant(self, u: Expr) -> bool:
        """Whether u holds numbers and parameters only."""
        return not any(s in self.series or s in self.inverted or s == TIME for s in u.free_symbols)

    def product_of(self, factors: Iterable[Expr]) -> Linear:
        """A product of powers, split into factors and composed from products and quotients that exist already."""
        scale: Expr = Integer(1)
        bag: Bag = Counter()
        for factor in factors:
            base, n = _base_and_exponent(self.inverted.get(factor, factor))
            series = self.of(base)
            if not series.terms:
                scale *= series.constant**n
                continue
            a, node = self.factored(series)
            whole = Integer(int(n))  # towards zero; the rest is a square root
            scale *= a**whole
            for part, times in self.bag_of(node).items():
                bag[part] += times * int(whole)
            if n != whole:
                bag[self.root(series)] += 1 if n > 0 else -1
        return self.compose(bag).scaled(scale)

    def power_of(self, base: Expr, exponent: Expr) -> Linear:
        if self.is_constant(base) or not self.is_constant(exponent):
            return self.of(sympy.exp(exponent * sympy.log(base)))
        n = exponent.xreplace(self.fixed)
        if n.is_Rational and n.q <= 2:
            return self.product_of([sympy.Pow(base, n, evaluate=False)])
        return single(self.real_power(self.node(self.of(base)), n))

    def choice_of(self, u: Choice) -> Linear:
        """One of two quantities for all coefficients, as the state at the start decides."""
        near, other = (self.nodes[self.node(self.of(v))] for v in u.args[1:])
        first, newest = (
            f"({a} if {u.args[0]} <= 0.0 else {b})" for a, b in ((near.start, other.start), (near.newest, other.newest))
        )
        return single(self.add(("choice", first), first, lambda _: newest))

    def function_of(self, u: Expr) -> Linear:
        name = type(u).__name__
        if name not in _FUNCTIONS:
            raise ValueError(f"{u}: there is no recurrence for {name}; there are those of {', '.join(_FUNCTIONS)}")
        return single(_FUNCTIONS[name](self, self.of(u.args[0])))

    # Products and quotients of sums ----------------------------------------------------------------------------------

    def compose(self, bag: Bag) -> Linear:
        """The product of powers of nodes: of existing products that cover most factors, then of few new ones."""
        found: Bag = Counter()
        while known := {node: self.covered(bag, part) for node, part in self.bags.items()}:
            node = max(known, key=lambda n: (known[n][0], -n))
            _, times = known[node]
            if times == 0:
                break
            bag.subtract({n: e * times for n, e in self.bags[node].items()})
            found[node] += times
        for m, n in itertools.combinations(sorted(bag), 2):  # squares of a product, or of a quotient
            several = min(abs(bag[m]), abs(bag[n]))
            if several < 2:
                continue
            signs = [1 if bag[node] > 0 else -1 for node in (m, n)]
            above, below = (m, n) if signs[0] > 0 else (n, m)
            both = self.product(m, n) if signs[0] == signs[1] else self.quotient(single(above), below)
            found[both] += several * (signs[0] if signs[0] == signs[1] else 1)
            bag.subtract({m: several * signs[0], n: several * signs[1]})
        found.update(bag)
        top, bottom = (self.powers((node, e * sign) for node, e in sorted(found.items())) for sign in (1, -1))
        return self.over(top, bottom)

    def covered(self, bag: Bag, part: Bag) -> tuple[int, int]:
        """Number of factors of a product that powers of a part cover, and the exponent, negative for its inverse."""
        for sign in (1, -1):
            times = min((sign * bag[n] // e if sign * bag[n] * e > 0 else 0 for n, e in part.items()), default=0)
            if times > 0:
                return times * sum(map(abs, part.values())), sign * times
        return 0, 0

    def powers(self, factors: Iterable[tuple[int, int]]) -> Linear:
        """The product of the powers with positive exponents."""
        total = Linear({}, Integer(1))
        for node, n in factors:
            if n > 0:
                total = self.times(total, self.whole_power(node, n))
        return total

    def times(self, u: Linear, v: Linear) -> Linear:
        if not u.terms or not v.terms:
            return v.scaled(u.constant) if not u.terms else u.scaled(v.constant)
        (a, m), (b, n) = self.factored(u), self.factored(v)
        return Linear({self.product(m, n): a * b})

    def whole_power(self, node: int, n: int) -> Linear:
        if n == 1:
            return single(node)
        half = self.whole_power(node, n // 2)
        square = self.times(half, half)
        return self.times(square, single(node)) if n % 2 else square

    def over(self, u: Linear, v: Linear) -> Linear:
        if not v.terms:
            return u.scaled(1 / v.constant)
        (below,) = v.terms
        if len(u.terms) == 1 and u.constant == 0:
            factor, above = self.factored(u)
            return Linear({self.quotient(single(above), below): factor})
        return Linear({self.quotient(u, below): Integer(1)})

    def code(self, field: list[Linear], guards: list[Linear]) -> SeriesCode:
        """The lines of the whole computation."""
        rates = [(f"f{i} = {self.start(f)}", f"f{i} = {self.newest(f)}") for i, f in enumerate(field)]
        rows = list(enumerate(guards, self.d))
        first = [f"c[{row}, 0] = {self.start(g)}" for row, g in rows]
        heights = [f"c[{row}, k] = {self.newest(g)}" for row, g in rows]
        needed, sums = self.needed([*heights, *(rate for _, rate in rates)])
        moved = ["pace = unit*inverse", *(f"y{i} = pace*f{i}" for i in range(self.d))]
        before, loop = self.recurrences(needed | set(range(self.d)), sums, moved)
        before += [*(start for start, _ in rates), *first, *self.unit()]
        loop += [*(rate for _, rate in rates), *heights]
        return self.whole(before, loop)

    def code_along(self, function: Linear) -> SeriesCode:
        """The lines that expand a function along coefficients of the state that are known."""
        first, height = f"c[{self.d}, 0] = {self.start(function)}", f"c[{self.d}, k] = {self.newest(function)}"
        needed, sums = self.needed([height])
        before, loop = self.recurrences(needed, sums, [f"y{i} = c[{i}, k]" for i in range(self.d)])
        return self.whole([*before, first], [*loop, height])

    def recurrences(self, needed: set[int], sums: set[str], moved: list[str]) -> tuple[list[str], list[str]]:
        """Lines that give all nodes needed their coefficients 0, and those that give them coefficients k."""
        before = [f"{name} = {printed(a)}" for a, name in self.constants.items()]
        loop = [*self.sums.lines(sums), "inverse = 1.0 / k", *moved]
        for n, node in enumerate(self.nodes):
            before += [f"{node.start} = {node.first}"] if n >= self.d else []
            before += [line for m, line in self.setup if m == n]
            if n not in needed:
                continue
            loop += [f"{node.newest} = {node.recurrence}"] if n >= self.d else []
            if node.row is not None:
                before.append(f"c[{node.row}, 0] = {node.start}")
                loop.append(f"c[{node.row}, k] = {node.newest}")
        return before, loop

    def whole(self, before: list[str], loop: list[str]) -> SeriesCode:
        """The lines of a computation, by those before the loop over k and those in it."""
        lines = [*self.unpack, *before, "for k in range(1, order + 1):", *(f"    {line}" for line in loop)]
        return SeriesCode(lines, self.rows)


def _base_and_exponent(u: Expr) -> tuple[Expr, sympy.Rational]:
    """Base and exponent of a power with an integer or half-integer exponent; else u itself and 1."""
    return (u.base, u.exp) if u.is_Pow and u.exp.is_Rational and u.exp.q <= 2 else (u, Integer(1))


_FUNCTIONS: dict[str, Callable[[_Writer, Linear], int]] = {
    "exp": _Writer.exponential,
    "log": _Writer.logarithm,
    "sin": lambda writer, u: writer.pair(u, 0, ("sin", "cos"), "-"),
    "cos": lambda writer, u: writer.pair(u, 1, ("sin", "cos"), "-"),
    "sinh": lambda writer, u: writer.pair(u, 0, ("sinh", "cosh"), ""),
    "cosh": lambda writer, u: writer.pair(u, 1, ("sinh", "cosh"), ""),
    "tan": lambda writer, u: writer.tangent(u, "tan", "1.0 + {w}*{w}", 1),
    "tanh": lambda writer, u: writer.tangent(u, "tanh", "1.0/math.cosh({u})**2", -1),
}
