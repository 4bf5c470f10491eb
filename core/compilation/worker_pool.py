"""Processes beside this one that compile, two at a time.

What they have compiled is on disk, and loaded from there. Nothing depends on them: what they have not compiled, whoever
needs it does.

They are no pool of `concurrent.futures`. That starts each process by running the user's program again unless it is
guarded by ``if __name__ == "__main__"``, gives up all work that is under way when one process dies, and leaves its
processes behind when the program is killed. These read from a pipe, which ends with the program.
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

__all__ = ["Workshop", "serve"]

_READY, _MADE = "ready\n", "made\n"
_PATIENCE = 60.0  #: seconds to wait for a free process: only where one after another has died


class Workshop:
    """Processes that are given texts, one at a time each.

    Parameters
    ----------
    program
        Python code that calls `serve`.
    environment
        Variables that these processes have besides those of this one.
    size
        How many; they begin at once, and take what is given out from when the first of them is ready.
    idle
        Seconds without a text after which they end.
    """

    def __init__(self, program: str, environment: Mapping[str, str], size: int, idle: float) -> None:
        self._start = partial(_Worker, program, {**os.environ, **environment})
        self._pool = ThreadPoolExecutor(size, thread_name_prefix="workshop")
        self._free: SimpleQueue[_Worker] = SimpleQueue()
        self._under_way: dict[str, Future[bool]] = {}
        self._lock = threading.RLock()
        self._idle, self._timer = idle, threading.Timer(idle, self.close)
        self.ready, self.closed = threading.Event(), False
        for _ in range(size):
            self._pool.submit(self._hire)
        self.keep()

    def keep(self) -> None:
        """Begin to count the idle time anew."""
        with self._lock:
            self._timer.cancel()
            if not self.closed:
                self._timer = threading.Timer(self._idle, self.close)
                self._timer.daemon = True
                self._timer.start()

    def begin(self, text: str) -> Future[bool] | None:
        """Give out a text, unless it is under way already; return what will tell whether it could be made.

        None where there is nobody to take it: nobody yet, or no longer.
        """
        with self._lock:
            if self.closed or not self.ready.is_set():
                return None
            if text not in self._under_way:
                self._under_way[text] = self._pool.submit(self._make, text)
                self.keep()
            return self._under_way[text]

    def close(self) -> None:
        """End all processes once they have made what was given out."""
        with self._lock:
            self.closed = True
            self._timer.cancel()
        self._pool.shutdown()
        while not self._free.empty():
            self._free.get().end()

    def _hire(self) -> None:
        worker = self._start()
        if worker.is_ready():
            self._free.put(worker)
            self.ready.set()
        else:
            worker.end()

    def _make(self, text: str) -> bool:
        try:
            worker = self._free.get(timeout=_PATIENCE)
            made = worker.make(text)
            if worker.lives:
                self._free.put(worker)
            else:
                worker.end()
                self._hire()
        except Empty:
            return False
        finally:
            with self._lock:
                del self._under_way[text]
        return made


class _Worker:
    """One process."""

    def __init__(self, program: str, environment: Mapping[str, str]) -> None:
        # In a session of its own: who interrupts this process at a terminal does not mean that one.
        self._process = subprocess.Popen(  # noqa: S603  (our own program, and no shell)
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8",
            env=environment, start_new_session=True,
        )  # fmt: skip
        self._questions, self._answers = cast("IO[str]", self._process.stdin), cast("IO[str]", self._process.stdout)

    @property
    def lives(self) -> bool:
        return self._process.poll() is None

    def is_ready(self) -> bool:
        """Wait until it takes texts; False if it ends before."""
        return self._answers.readline() == _READY

    def make(self, text: str) -> bool:
        """Whether it has done with a text what it does; not, if it ends before."""
        try:
            self._questions.write(json.dumps(text) + "\n")
            self._questions.flush()
        except OSError:
            return False
        if answer := self._answers.readline():
            return answer == _MADE
        self._process.wait()
        return False

    def end(self) -> None:
        with suppress(OSError):  # of what was written and never read
            self._questions.close()
        self._answers.close()
        self._process.wait()


def serve(make: Callable[[str], object]) -> None:
    """Do with each text that comes in what is to be done, until the other end is closed.

    Parameters
    ----------
    make
        If it raises, the text counts as not made; who needs it will see the same exception.
    """
    if hasattr(os, "nice"):
        os.nice(10)  # who waits for an answer comes first
    answers, sys.stdout = sys.stdout, sys.stderr  # what a library may print is no answer
    gc.freeze()  # what is there now stays: to look through it time and again takes a tenth of the time of compiling
    _answer(answers, _READY)
    for line in sys.stdin:
        try:
            make(json.loads(line))
        except Exception as why:  # of whatever kind: it is told where the text is needed
            _answer(answers, f"not made: {type(why).__name__}\n")
        else:
            _answer(answers, _MADE)


def _answer(answers: IO[str], words: str) -> None:
    answers.write(words)
    answers.flush()
