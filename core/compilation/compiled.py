"""Compile laws and methods to functions, cached in memory and on disk.

The text of a module is written to the user's cache folder, under a name derived from its contents, and imported from
there. Its machine code is kept in the same folder, so that another process loads it instead of compiling. After
`compile_beside`, worker processes compile, and this one loads.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import threading
from concurrent.futures import wait
from contextlib import suppress
from functools import lru_cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.compilation.guards import guard_table
from core.compilation.texts import rows_of_events, texts_of_events, texts_of_modes
from core.compilation.worker_pool import WorkerPool, serve
from core.interface.arguments import count, number
from core.interface.under_way import compiling
from core.kernels.abi import FUNCTIONS, PREPARE, STEP
from core.kernels.digest import imported_modules, source_digest
from core.methods import Method
from core.symbolic.laws import Laws

__all__ = ["Compiled", "compile_beside", "compile_run", "modes_entered"]

MAX_MODULES = 200  #: modules kept in memory
MAX_FILES = 1000  #: modules kept on disk
MAX_REGISTERED = 50  #: modules kept in `sys.modules`
_TRIES = 5  #: of importing a module that other processes prune meanwhile

_PATIENCE = 120.0  #: seconds to wait for worker processes; then this process compiles the rest

_lock = threading.RLock()
_registered: dict[str, None] = {}
_pool: WorkerPool | None = None


class Compiled(NamedTuple):
    """The compiled functions of some modes of a system, for a method."""

    addresses: NDArray[np.int64]
    """(rows, functions) in the order of `abi.FUNCTIONS`, with one row for each guard of each mode, then one for each
    event function in each mode; 0 for functions that the run does not need, and for modes that are not compiled."""
    modules: tuple[ModuleType, ...]
    """The modules, which keep the machine code alive."""


@lru_cache(maxsize=MAX_MODULES)
def modes_entered(laws: Laws, method: Method, levels: bool = False) -> set[int]:
    """Numbers of the modes that runs have entered so far, to which theirs are added: the next run compiles them first.

    Of two regions nearly every run enters both.
    """
    return {0, 1} if len(laws.regions) == 2 else set()


@lru_cache(maxsize=MAX_MODULES)
def compile_run(
    laws: Laws, method: Method, levels: bool = False, modes: tuple[int, ...] = (0, 1), events: tuple[Expr, ...] = ()
) -> Compiled:
    """Compile the functions that a run of a method calls in some modes.

    Parameters
    ----------
    levels
        Also compile ψ, so that a run that does not conserve it can be monitored.
    modes
        Numbers of the modes.
    events
        Event functions.
    """
    table, texts, submitted = guard_table(laws), [], []
    with _lock:
        for rows, text in [*texts_of_modes(laws, method, levels, modes), *texts_of_events(laws, method, modes, events)]:
            texts.append((rows, text))
            if _pool is not None and not _is_compiled(text):
                submitted.append(_pool.submit(text))
    rows_in_all = len(table.guards) + laws.count * len(events)
    addresses = np.zeros((rows_in_all, len(FUNCTIONS)), dtype=np.int64)
    with compiling(method.name):
        wait(filter(None, submitted), _PATIENCE)
        modules = [_loaded(text) for _, text in texts]
    for (rows, _), module in zip(texts, modules, strict=True):
        for k, name in enumerate(FUNCTIONS):
            if hasattr(module, name):
                addresses[rows, k] = getattr(module, name).address
    for mode in modes if events else ():
        own = addresses[table.first_rows[mode]]
        for row in rows_of_events(laws, mode, events):
            addresses[row, [PREPARE, STEP]] = own[[PREPARE, STEP]]
    return Compiled(addresses, tuple(modules))


def compile_beside(size: int = 2, idle: float = 900.0) -> None:
    """Start worker processes, which compile all later systems once they are ready.

    Two workers compile a system of eight variables in two thirds of the time. They take 250 MB each, are ready after
    some seconds, and end with this process.

    Parameters
    ----------
    size
        Number of workers, at most the number of processors.
    idle
        Seconds without work after which they end; another call of this function starts new ones.

    Raises
    ------
    ValueError
        If `size` is not a positive integer, or `idle` not a positive number.
    """
    global _pool
    size, idle = count(size, "size"), number(idle, "idle")
    if not idle > 0:
        raise ValueError(f"idle = {idle!r}: a positive number of seconds is needed")
    with _lock:
        if _pool is not None and not _pool.closed:
            _pool.restart_timer()
        else:
            roots = os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]))
            environment = {"PWSVIZ_CACHE": str(_folder()), "PYTHONPATH": roots}
            program = "from core.compilation.compiled import serve_worker; serve_worker()"
            _pool = WorkerPool(program, environment, min(size, os.cpu_count() or 1), idle)


def serve_worker() -> None:
    """Run a worker process: compile the texts that it receives."""
    serve(_load)


def _is_compiled(text: str) -> bool:
    """Whether the machine code of all functions of a text is on disk."""
    path = _path(text)
    return len(list(path.parent.glob(f"__pycache__/{path.stem}.*.o"))) >= text.count("@native")


def _loaded(text: str) -> ModuleType:
    with _lock:
        return _load(text)


@lru_cache(maxsize=MAX_MODULES)
def _load(text: str) -> ModuleType:
    """Import a module of generated text from the cache folder.

    Another process may prune it between our mark that it is in use and the import: it is then written anew.
    """
    for _ in range(_TRIES):
        with suppress(FileNotFoundError):
            return _import(_written(text))
    return _import(_written(text))


def _written(text: str) -> Path:
    """The file of a generated text, written unless it is there."""
    path = _path(text)
    if not _touch_if_current(path, text):
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
        _prune(path.parent)
    return path


def _import(path: Path) -> ModuleType:
    """Import a module of generated text; its functions are compiled, or loaded from the cache."""
    module = ModuleType(path.stem)  # without __file__, so that tools do not take it for a user's source
    _register(module)
    SourceFileLoader(path.stem, str(path)).exec_module(module)
    return module


def _path(text: str) -> Path:
    sources = source_digest(*imported_modules(text))  # of inlined functions, and of the compiler
    key = hashlib.sha256("\0".join((text, sources, numba.__version__, sys.version)).encode()).hexdigest()[:32]
    return _folder() / f"pws_{key}.py"


def _register(module: ModuleType) -> None:
    """Add a module to `sys.modules`, where numba looks for the globals of a cached function while loading it.

    The latest modules stay, so that other threads which iterate over `sys.modules` do not find one gone.
    """
    sys.modules[module.__name__] = module
    _registered.pop(module.__name__, None)
    _registered[module.__name__] = None  # as the last
    if len(_registered) > MAX_REGISTERED:
        first = next(iter(_registered))
        del _registered[first]
        sys.modules.pop(first, None)  # the functions keep it alive for as long as they are needed


def _touch_if_current(path: Path, text: str) -> bool:
    """Whether a file has this text; marks it as just used, so that it is pruned last."""
    try:
        os.utime(path)
        return path.read_text(encoding="utf-8") == text
    except FileNotFoundError:
        return False


@lru_cache(maxsize=1)
def _folder() -> Path:
    """Folder for generated text: $PWSVIZ_CACHE, the user's cache, or else a temporary one for this process."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("PWSVIZ_CACHE") or Path(home) / "pwsviz")
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        status = folder.stat()
        ours = not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o022)
        if ours and os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass  # a read-only home
    return Path(tempfile.mkdtemp(prefix="pwsviz-"))


def _prune(folder: Path) -> None:
    """Delete the least recently used modules beyond `MAX_FILES`, with their machine code."""
    modules = sorted(folder.glob("pws_*.py"), key=_last_used)
    for path in modules[:-MAX_FILES]:
        for file in (path, *folder.glob(f"__pycache__/{path.stem}.*")):
            file.unlink(missing_ok=True)


def _last_used(path: Path) -> float:
    """Time at which a file was last used; 0 if another process has deleted it meanwhile."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0
