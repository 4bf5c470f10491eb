"""Operations on numbers, as lines of LLVM's intermediate representation."""

from __future__ import annotations

import ast
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

__all__ = [
    "BOOLEAN",
    "DOUBLE",
    "INTEGER",
    "POINTER",
    "RANK",
    "Object",
    "Operations",
    "Unsupported",
    "Value",
    "bits",
    "constant",
    "return_type",
    "wider",
]

#: LLVM's types, the kinds of values.
DOUBLE = "double"
INTEGER = "i64"
BOOLEAN = "i1"
POINTER = "ptr"  #: to floating-point numbers
RANK = {BOOLEAN: 0, INTEGER: 1, DOUBLE: 2}  #: a variable has the widest type of the values assigned to it
_LARGEST_POWER = 0x10000  #: integer exponents up to this size are expanded into products

_FLOAT = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_INT = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and", ast.BitOr: "or", ast.LShift: "shl",
    ast.RShift: "ashr",
}  # fmt: skip
_FOLDED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b, ast.Pow: lambda a, b: a**b,
}  # fmt: skip
#: Functions of `math` that are intrinsics of LLVM.
_INTRINSICS = frozenset(("sqrt", "exp", "log", "sin", "cos", "pow"))
#: Functions of `math` taken from the C library.
_LIBRARY = frozenset(("expm1", "log1p", "tan", "sinh", "cosh", "tanh"))


class Unsupported(Exception):  # noqa: N818 - no error: numba compiles the function instead
    """A construct outside the subset of Python that this compiler translates."""


@dataclass(frozen=True)
class Value:
    """A scalar or a pointer: a register or a constant."""

    kind: str
    text: str
    stride: str = ""
    """Stride of the first index of a pointer that takes two, a number or a register; else empty."""
    known: Any = None
    """The number, if it is known at compile time."""


@dataclass(frozen=True)
class Object:
    """An object of the function's module that is not a number: a function, a module, a table."""

    what: Any


def constant(value: float) -> Value:
    """A number as a value."""
    return (
        Value(INTEGER, str(value), known=value) if isinstance(value, int) else Value(DOUBLE, bits(value), known=value)
    )


def bits(value: float) -> str:
    """Text of a floating-point number: its exact bits."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def return_type(kinds: Sequence[str]) -> str:
    """LLVM's return type of a function with results of these kinds."""
    return "void" if not kinds else kinds[0] if len(kinds) == 1 else f"{{{', '.join(kinds)}}}"


def wider(a: Value, b: Value) -> str:
    """The kind that can hold both."""
    return max(a.kind, b.kind, key=RANK.__getitem__)


class Operations:
    """The lines of a function, to which operations are appended; registers are numbered in this order."""

    def __init__(self, module: Any, names: dict[str, Any], kinds: dict[str, str]) -> None:
        self.module, self.globals, self.kinds = module, names, kinds
        self.numbers = count()
        self.stack: list[str] = []
        self.lines: list[str] = []
        self.bound: dict[str, Any] = {}
        self.places: set[str] = set()

    def emit(self, line: str) -> None:
        """Append a line."""
        self.lines.append(f"  {line}")

    def let(self, kind: str, operation: str) -> Value:
        """Append an operation; returns its result, a new register."""
        name = f"%r{next(self.numbers)}"
        self.lines.append(f"  {name} = {operation}")
        return Value(kind, name)

    def label(self) -> str:
        """A new label for a block."""
        return f"b{next(self.numbers)}"

    def begin(self, label: str) -> None:
        """Branch to the block of this label, and begin it."""
        self.emit(f"br label %{label}")
        self.lines.append(f"{label}:")

    def leave(self, line: str) -> None:
        """End the block with this line; later lines go to a new block that is never reached."""
        self.emit(line)
        self.lines.append(f"{self.label()}:")

    def branch(self, condition: Value, yes: str, no: str) -> None:
        """Branch to one of two blocks."""
        self.emit(f"br i1 {condition.text}, label %{yes}, label %{no}")

    def slot(self, kind: str) -> str:
        """Allocate one value on the stack; returns its address."""
        name = f"%s{next(self.numbers)}"
        self.stack.append(f"  {name} = alloca {kind}")
        return name

    def load(self, address: str) -> Value:
        """The number at an address."""
        return self.let(DOUBLE, f"load double, ptr {address}")

    def element(self, base: str, index: str) -> str:
        """Address of an element of an array."""
        return self.let(POINTER, f"getelementptr inbounds double, ptr {base}, i64 {index}").text

    def cast(self, value: Value, kind: str) -> str:
        """Text of a value, converted to a wider kind."""
        if not isinstance(value, Value):
            raise Unsupported(f"a {type(value).__name__} in place of a number")
        if value.kind == kind:
            return value.text
        if kind == DOUBLE and value.known is not None:
            return bits(float(value.known))
        if value.kind == POINTER or RANK[kind] < RANK[value.kind]:
            raise Unsupported(f"{value.kind} in place of {kind}")
        how = "sitofp" if value.kind == INTEGER else "uitofp" if kind == DOUBLE else "zext"
        return self.let(kind, f"{how} {value.kind} {value.text} to {kind}").text

    def double(self, value: Any) -> str:
        """Text of a value, converted to a floating-point number."""
        return self.cast(value, DOUBLE)

    def binary(self, op: ast.operator, a: Any, b: Any) -> Value:
        """A binary operation, with the meaning it has in Python."""
        if not (isinstance(a, Value) and isinstance(b, Value)):
            raise Unsupported(f"{type(op).__name__} of operands that are not numbers")
        if a.known is not None and b.known is not None and type(op) in _FOLDED:
            return constant(_FOLDED[type(op)](a.known, b.known))
        if isinstance(op, ast.Pow):
            return self.power(a, b)
        if a.kind == b.kind == INTEGER and not isinstance(op, ast.Div):
            if isinstance(op, ast.Mod):
                return self.integer_remainder(a, b)
            if isinstance(op, ast.FloorDiv):
                even = self.let(INTEGER, f"sub i64 {a.text}, {self.integer_remainder(a, b).text}").text
                return self.let(INTEGER, f"sdiv i64 {even}, {b.text}")
            if type(op) in _INT:
                return self.let(INTEGER, f"{_INT[type(op)]} i64 {a.text}, {b.text}")
        if isinstance(op, ast.Mod):
            return self.remainder(self.double(a), self.double(b))
        if type(op) in _FLOAT:
            return self.let(DOUBLE, f"{_FLOAT[type(op)]} double {self.double(a)}, {self.double(b)}")
        raise Unsupported(f"{type(op).__name__} of {a.kind} and {b.kind}")

    def power(self, a: Value, b: Value) -> Value:
        """A power; integer exponents known at compile time are expanded into products, as by numba."""
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
        """Python's remainder, which has the sign of b."""
        rest = self.let(DOUBLE, f"frem double {a}, {b}").text
        other, rounded = (self.let(BOOLEAN, f"fcmp olt double {u}, {bits(0.0)}").text for u in (b, rest))
        differs = self.let(BOOLEAN, f"xor i1 {other}, {rounded}").text
        left = self.let(BOOLEAN, f"fcmp une double {rest}, {bits(0.0)}").text
        both = self.let(BOOLEAN, f"and i1 {differs}, {left}").text
        moved = self.let(DOUBLE, f"fadd double {rest}, {b}").text
        return self.let(DOUBLE, f"select i1 {both}, double {moved}, double {rest}")

    def integer_remainder(self, a: Value, b: Value) -> Value:
        """Python's remainder of integers, for a positive divisor."""
        if not (isinstance(b.known, int) and b.known > 0):
            raise Unsupported("a remainder whose divisor is not a positive constant")
        rest = self.let(INTEGER, f"srem i64 {a.text}, {b.text}").text
        below = self.let(BOOLEAN, f"icmp slt i64 {rest}, 0").text
        moved = self.let(INTEGER, f"add i64 {rest}, {b.text}").text
        return self.let(INTEGER, f"select i1 {below}, i64 {moved}, i64 {rest}")

    def truncated(self, u: Value) -> Value:
        """A number truncated to an integer."""
        return u if u.kind == INTEGER else self.let(INTEGER, f"fptosi double {self.double(u)} to i64")

    def negative(self, u: Value) -> Value:
        """The negative of a number."""
        if u.known is not None:
            return constant(-u.known)
        if u.kind == INTEGER:
            return self.let(INTEGER, f"sub i64 0, {u.text}")
        return self.let(DOUBLE, f"fneg double {self.double(u)}")

    def extremum(self, order: str, given: Sequence[Value]) -> Value:
        """The largest or smallest of numbers: each replaces the best before it if it compares better."""
        best = self.double(given[0])
        for u in given[1:]:
            other = self.double(u)
            better = self.let(BOOLEAN, f"fcmp {order} double {other}, {best}").text
            best = self.let(DOUBLE, f"select i1 {better}, double {other}, double {best}").text
        return Value(DOUBLE, best)

    def intrinsic(self, name: str, *given: str) -> Value:
        """Call an intrinsic function of LLVM."""
        symbol = f"@llvm.{name}.f64"
        self.module.declare(symbol, f"declare double {symbol}({', '.join(['double'] * len(given))})")
        return self.let(DOUBLE, f"call double {symbol}({', '.join(f'double {u}' for u in given)})")

    def math_function(self, name: str, given: Sequence[Value]) -> Any:
        """Call a function of Python's module `math`."""
        if name == "ldexp":
            return self.ldexp(*given)
        texts = [self.double(u) for u in given]
        if name == "isfinite":
            size = self.intrinsic("fabs", *texts).text
            return self.let(BOOLEAN, f"fcmp one double {size}, {bits(math.inf)}")
        if name == "floor":
            return self.truncated(self.intrinsic("floor", *texts))
        if name == "frexp":
            return self.frexp(*texts)
        if name in _INTRINSICS:
            return self.intrinsic(name, *texts)
        if name in _LIBRARY:
            self.module.declare(f"@{name}", f"declare double @{name}(double)")
            return self.let(DOUBLE, f"call double @{name}(double {texts[0]})")
        raise Unsupported(f"math.{name}")

    def ldexp(self, u: Value, power: Value) -> Value:
        """A number times a power of two."""
        self.module.declare("@ldexp", "declare double @ldexp(double, i32)")
        exponent = self.let("", f"trunc i64 {power.text} to i32").text
        return self.let(DOUBLE, f"call double @ldexp(double {self.double(u)}, i32 {exponent})")

    def frexp(self, u: str) -> tuple[Value, Value]:
        """Fraction and exponent of a number."""
        self.module.declare("@frexp", "declare double @frexp(double, ptr)")
        place = self.slot("i32")
        fraction = self.let(DOUBLE, f"call double @frexp(double {u}, ptr {place})")
        exponent = self.let("", f"load i32, ptr {place}").text
        return fraction, self.let(INTEGER, f"sext i32 {exponent} to i64")
