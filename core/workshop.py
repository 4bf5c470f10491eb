"""Processes beside this one that compile: numba holds the interpreter meanwhile, and two of them are done sooner.

What they have compiled is on disk, and loaded from there. Nothing depends on them: what they have not compiled, whoever
needs it does.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from queue import SimpleQueue
from typing import IO, cast

__all__ = ["Workshop", "serve"]

#: Seconds after which a process that nobody needs ends; the next text has another begin.
IDLE = 900.0
_MADE = "made\n"


class Workshop:
    """Processes that are given texts, one at a time each.

    Parameters
    ----------
    program
        Python code that calls `serve`.
    environment
        Variables that these processes have besides those of this one.
    size
        How many; they begin at once.
    """

    def __init__(self, program: str, environment: Mapping[str, str], size: int) -> None:
        self._begin = partial(_Worker, program, {**os.environ, **environment})
        self._pool = ThreadPoolExecutor(size, thread_name_prefix="workshop")
        self._free: SimpleQueue[_Worker] = SimpleQueue()
        self._under_way: dict[str, Future[bool]] = {}
        self._lock = threading.Lock()
        for _ in range(size):
            self._free.put(self._begin())

    def make(self, texts: Iterable[str]) -> bool:
        """Give out texts that are not under way yet, wait for all, and return whether all could be made."""
        longest_first = sorted(texts, key=len, reverse=True)  # so that none is left alone with a long one
        with self._lock:
            for text in longest_first:
                if text not in self._under_way:
                    self._under_way[text] = self._pool.submit(self._make, text)
            awaited = [self._under_way[text] for text in longest_first]
        return all(future.result() for future in awaited)

    def close(self) -> None:
        """End all processes once they are done with what they do."""
        self._pool.shutdown()
        while not self._free.empty():
            self._free.get().end()

    def _make(self, text: str) -> bool:
        worker = self._free.get()
        try:
            if not worker.lives:
                worker.end()
                worker = self._begin()
            return worker.make(text)
        finally:
            self._free.put(worker)
            with self._lock:
                del self._under_way[text]


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

    def make(self, text: str) -> bool:
        """Whether it has done with a text what it does; not, if it ends before."""
        try:
            self._questions.write(json.dumps(text) + "\n")
            self._questions.flush()
        except OSError:
            return False
        return self._answers.readline() == _MADE

    def end(self) -> None:
        with suppress(OSError):  # of what was written and never read
            self._questions.close()
        self._answers.close()
        self._process.wait()


def serve(make: Callable[[str], object], idle: float = IDLE) -> None:
    """Do with each text that comes in what is to be done, until none comes any more.

    Parameters
    ----------
    make
        If it raises, the text counts as not made; who needs it will see the same exception.
    idle
        Seconds without a text after which the process ends.
    """
    answers, sys.stdout = sys.stdout, sys.stderr  # what a library may print is no answer
    watch = _Watch(idle)
    for line in sys.stdin:
        watch.busy()
        try:
            make(json.loads(line))
        except Exception as why:  # of whatever kind: it is told where the text is needed
            answer = f"not made: {type(why).__name__}\n"
        else:
            answer = _MADE
        answers.write(answer)
        answers.flush()
        watch.rest()


class _Watch:
    """Ends the process when it has rested for too long."""

    def __init__(self, idle: float) -> None:
        self._idle, self._since = idle, time.monotonic()
        threading.Thread(target=self._look, daemon=True).start()

    def busy(self) -> None:
        self._since = float("inf")

    def rest(self) -> None:
        self._since = time.monotonic()

    def _look(self) -> None:
        while time.monotonic() - self._since < self._idle:
            time.sleep(min(self._idle / 10, 5.0))
        os._exit(0)
