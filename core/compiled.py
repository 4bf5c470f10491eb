"""Laws and methods → compiled functions, kept in memory and on disk.

The text of a module is written to the user's cache folder under a name made of its contents, and imported from there:
so numba can keep the machine code beside it, and a second process loads it instead of compiling.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numba
import sympy

from core import arithmetic, divided
from core.codegen import StepCode, function_text, module_text, values_text
from core.laws import Laws
from core.methods import Method

__all__ = ["Steps", "Surface", "compile_steps", "compile_surface"]

MAX_MODULES = 200  #: kept in memory
MAX_FILES = 1000  #: kept on disk

_lock = threading.RLock()


class Steps(NamedTuple):
    """One step of a method on either side: `signatures.STEP`."""

    minus: Callable[..., Any]
    plus: Callable[..., Any]


class Surface(NamedTuple):
    """The switching surface: `signatures.SWITCHING`, `RATE` and `JUMP`."""

    switching: Callable[..., Any]
    rate: Callable[..., Any]
    jump: Callable[..., Any]


@lru_cache(maxsize=MAX_MODULES)
def compile_steps(laws: Laws, method: Method) -> Steps:
    """Compile a method's step for both sides."""
    with _lock:
        texts = []
        for side in (laws.sides[-1], laws.sides[1]):
            code = StepCode(laws, side)
            texts.append(code.text("step", method.build(side, code)))
        minus, plus = (_load(module_text([text])).step for text in texts)
    return Steps(minus, plus)


@lru_cache(maxsize=MAX_MODULES)
def compile_surface(laws: Laws) -> Surface:
    """Compile g, its rates with either field, and the jump (the identity where there is none)."""
    with _lock:
        module = _load(module_text([_switching_text(laws), _rate_text(laws), _jump_text(laws)]))
    return Surface(module.switching, module.rate, module.jump)


def _switching_text(laws: Laws) -> str:
    lines = values_text(laws, [laws.g], ["value"])
    return function_text("switching", "SWITCHING", "t, x, p", [*lines, "return value"])


def _rate_text(laws: Laws) -> str:
    lines = []
    for sign, condition in ((-1, "if side < 0:"), (1, "else:")):
        inner = values_text(laws, [laws.sides[sign].g_dot], ["value"])
        lines += [condition, *(f"    {line}" for line in inner)]
    return function_text("rate", "RATE", "side, t, x, p", [*lines, "return value"])


def _jump_text(laws: Laws) -> str:
    after: tuple[sympy.Expr, ...] = laws.jump if laws.jump is not None else laws.x
    lines = values_text(laws, after, [f"after[{k}]" for k in range(len(after))])
    return function_text("jump", "JUMP", "t, x, p, after", lines)


@lru_cache(maxsize=MAX_MODULES)
def _load(text: str) -> ModuleType:
    """Import a module of generated text from the cache folder."""
    # numba looks at a function's own file only: what it inlines from elsewhere has to be part of the name.
    inlined = "".join(Path(str(m.__file__)).read_text(encoding="utf-8") for m in (arithmetic, divided))
    key = hashlib.sha256("\0".join((text, inlined, numba.__version__, sys.version)).encode()).hexdigest()[:32]
    path = _folder() / f"pws_{key}.py"
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
        _prune(path.parent)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # where numba looks for a cached function's globals
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[path.stem]  # the functions keep it alive for as long as they are needed
    return module


@lru_cache(maxsize=1)
def _folder() -> Path:
    """A folder of ours for generated text: $PWSVIZ_CACHE, the user's cache, or else one for this process only."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("PWSVIZ_CACHE") or Path(home) / "pwsviz")
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        status = folder.stat()
        ours = not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o022)
        if ours and os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass  # a read-only home: the folder below serves
    return Path(tempfile.mkdtemp(prefix="pwsviz-"))


def _prune(folder: Path) -> None:
    """Drop the oldest modules, and their machine code, beyond `MAX_FILES`."""
    modules = sorted(folder.glob("pws_*.py"), key=lambda path: path.stat().st_mtime)
    for path in modules[:-MAX_FILES]:
        for file in (path, *folder.glob(f"__pycache__/{path.stem}.*")):
            file.unlink(missing_ok=True)
