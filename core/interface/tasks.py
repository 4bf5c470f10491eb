"""Run many tasks in parallel: on threads of its own, or on any executor, such as that of a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import Any, TypeVar

import numpy as np

from core.interface.cancelling import Cancel

__all__ = ["GivenUp", "as_completed", "check_hooks"]

Result = TypeVar("Result")

#: Most tasks submitted and not done: enough to keep some hundred cores busy, and few to cancel.
_OUTSTANDING = 256
#: Seconds between two calls of `cancel`.
_POLL = 0.05


def check_hooks(cancel: Any, progress: Any, executor: Any = None) -> None:
    """Raise ValueError unless cancel and progress can be called, and the executor is one; None is any of them."""
    for name, hook in (("cancel", cancel), ("progress", progress)):
        if hook is not None and not callable(hook):
            raise ValueError(f"{name} = {hook!r}: a function is needed, or None")
    if executor is not None and not isinstance(executor, Executor):
        raise ValueError(f"executor = {executor!r}: an Executor of concurrent.futures is needed, or None")


class GivenUp:
    """A `Cancel` for tasks: True once their results are no longer wanted; in another process it never is.

    Attributes
    ----------
    flag
        (1,) the same for compiled loops: not 0 once they are not wanted.
    """

    def __init__(self) -> None:
        self.flag = np.zeros(1, dtype=np.int64)

    def set(self) -> None:
        """Let the tasks stop."""
        self.flag[0] = 1

    def __call__(self) -> bool:
        """Return whether the results are no longer wanted."""
        return bool(self.flag[0])

    def __reduce__(self) -> tuple[type[GivenUp], tuple[()]]:
        """Pickle without the flag, which does not leave its process."""
        return GivenUp, ()


def as_completed(
    call: Callable[..., Result],
    tasks: Iterable[Any],
    executor: Executor | None = None,
    cancel: Cancel | None = None,
    given_up: GivenUp | None = None,
) -> Iterator[tuple[int, Result]]:
    """Call a function for each of many tasks, and yield the results in the order of completion.

    Parameters
    ----------
    call
        Called as ``call(*task)`` where the task is a tuple, else as ``call(task)``. For processes and clusters it must
        be a function of a module, and tasks and results must be picklable.
    tasks
        Taken one by one; at most 256 are submitted and not done.
    executor
        Any of `concurrent.futures`, or ``dask.distributed.Client(...).get_executor()``; it is not shut down. None: as
        many threads as there are processors, for this call only. (Compiled loops run in parallel in threads.)
    cancel
        Called twenty times a second. Once it returns True, tasks that have not begun are cancelled and the iteration
        ends, without waiting for those that run.
    given_up
        Set when the iteration ends, so that tasks that hold it do not go on for nobody.

    Yields
    ------
    tuple of int and result
        The task's index, and what the call returned.

    Raises
    ------
    Exception
        What a call raised, when its result is due; the other tasks are cancelled.
    """
    pool = ThreadPoolExecutor(os.cpu_count()) if executor is None else executor
    try:
        yield from _completed(call, tasks, pool, cancel)
    finally:
        if given_up is not None:
            given_up.set()
        if executor is None:
            pool.shutdown(wait=False, cancel_futures=True)


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
            for future in sorted(done, key=under_way.__getitem__):
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
    """Submit tasks until `_OUTSTANDING` are not done, or none is left."""
    while len(under_way) < _OUTSTANDING:
        following = next(waiting, None)
        if following is None:
            return
        number, task = following
        arguments = task if isinstance(task, tuple) else (task,)
        under_way[executor.submit(call, *arguments)] = number
