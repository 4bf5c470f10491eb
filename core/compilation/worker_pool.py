"""Worker processes that compile modules.

Their machine code is loaded from disk. Nothing depends on the workers: a text that they have not compiled is compiled
by the process that needs it.

A process pool of `concurrent.futures` does not serve: it starts each process by running the user's program again unless
that is guarded by ``if __name__ == "__main__"``, abandons all pending work when one process dies, and leaves processes
behind when the program is killed. These workers read from a pipe, which closes when the program ends.
"""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import IO, cast

__all__ = ["WorkerPool", "serve"]

_READY = "ready\n"  #: a worker's first answer
_DONE = "done\n"  #: its answer to a text that it has compiled
_PATIENCE = 60.0  #: seconds to wait for a free worker, in case one after another has died


class WorkerPool:
    """Worker processes, each of which compiles one text at a time.

    Parameters
    ----------
    program
        Python code that calls `serve`.
    environment
        Environment variables of the workers, in addition to those of this process.
    size
        Number of workers. They start at once; texts are accepted once the first of them is ready.
    idle
        Seconds without a new text after which they end.
    """

    def __init__(self, program: str, environment: Mapping[str, str], size: int, idle: float) -> None:
        self._start = partial(_Worker, program, {**os.environ, **environment})
        self._threads = ThreadPoolExecutor(size, thread_name_prefix="compile")
        self._free: SimpleQueue[_Worker] = SimpleQueue()
        self._pending: dict[str, Future[bool]] = {}
        self._lock = threading.RLock()
        self._idle, self._timer = idle, threading.Timer(idle, self.close)
        self.ready, self.closed = threading.Event(), False
        for _ in range(size):
            self._threads.submit(self._add_worker)
        self.restart_timer()

    def restart_timer(self) -> None:
        """Restart the timer of the idle time."""
        with self._lock:
            self._timer.cancel()
            if not self.closed:
                self._timer = threading.Timer(self._idle, self.close)
                self._timer.daemon = True
                self._timer.start()

    def submit(self, text: str) -> Future[bool] | None:
        """Submit a text, unless it is pending; returns the future result, whether it was compiled.

        None if there are no workers, being not yet ready or closed.
        """
        with self._lock:
            if self.closed or not self.ready.is_set():
                return None
            if text not in self._pending:
                self._pending[text] = self._threads.submit(self._run, text)
                self.restart_timer()
            return self._pending[text]

    def close(self) -> None:
        """End all workers once they have compiled what was submitted."""
        with self._lock:
            self.closed = True
            self._timer.cancel()
        self._threads.shutdown()
        while not self._free.empty():
            self._free.get().end()

    def _add_worker(self) -> None:
        worker = self._start()
        if worker.wait_until_ready():
            self._free.put(worker)
            self.ready.set()
        else:
            worker.end()

    def _run(self, text: str) -> bool:
        try:
            worker = self._free.get(timeout=_PATIENCE)
            done = worker.compile(text)
            if worker.is_alive:
                self._free.put(worker)
            else:
                worker.end()
                self._add_worker()
        except Empty:
            return False
        finally:
            with self._lock:
                del self._pending[text]
        return done


class _Worker:
    """One worker process."""

    def __init__(self, program: str, environment: Mapping[str, str]) -> None:
        # In a session of its own, so that an interrupt at the terminal does not reach it.
        self._process = subprocess.Popen(  # noqa: S603  (our own program, and no shell)
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8",
            env=environment, start_new_session=True,
        )  # fmt: skip
        self._questions, self._answers = cast("IO[str]", self._process.stdin), cast("IO[str]", self._process.stdout)

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def wait_until_ready(self) -> bool:
        """Wait until the process accepts texts; returns False if it ends before."""
        return self._answers.readline() == _READY

    def compile(self, text: str) -> bool:
        """Compile a text; returns whether that succeeded, False also if the process has ended."""
        try:
            self._questions.write(json.dumps(text) + "\n")
            self._questions.flush()
        except OSError:
            return False
        if answer := self._answers.readline():
            return answer == _DONE
        self._process.wait()
        return False

    def end(self) -> None:
        with suppress(OSError):  # unread text may be left in the pipe
            self._questions.close()
        self._answers.close()
        self._process.wait()


def serve(make: Callable[[str], object]) -> None:
    """Run a worker process: call `make` with each text received, until the pipe is closed.

    Parameters
    ----------
    make
        If it raises, the text counts as failed; the process that needs it will raise the same exception.
    """
    if hasattr(os, "nice"):
        os.nice(10)  # interactive processes have priority
    answers, sys.stdout = sys.stdout, sys.stderr  # keep output of libraries out of the answers
    gc.freeze()  # scanning the modules loaded so far again and again takes a tenth of the time of compiling
    _answer(answers, _READY)
    for line in sys.stdin:
        try:
            make(json.loads(line))
        except Exception as why:  # any exception: it is raised again where the text is needed
            _answer(answers, f"failed: {type(why).__name__}\n")
        else:
            _answer(answers, _DONE)


def _answer(answers: IO[str], words: str) -> None:
    answers.write(words)
    answers.flush()
