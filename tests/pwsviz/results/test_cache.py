"""The cache computes once, forgets the oldest, and hands over what was cancelled."""

from threading import Barrier, Event, Thread

import numpy as np
import pytest

import core
from pwsviz.results.cache import Cache, nbytes
from pwsviz.tasks.cancellation import Cancelled


def test_second_request_computes_nothing():
    cache = Cache()
    assert [cache.get("square", 3, lambda: 9) for _ in range(5)] == [9] * 5
    assert cache.computed == {"square": 1}


def test_threads_that_ask_at_once_share_one_computation():
    cache, barrier, answers = Cache(), Barrier(8), []
    may_end = Event()

    def compute():
        may_end.wait(5)
        return 1

    def ask():
        barrier.wait(5)
        answers.append(cache.get("slow", 0, compute))

    threads = [Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    may_end.set()
    for thread in threads:
        thread.join(5)
    assert answers == [1] * 8
    assert cache.computed["slow"] == 1


def test_what_was_cancelled_is_computed_by_whoever_still_waits():
    cache, started, answers = Cache(), Event(), []
    stop = Event()

    def cancelled():
        started.set()
        stop.wait(5)
        raise Cancelled

    def first():
        with pytest.raises(Cancelled):
            cache.get("run", 0, cancelled)

    one = Thread(target=first)
    one.start()
    started.wait(5)
    two = Thread(target=lambda: answers.append(cache.get("run", 0, lambda: "done")))
    two.start()
    stop.set()
    one.join(5)
    two.join(5)
    assert answers == ["done"]


def test_failures_are_not_remembered():
    cache = Cache()
    with pytest.raises(ZeroDivisionError):
        cache.get("bad", 0, lambda: 1 / 0)
    assert cache.get("bad", 0, lambda: 2) == 2


def test_memory_is_bounded_and_the_oldest_goes_first():
    cache = Cache(max_bytes=3000)
    for k in range(5):
        cache.get("array", k, lambda: np.zeros(100))
    cache.get("array", 4, lambda: pytest.fail("was there"))
    cache.get("array", 0, lambda: np.zeros(100))
    assert cache.computed["array"] == 6


def test_a_value_too_large_to_be_kept_drops_no_other():
    cache = Cache(max_bytes=1000)
    cache.get("array", 0, lambda: np.zeros(100))
    assert cache.get("array", 1, lambda: np.ones(200)).sum() == 200
    cache.get("array", 0, lambda: pytest.fail("was there"))


class Counted:
    """Inputs that count how often they are looked up."""

    hashed = 0

    def __hash__(self):
        Counted.hashed += 1
        return id(self)


def test_dropping_the_oldest_takes_no_longer_the_more_values_are_kept(monkeypatch):
    monkeypatch.setattr("pwsviz.results.cache.MAX_VALUES", 200)
    cache = Cache()
    for _ in range(200):
        cache.get("full", Counted(), object)
    Counted.hashed = 0
    cache.get("one more", Counted(), object)
    assert Counted.hashed < 20


def test_bytes_of_nested_arrays_are_counted():
    assert nbytes([np.zeros(2), (np.zeros(3), "text")]) == 40


def test_bytes_of_a_run_are_those_of_its_arrays_though_they_are_made_late():
    run = core.integrate("elliptic_curve", (0.0, 10.0), tau=1e-3)
    found = nbytes(run)
    arrays = (run.t, run.x, run.mode, run.segment, run.entered_t, run.entered_x, run.crossings.t, run.samples)
    assert sum(array.nbytes for array in arrays) < found < 2 * run.x.nbytes + 3 * run.t.nbytes
