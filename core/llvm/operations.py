"""Operations on numbers, as lines of LLVM's language."""

from __future__ import annotations

import ast
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

__all__ = [
    "DOUBLE",
    "RANK",
    "ROWS",
    "TRUTH",
    "WHOLE",
    "Operations",
    "Thing",
    "Unknown",
    "Value",
    "bits",
    "number_of",
    "returned",
    "wider",
]

DOUBLE, WHOLE, TRUTH, ROWS = "double", "i64", "i1", "ptr"
RANK = {TRUTH: 0, WHOLE: 1, DOUBLE: 2}  #: a variable has the widest type of what it is given
_LARGEST_POWER = 0x10000  #: a whole exponent up to which a power is multiplied out

_FLOAT = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_INT = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and", ast.BitOr: "or", ast.LShift: "shl",
    ast.RShift: "ashr",
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


class Operations:
    """The lines written so far, and how an operation is added to them; registers are numbered as they come."""

    def __init__(self, module: Any, names: dict[str, Any], kinds: dict[str, str]) -> None:
        self.module, self.globals, self.kinds = module, names, kinds
        self.numbers = count()
        self.stack: list[str] = []
        self.lines: list[str] = []
        self.bound: dict[str, Any] = {}
        self.places: set[str] = set()

    def emit(self, line: str) -> None:
        """Write a line."""
        self.lines.append(f"  {line}")

    def let(self, kind: str, operation: str) -> Value:
        """Write an operation, whose result goes to a new register."""
        name = f"%r{next(self.numbers)}"
        self.lines.append(f"  {name} = {operation}")
        return Value(kind, name)

    def label(self) -> str:
        """A new name for a block."""
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
        """Go on in one of two blocks."""
        self.emit(f"br i1 {condition.text}, label %{yes}, label %{no}")

    def slot(self, kind: str) -> str:
        """Room for one value on the stack."""
        name = f"%s{next(self.numbers)}"
        self.stack.append(f"  {name} = alloca {kind}")
        return name

    def load(self, address: str) -> Value:
        """The number at an address."""
        return self.let(DOUBLE, f"load double, ptr {address}")

    def element(self, base: str, index: str) -> str:
        """The address of one of several numbers."""
        return self.let(ROWS, f"getelementptr inbounds double, ptr {base}, i64 {index}").text

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
        """Text of a value as a floating-point number."""
        return self.cast(value, DOUBLE)

    def binary(self, op: ast.operator, a: Any, b: Any) -> Value:
        """An operation on two numbers, as Python writes it."""
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
        """A power; whole ones known beforehand are multiplied out, as numba does it."""
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
        """Python's, by a positive number."""
        if not (isinstance(b.known, int) and b.known > 0):
            raise Unknown("a remainder of a division by what is no positive number")
        rest = self.let(WHOLE, f"srem i64 {a.text}, {b.text}").text
        below = self.let(TRUTH, f"icmp slt i64 {rest}, 0").text
        moved = self.let(WHOLE, f"add i64 {rest}, {b.text}").text
        return self.let(WHOLE, f"select i1 {below}, i64 {moved}, i64 {rest}")

    def truncated(self, u: Value) -> Value:
        """A number without its fraction."""
        return u if u.kind == WHOLE else self.let(WHOLE, f"fptosi double {self.double(u)} to i64")

    def negative(self, u: Value) -> Value:
        """A number with the other sign."""
        if u.known is not None:
            return number_of(-u.known)
        if u.kind == WHOLE:
            return self.let(WHOLE, f"sub i64 0, {u.text}")
        return self.let(DOUBLE, f"fneg double {self.double(u)}")

    def extreme(self, order: str, given: Sequence[Value]) -> Value:
        """The first of numbers that no other one is beyond."""
        best = self.double(given[0])
        for u in given[1:]:
            other = self.double(u)
            better = self.let(TRUTH, f"fcmp {order} double {other}, {best}").text
            best = self.let(DOUBLE, f"select i1 {better}, double {other}, double {best}").text
        return Value(DOUBLE, best)

    def intrinsic(self, name: str, *given: str) -> Value:
        """A function that LLVM knows itself."""
        symbol = f"@llvm.{name}.f64"
        self.module.declare(symbol, f"declare double {symbol}({', '.join(['double'] * len(given))})")
        return self.let(DOUBLE, f"call double {symbol}({', '.join(f'double {u}' for u in given)})")

    def mathematical(self, name: str, given: Sequence[Value]) -> Any:
        """A function of Python's module `math`."""
        if name == "ldexp":
            return self.scaled(*given)
        texts = [self.double(u) for u in given]
        if name == "isfinite":
            size = self.intrinsic("fabs", *texts).text
            return self.let(TRUTH, f"fcmp one double {size}, {bits(math.inf)}")
        if name == "floor":
            return self.truncated(self.intrinsic("floor", *texts))
        if name == "frexp":
            return self.taken_apart(*texts)
        if name in _INTRINSICS:
            return self.intrinsic(name, *texts)
        if name in _LIBRARY:
            self.module.declare(f"@{name}", f"declare double @{name}(double)")
            return self.let(DOUBLE, f"call double @{name}(double {texts[0]})")
        raise Unknown(f"math.{name}")

    def scaled(self, u: Value, power: Value) -> Value:
        """A number times a power of two."""
        self.module.declare("@ldexp", "declare double @ldexp(double, i32)")
        exponent = self.let("", f"trunc i64 {power.text} to i32").text
        return self.let(DOUBLE, f"call double @ldexp(double {self.double(u)}, i32 {exponent})")

    def taken_apart(self, u: str) -> tuple[Value, Value]:
        """Fraction and exponent of a number."""
        self.module.declare("@frexp", "declare double @frexp(double, ptr)")
        place = self.slot("i32")
        fraction = self.let(DOUBLE, f"call double @frexp(double {u}, ptr {place})")
        exponent = self.let("", f"load i32, ptr {place}").text
        return fraction, self.let(WHOLE, f"sext i32 {exponent} to i64")
