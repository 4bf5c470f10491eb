"""Tasks side by side: everything is done once, in any order, until cancelled."""

import math
import multiprocessing
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from core.interface.tasks import as_completed


def test_every_task_is_done_once_and_told_with_its_number():
    tasks = [(k, 2) for k in range(1000)]
    assert sorted(as_completed(pow, tasks)) == [(k, k**2) for k in range(1000)]


def test_a_task_that_is_no_tuple_is_the_argument_itself():
    assert sorted(as_completed(abs, [-1, -2])) == [(0, 1), (1, 2)]


def test_no_tasks_give_no_results():
    assert list(as_completed(abs, [])) == []


def test_results_come_in_the_order_of_completion():
    first_may_end = threading.Event()

    def call(number):
        if number == 0:
            assert first_may_end.wait(10)
        return number

    with ThreadPoolExecutor(2) as pool:
        results = as_completed(call, [0, 1], pool)
        assert next(results) == (1, 1)
        first_may_end.set()
        assert list(results) == [(0, 0)]


def test_processes_do_the_same():
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        found = dict(as_completed(math.factorial, range(5), pool))
    assert found == {0: 1, 1: 1, 2: 2, 3: 6, 4: 24}


def test_a_given_executor_is_left_running():
    with ThreadPoolExecutor(1) as pool:
        list(as_completed(abs, [1], pool))
        assert pool.submit(abs, -3).result() == 3


def test_cancelling_ends_at_once_and_begins_nothing_more():
    begun, may_end = [], threading.Event()

    def call(number):
        begun.append(number)
        assert may_end.wait(10)

    with ThreadPoolExecutor(1) as pool:
        try:
            assert list(as_completed(call, range(10), pool, cancel=lambda: bool(begun))) == []
        finally:
            may_end.set()
    assert begun == [0]  # the pool has ended: no other can follow


def test_cancelled_threads_of_its_own_are_not_waited_for():
    began, may_end, ended = threading.Event(), threading.Event(), []

    def call(number):
        began.set()
        may_end.wait(5)
        ended.append(number)

    assert list(as_completed(call, range(1000), cancel=began.is_set)) == []
    assert ended == []
    may_end.set()


def test_an_exception_is_raised_here_and_cancels_the_rest():
    begun, may_end = [], threading.Event()

    def call(number):
        begun.append(number)
        if number == 0:
            raise ZeroDivisionError(number)
        assert may_end.wait(10)

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(ZeroDivisionError):
            list(as_completed(call, range(100), pool))
        may_end.set()
    assert len(begun) <= 2  # the one after may have begun before


def test_leaving_off_half_way_cancels_the_rest():
    begun = []
    with ThreadPoolExecutor(1) as pool:
        held = threading.Event()

        def call(number):
            begun.append(number)
            if number:
                assert held.wait(10)

        results = as_completed(call, range(100), pool)
        next(results)
        results.close()
        held.set()
    assert len(begun) <= 2


def test_no_more_than_a_few_hundred_are_handed_over_and_not_done():
    taken, began, may_end = [], threading.Event(), threading.Event()

    def tasks():
        for k in range(10_000):
            taken.append(k)
            yield k

    def call(_):
        began.set()
        assert may_end.wait(10)

    with ThreadPoolExecutor(1) as pool:
        list(as_completed(call, tasks(), pool, cancel=began.is_set))
        may_end.set()
    assert 100 < len(taken) < 1000
