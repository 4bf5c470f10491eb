"""Expressions of generated text → LLVM (see `statements`)."""

from __future__ import annotations

import ast
import inspect
import math
from dataclasses import replace
from typing import Any

import numpy as np
from numba import carray  # type: ignore[attr-defined]

from core.kernels.doubledouble import arithmetic
from core.kernels.stack_array import stack_array
from core.llvm.operations import (
    DOUBLE,
    ROWS,
    TRUTH,
    WHOLE,
    Operations,
    Thing,
    Unknown,
    Value,
    number_of,
    returned,
    wider,
)

__all__ = ["Expressions"]

_ORDER = {
    ast.Lt: ("olt", "slt"), ast.LtE: ("ole", "sle"), ast.Gt: ("ogt", "sgt"), ast.GtE: ("oge", "sge"),
    ast.Eq: ("oeq", "eq"), ast.NotEq: ("une", "ne"),
}  # fmt: skip


class Expressions(Operations):
    """How each kind of expression is turned into operations; what a name stands for is known as lines are read."""

    def value(self, node: ast.expr) -> Any:
        """A scalar, a pointer, or a tuple of them."""
        match node:
            case ast.Constant(value=bool() as number):
                return Value(TRUTH, str(number).lower())
            case ast.Constant(value=int() | float() as number):
                return number_of(number)
            case ast.Name(id=name):
                return self.named(name)
            case ast.Tuple(elts=elements):
                return tuple(self.value(e) for e in elements)
            case ast.BinOp(left=left, op=op, right=right):
                return self.binary(op, self.value(left), self.value(right))
            case ast.UnaryOp(op=ast.Not()):
                return self.let(TRUTH, f"xor i1 {self.truth(node.operand).text}, true")
            case ast.UnaryOp(op=ast.USub()):
                return self.negative(self.value(node.operand))
            case ast.BoolOp():
                return self.either(node)
            case ast.Compare():
                return self.comparison(node)
            case ast.IfExp():
                return self.choice(node)
            case ast.Call():
                return self.call(node)
            case ast.Subscript():
                return self.subscript(node)
            case ast.Attribute(value=ast.Name(id="math"), attr="inf" | "nan" as name):
                return number_of(getattr(math, name))
        raise Unknown(f"{ast.unparse(node)}: an expression of the kind {type(node).__name__}")

    def named(self, name: str) -> Any:
        """What a name stands for here."""
        if name in self.bound:
            bound = self.bound[name]
            return tuple(self.named(f"{name}.{k}") for k in range(bound)) if isinstance(bound, int) else bound
        if name in self.kinds:
            if name not in self.places:  # read before it is given a value in an earlier round of a loop
                self.places.add(name)
                self.stack.append(f"  %v.{name} = alloca {self.kinds[name]}")
            return self.let(self.kinds[name], f"load {self.kinds[name]}, ptr %v.{name}")
        return self.known(self.thing(name), name)

    def thing(self, name: str) -> Any:
        """What a name stands for in the function's module."""
        if name not in self.globals:
            raise Unknown(f"the name {name}")
        return self.globals[name]

    def known(self, what: Any, name: str) -> Any:
        """A number of a module, or something else of it."""
        if isinstance(what, int | float) and not isinstance(what, bool):
            return number_of(what)
        if isinstance(what, np.ndarray) and what.ndim == 1 and what.dtype == np.float64:
            return Value(ROWS, self.module.table(what.tolist()))
        if isinstance(what, tuple):
            return Thing(what)
        raise Unknown(f"{name}, which is of the type {type(what).__name__}")

    def truth(self, node: ast.expr) -> Value:
        """A condition."""
        value = self.value(node)
        if not (isinstance(value, Value) and value.kind == TRUTH):
            raise Unknown(f"{ast.unparse(node)} as a condition")
        return value

    def either(self, node: ast.BoolOp) -> Value:
        """`and`, `or`: what comes later is not looked at where the first tells."""
        place, after, both = self.slot(TRUTH), self.label(), isinstance(node.op, ast.And)
        for k, operand in enumerate(node.values):
            value = self.truth(operand)
            self.emit(f"store i1 {value.text}, ptr {place}")
            if k + 1 < len(node.values):
                following = self.label()
                self.branch(value, *((following, after) if both else (after, following)))
                self.lines.append(f"{following}:")
        self.begin(after)
        return self.let(TRUTH, f"load i1, ptr {place}")

    def comparison(self, node: ast.Compare) -> Value:
        """Comparisons in a chain: all are worked out."""
        values = [self.value(e) for e in (node.left, *node.comparators)]
        found: Value | None = None
        for op, a, b in zip(node.ops, values, values[1:], strict=False):
            floating, whole = _ORDER.get(type(op), ("", ""))
            if not floating:
                raise Unknown(f"the comparison {type(op).__name__}")
            if a.kind == b.kind == WHOLE or a.kind == b.kind == TRUTH:
                one = self.let(TRUTH, f"icmp {whole} {a.kind} {a.text}, {b.text}")
            else:
                one = self.let(TRUTH, f"fcmp {floating} double {self.double(a)}, {self.double(b)}")
            found = one if found is None else self.let(TRUTH, f"and i1 {found.text}, {one.text}")
        assert found is not None  # noqa: S101
        return found

    def choice(self, node: ast.IfExp) -> Any:
        """One of two values, or tuples: only that one is worked out."""
        yes, no, after = self.label(), self.label(), self.label()
        self.branch(self.truth(node.test), yes, no)
        before, parts = self.lines, []
        for part in (node.body, node.orelse):
            self.lines = []
            value = self.value(part)
            parts.append((self.lines, value if isinstance(value, tuple) else (value,)))
        self.lines = before
        kinds = [wider(a, b) for a, b in zip(parts[0][1], parts[1][1], strict=True)]
        places = [self.slot(kind) for kind in kinds]
        for label, (lines, results) in zip((yes, no), parts, strict=True):
            self.lines += [f"{label}:", *lines]
            for value, kind, place in zip(results, kinds, places, strict=True):
                self.emit(f"store {kind} {self.cast(value, kind)}, ptr {place}")
            self.emit(f"br label %{after}")
        self.lines.append(f"{after}:")
        loaded = tuple(self.let(kind, f"load {kind}, ptr {place}") for kind, place in zip(kinds, places, strict=True))
        return loaded if len(loaded) > 1 else loaded[0]

    def subscript(self, node: ast.Subscript) -> Any:
        """A number of a row, or an element of a tuple."""
        if isinstance(node.value, ast.Name | ast.Subscript):
            base = self.value(node.value)
            if isinstance(base, Thing | tuple):
                index = self.value(node.slice).known
                if index is None:
                    raise Unknown(f"{ast.unparse(node)}: one of several values, not known beforehand which")
                return base[index] if isinstance(base, tuple) else self.known(base.what[index], ast.unparse(node))
        return self.load(self.address(node))

    def address(self, node: ast.Subscript) -> str:
        """Where a number of a row is."""
        base, index = self.value(node.value), self.value(node.slice)
        if not (isinstance(base, Value) and base.kind == ROWS):
            raise Unknown(f"{ast.unparse(node)}: no row of numbers")
        parts = index if isinstance(index, tuple) else (index,)
        if any(part.kind != WHOLE for part in parts) or (len(parts) == 2) != bool(base.stride):
            raise Unknown(f"{ast.unparse(node)}: an index that is none")
        place = parts[-1]
        if base.stride:
            row = self.binary(ast.Mult(), parts[0], Value(WHOLE, base.stride))
            place = self.binary(ast.Add(), row, parts[1])
        return self.element(base.text, place.text)

    def call(self, node: ast.Call) -> Any:
        """A call of any kind."""
        if node.keywords:
            raise Unknown(f"{ast.unparse(node)}: arguments by name")
        match node.func:
            case ast.Name(id=name):
                builtin = None if name in self.globals else getattr(self, f"call_{name}", None)
                arguments = tuple(self.value(a) for a in node.args)
                return builtin(*arguments) if builtin is not None else self.apply(self.thing(name), name, arguments)
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return self.mathematical(name, [self.value(a) for a in node.args])
            case ast.Attribute(value=ast.Name(id="np"), attr="float64" | "int64" as name):
                (argument,) = (self.value(a) for a in node.args)
                return Value(DOUBLE, self.double(argument)) if name == "float64" else self.call_int(argument)
            case ast.Attribute(value=inner, attr="view"):
                return self.view(self.value(inner), ast.unparse(node.args[0]))
        raise Unknown(f"{ast.unparse(node)}: a call")

    def view(self, value: Value, kind: str) -> Value:
        """The same bits as another type."""
        wanted = {"np.int64": WHOLE, "np.float64": DOUBLE}.get(kind)
        if wanted is None:
            raise Unknown(f"a view as {kind}")
        return self.let(wanted, f"bitcast {value.kind} {value.text} to {wanted}")

    def apply(self, what: Any, name: str, arguments: tuple[Any, ...]) -> Any:
        """A jitted function, or one of numba's own."""
        if what is np.uint64:
            return self.call_int(*arguments)
        if what is carray:
            return self.shaped(*arguments)
        if what is arithmetic.fma:
            a, b, c = map(self.double, arguments)
            return self.intrinsic("fma", a, b, c)
        if what is stack_array:
            return self.room(*arguments)
        if not (hasattr(what, "py_func") or inspect.isfunction(what)):
            raise Unknown(f"the function {name}")
        if not all(isinstance(a, Thing) or (isinstance(a, Value) and not a.stride.startswith("%")) for a in arguments):
            raise Unknown(f"{name} of tuples, or of rows whose length is not known beforehand")
        symbol, result = self.module.function(what, arguments)
        given = ", ".join(f"{a.kind} {a.text}" for a in arguments if isinstance(a, Value))
        if not result:
            self.emit(f"call void {symbol}({given})")
            return ()
        whole = self.let(result[0], f"call {returned(result)} {symbol}({given})")
        if len(result) == 1:
            return whole
        return tuple(
            self.let(kind, f"extractvalue {returned(result)} {whole.text}, {k}") for k, kind in enumerate(result)
        )

    def call_abs(self, u: Value) -> Value:
        """Size of a number."""
        return self.intrinsic("fabs", self.double(u))

    def call_max(self, *given: Value) -> Value:
        """As Python works it out: the first of equals, and nan only where it is the first."""
        return self.extreme("ogt", given)

    def call_min(self, *given: Value) -> Value:
        """As Python works it out, like `call_max`."""
        return self.extreme("olt", given)

    def call_int(self, u: Value) -> Value:
        """A number without its fraction."""
        return self.truncated(u)

    def call_float(self, u: Value) -> Value:
        """A whole number as one with a fraction."""
        return Value(DOUBLE, self.double(u))

    def shaped(self, rows: Value, shape: Any) -> Value:
        """A pointer that takes two indices."""
        if rows.kind != ROWS or not isinstance(shape, tuple) or len(shape) != 2:
            raise Unknown("carray of a shape that is no pair")
        return replace(rows, stride=shape[1].text)

    def room(self, size: Value) -> Value:
        """Numbers on the stack, of no certain value."""
        if not isinstance(size.known, int):
            raise Unknown("an array of a size that is not known beforehand")
        return Value(ROWS, self.slot(f"[{size.known} x double]"))
