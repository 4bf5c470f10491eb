"""Translate expressions of generated text to LLVM (see `statements`)."""

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
    BOOLEAN,
    DOUBLE,
    INTEGER,
    POINTER,
    Object,
    Operations,
    Unsupported,
    Value,
    constant,
    return_type,
    wider,
)

__all__ = ["Expressions"]

_ORDER = {
    ast.Lt: ("olt", "slt"), ast.LtE: ("ole", "sle"), ast.Gt: ("ogt", "sgt"), ast.GtE: ("oge", "sge"),
    ast.Eq: ("oeq", "eq"), ast.NotEq: ("une", "ne"),
}  # fmt: skip


class Expressions(Operations):
    """Translates each kind of expression to operations; the types of names are known when an expression is read."""

    def value(self, node: ast.expr) -> Any:
        """Translate an expression; returns a scalar, a pointer, or a tuple of them."""
        match node:
            case ast.Constant(value=bool() as number):
                return Value(BOOLEAN, str(number).lower())
            case ast.Constant(value=int() | float() as number):
                return constant(number)
            case ast.Name(id=name):
                return self.lookup(name)
            case ast.Tuple(elts=elements):
                return tuple(self.value(e) for e in elements)
            case ast.BinOp(left=left, op=op, right=right):
                return self.binary(op, self.value(left), self.value(right))
            case ast.UnaryOp(op=ast.Not()):
                return self.let(BOOLEAN, f"xor i1 {self.condition(node.operand).text}, true")
            case ast.UnaryOp(op=ast.USub()):
                return self.negative(self.value(node.operand))
            case ast.BoolOp():
                return self.boolean_operation(node)
            case ast.Compare():
                return self.comparison(node)
            case ast.IfExp():
                return self.conditional(node)
            case ast.Call():
                return self.call(node)
            case ast.Subscript():
                return self.subscript(node)
            case ast.Attribute(value=ast.Name(id="math"), attr="inf" | "nan" as name):
                return constant(getattr(math, name))
        raise Unsupported(f"{ast.unparse(node)}: an expression of the kind {type(node).__name__}")

    def lookup(self, name: str) -> Any:
        """Value of a name: a local variable, or an object of the function's module."""
        if name in self.bound:
            bound = self.bound[name]
            return tuple(self.lookup(f"{name}.{k}") for k in range(bound)) if isinstance(bound, int) else bound
        if name in self.kinds:
            if name not in self.places:  # assigned further below in a loop: by an earlier iteration
                self.places.add(name)
                self.stack.append(f"  %v.{name} = alloca {self.kinds[name]}")
            return self.let(self.kinds[name], f"load {self.kinds[name]}, ptr %v.{name}")
        return self.as_value(self.object(name), name)

    def object(self, name: str) -> Any:
        """Object of this name in the function's module."""
        if name not in self.globals:
            raise Unsupported(f"the name {name}")
        return self.globals[name]

    def as_value(self, what: Any, name: str) -> Any:
        """An object of the function's module as a value."""
        if isinstance(what, int | float) and not isinstance(what, bool):
            return constant(what)
        if isinstance(what, np.ndarray) and what.ndim == 1 and what.dtype == np.float64:
            return Value(POINTER, self.module.table(what.tolist()))
        if isinstance(what, tuple):
            return Object(what)
        raise Unsupported(f"{name}, which is of the type {type(what).__name__}")

    def condition(self, node: ast.expr) -> Value:
        """Translate a condition."""
        value = self.value(node)
        if not (isinstance(value, Value) and value.kind == BOOLEAN):
            raise Unsupported(f"{ast.unparse(node)} as a condition")
        return value

    def boolean_operation(self, node: ast.BoolOp) -> Value:
        """Translate `and` and `or`; later operands are evaluated only if the earlier ones leave the result open."""
        place, after, both = self.slot(BOOLEAN), self.label(), isinstance(node.op, ast.And)
        for k, operand in enumerate(node.values):
            value = self.condition(operand)
            self.emit(f"store i1 {value.text}, ptr {place}")
            if k + 1 < len(node.values):
                following = self.label()
                self.branch(value, *((following, after) if both else (after, following)))
                self.lines.append(f"{following}:")
        self.begin(after)
        return self.let(BOOLEAN, f"load i1, ptr {place}")

    def comparison(self, node: ast.Compare) -> Value:
        """Translate a chain of comparisons, all of which are evaluated."""
        values = [self.value(e) for e in (node.left, *node.comparators)]
        found: Value | None = None
        for op, a, b in zip(node.ops, values, values[1:], strict=False):
            floating, whole = _ORDER.get(type(op), ("", ""))
            if not floating:
                raise Unsupported(f"the comparison {type(op).__name__}")
            if a.kind == b.kind == INTEGER or a.kind == b.kind == BOOLEAN:
                one = self.let(BOOLEAN, f"icmp {whole} {a.kind} {a.text}, {b.text}")
            else:
                one = self.let(BOOLEAN, f"fcmp {floating} double {self.double(a)}, {self.double(b)}")
            found = one if found is None else self.let(BOOLEAN, f"and i1 {found.text}, {one.text}")
        assert found is not None  # noqa: S101
        return found

    def conditional(self, node: ast.IfExp) -> Any:
        """Translate a conditional expression of values or tuples: only one branch is evaluated."""
        yes, no, after = self.label(), self.label(), self.label()
        self.branch(self.condition(node.test), yes, no)
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
        """Element of an array, or of a tuple."""
        if isinstance(node.value, ast.Name | ast.Subscript):
            base = self.value(node.value)
            if isinstance(base, Object | tuple):
                index = self.value(node.slice).known
                if index is None:
                    raise Unsupported(f"{ast.unparse(node)}: an index of a tuple that is not known at compile time")
                return base[index] if isinstance(base, tuple) else self.as_value(base.what[index], ast.unparse(node))
        return self.load(self.address(node))

    def address(self, node: ast.Subscript) -> str:
        """Address of an element of an array."""
        base, index = self.value(node.value), self.value(node.slice)
        if not (isinstance(base, Value) and base.kind == POINTER):
            raise Unsupported(f"{ast.unparse(node)}: not an array of numbers")
        parts = index if isinstance(index, tuple) else (index,)
        if any(part.kind != INTEGER for part in parts) or (len(parts) == 2) != bool(base.stride):
            raise Unsupported(f"{ast.unparse(node)}: not an index, or the wrong number of indices")
        place = parts[-1]
        if base.stride:
            row = self.binary(ast.Mult(), parts[0], Value(INTEGER, base.stride))
            place = self.binary(ast.Add(), row, parts[1])
        return self.element(base.text, place.text)

    def call(self, node: ast.Call) -> Any:
        """Translate a call."""
        if node.keywords:
            raise Unsupported(f"{ast.unparse(node)}: arguments by name")
        match node.func:
            case ast.Name(id=name):
                builtin = None if name in self.globals else getattr(self, f"call_{name}", None)
                arguments = tuple(self.value(a) for a in node.args)
                return builtin(*arguments) if builtin is not None else self.apply(self.object(name), name, arguments)
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return self.math_function(name, [self.value(a) for a in node.args])
            case ast.Attribute(value=ast.Name(id="np"), attr="float64" | "int64" as name):
                (argument,) = (self.value(a) for a in node.args)
                return Value(DOUBLE, self.double(argument)) if name == "float64" else self.call_int(argument)
            case ast.Attribute(value=inner, attr="view"):
                return self.view(self.value(inner), ast.unparse(node.args[0]))
        raise Unsupported(f"{ast.unparse(node)}: a call")

    def view(self, value: Value, kind: str) -> Value:
        """The same bits, read as another type."""
        wanted = {"np.int64": INTEGER, "np.float64": DOUBLE}.get(kind)
        if wanted is None:
            raise Unsupported(f"a view as {kind}")
        return self.let(wanted, f"bitcast {value.kind} {value.text} to {wanted}")

    def apply(self, what: Any, name: str, arguments: tuple[Any, ...]) -> Any:
        """Call a jitted function, or one with a translation of its own."""
        if what is np.uint64:
            return self.call_int(*arguments)
        if what is carray:
            return self.with_shape(*arguments)
        if what is arithmetic.fma:
            a, b, c = map(self.double, arguments)
            return self.intrinsic("fma", a, b, c)
        if what is stack_array:
            return self.allocate(*arguments)
        if not (hasattr(what, "py_func") or inspect.isfunction(what)):
            raise Unsupported(f"the function {name}")
        if not all(isinstance(a, Object) or (isinstance(a, Value) and not a.stride.startswith("%")) for a in arguments):
            raise Unsupported(
                f"{name} called with tuples, or with arrays whose row length is not known at compile time"
            )
        symbol, result = self.module.function(what, arguments)
        given = ", ".join(f"{a.kind} {a.text}" for a in arguments if isinstance(a, Value))
        if not result:
            self.emit(f"call void {symbol}({given})")
            return ()
        whole = self.let(result[0], f"call {return_type(result)} {symbol}({given})")
        if len(result) == 1:
            return whole
        return tuple(
            self.let(kind, f"extractvalue {return_type(result)} {whole.text}, {k}") for k, kind in enumerate(result)
        )

    def call_abs(self, u: Value) -> Value:
        """Absolute value."""
        return self.intrinsic("fabs", self.double(u))

    def call_max(self, *given: Value) -> Value:
        """Python's `max`: the first of equal numbers, and nan only if nan comes first."""
        return self.extremum("ogt", given)

    def call_min(self, *given: Value) -> Value:
        """Python's `min`, with the rules of `call_max`."""
        return self.extremum("olt", given)

    def call_int(self, u: Value) -> Value:
        """A number truncated to an integer."""
        return self.truncated(u)

    def call_float(self, u: Value) -> Value:
        """A number converted to floating point."""
        return Value(DOUBLE, self.double(u))

    def with_shape(self, rows: Value, shape: Any) -> Value:
        """A pointer that takes two indices, from `carray`."""
        if rows.kind != POINTER or not isinstance(shape, tuple) or len(shape) != 2:
            raise Unsupported("carray of a shape that is not a pair")
        return replace(rows, stride=shape[1].text)

    def allocate(self, size: Value) -> Value:
        """Allocate an uninitialised array on the stack."""
        if not isinstance(size.known, int):
            raise Unsupported("an array whose size is not known at compile time")
        return Value(POINTER, self.slot(f"[{size.known} x double]"))
