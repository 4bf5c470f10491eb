"""Laws and methods → compiled functions, kept in memory and on disk.

The text of a module is written to the user's cache folder under a name made of its contents, and imported from there:
so numba can keep the machine code beside it, and a second process loads it instead of compiling. After
`compile_beside`, other processes do the compiling, and this one always loads.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from concurrent.futures import wait
from functools import lru_cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from core.codegen.functions import (
    evaluate_switching_text,
    jump_text,
    levels_texts,
    module_text,
    project_to_surface_text,
)
from core.codegen.step import StepCode
from core.compilation.worker_pool import Workshop, serve
from core.interface.arguments import count, number
from core.kernels.abi import FUNCTIONS
from core.kernels.digest import imported_modules, source_digest
from core.methods import Method
from core.methods.taylor_step import prepare_step_text
from core.symbolic.laws import Laws

__all__ = ["Compiled", "compile_beside", "compile_run"]

MAX_MODULES = 200  #: kept in memory
MAX_FILES = 1000  #: kept on disk
MAX_REGISTERED = 50  #: kept in `sys.modules`

_PATIENCE = 120.0  #: seconds to wait for other processes; then what they have not compiled is compiled here

_lock = threading.RLock()
_registered: dict[str, None] = {}
_workshop: Workshop | None = None


class Compiled(NamedTuple):
    """The compiled functions of a system and method."""

    addresses: NDArray[np.int64]
    """(modes, functions) in the order of `abi.FUNCTIONS`; 0 where a run has no use for one."""
    modules: tuple[ModuleType, ...]
    """What keeps their machine code alive."""


@lru_cache(maxsize=MAX_MODULES)
def compile_run(laws: Laws, method: Method, levels: bool = False) -> Compiled:
    """Compile what a run of a method calls.

    Parameters
    ----------
    levels
        Also compile ψ, so that a run that does not conserve it can be monitored.
    """
    texts, given_out = [], []
    with _lock:
        for modes, text in _texts(laws, method, levels):
            texts.append((modes, text))
            if _workshop is not None and not _is_compiled(text):
                given_out.append(_workshop.begin(text))
    wait(filter(None, given_out), _PATIENCE)
    addresses, modules = np.zeros((len(laws.modes), len(FUNCTIONS)), dtype=np.int64), []
    for modes, text in texts:
        with _lock:
            module = _load(text)
        modules.append(module)
        for k, name in enumerate(FUNCTIONS):
            if hasattr(module, name):
                addresses[modes, k] = getattr(module, name).address
    return Compiled(addresses, tuple(modules))


def compile_beside(size: int = 2, idle: float = 900.0) -> None:
    """Have what is yet to be compiled compiled in other processes, from when they are ready on.

    Two of them are done with a system of eight variables in two thirds of the time. They take 250 MB each, are ready
    after some seconds, and end with this one.

    Parameters
    ----------
    size
        How many of them; one more than there are processors has no use.
    idle
        Seconds without anything to compile after which they end, too; called once more, this begins others.

    Raises
    ------
    ValueError
        If there is no such number of processes, or of seconds.
    """
    global _workshop
    size, idle = count(size, "size"), number(idle, "idle")
    if not idle > 0:
        raise ValueError(f"idle = {idle!r}: a positive number of seconds is needed")
    with _lock:
        if _workshop is not None and not _workshop.closed:
            _workshop.keep()
        else:
            roots = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH")]))
            environment = {"PWSVIZ_CACHE": str(_folder()), "PYTHONPATH": roots}
            program = "from core.compilation.compiled import serve_workshop; serve_workshop()"
            _workshop = Workshop(program, environment, min(size, os.cpu_count() or 1), idle)


def serve_workshop() -> None:
    """Compile what comes in, in a process of its own."""
    serve(_load)


def _texts(laws: Laws, method: Method, levels: bool) -> Iterator[tuple[int | list[int], str]]:
    """Texts of modules, each with the mode or the modes that it is of; what takes longest to compile first."""
    sides = tuple(laws.modes.values())
    codes = [(side, StepCode(laws, side)) for side in sides]
    yield from enumerate(module_text([code.text(method.scheme.write(side, code))]) for side, code in codes)
    if method.adaptive:
        yield from enumerate(module_text([prepare_step_text(laws, side)]) for side in sides)
    yield from enumerate(module_text([project_to_surface_text(laws, side, method.conservative)]) for side in sides)
    if method.conservative or levels:
        yield from enumerate(module_text(levels_texts(laws, side)) for side in sides)
    yield list(range(len(sides))), module_text([evaluate_switching_text(laws), jump_text(laws)])


def _is_compiled(text: str) -> bool:
    """Whether machine code of all functions of a text is kept on disk."""
    path = _path(text)
    return len(list(path.parent.glob(f"__pycache__/{path.stem}.*.o"))) >= text.count("@native")


@lru_cache(maxsize=MAX_MODULES)
def _load(text: str) -> ModuleType:
    """Import a module of generated text from the cache folder."""
    path = _path(text)
    if not _stands(path, text):
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
        _prune(path.parent)
    return _import(path)


def _import(path: Path) -> ModuleType:
    """Import a module of generated text; numba compiles it, or loads what it has kept."""
    module = ModuleType(path.stem)  # without the file's name: it is none of those that a user works on
    _register(module)
    SourceFileLoader(path.stem, str(path)).exec_module(module)
    return module


def _path(text: str) -> Path:
    sources = source_digest(*imported_modules(text))  # of what is inlined, and of what makes machine code
    key = hashlib.sha256("\0".join((text, sources, numba.__version__, sys.version)).encode()).hexdigest()[:32]
    return _folder() / f"pws_{key}.py"


def _register(module: ModuleType) -> None:
    """Let numba find a module, where it looks for a cached function's globals, while it is being loaded.

    The last ones stay: other threads that look through `sys.modules` meanwhile find nothing gone that was just there.
    """
    sys.modules[module.__name__] = module
    _registered.pop(module.__name__, None)
    _registered[module.__name__] = None  # as the last
    if len(_registered) > MAX_REGISTERED:
        first = next(iter(_registered))
        del _registered[first]
        sys.modules.pop(first, None)  # the functions keep it alive for as long as they are needed


def _stands(path: Path, text: str) -> bool:
    """Whether a file has this text; it is then the last that another process would drop."""
    try:
        os.utime(path)
        return path.read_text(encoding="utf-8") == text
    except FileNotFoundError:
        return False


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
    """Drop the modules not used for longest, and their machine code, beyond `MAX_FILES`."""
    modules = sorted(folder.glob("pws_*.py"), key=_last_used)
    for path in modules[:-MAX_FILES]:
        for file in (path, *folder.glob(f"__pycache__/{path.stem}.*")):
            file.unlink(missing_ok=True)


def _last_used(path: Path) -> float:
    """When a file was last used; long ago where another process has dropped it meanwhile."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0
