"""Compile LLVM's text to machine code, cached beside the source file of the function like numba's own cache."""

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
from core.llvm.operations import Unsupported
from core.llvm.statements import lowered

__all__ = ["Native", "native"]

_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, ctypes.c_double, *(ctypes.POINTER(ctypes.c_double),) * 3)
_SPEED = 3  #: LLVM's optimisation level, the same as numba's
_lock = threading.Lock()


class Native:
    """A compiled function of the signature of `abi`.

    Attributes
    ----------
    address
        Address of its machine code.
    ctypes
        The function as a ctypes object, for calls from Python.
    cache_hits
        1 if it was loaded from the cache, 0 if it was compiled.
    """

    def __init__(self, code: bytes, symbol: str, cache_hits: int) -> None:
        # An engine frees its target machine with itself, so each needs its own.
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _new_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address, self.cache_hits = int(self._engine.get_function_address(symbol)), cache_hits
        self.ctypes = _PROTOTYPE(self.address)


def native(function: Any) -> Any:
    """Compile a function of generated text, or load its machine code from the cache.

    Functions that `statements` cannot translate are compiled by numba, with the same results, in twenty times the time.
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
        except Unsupported:
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
    """Key of the processor and the compiler: machine code may not run on another processor."""
    features = llvm.get_host_cpu_features().flatten()
    parts = (llvm.get_process_triple(), llvm.get_host_cpu_name(), features, llvmlite.__version__)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:12]


@lru_cache(maxsize=1)
def _machine() -> Any:
    """Target machine for compiling, shared by all functions."""
    return _new_machine()


def _new_machine() -> Any:
    """New target machine for this processor, with the options that numba uses."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    triple = llvm.get_process_triple()
    reloc = "static" if triple.startswith(("x86", "i686")) else "default"
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_SPEED, reloc=reloc,
        codemodel="jitdefault", jit=True,
    )  # fmt: skip


def _code(text: str) -> bytes:
    """Optimise a module and compile it to machine code."""
    machine = _machine()
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = llvm.get_process_triple(), str(machine.target_data)
    module.verify()
    tuning = llvm.create_pipeline_tuning_options(speed_level=_SPEED)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))
