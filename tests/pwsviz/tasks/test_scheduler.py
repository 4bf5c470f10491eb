"""Work goes to threads by lanes, and only what is still wanted comes back."""

from functools import partial
from threading import Event
from time import sleep

import pytest

from pwsviz.tasks import turns
from pwsviz.tasks.cancellation import Cancelled
from pwsviz.tasks.scheduler import Scheduler


@pytest.fixture
def scheduler():
    made = Scheduler()
    yield made
    made.close()


def test_the_same_is_computed_once(scheduler):
    seen = []
    assert scheduler.submit("a", 1, lambda _cancel, _report: "one", seen.append)
    assert scheduler.settle(60)
    assert not scheduler.submit("a", 1, lambda _cancel, _report: "again", seen.append)
    scheduler.forget("a")
    assert scheduler.submit("a", 1, lambda _cancel, _report: "again", seen.append)
    assert scheduler.settle(60)
    assert seen == ["one", "again"]


def test_an_outcome_on_its_way_is_not_shown_once_it_is_forgotten(scheduler, monkeypatch):
    seen, under_way = [], []
    monkeypatch.setattr(scheduler, "_delivery", lambda show, *outcome, **_: under_way.append(partial(show, *outcome)))
    for inputs in (1, 2):
        scheduler.submit("a", inputs, lambda _cancel, _report: "of another start", seen.append)
        assert scheduler.settle(60)
    scheduler.forget("a")
    scheduler.submit("a", 3, lambda _cancel, _report: "wanted", seen.append)
    assert scheduler.settle(60)
    assert len(under_way) == 3
    for show in under_way:
        show()
    assert seen == ["wanted"]


def test_what_was_cancelled_may_be_submitted_again(scheduler):
    seen, started = [], Event()

    def endless(cancel, _report):
        started.set()
        while not cancel():
            pass
        raise Cancelled

    scheduler.submit("a", 1, endless, seen.append)
    assert started.wait(60)
    assert scheduler.cancel("a")
    assert scheduler.settle(60)
    assert not scheduler.cancel("a"), "nothing is under way"
    assert scheduler.submit("a", 1, lambda _cancel, _report: "done", seen.append)
    assert scheduler.settle(60)
    assert seen == ["done"]


def test_progress_is_told_while_it_is_wanted_and_not_too_often(scheduler):
    told, seen = [], []

    def study(_cancel, report):
        for done in range(1, 1001):
            report(done, 1000, "part")
        return "whole"

    scheduler.submit("a", 1, study, seen.append, lambda *news: told.append(news))
    assert scheduler.settle(60)
    assert seen == ["whole"]
    assert told[0] == (1, 1000, "part")
    assert len(told) < 20


def test_what_is_short_does_not_wait_for_what_is_long(scheduler):
    gate, seen = Event(), []
    scheduler.submit("long", 1, lambda _cancel, _report: gate.wait(5), seen.append, quiet=1e-3)
    scheduler.submit("short", 1, lambda _cancel, _report: "short", lambda outcome: (seen.append(outcome), gate.set()))
    assert scheduler.settle(60)
    assert seen == ["short", True]


def test_short_work_is_done_one_at_a_time(scheduler, monkeypatch):
    monkeypatch.setattr(turns, "LONGEST", 5.0)  # a busy machine takes a while for what is short
    under_way, most = [], []

    def short(_cancel, _report):
        under_way.append(1)
        most.append(len(under_way))
        sleep(0.005)
        under_way.pop()

    for k in range(8):
        scheduler.submit(f"lane {k}", 1, short, lambda _: None)
    assert scheduler.settle(60)
    assert most == [1] * 8


def test_the_first_of_two_short_outcomes_waits_for_the_second_and_for_nothing_long(scheduler, monkeypatch):
    lacks, gate, first, never = [], Event(), Event(), Event()

    def deliver(_show, *_outcome, lacking=lambda: None):
        lacks.append(lacking())
        first.set()

    monkeypatch.setattr(scheduler, "_delivery", deliver)
    scheduler.submit("long", 1, lambda _cancel, _report: never.wait(5), lambda _: None, quiet=1e-3)
    scheduler.submit("view", 1, lambda _cancel, _report: gate.wait(5), lambda _: None)
    scheduler.submit("curves", 1, lambda _cancel, _report: "curves", lambda _: None)
    assert first.wait(60)
    assert lacks == [True]
    scheduler.submit("curves", 2, lambda _cancel, _report: never.wait(5), lambda _: None)  # newer than what has come
    gate.set()
    assert scheduler._lanes["view"].join(60)
    assert lacks == [True, False], "curves that wait to be shown do not wait for newer ones"
    never.set()


def test_a_closed_scheduler_delivers_nothing(scheduler):
    gate, seen = Event(), []
    scheduler.submit("a", 1, lambda _cancel, _report: gate.wait(5), seen.append)
    scheduler.close()
    gate.set()
    assert scheduler.settle(60)
    assert seen == []
