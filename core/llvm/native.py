"""LLVM's text → machine code, kept beside the file of the function, as numba keeps its own."""

# mypy: disable-error-code="no-untyped-call"
# llvmlite's functions have no types

from __future__ import annotations

import ctypes
import hashlib
import os
import threading
from functools import lru_cache
from pathlib import Path
from typing import Any

import llvmlite
from llvmlite import binding as llvm
from numba import cfunc

from core.kernels.abi import CALL
from core.llvm.operations import Unknown
from core.llvm.statements import lowered

__all__ = ["Native", "native"]

_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, ctypes.c_double, *(ctypes.POINTER(ctypes.c_double),) * 3)
_SPEED = 3  #: of LLVM's levels of optimisation the one that numba takes too
_lock = threading.Lock()


class Native:
    """A compiled function of the signature of `abi`.

    Attributes
    ----------
    address
        Where its machine code is.
    ctypes
        The function, to be called from Python.
    cache_hits
        1 if it was loaded, 0 if it was compiled here.
    """

    def __init__(self, code: bytes, symbol: str, cache_hits: int) -> None:
        # An engine frees its machine when it is freed: each has one of its own.
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _new_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address, self.cache_hits = int(self._engine.get_function_address(symbol)), cache_hits
        self.ctypes = _PROTOTYPE(self.address)


def native(function: Any) -> Any:
    """Compile a function of generated text, or load what was compiled of it before.

    What `statements` does not know, numba compiles: to the same numbers, in twenty times the time.
    """
    symbol = function.__name__
    path = _path(function)
    with _lock:
        try:
            return Native(path.read_bytes(), symbol, 1)
        except FileNotFoundError:
            pass
        try:
            code = _code(lowered(function, symbol))
        except Unknown:
            return cfunc(CALL, cache=True, error_model="numpy")(function)
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.parent.mkdir(exist_ok=True)
        partial.write_bytes(code)
        partial.replace(path)
        return Native(code, symbol, 0)


def _path(function: Any) -> Path:
    source = Path(function.__code__.co_filename)
    return source.parent / "__pycache__" / f"{source.stem}.{function.__name__}.{_target_name()}.o"


@lru_cache(maxsize=1)
def _target_name() -> str:
    """A name for the processor and the compiler, whose code another one may not run."""
    features = llvm.get_host_cpu_features().flatten()
    parts = (llvm.get_process_triple(), llvm.get_host_cpu_name(), features, llvmlite.__version__)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:12]


@lru_cache(maxsize=1)
def _machine() -> Any:
    """The processor at hand, to compile for."""
    return _new_machine()


def _new_machine() -> Any:
    """The processor at hand, told as numba tells LLVM of it."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    triple = llvm.get_process_triple()
    reloc = "static" if triple.startswith(("x86", "i686")) else "default"
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_SPEED, reloc=reloc,
        codemodel="jitdefault", jit=True,
    )  # fmt: skip


def _code(text: str) -> bytes:
    """Machine code of a module, optimised."""
    machine = _machine()
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = llvm.get_process_triple(), str(machine.target_data)
    module.verify()
    tuning = llvm.create_pipeline_tuning_options(speed_level=_SPEED)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))
