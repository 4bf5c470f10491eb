"""Only the newest request counts, and nothing that goes wrong is lost."""

from threading import Event

import pytest

from pwsviz.tasks.cancellation import Cancelled
from pwsviz.tasks.latest_wins import Job, Lane


def test_requests_that_were_overtaken_are_never_started():
    lane, seen, started, gate = Lane(), [], Event(), Event()
    lane.submit(Job(lambda _: started.set() or gate.wait(5), seen.append))
    assert started.wait(60)
    for k in range(20):
        lane.submit(Job(lambda _, k=k: k, seen.append))
    gate.set()
    assert lane.join(60)
    assert seen == [True, 19]


def test_a_job_that_takes_longer_than_its_patience_is_given_up_for_a_newer_one():
    lane, seen, started = Lane(), [], Event()

    def long(given_up):
        started.set()
        while not given_up():
            pass
        raise Cancelled

    lane.submit(Job(long, seen.append, patience=0.05))
    assert started.wait(60)
    lane.submit(Job(lambda _: "new", seen.append))
    assert lane.join(60)
    assert seen == ["new"]


def test_a_lane_rests_while_all_it_has_waits_for_quiet():
    lane = Lane()
    assert lane.resting
    lane.submit(Job(lambda _: None, lambda _: None, quiet=10.0))
    assert lane.resting
    assert lane.busy
    lane.submit(Job(lambda _: None, lambda _: None))
    assert lane.join(60)
    assert lane.resting


def test_a_job_that_wants_quiet_starts_when_requests_rest():
    lane, started, shown = Lane(), [], Event()
    for k in range(10):
        lane.submit(Job(lambda _, k=k: started.append(k), lambda _: shown.set(), quiet=0.05))
    assert shown.wait(60)
    assert started == [9]


def test_to_wait_for_all_jobs_ends_their_quiet():
    lane, seen = Lane(), []
    lane.submit(Job(lambda _: "done", seen.append, quiet=60.0))
    assert lane.join(60)
    assert seen == ["done"]


def test_exceptions_are_delivered():
    lane, seen = Lane(), []
    lane.submit(Job(lambda _: int("x"), seen.append))
    assert lane.join(60)
    assert isinstance(seen[0], ValueError)


def test_a_result_that_cannot_be_shown_is_told_and_does_not_stop_later_ones():
    lane, seen = Lane(), []

    def refuse(_):
        raise TypeError("no place for it")

    lane.submit(Job(lambda _: 1, refuse))
    with pytest.raises(TypeError, match="no place"):
        lane.join(5)
    lane.submit(Job(lambda _: 2, seen.append))
    assert lane.join(60)
    assert seen == [2]


def test_cancel_drops_what_waits():
    lane, seen = Lane(), []
    lane.submit(Job(lambda _: 1, seen.append, quiet=10.0))
    lane.cancel()
    assert lane.join(60)
    assert seen == []


def test_a_short_job_is_finished_although_a_newer_one_waits():
    lane, seen, started, gate = Lane(), [], Event(), Event()

    def short(given_up):
        started.set()
        gate.wait(5)
        return given_up()

    lane.submit(Job(short, seen.append, patience=60.0))
    assert started.wait(60)
    lane.submit(Job(lambda _: "new", seen.append))
    gate.set()
    assert lane.join(60)
    assert seen == [False, "new"]
