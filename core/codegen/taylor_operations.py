"""Operations on power series: text of the recurrences of their coefficients.

The recurrences contain sums Σ aⱼ bₖ₋ⱼ. Their two terms with the newest coefficients, j = 0 and j = k, are written apart
and use values still in registers: only these are on the critical path, one operation each. The other terms,
1 ≤ j ≤ k − 1, are summed before (`convolutions`).

References: Griewank, Walther, Evaluating Derivatives, ch. 13; Jorba, Zou, Exp. Math. 14 (2005).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy
from sympy import Expr, Integer

from core.codegen.convolutions import Sums

__all__ = ["Bag", "Linear", "Node", "Operations", "key_of", "single"]

#: Factor that makes every subnormal number normal.
_LIFT = 2.0**64

#: Nodes and their exponents in a product.
Bag = Counter[int]


@dataclass
class Node:
    """One function of time: the names of its coefficients 0 and k, and the texts that evaluate them."""

    start: str
    newest: str
    first: str
    recurrence: str
    row: int | None = None  # row of c with all coefficients, if any sum needs them


@dataclass(frozen=True)
class Linear:
    """A linear combination of nodes, plus a constant; the factors are expressions in the parameters."""

    terms: dict[int, Expr]
    constant: Expr = sympy.S.Zero

    def scaled(self, factor: Expr) -> Linear:
        """Multiply by an expression in the parameters."""
        return Linear({n: a * factor for n, a in self.terms.items()}, self.constant * factor)

    def plus(self, other: Linear) -> Linear:
        """The sum of two combinations."""
        terms = {n: self.terms.get(n, 0) + other.terms.get(n, 0) for n in {**self.terms, **other.terms}}
        return Linear({n: a for n, a in terms.items() if a != 0}, self.constant + other.constant)


def single(node: int) -> Linear:
    """A node as a combination."""
    return Linear({node: Integer(1)})


def key_of(u: Linear) -> tuple[Any, ...]:
    """Key of a combination for `Operations.add`."""
    return tuple(sorted(u.terms.items(), key=lambda term: term[0])), u.constant


class Operations:
    """The operations so far, each once, by name and operands. Nodes 0 … d − 1 are the state; guards have rows too."""

    def __init__(self, d: int, guards: int = 1) -> None:
        self.d = d
        self.nodes = [Node(f"x{i}", f"y{i}", "", "", row=i) for i in range(d)]
        self.rows = d + guards
        self.sums = Sums()
        self.constants: dict[Expr, str] = {}
        self.setup: list[tuple[int, str]] = []  # (node, line before it): values evaluated once, before the loop
        self.known: dict[Any, int] = {}
        self.bags: dict[int, Bag] = {}  # the factors of products and quotients

    def factored(self, u: Linear) -> tuple[Expr, int]:
        """A factor and a node whose product is u: scalar multiples need no separate node."""
        if len(u.terms) == 1 and u.constant == 0:
            ((node, factor),) = u.terms.items()
            return factor, node
        return Integer(1), self.node(u)

    def bag_of(self, node: int) -> Bag:
        """Factors and exponents of a node that is a product or a quotient; else the node itself."""
        return self.bags.get(node, Counter({node: 1}))

    def add(self, key: Any, first: str, recurrence: Callable[[Node], str]) -> int:
        """A new node, unless there is one under this key."""
        n = self.known.setdefault(key, len(self.nodes))
        if n == len(self.nodes):
            self.nodes.append(node := Node(f"z{n}", f"y{n}", first, ""))
            node.recurrence = recurrence(node)
        return n

    def node(self, u: Linear) -> int:
        """The node of a combination, added if there is none."""
        if len(u.terms) == 1 and u.constant == 0 and 1 in u.terms.values():
            (only,) = u.terms
            return only
        return self.add(("sum", *key_of(u)), self.start(u), lambda _: self.newest(u))

    def time(self) -> int:
        """The node of the time."""
        return self.add("t", "t", lambda _: "unit if k == 1 else 0.0")

    def product(self, m: int, n: int) -> int:
        """The product of two nodes."""
        a, b = self.nodes[m], self.nodes[n]
        first = f"{a.start}*{b.start}"
        if self.known.get("t") in (m, n):
            other, row = (b, self.row(b)) if m == self.known["t"] else (a, self.row(a))
            return self.add(("*", *sorted((m, n))), first, lambda _: f"t*{other.newest} + unit*c[{row}, k - 1]")
        if m == n:
            inner = self.sums.product(self.row(a), self.row(a))
            n = self.add(("*", n, n), first, lambda _: f"fma(2.0*{a.start}, {a.newest}, {inner})")
            return self.with_factors(n, self.bag_of(m), self.bag_of(m), 1)
        inner = self.sums.product(self.row(a), self.row(b))
        ends = f"fma({a.start}, {b.newest}, fma({b.start}, {a.newest}, {inner}))"
        both = self.add(("*", *sorted((m, n))), first, lambda _: ends)
        return self.with_factors(both, self.bag_of(m), self.bag_of(n), 1)

    def with_factors(self, node: int, first: Bag, second: Bag, sign: int) -> int:
        """Note that a node is first·second^sign."""
        bag = Counter(first)
        for n, e in second.items():
            bag[n] += sign * e
        self.bags.setdefault(node, Counter({n: e for n, e in bag.items() if e}))
        return node

    def quotient(self, u: Linear, below: int) -> int:
        """The quotient w = u/v: w₀ vₖ + … + wₖ v₀ = uₖ."""
        b = self.nodes[below]
        inverse = self.once("q", below, f"1.0/{b.start}")

        def recurrence(w: Node) -> str:
            known = f"-{inverse}*{self.sums.product(self.row(b), self.row(w))}"
            return self.newest(u, scale=inverse, more={below: f"-({w.start}*{inverse})"}, known=known)

        n = self.add(("/", *key_of(u), below), f"({self.start(u)})/{b.start}", recurrence)
        above = self.bag_of(next(iter(u.terms))) if u.terms else Counter()
        return n if len(u.terms) > 1 else self.with_factors(n, above, self.bag_of(below), -1)

    def root(self, u: Linear) -> int:
        """The square root w of u: 2 w₀ wₖ + … = uₖ."""

        def recurrence(w: Node) -> str:
            half = f"(0.5/{w.start})"
            known = f"-{half}*{self.sums.product(self.row(w), self.row(w))}"
            return self.newest(u, scale=half, known=known)

        return self.add(("sqrt", *key_of(u)), f"math.sqrt({self.start(u)})", recurrence)

    def real_power(self, base: int, exponent: Expr) -> int:
        """The power w = uᵃ with u w' = a u' w: k u₀ wₖ = Σ (a j uⱼ wₖ₋ⱼ − (k − j) uⱼ wₖ₋ⱼ), k u₀ uₖ aside.

        With 0 in place of 1/u₀ it gives 1, 0, 0, …, which is u⁰ also where u₀ = 0.
        """
        u, a = self.nodes[base], self.constant(exponent)
        inverse, slope = self.once("q", base, f"1.0/{u.start}"), self.slope(base)
        if not exponent.is_number:
            inverse = self.once(f"p{a}_", base, f"(0.0 if {a} == 0.0 else 1.0/{u.start})")

        def recurrence(w: Node) -> str:
            moved, still = (self.sums.product(self.row(n), self.row(w)) for n in (slope, u))
            known = f"{inverse}*fma(inverse*({a} + 1.0), {moved}, -{still})"
            return f"fma({a}*{w.start}*{inverse}, {u.newest}, {known})"

        return self.add(("**", base, exponent), f"{u.start}**{a}", recurrence)

    def logarithm(self, u: Linear) -> int:
        """Log u = w with u w' = u', the coefficients of s w'(s) being a node of their own."""
        n = self.node(u)
        if ("log", n) not in self.known:
            a = self.nodes[n]
            inverse = self.once("q", n, f"1.0/{a.start}")
            w = self.nodes[self.add(("log", n), f"math.log({a.start})", lambda _: "")]
            slope = self.nodes[self.add(("rate of log", n), "0.0", lambda _: f"k*{w.newest}")]
            known = f"(-inverse*{inverse})*{self.sums.product(self.row(a), self.row(slope))}"
            w.recurrence = f"fma({inverse}, {a.newest}, {known})"
        return self.known["log", n]

    def slope(self, n: int) -> Node:
        """The node whose coefficients are those of s u'(s), j uⱼ."""
        return self.nodes[self.add(("slope", n), "0.0", lambda _: f"k*{self.nodes[n].newest}")]

    def rate(self, u: Linear, sign: str = "") -> Callable[[Node], str]:
        """Text of coefficient k of ±∫ u' w ds, given w: ±inverse · Σ j uⱼ wₖ₋ⱼ."""
        factor, n = self.factored(Linear(u.terms))
        text = sign + (f"{self.constant(factor)}*" if factor != 1 else "")
        if n == self.known.get("t"):
            return lambda w: f"{text}inverse*(unit*c[{self.row(w)}, k - 1])"
        newest, row = self.nodes[n].newest, self.row(self.slope(n))
        # The term j = k, whose slope is k uₖ, needs no division by k.
        return lambda w: f"fma({text}{w.start}, {newest}, ({text}inverse)*{self.sums.product(row, self.row(w))})"

    def exponential(self, u: Linear) -> int:
        """The exponential w of u, with w' = u' w."""
        return self.add(("exp", *key_of(u)), f"math.exp({self.start(u)})", self.rate(u))

    def pair(self, u: Linear, which: int, names: tuple[str, str], sign: str) -> int:
        """Functions with φ' = u' χ, χ' = ±u' φ: sine and cosine, of the circle or the hyperbola."""
        key = key_of(u)
        if (names[0], *key) not in self.known:
            rates = self.rate(u), self.rate(u, sign)
            pair = [self.add((name, *key), f"math.{name}({self.start(u)})", lambda _: "") for name in names]
            first, second = (self.nodes[n] for n in pair)
            first.recurrence, second.recurrence = rates[0](second), rates[1](first)
        return self.known[names[which], *key]

    def tangent(self, u: Linear, name: str, first: str, sign: int) -> int:
        """Functions with φ' = u' (1 ± φ²): the tangents; 1 ± φ² is a node, `first` its value."""
        rate, key = self.rate(u), key_of(u)
        if (name, *key) not in self.known:
            n = self.add((name, *key), f"math.{name}({self.start(u)})", lambda _: "")
            w = self.nodes[n]
            slope = Linear({self.product(n, n): Integer(sign)}, Integer(1))
            value = first.format(u=self.start(u), w=w.start)
            w.recurrence = rate(self.nodes[self.add(("sum", *key_of(slope)), value, lambda _: self.newest(slope))])
        return self.known[name, *key]

    # Text ------------------------------------------------------------------------------------------------------------

    def row(self, node: Node) -> int:
        """Row of c for a node's coefficients, assigned at the first call."""
        if node.row is None:
            node.row, self.rows = self.rows, self.rows + 1
        return node.row

    def once(self, stem: str, node: int, value: str) -> str:
        """Name of a value that is evaluated before the loop, once coefficient 0 of `node` is known."""
        name = f"{stem}{node}"
        if (node, f"{name} = {value}") not in self.setup:
            self.setup.append((node, f"{name} = {value}"))
        return name

    def constant(self, a: Expr) -> str:
        """Text of a constant: a number, a parameter, or the name of an expression in them, evaluated once."""
        if a.is_number:
            value = complex(a)
            return repr(value.real) if value.imag == 0 else "math.nan"
        if a.is_Symbol:
            return str(a)
        return self.constants.setdefault(a, f"a{len(self.constants)}")

    def start(self, u: Linear) -> str:
        """Text of coefficient 0 of a combination."""
        terms = [self.term(a, self.nodes[n].start) for n, a in u.terms.items()]
        return " + ".join([*terms, self.constant(u.constant)] if u.constant != 0 or not terms else terms)

    def newest(self, u: Linear, scale: str = "", more: Mapping[int, str] = {}, known: str = "") -> str:
        """Text of coefficient k ≥ 1 of scale·u, plus `more` (node: factor), plus `known`, evaluated before.

        The node evaluated last is added last, so that only one operation has to wait for it.
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
        """Text of the factor a·scale: empty for 1, a sign for −1."""
        if a in (1, -1):
            return ("-" if a == -1 else "") + scale
        return f"({self.constant(a)}*{scale})" if scale else self.constant(a)

    def term(self, a: Expr, name: str) -> str:
        """Text of a factor times the value of this name."""
        return name if a == 1 else f"-{name}" if a == -1 else f"{self.constant(a)}*{name}"

    def unit(self) -> list[str]:
        """Lines that set the unit of time: `shrink` times a power of two near |x|/|f|, also of subnormal numbers."""
        size, speed = (" + ".join(f"abs({u}{i})" for i in range(self.d)) for u in "xf")
        lines = [f"size, speed = {size}, {speed}", f"lift = {_LIFT} if size + speed < 1.0 else 1.0"]
        return [*lines, "unit = shrink*power_near(lift*size, lift*speed)"]

    def needed(self, texts: Iterable[str]) -> tuple[set[int], set[str]]:
        """Nodes and sums whose coefficients these texts need; factoring products differently leaves some unused."""
        nodes, sums, pending = set[int](), set[str](), list(texts)
        owner = {node.row: n for n, node in enumerate(self.nodes) if node.row is not None}
        while pending:
            for kind, number in re.findall(r"\b(y|sum|c\[)(\d+)\b", pending.pop()):
                of_sum = self.sums.rows_of(f"sum{number}") if kind == "sum" else ()
                sums |= {f"sum{number}"} if kind == "sum" else set()
                new = [int(number)] if kind == "y" else [owner[row] for row in of_sum or [int(number)] if row in owner]
                pending += [self.nodes[n].recurrence for n in new if n not in nodes]
                nodes |= set(new)
        return nodes, sums
