"""Fields → text that works out the Taylor coefficients in time of their solutions, by recurrences.

Every quantity u(t, x) has coefficients u₀, u₁, … along the solution: u(t + s, x(t + s)) = Σ uₖ sᵏ. The expressions are
taken apart into operations, each of which gives its coefficient k from those of its operands up to k and its own up to
k − 1; then x' = f gives xₖ₊₁ = fₖ / (k + 1). One loop over k serves every order.

The recurrences hold sums Σ aⱼ bₖ₋ⱼ. Their two terms with the newest coefficients, j = 0 and j = k, are written out with
values that are still in registers: they are all that a coefficient has to wait for. The others, 1 ≤ j ≤ k − 1, are
known before (`sums`).

References: Griewank, Walther, Evaluating Derivatives, ch. 13; Jorba, Zou, Exp. Math. 14 (2005).
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy
from sympy import Expr, Integer, Symbol

from core.codegen import Names
from core.expressions import TIME
from core.laws import Laws, Side
from core.printing import printed
from core.sums import Sums

__all__ = ["SeriesCode", "series_code"]


@dataclass(frozen=True)
class SeriesCode:
    """Lines that read the frame and the parameters, and use t, order, c and `shrink`, a power of two.

    They write `unit`, a length of time, and c[i, k], k ≤ order: for i < d the coefficients of the state in time over
    unit, for i = d those of the height ±g over the surface; the rows from d + 1 on are scratch. In units of its own no
    system's coefficients leave floating point.
    """

    lines: list[str]
    rows: int
    """How many rows c has at least."""


def series_code(laws: Laws, side: Side) -> SeriesCode:
    """Write the recurrences of one side's field, and of the height ±g along its solution.

    Parameters
    ----------
    laws, side
        The system, and the side whose field is followed.

    Raises
    ------
    ValueError
        On a function that is not one of `expressions.FUNCTIONS`.
    """
    names = Names(laws)
    given = [e.xreplace(names.symbols) for e in (*side.field, side.sign * laws.g)]
    writer = _Writer(names)
    shared, final = sympy.cse(given, symbols=sympy.numbered_symbols("s"), order="none")
    for symbol, value in shared:
        writer.share(symbol, value)
    *field, g = [writer.of(e) for e in final]
    return writer.code(field, g)


#: Nodes and their exponents in a product.
Bag = Counter[int]


@dataclass
class _Node:
    """One function of time that is worked out: the names of its coefficients 0 and k, and how to get them."""

    start: str
    newest: str
    first: str
    recurrence: str
    row: int | None = None  # where all coefficients are kept, if any sum needs them


@dataclass(frozen=True)
class _Sum:
    """A linear combination of nodes, plus a constant; the factors are expressions in the parameters."""

    terms: dict[int, Expr]
    constant: Expr = sympy.S.Zero

    def scaled(self, factor: Expr) -> _Sum:
        return _Sum({n: a * factor for n, a in self.terms.items()}, self.constant * factor)

    def plus(self, other: _Sum) -> _Sum:
        terms = {n: self.terms.get(n, 0) + other.terms.get(n, 0) for n in {**self.terms, **other.terms}}
        return _Sum({n: a for n, a in terms.items() if a != 0}, self.constant + other.constant)


class _Writer:
    """The operations so far. Nodes 0 … d − 1 are the state; each operation appears once, under its operands."""

    def __init__(self, names: Names) -> None:
        self.unpack = names.unpack
        self.d = len(names.x)
        self.nodes = [_Node(f"x{i}", f"y{i}", "", "", row=i) for i in range(self.d)]
        self.rows = self.d + 1
        self.sums = Sums()
        self.constants: dict[Expr, str] = {}
        self.setup: list[tuple[int, str]] = []  # (before which node, line): what is worked out once
        self.known: dict[Any, int] = {}
        self.series = {v: _Sum({i: Integer(1)}) for i, v in enumerate(names.x)}  # symbol -> its series
        self.inverted: dict[Expr, Expr] = {}  # symbols that stand for 1 over a power
        self.bags: dict[int, Bag] = {}  # the factors of products and quotients
        self.fixed: dict[Symbol, Expr] = {}  # symbols that stand for constants

    # Expressions → sums of nodes -------------------------------------------------------------------------------------

    def share(self, symbol: Symbol, value: Expr) -> None:
        """Let `symbol` stand for an expression that is used more than once."""
        if _taken_apart(value)[1] < 0 and not self.is_constant(value):  # to divide takes no longer than to multiply
            self.inverted[symbol] = value
            return
        series = self.of(value)
        if not series.terms:
            self.fixed[symbol] = series.constant
        elif len(series.terms) == 1:
            self.series[symbol] = series
        else:  # added up once
            self.series[symbol] = _Sum({self.node(series): Integer(1)})

    def of(self, u: Expr) -> _Sum:
        """An expression as a sum of nodes; operations that are not linear become nodes."""
        if self.is_constant(u):
            return _Sum({}, u.xreplace(self.fixed))
        if u == TIME:
            return _Sum({self.time(): Integer(1)})
        if u in self.inverted:
            return self.product_of([u])
        if u.is_Symbol:
            return self.series[u]
        if u.is_Add:
            total = _Sum({})
            for term in u.args:
                total = total.plus(self.of(term))
            return total
        if u.is_Mul:
            return self.product_of(u.args)
        if u.is_Pow:
            return self.power_of(u.base, u.exp)
        return self.function_of(u)

    def is_constant(self, u: Expr) -> bool:
        """Whether u holds numbers and parameters only."""
        return not any(s in self.series or s in self.inverted or s == TIME for s in u.free_symbols)

    def product_of(self, factors: Iterable[Expr]) -> _Sum:
        """Products of powers, taken apart into factors and put together from products and quotients that are there."""
        scale: Expr = Integer(1)
        bag: Bag = Counter()
        for factor in factors:
            base, n = _taken_apart(self.inverted.get(factor, factor))
            series = self.of(base)
            if not series.terms:
                scale *= series.constant**n
                continue
            a, node = self.factored(series)
            whole = Integer(int(n))  # towards zero; what is left is a root
            scale *= a**whole
            for part, times in self.bag_of(node).items():
                bag[part] += times * int(whole)
            if n != whole:
                bag[self.root(series)] += 1 if n > 0 else -1
        return self.put_together(bag).scaled(scale)

    def power_of(self, base: Expr, exponent: Expr) -> _Sum:
        if self.is_constant(base) or not self.is_constant(exponent):
            return self.of(sympy.exp(exponent * sympy.log(base)))
        n = exponent.xreplace(self.fixed)
        if n.is_Rational and n.q <= 2:
            return self.product_of([sympy.Pow(base, n, evaluate=False)])
        return _one(self.real_power(self.node(self.of(base)), n))

    def function_of(self, u: Expr) -> _Sum:
        name = type(u).__name__
        if name not in _FUNCTIONS:
            raise ValueError(f"{u}: there is no recurrence for {name}; there are those of {', '.join(_FUNCTIONS)}")
        return _one(_FUNCTIONS[name](self, self.of(u.args[0])))

    # Products and quotients of sums ----------------------------------------------------------------------------------

    def factored(self, u: _Sum) -> tuple[Expr, int]:
        """A factor and a node whose product is u: scalar multiples need no node of their own."""
        if len(u.terms) == 1 and u.constant == 0:
            ((node, factor),) = u.terms.items()
            return factor, node
        return Integer(1), self.node(u)

    def bag_of(self, node: int) -> Bag:
        """The factors of a node that is a product or a quotient, with their exponents; else itself."""
        return self.bags.get(node, Counter({node: 1}))

    def put_together(self, bag: Bag) -> _Sum:
        """The product of nodes to powers: of what is there, the largest parts first, then of as little as can be."""
        found: Bag = Counter()
        for node, part in sorted(self.bags.items(), key=lambda known: -sum(map(abs, known[1].values()))):
            for sign in (1, -1):
                while all(bag[n] * e * sign >= e * e for n, e in part.items()):
                    bag.subtract({n: e * sign for n, e in part.items()})
                    found[node] += sign
        for m, n in itertools.combinations(sorted(bag), 2):  # squares of a product, or of a quotient
            several = min(abs(bag[m]), abs(bag[n]))
            if several < 2:
                continue
            signs = [1 if bag[node] > 0 else -1 for node in (m, n)]
            above, below = (m, n) if signs[0] > 0 else (n, m)
            both = self.product(m, n) if signs[0] == signs[1] else self.quotient(_one(above), below)
            found[both] += several * (signs[0] if signs[0] == signs[1] else 1)
            bag.subtract({m: several * signs[0], n: several * signs[1]})
        found.update(bag)
        above, below = (self.powers((node, e * sign) for node, e in sorted(found.items())) for sign in (1, -1))
        return self.over(above, below)

    def powers(self, factors: Iterable[tuple[int, int]]) -> _Sum:
        """The product of the powers that are positive."""
        total = _Sum({}, Integer(1))
        for node, n in factors:
            if n > 0:
                total = self.times(total, self.whole_power(node, n))
        return total

    def times(self, u: _Sum, v: _Sum) -> _Sum:
        if not u.terms or not v.terms:
            return v.scaled(u.constant) if not u.terms else u.scaled(v.constant)
        (a, m), (b, n) = self.factored(u), self.factored(v)
        return _Sum({self.product(m, n): a * b})

    def whole_power(self, node: int, n: int) -> _Sum:
        if n == 1:
            return _one(node)
        half = self.whole_power(node, n // 2)
        square = self.times(half, half)
        return self.times(square, _one(node)) if n % 2 else square

    def over(self, u: _Sum, v: _Sum) -> _Sum:
        if not v.terms:
            return u.scaled(1 / v.constant)
        (below,) = v.terms
        if len(u.terms) == 1 and u.constant == 0:
            factor, above = self.factored(u)
            return _Sum({self.quotient(_one(above), below): factor})
        return _Sum({self.quotient(u, below): Integer(1)})

    # Nodes: the recurrences ------------------------------------------------------------------------------------------

    def add(self, key: Any, first: str, recurrence: Callable[[_Node], str]) -> int:
        """A new node, unless there is one under this key."""
        n = self.known.setdefault(key, len(self.nodes))
        if n == len(self.nodes):
            self.nodes.append(node := _Node(f"z{n}", f"y{n}", first, ""))
            node.recurrence = recurrence(node)
        return n

    def node(self, u: _Sum) -> int:
        """The node of a sum, worked out if it is not a node already."""
        if len(u.terms) == 1 and u.constant == 0 and 1 in u.terms.values():
            (only,) = u.terms
            return only
        return self.add(("sum", *_key(u)), self.start(u), lambda _: self.newest(u))

    def time(self) -> int:
        return self.add("t", "t", lambda _: "unit if k == 1 else 0.0")

    def product(self, m: int, n: int) -> int:
        a, b = self.nodes[m], self.nodes[n]
        first = f"{a.start}*{b.start}"
        if self.known.get("t") in (m, n):
            other, row = (b, self.row(b)) if m == self.known["t"] else (a, self.row(a))
            return self.add(("*", *sorted((m, n))), first, lambda _: f"t*{other.newest} + unit*c[{row}, k - 1]")
        if m == n:
            inner = self.sums.product(self.row(a), self.row(a))
            n = self.add(("*", n, n), first, lambda _: f"fma(2.0*{a.start}, {a.newest}, {inner})")
            return self.made_of(n, self.bag_of(m), self.bag_of(m), 1)
        inner = self.sums.product(self.row(a), self.row(b))
        ends = f"fma({a.start}, {b.newest}, fma({b.start}, {a.newest}, {inner}))"
        both = self.add(("*", *sorted((m, n))), first, lambda _: ends)
        return self.made_of(both, self.bag_of(m), self.bag_of(n), 1)

    def made_of(self, node: int, first: Bag, second: Bag, sign: int) -> int:
        """Keep that a node is first·second^sign."""
        bag = Counter(first)
        for n, e in second.items():
            bag[n] += sign * e
        self.bags.setdefault(node, Counter({n: e for n, e in bag.items() if e}))
        return node

    def quotient(self, u: _Sum, below: int) -> int:
        b = self.nodes[below]
        inverse = self.once("q", below, f"1.0/{b.start}")

        def recurrence(w: _Node) -> str:
            known = f"-{inverse}*{self.sums.product(self.row(b), self.row(w), awaited=True)}"
            return self.newest(u, scale=inverse, more={below: f"-({w.start}*{inverse})"}, known=known)

        n = self.add(("/", *_key(u), below), f"({self.start(u)})/{b.start}", recurrence)
        above = self.bag_of(next(iter(u.terms))) if u.terms else Counter()
        return n if len(u.terms) > 1 else self.made_of(n, above, self.bag_of(below), -1)

    def root(self, u: _Sum) -> int:
        def recurrence(w: _Node) -> str:
            half = f"(0.5/{w.start})"
            known = f"-{half}*{self.sums.product(self.row(w), self.row(w), awaited=True)}"
            return self.newest(u, scale=half, known=known)

        return self.add(("sqrt", *_key(u)), f"math.sqrt({self.start(u)})", recurrence)

    def real_power(self, base: int, exponent: Expr) -> int:
        """The power w = uᵃ with u w' = a u' w: k u₀ wₖ = Σ (a j uⱼ wₖ₋ⱼ − (k − j) uⱼ wₖ₋ⱼ), k u₀ uₖ aside."""
        u, a = self.nodes[base], self.constant(exponent)
        inverse, slope = self.once("q", base, f"1.0/{u.start}"), self.slope(base)

        def recurrence(w: _Node) -> str:
            moved, still = (self.sums.product(self.row(n), self.row(w), awaited=True) for n in (slope, u))
            known = f"{inverse}*fma(inverse*({a} + 1.0), {moved}, -{still})"
            return f"fma({a}*{w.start}*{inverse}, {u.newest}, {known})"

        return self.add(("**", base, exponent), f"{u.start}**{a}", recurrence)

    def logarithm(self, u: _Sum) -> int:
        """Log u = w with u w' = u', the coefficients of s w'(s) being a node of their own."""
        n = self.node(u)
        if ("log", n) not in self.known:
            a = self.nodes[n]
            inverse = self.once("q", n, f"1.0/{a.start}")
            w = self.nodes[self.add(("log", n), f"math.log({a.start})", lambda _: "")]
            slope = self.nodes[self.add(("rate of log", n), "0.0", lambda _: f"k*{w.newest}")]
            known = f"(-inverse*{inverse})*{self.sums.product(self.row(a), self.row(slope), awaited=True)}"
            w.recurrence = f"fma({inverse}, {a.newest}, {known})"
        return self.known["log", n]

    def slope(self, n: int) -> _Node:
        """The node whose coefficients are those of s u'(s), j uⱼ."""
        return self.nodes[self.add(("slope", n), "0.0", lambda _: f"k*{self.nodes[n].newest}")]

    def rate(self, u: _Sum, sign: str = "") -> Callable[[_Node], str]:
        """How coefficient k of ±∫ u' w ds is written, given w: ±inverse · Σ j uⱼ wₖ₋ⱼ."""
        factor, n = self.factored(_Sum(u.terms))
        text = sign + (f"{self.constant(factor)}*" if factor != 1 else "")
        if n == self.known.get("t"):
            return lambda w: f"{text}inverse*(unit*c[{self.row(w)}, k - 1])"
        newest, row = self.nodes[n].newest, self.row(self.slope(n))
        # The term j = k, whose slope is k uₖ, needs no division by k: it may be the last to come.
        return lambda w: (
            f"fma({text}{w.start}, {newest}, ({text}inverse)*{self.sums.product(row, self.row(w), awaited=True)})"
        )

    def exponential(self, u: _Sum) -> int:
        return self.add(("exp", *_key(u)), f"math.exp({self.start(u)})", self.rate(u))

    def pair(self, u: _Sum, which: int, names: tuple[str, str], sign: str) -> int:
        """Functions with φ' = u' χ, χ' = ±u' φ: sine and cosine, of the circle or the hyperbola."""
        key = _key(u)
        if (names[0], *key) not in self.known:
            rates = self.rate(u), self.rate(u, sign)
            pair = [self.add((name, *key), f"math.{name}({self.start(u)})", lambda _: "") for name in names]
            first, second = (self.nodes[n] for n in pair)
            first.recurrence, second.recurrence = rates[0](second), rates[1](first)
        return self.known[names[which], *key]

    def tangent(self, u: _Sum, name: str, first: str, sign: int) -> int:
        """Functions with φ' = u' (1 ± φ²): the tangents; 1 ± φ² is a node, `first` its value."""
        rate, key = self.rate(u), _key(u)
        if (name, *key) not in self.known:
            n = self.add((name, *key), f"math.{name}({self.start(u)})", lambda _: "")
            w = self.nodes[n]
            slope = _Sum({self.product(n, n): Integer(sign)}, Integer(1))
            value = first.format(u=self.start(u), w=w.start)
            w.recurrence = rate(self.nodes[self.add(("sum", *_key(slope)), value, lambda _: self.newest(slope))])
        return self.known[name, *key]

    # Text ------------------------------------------------------------------------------------------------------------

    def row(self, node: _Node) -> int:
        """The row in which a node's coefficients are kept from now on."""
        if node.row is None:
            node.row, self.rows = self.rows, self.rows + 1
        return node.row

    def once(self, stem: str, node: int, value: str) -> str:
        """The name of a value that is worked out before the loop, as soon as `node` has its coefficient 0."""
        name = f"{stem}{node}"
        if (node, f"{name} = {value}") not in self.setup:
            self.setup.append((node, f"{name} = {value}"))
        return name

    def constant(self, a: Expr) -> str:
        """Text of a constant: a number, a parameter, or the name of what is worked out of them once."""
        if a.is_number:
            value = complex(a)
            return repr(value.real) if value.imag == 0 else "math.nan"
        if a.is_Symbol:
            return str(a)
        return self.constants.setdefault(a, f"a{len(self.constants)}")

    def start(self, u: _Sum) -> str:
        """Text of coefficient 0 of a sum."""
        terms = [self.term(a, self.nodes[n].start) for n, a in u.terms.items()]
        return " + ".join([*terms, self.constant(u.constant)] if u.constant != 0 or not terms else terms)

    def newest(self, u: _Sum, scale: str = "", more: Mapping[int, str] = {}, known: str = "") -> str:
        """Text of coefficient k ≥ 1 of scale·u, plus `more` (node: factor), plus what is known before.

        The node that is written last comes last: it adds the time of one operation to what has to be waited for.
        """
        terms = [(n, self.factor(a, scale)) for n, a in u.terms.items()] + list(more.items())
        text = known
        for n, factor in sorted(terms):
            y = self.nodes[n].newest
            if factor in ("", "-"):
                text = f"({text} {factor or '+'} {y})" if text else f"{factor}{y}"
            else:
                text = f"fma({factor}, {y}, {text})" if text else f"{factor}*{y}"
        return text or "0.0"

    def factor(self, a: Expr, scale: str) -> str:
        """Text of the factor a·scale: nothing for 1, a sign for −1."""
        if a in (1, -1):
            return ("-" if a == -1 else "") + scale
        return f"({self.constant(a)}*{scale})" if scale else self.constant(a)

    def term(self, a: Expr, name: str) -> str:
        return name if a == 1 else f"-{name}" if a == -1 else f"{self.constant(a)}*{name}"

    def unit(self) -> list[str]:
        """About the time in which the state moves by its own size, a power of two, times `shrink`."""
        size, speed = (" + ".join(f"abs({u}{i})" for i in range(self.d)) for u in "xf")
        return [f"size, speed = {size}, {speed}", "unit = shrink*power_near(size, speed)"]

    def needed(self, texts: Iterable[str]) -> tuple[set[int], set[str]]:
        """Nodes, and sums, whose coefficients these texts need: what is put together otherwise leaves some unused."""
        nodes, sums, pending = set[int](), set[str](), list(texts)
        owner = {node.row: n for n, node in enumerate(self.nodes) if node.row is not None}
        while pending:
            for kind, number in re.findall(r"\b(y|sum)(\d+)\b", pending.pop()):
                new = [owner[row] for row in self.sums.rows_of(f"sum{number}")] if kind == "sum" else [int(number)]
                sums |= {f"sum{number}"} if kind == "sum" else set()
                pending += [self.nodes[n].recurrence for n in new if n not in nodes]
                nodes |= set(new)
        return nodes, sums

    def code(self, field: list[_Sum], g: _Sum) -> SeriesCode:
        """The whole body."""
        rates = [(f"f{i} = {self.start(f)}", f"f{i} = {self.newest(f)}") for i, f in enumerate(field)]
        heights = f"c[{self.d}, 0] = {self.start(g)}", f"c[{self.d}, k] = {self.newest(g)}"
        needed, sums = self.needed([heights[1], *(rate for _, rate in rates)])
        needed |= set(range(self.d))
        before = [f"{name} = {printed(a)}" for a, name in self.constants.items()]
        loop = [*self.sums.lines(sums), "inverse = 1.0 / k", "pace = unit*inverse"]
        loop += [f"y{i} = pace*f{i}" for i in range(self.d)]
        for n, node in enumerate(self.nodes):
            before += [f"{node.start} = {node.first}"] if n >= self.d else []
            before += [line for m, line in self.setup if m == n]
            if n not in needed:
                continue
            loop += [f"{node.newest} = {node.recurrence}"] if n >= self.d else []
            if node.row is not None:
                before.append(f"c[{node.row}, 0] = {node.start}")
                loop.append(f"c[{node.row}, k] = {node.newest}")
        before += [*(first for first, _ in rates), heights[0], *self.unit()]
        newest = {node.row: node.newest for node in self.nodes if node.row is not None}
        loop += [*(rate for _, rate in rates), heights[1], *self.sums.after(newest, sums)]
        before += self.sums.before(sums)
        lines = [*self.unpack, *before, "for k in range(1, order + 1):", *(f"    {line}" for line in loop)]
        return SeriesCode(lines, self.rows)


def _taken_apart(u: Expr) -> tuple[Expr, sympy.Rational]:
    """Base and exponent of a power that takes products and a root at most; else u itself, and 1."""
    return (u.base, u.exp) if u.is_Pow and u.exp.is_Rational and u.exp.q <= 2 else (u, Integer(1))


def _one(node: int) -> _Sum:
    return _Sum({node: Integer(1)})


def _key(u: _Sum) -> tuple[Any, ...]:
    return tuple(sorted(u.terms.items(), key=lambda term: term[0])), u.constant


_FUNCTIONS: dict[str, Callable[[_Writer, _Sum], int]] = {
    "exp": _Writer.exponential,
    "log": _Writer.logarithm,
    "sin": lambda writer, u: writer.pair(u, 0, ("sin", "cos"), "-"),
    "cos": lambda writer, u: writer.pair(u, 1, ("sin", "cos"), "-"),
    "sinh": lambda writer, u: writer.pair(u, 0, ("sinh", "cosh"), ""),
    "cosh": lambda writer, u: writer.pair(u, 1, ("sinh", "cosh"), ""),
    "tan": lambda writer, u: writer.tangent(u, "tan", "1.0 + {w}*{w}", 1),
    "tanh": lambda writer, u: writer.tangent(u, "tanh", "1.0/math.cosh({u})**2", -1),
}
