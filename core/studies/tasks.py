"""Many tasks side by side: on threads of its own, or on any executor, a cluster's among them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import Any, TypeVar

__all__ = ["Cancel", "as_completed"]

Cancel = Callable[[], bool]
"""Asked whether to give up."""

Result = TypeVar("Result")

_OUTSTANDING = 256  #: tasks handed over and not done: more than any cluster in sight has cores, and quickly taken back
_POLL = 0.05  #: seconds between two questions to `cancel`


def as_completed(
    call: Callable[..., Result],
    tasks: Iterable[Any],
    executor: Executor | None = None,
    cancel: Cancel | None = None,
) -> Iterator[tuple[int, Result]]:
    """Call a function for each of many tasks, and yield what comes of them in the order of completion.

    Parameters
    ----------
    call
        Called as ``call(*task)`` where the task is a tuple, else as ``call(task)``. For processes and clusters: a
        function of a module, and tasks that can be pickled.
    tasks
        Taken one by one; never more than 256 are handed over and not done.
    executor
        Any of `concurrent.futures`, or ``dask.distributed.Client(...).get_executor()``; it is not shut down. None: as
        many threads as there are processors, for this call only. (Compiled loops run side by side in threads.)
    cancel
        Asked twenty times a second. Once it returns True, what has not begun is cancelled and the iteration ends,
        without waiting for what is under way.

    Yields
    ------
    tuple of int and result
        The task's number from 0, and what the call returned.

    Raises
    ------
    Exception
        What a call raised, when its turn comes; the rest is cancelled.
    """
    if executor is not None:
        yield from _completed(call, tasks, executor, cancel)
        return
    own = ThreadPoolExecutor(os.cpu_count())
    try:
        yield from _completed(call, tasks, own, cancel)
    finally:
        own.shutdown(wait=False, cancel_futures=True)


def _completed(
    call: Callable[..., Result], tasks: Iterable[Any], executor: Executor, cancel: Cancel | None
) -> Iterator[tuple[int, Result]]:
    waiting = enumerate(tasks)
    under_way: dict[Future[Result], int] = {}
    try:
        while not (cancel is not None and cancel()):
            _submit(call, waiting, executor, under_way)
            if not under_way:
                return
            done, _ = wait(under_way, None if cancel is None else _POLL, FIRST_COMPLETED)
            for future in done:
                yield under_way.pop(future), future.result()
    finally:
        for future in under_way:
            future.cancel()


def _submit(
    call: Callable[..., Result],
    waiting: Iterator[tuple[int, Any]],
    executor: Executor,
    under_way: dict[Future[Result], int],
) -> None:
    """Submit tasks as long as there are any and there is room."""
    while len(under_way) < _OUTSTANDING:
        following = next(waiting, None)
        if following is None:
            return
        number, task = following
        arguments = task if isinstance(task, tuple) else (task,)
        under_way[executor.submit(call, *arguments)] = number
