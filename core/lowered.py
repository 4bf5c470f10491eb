"""Expressions of generated text → LLVM (see `lowering`)."""

from __future__ import annotations

import ast
import inspect
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numba
import numpy as np

from core import doubled
from core.scratch import scratch

__all__ = [
    "DOUBLE",
    "RANK",
    "ROWS",
    "TRUTH",
    "WHOLE",
    "Expressions",
    "Thing",
    "Unknown",
    "Value",
    "bits",
    "number_of",
    "returned",
]

DOUBLE, WHOLE, TRUTH, ROWS = "double", "i64", "i1", "ptr"
RANK = {TRUTH: 0, WHOLE: 1, DOUBLE: 2}  #: a variable has the widest type of what it is given
_LARGEST_POWER = 0x10000  #: a whole exponent up to which a power is multiplied out

_FLOAT = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_INT = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and", ast.BitOr: "or", ast.LShift: "shl",
    ast.RShift: "ashr",
}  # fmt: skip
_ORDER = {
    ast.Lt: ("olt", "slt"), ast.LtE: ("ole", "sle"), ast.Gt: ("ogt", "sgt"), ast.GtE: ("oge", "sge"),
    ast.Eq: ("oeq", "eq"), ast.NotEq: ("une", "ne"),
}  # fmt: skip
_FOLDED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b, ast.Pow: lambda a, b: a**b,
}  # fmt: skip
#: Functions of `math` that LLVM has, and those of the C library.
_INTRINSICS = frozenset(("sqrt", "exp", "log", "sin", "cos", "pow"))
_LIBRARY = frozenset(("expm1", "log1p", "tan", "sinh", "cosh", "tanh"))


class Unknown(Exception):  # noqa: N818 - no error: numba compiles what is unknown here
    """A construct that is not among those that generated text is written in."""


@dataclass(frozen=True)
class Value:
    """A scalar or a pointer, in a register or a constant."""

    kind: str
    text: str
    stride: str = ""
    """Of the first index of a pointer that takes two: a number or a register."""
    known: Any = None
    """The number, where it is known beforehand."""


@dataclass(frozen=True)
class Thing:
    """What has a name and is no number: a function, a module, a table."""

    what: Any


def number_of(value: float) -> Value:
    """A constant."""
    return Value(WHOLE, str(value), known=value) if isinstance(value, int) else Value(DOUBLE, bits(value), known=value)


def bits(value: float) -> str:
    """Text of a floating-point number, to the last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def returned(kinds: Sequence[str]) -> str:
    """Type of what a function returns."""
    return "void" if not kinds else kinds[0] if len(kinds) == 1 else f"{{{', '.join(kinds)}}}"


def wider(a: Value, b: Value) -> str:
    """The kind that holds both."""
    return max(a.kind, b.kind, key=RANK.__getitem__)


class Expressions:
    """The lines written so far, and how each kind of expression is added to them."""

    def __init__(self, module: Any, names: dict[str, Any], kinds: dict[str, str]) -> None:
        self.module, self.globals, self.kinds = module, names, kinds
        self.numbers = count()
        self.stack: list[str] = []
        self.lines: list[str] = []
        self.bound: dict[str, Any] = {}
        self.places: set[str] = set()

    # Lines ------------------------------------------------------------------------------------------------------------

    def emit(self, line: str) -> None:
        self.lines.append(f"  {line}")

    def let(self, kind: str, operation: str) -> Value:
        name = f"%r{next(self.numbers)}"
        self.lines.append(f"  {name} = {operation}")
        return Value(kind, name)

    def label(self) -> str:
        return f"b{next(self.numbers)}"

    def begin(self, label: str) -> None:
        """Go on in the block of this label, from wherever one is."""
        self.emit(f"br label %{label}")
        self.lines.append(f"{label}:")

    def leave(self, line: str) -> None:
        """End the block; what follows in it is never reached."""
        self.emit(line)
        self.lines.append(f"{self.label()}:")

    def branch(self, condition: Value, yes: str, no: str) -> None:
        self.emit(f"br i1 {condition.text}, label %{yes}, label %{no}")

    def slot(self, kind: str) -> str:
        name = f"%s{next(self.numbers)}"
        self.stack.append(f"  {name} = alloca {kind}")
        return name

    # Expressions ------------------------------------------------------------------------------------------------------

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

    def cast(self, value: Value, kind: str) -> str:
        """Text of a value as one of a wider kind."""
        if not isinstance(value, Value):
            raise Unknown(f"a {type(value).__name__} in place of a number")
        if value.kind == kind:
            return value.text
        if kind == DOUBLE and value.known is not None:
            return bits(float(value.known))
        if value.kind == ROWS or RANK[kind] < RANK[value.kind]:
            raise Unknown(f"{value.kind} in place of {kind}")
        how = "sitofp" if value.kind == WHOLE else "uitofp" if kind == DOUBLE else "zext"
        return self.let(kind, f"{how} {value.kind} {value.text} to {kind}").text

    def double(self, value: Any) -> str:
        return self.cast(value, DOUBLE)

    def binary(self, op: ast.operator, a: Any, b: Any) -> Value:
        if not (isinstance(a, Value) and isinstance(b, Value)):
            raise Unknown(f"{type(op).__name__} of what are no numbers")
        if a.known is not None and b.known is not None and type(op) in _FOLDED:
            return number_of(_FOLDED[type(op)](a.known, b.known))
        if isinstance(op, ast.Pow):
            return self.power(a, b)
        if a.kind == b.kind == WHOLE and not isinstance(op, ast.Div):
            if isinstance(op, ast.Mod):
                return self.whole_remainder(a, b)
            if isinstance(op, ast.FloorDiv):
                even = self.let(WHOLE, f"sub i64 {a.text}, {self.whole_remainder(a, b).text}").text
                return self.let(WHOLE, f"sdiv i64 {even}, {b.text}")
            if type(op) in _INT:
                return self.let(WHOLE, f"{_INT[type(op)]} i64 {a.text}, {b.text}")
        if isinstance(op, ast.Mod):
            return self.remainder(self.double(a), self.double(b))
        if type(op) in _FLOAT:
            return self.let(DOUBLE, f"{_FLOAT[type(op)]} double {self.double(a)}, {self.double(b)}")
        raise Unknown(f"{type(op).__name__} of {a.kind} and {b.kind}")

    def power(self, a: Value, b: Value) -> Value:
        base = self.double(a)
        if not isinstance(b.known, int) or abs(b.known) > _LARGEST_POWER:
            return self.intrinsic("pow", base, self.double(b))
        n, product, square = abs(b.known), bits(1.0), base
        while n:
            if n & 1:
                product = self.let(DOUBLE, f"fmul double {product}, {square}").text
            n >>= 1
            if n:
                square = self.let(DOUBLE, f"fmul double {square}, {square}").text
        if b.known < 0:
            return self.let(DOUBLE, f"fdiv double {bits(1.0)}, {product}")
        return Value(DOUBLE, product)

    def remainder(self, a: str, b: str) -> Value:
        """Python's, which has the sign of b."""
        rest = self.let(DOUBLE, f"frem double {a}, {b}").text
        other, rounded = (self.let(TRUTH, f"fcmp olt double {u}, {bits(0.0)}").text for u in (b, rest))
        differs = self.let(TRUTH, f"xor i1 {other}, {rounded}").text
        left = self.let(TRUTH, f"fcmp une double {rest}, {bits(0.0)}").text
        both = self.let(TRUTH, f"and i1 {differs}, {left}").text
        moved = self.let(DOUBLE, f"fadd double {rest}, {b}").text
        return self.let(DOUBLE, f"select i1 {both}, double {moved}, double {rest}")

    def whole_remainder(self, a: Value, b: Value) -> Value:
        if not (isinstance(b.known, int) and b.known > 0):
            raise Unknown("a remainder of a division by what is no positive number")
        rest = self.let(WHOLE, f"srem i64 {a.text}, {b.text}").text
        below = self.let(TRUTH, f"icmp slt i64 {rest}, 0").text
        moved = self.let(WHOLE, f"add i64 {rest}, {b.text}").text
        return self.let(WHOLE, f"select i1 {below}, i64 {moved}, i64 {rest}")

    def negative(self, u: Value) -> Value:
        if u.known is not None:
            return number_of(-u.known)
        if u.kind == WHOLE:
            return self.let(WHOLE, f"sub i64 0, {u.text}")
        return self.let(DOUBLE, f"fneg double {self.double(u)}")

    def truth(self, node: ast.expr) -> Value:
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

    # Rows of numbers --------------------------------------------------------------------------------------------------

    def subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Name | ast.Subscript):
            base = self.value(node.value)
            if isinstance(base, Thing | tuple):
                index = self.value(node.slice).known
                if index is None:
                    raise Unknown(f"{ast.unparse(node)}: one of several values, not known beforehand which")
                return base[index] if isinstance(base, tuple) else self.known(base.what[index], ast.unparse(node))
        return self.load(self.address(node))

    def load(self, address: str) -> Value:
        return self.let(DOUBLE, f"load double, ptr {address}")

    def element(self, base: str, index: str) -> str:
        return self.let(ROWS, f"getelementptr inbounds double, ptr {base}, i64 {index}").text

    def address(self, node: ast.Subscript) -> str:
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

    # Calls ------------------------------------------------------------------------------------------------------------

    def call(self, node: ast.Call) -> Any:
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
        if what is numba.carray:
            return self.shaped(*arguments)
        if what is doubled.fma:
            a, b, c = map(self.double, arguments)
            return self.intrinsic("fma", a, b, c)
        if what is scratch:
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
        return self.intrinsic("fabs", self.double(u))

    def call_max(self, *given: Value) -> Value:
        """As Python works it out: the first of equals, and nan only where it is the first."""
        return self.extreme("ogt", given)

    def call_min(self, *given: Value) -> Value:
        return self.extreme("olt", given)

    def extreme(self, order: str, given: Sequence[Value]) -> Value:
        best = self.double(given[0])
        for u in given[1:]:
            other = self.double(u)
            better = self.let(TRUTH, f"fcmp {order} double {other}, {best}").text
            best = self.let(DOUBLE, f"select i1 {better}, double {other}, double {best}").text
        return Value(DOUBLE, best)

    def call_int(self, u: Value) -> Value:
        return u if u.kind == WHOLE else self.let(WHOLE, f"fptosi double {self.double(u)} to i64")

    def call_float(self, u: Value) -> Value:
        return Value(DOUBLE, self.double(u))

    def shaped(self, rows: Value, shape: Any) -> Value:
        """A pointer that takes two indices."""
        if rows.kind != ROWS or not isinstance(shape, tuple) or len(shape) != 2:
            raise Unknown("carray of a shape that is no pair")
        return replace(rows, stride=shape[1].text)

    def room(self, size: Value) -> Value:
        """Numbers on the stack, of no certain value."""
        if not isinstance(size.known, int):
            raise Unknown("scratch of a size that is not known beforehand")
        return Value(ROWS, self.slot(f"[{size.known} x double]"))

    def intrinsic(self, name: str, *given: str) -> Value:
        symbol = f"@llvm.{name}.f64"
        self.module.declare(symbol, f"declare double {symbol}({', '.join(['double'] * len(given))})")
        return self.let(DOUBLE, f"call double {symbol}({', '.join(f'double {u}' for u in given)})")

    def mathematical(self, name: str, given: Sequence[Value]) -> Any:
        if name == "ldexp":
            return self.scaled(*given)
        texts = [self.double(u) for u in given]
        if name == "isfinite":
            size = self.intrinsic("fabs", *texts).text
            return self.let(TRUTH, f"fcmp one double {size}, {bits(math.inf)}")
        if name == "floor":
            return self.call_int(self.intrinsic("floor", *texts))
        if name == "frexp":
            return self.taken_apart(*texts)
        if name in _INTRINSICS:
            return self.intrinsic(name, *texts)
        if name in _LIBRARY:
            self.module.declare(f"@{name}", f"declare double @{name}(double)")
            return self.let(DOUBLE, f"call double @{name}(double {texts[0]})")
        raise Unknown(f"math.{name}")

    def scaled(self, u: Value, power: Value) -> Value:
        self.module.declare("@ldexp", "declare double @ldexp(double, i32)")
        exponent = self.let("", f"trunc i64 {power.text} to i32").text
        return self.let(DOUBLE, f"call double @ldexp(double {self.double(u)}, i32 {exponent})")

    def taken_apart(self, u: str) -> tuple[Value, Value]:
        self.module.declare("@frexp", "declare double @frexp(double, ptr)")
        place = self.slot("i32")
        fraction = self.let(DOUBLE, f"call double @frexp(double {u}, ptr {place})")
        exponent = self.let("", f"load i32, ptr {place}").text
        return fraction, self.let(WHOLE, f"sext i32 {exponent} to i64")
