"""Translate generated text to LLVM: only the subset of Python in which it is written.

numba takes some milliseconds for a line, most of them for type inference, and a step of sixteen variables has
thousands of lines. Generated text has only three scalar types (floating-point numbers, 64-bit integers, truth values)
and pointers to floating-point numbers, known as the lines are read. Operations and their order are numba's, so that
results agree to the last bit.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from core.llvm.expressions import Expressions
from core.llvm.operations import (
    BOOLEAN,
    DOUBLE,
    INTEGER,
    POINTER,
    RANK,
    Object,
    Unsupported,
    Value,
    bits,
    constant,
    return_type,
)

__all__ = ["lowered"]

#: Types of the arguments (t, h, p, w, scratch) of a function of `abi`, which returns an integer.
_ENTRY = (DOUBLE, DOUBLE, POINTER, POINTER, POINTER)


@dataclass
class _Module:
    """A module: the functions and tables that a function needs, each once."""

    symbol: str
    parts: list[str] = field(default_factory=list)
    declared: dict[str, str] = field(default_factory=dict)
    functions: dict[tuple[Any, ...], tuple[str, Any]] = field(default_factory=dict)
    tables: dict[Any, str] = field(default_factory=dict)

    def declare(self, name: str, line: str) -> None:
        self.declared[name] = line

    def table(self, numbers: Sequence[float]) -> str:
        """Pointer to a table of constants."""
        key = tuple(map(bits, numbers))
        if key not in self.tables:
            name = self.tables[key] = f"@table{len(self.tables)}"
            body = ", ".join(f"double {bits}" for bits in key)
            self.parts.append(f"{name} = private unnamed_addr constant [{len(key)} x double] [{body}]")
        return self.tables[key]

    def function(self, what: Any, arguments: Sequence[Value | Object]) -> tuple[str, Any]:
        """Name and result kinds of a function for arguments of these kinds.

        A function that is not jitted is compiled anew for all values of integer arguments known at compile time, which
        are sizes of arrays.
        """
        python = getattr(what, "py_func", what)
        if python is not what:
            arguments = [replace(a, known=None) if isinstance(a, Value) else a for a in arguments]
        key = (python, *((a.kind, a.stride, a.known) if isinstance(a, Value) else a for a in arguments))
        if key not in self.functions:
            name = f"@{python.__name__}.{len(self.functions)}"
            lines, result = _Function.read(self, python, name, arguments)
            self.parts.append(lines)
            self.functions[key] = name, result
        return self.functions[key]


def lowered(function: Any, symbol: str) -> str:
    """Text of an LLVM module with one function of the signature of `abi` and all functions that it calls.

    Parameters
    ----------
    function
        A Python function of t, h, p, w, scratch; the functions that it calls are jitted, or could be.
    symbol
        Its name in the module.

    Raises
    ------
    Unsupported
        Naming a construct that cannot be translated.
    """
    module = _Module(symbol)
    arguments = [Value(kind, "") for kind in _ENTRY]
    lines, result = _Function.read(module, function, f"@{symbol}", arguments, entry=True)
    if result != (INTEGER,):
        raise Unsupported(f"{function.__name__} returns {result}, not an integer")
    return "\n".join([*module.parts, *module.declared.values(), lines])


class WiderType(Exception):  # noqa: N818
    """A variable needs a wider type than assumed so far: its function is read again."""


@lru_cache(maxsize=1024)
def _tree(function: Any) -> ast.FunctionDef:
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(tree, ast.FunctionDef)  # noqa: S101 - numba compiles no other source
    return tree


class _Function(Expressions):
    """One function, read line by line; variables are allocated on the stack, and LLVM moves them to registers."""

    def __init__(
        self, module: _Module, function: Any, arguments: Sequence[Value | Object], kinds: dict[str, str]
    ) -> None:
        super().__init__(module, function.__globals__, kinds)
        self.tree = _tree(function)
        self.loops: list[tuple[str, str]] = []
        self.result: tuple[str, ...] | None = None
        parameters = [a.arg for a in self.tree.args.args]
        if len(parameters) != len(arguments):
            raise Unsupported(f"{self.tree.name} takes {len(parameters)} arguments, here it has {len(arguments)}")
        self.parameters: list[Value] = []
        for name, value in zip(parameters, arguments, strict=True):
            self.bind_argument(name, value)

    @classmethod
    def read(
        cls, module: _Module, function: Any, name: str, arguments: Sequence[Value | Object], entry: bool = False
    ) -> tuple[str, tuple[str, ...]]:
        """Text of a function, and the kinds of its results."""
        kinds: dict[str, str] = {}
        while True:
            try:
                reader = cls(module, function, arguments, kinds)
                reader.block(reader.tree.body)
                break
            except WiderType:
                continue
        result = reader.result or ()
        given = ", ".join(f"{a.kind}{' noalias' * (a.kind == POINTER and entry)} {a.text}" for a in reader.parameters)
        head = f"define {'' if entry else 'internal '}{return_type(result)} {name}({given}) {{"
        end = "unreachable" if result else "ret void"
        body = [head, *reader.stack, *reader.lines, f"  {end}", "}"]
        return "\n".join(body), result

    def bind_argument(self, name: str, value: Value | Object) -> None:
        """Bind an argument; constants that the function is compiled for are no parameters."""
        if isinstance(value, Object):
            self.bound[name] = value
            return
        self.parameters.append(replace(value, text=f"%arg.{name}"))
        if isinstance(value.known, int):
            self.bound[name] = constant(value.known)
        else:
            self.assign_name(name, self.parameters[-1])

    # Statements -------------------------------------------------------------------------------------------------------

    def block(self, body: Sequence[ast.stmt]) -> None:
        for statement in body:
            handler = getattr(self, f"do_{type(statement).__name__}", None)
            if handler is None:
                raise Unsupported(f"a statement of the kind {type(statement).__name__}")
            handler(statement)

    def do_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):  # a docstring
            self.value(node.value)

    def do_Assign(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)

    def do_AugAssign(self, node: ast.AugAssign) -> None:
        read = ast.parse(ast.unparse(node.target), mode="eval").body
        self.assign(node.target, self.binary(node.op, self.value(read), self.value(node.value)))

    def assign(self, target: ast.expr, value: Any) -> None:
        match target:
            case ast.Name(id=name):
                self.assign_name(name, value)
            case ast.Tuple(elts=targets) if isinstance(value, tuple) and len(value) == len(targets):
                for each, part in zip(targets, value, strict=True):
                    self.assign(each, part)
            case ast.Subscript():
                self.emit(f"store double {self.double(value)}, ptr {self.address(target)}")
            case _:
                raise Unsupported(f"an assignment to {ast.unparse(target)}")

    def assign_name(self, name: str, value: Any) -> None:
        if isinstance(value, tuple):
            for k, part in enumerate(value):
                self.assign_name(f"{name}.{k}", part)
            value = len(value)
        if not isinstance(value, Value) or value.kind == POINTER or name in self.bound:
            if self.bound.setdefault(name, value) != value:
                raise Unsupported(f"{name}, which has two meanings")
            return
        kind = self.kinds.setdefault(name, value.kind)
        if RANK[value.kind] > RANK[kind]:
            self.kinds[name] = value.kind
            raise WiderType
        if name not in self.places:
            self.places.add(name)
            self.stack.append(f"  %v.{name} = alloca {kind}")
        self.emit(f"store {kind} {self.cast(value, kind)}, ptr %v.{name}")

    def do_If(self, node: ast.If) -> None:
        yes, no, after = self.label(), self.label(), self.label()
        self.branch(self.condition(node.test), yes, no)
        for label, body in ((yes, node.body), (no, node.orelse)):
            self.lines.append(f"{label}:")
            self.block(body)
            self.emit(f"br label %{after}")
        self.lines.append(f"{after}:")

    def do_While(self, node: ast.While) -> None:
        head, inner, other, after = (self.label() for _ in range(4))
        self.begin(head)
        self.branch(self.condition(node.test), inner, other)
        self.lines.append(f"{inner}:")
        self.loop(node, head, other, after)

    def loop(self, node: ast.While | ast.For, head: str, other: str, after: str) -> None:
        """Translate the body of a loop, and its `else` clause."""
        self.loops.append((head, after))
        self.block(node.body)
        self.loops.pop()
        self.emit(f"br label %{head}")
        self.lines.append(f"{other}:")
        self.block(node.orelse)
        self.begin(after)

    def do_For(self, node: ast.For) -> None:
        counter, (first, last, step), value_at = self.slot(INTEGER), *self.iterated(node.iter)
        head, inner, other, after = (self.label() for _ in range(4))
        self.emit(f"store i64 {first}, ptr {counter}")
        self.begin(head)
        k = self.let(INTEGER, f"load i64, ptr {counter}")
        order = "slt" if step > 0 else "sgt"
        self.branch(self.let(BOOLEAN, f"icmp {order} i64 {k.text}, {last}"), inner, other)
        self.lines.append(f"{inner}:")
        self.emit(f"store i64 {self.let(INTEGER, f'add i64 {k.text}, {step}').text}, ptr {counter}")
        self.assign(node.target, value_at(k))
        self.loop(node, head, other, after)

    def iterated(self, node: ast.expr) -> tuple[tuple[str, str, int], Callable[[Value], Any]]:
        """First value, end (excluded) and step of the counter of a loop, and the loop variable as a function of it."""
        match node:
            case ast.Call(func=ast.Name(id="range"), args=arguments):
                values = [self.value(a) for a in arguments]
                if len(values) == 1:
                    values = [constant(0), *values]
                step = values[2].known if len(values) == 3 else 1
                if not isinstance(step, int) or any(v.kind != INTEGER for v in values):
                    raise Unsupported(f"a loop over {ast.unparse(node)}")
                return (values[0].text, values[1].text, step), lambda k: k
            case ast.Tuple(elts=elements):
                numbers = [self.value(e) for e in elements]
                if any(n.known is None for n in numbers):
                    raise Unsupported(f"a loop over {ast.unparse(node)}")
                table = self.module.table([float(n.known) for n in numbers])
                return ("0", str(len(numbers)), 1), lambda k: self.load(self.element(table, k.text))
        raise Unsupported(f"a loop over {ast.unparse(node)}")

    def do_Break(self, _: ast.Break) -> None:
        self.leave(f"br label %{self.loops[-1][1]}")

    def do_Continue(self, _: ast.Continue) -> None:
        self.leave(f"br label %{self.loops[-1][0]}")

    def do_Pass(self, _: ast.Pass) -> None:
        pass

    def do_Return(self, node: ast.Return) -> None:
        values = () if node.value is None else self.value(node.value)
        values = values if isinstance(values, tuple) else (values,)
        kinds = tuple(v.kind for v in values)
        self.result = self.result or kinds
        if self.result != kinds:
            raise Unsupported(f"{self.tree.name} returns {self.result} and {kinds}")
        if len(values) < 2:
            self.leave(f"ret {kinds[0]} {values[0].text}" if values else "ret void")
            return
        whole = "undef"
        for k, v in enumerate(values):
            whole = self.let("", f"insertvalue {return_type(kinds)} {whole}, {v.kind} {v.text}, {k}").text
        self.leave(f"ret {return_type(kinds)} {whole}")
