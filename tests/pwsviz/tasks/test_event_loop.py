"""Outcomes reach a page whatever it is doing: being made, being built in a browser, or there."""

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Thread
from types import SimpleNamespace

import panel as pn
import pytest
from bokeh.document import Document
from panel.io.state import set_curdoc

from pwsviz.tasks import event_loop
from pwsviz.tasks.event_loop import Delivery


@pytest.fixture
def served():
    """A page's document with a session, and how many browsers have fetched it."""
    session = SimpleNamespace(connection_count=0)
    context = SimpleNamespace(session=session, id="one", request=None, destroyed=False)
    document = Document()
    document._session_context = lambda: context
    return document, session


def in_a_loop(coroutine):
    """Run in a thread of its own: the browser of other tests has left its event loop running in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()


def call_back(document):
    """Do what the event loop of a server does next."""
    with set_curdoc(document):
        for callback in list(document.session_callbacks):
            document.remove_next_tick_callback(callback)
            callback.callback()


def test_without_a_page_an_outcome_is_shown_at_once():
    seen = []
    Delivery()(seen.append, "outcome")
    assert seen == ["outcome"]


def test_what_comes_while_the_page_is_made_is_shown_once_it_is(served):
    document, _ = served
    seen = []

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        document.hold()  # as Panel does
        thread = Thread(target=delivery, args=(seen.append, "outcome"))
        thread.start()
        thread.join()
        assert not document.session_callbacks, "what is added now Panel forgets"
        document.unhold()
        await asyncio.sleep(0.01)
        call_back(document)

    in_a_loop(serve())
    assert seen == ["outcome"]


def test_what_comes_in_time_is_part_of_the_page_and_the_rest_is_shown_later(served):
    document, _ = served
    seen, coming = [], [True]

    def compute(delivery):
        time.sleep(0.02)
        delivery(seen.append, "in time")
        coming.pop()

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        Thread(target=compute, args=(delivery,)).start()
        delivery.run(lambda: bool(coming), timeout=10)
        assert seen == ["in time"]
        start = time.monotonic()
        delivery.run(lambda: True, timeout=0.05)
        assert time.monotonic() - start < 5, "it waits no longer than it was told to"
        delivery(seen.append, "late")
        await asyncio.sleep(0.01)
        call_back(document)

    in_a_loop(serve())
    assert seen == ["in time", "late"]


def test_what_comes_while_a_browser_builds_the_page_waits_until_it_is_there(served):
    document, session = served
    seen = []

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        session.connection_count = 1
        for outcome in "ab":
            delivery(seen.append, outcome)
        await asyncio.sleep(0.01)
        call_back(document)
        assert seen == []
        pn.state._on_load(document)
        await asyncio.sleep(0.01)
        call_back(document)
        assert sorted(seen) == ["a", "b"]  # event loops promise no order
        delivery(seen.append, "c")
        await asyncio.sleep(0.01)
        call_back(document)

    in_a_loop(serve())
    assert seen[2:] == ["c"]


def test_an_outcome_waits_for_another_that_is_lacking_but_not_for_ever(served, monkeypatch):
    document, _ = served
    monkeypatch.setattr(event_loop, "TOGETHER", 0.05)
    seen, lacking = [], [True]

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        for outcome in "ab":
            delivery(seen.append, outcome, lacking=lambda: bool(lacking))
            await asyncio.sleep(0.01)
            assert not document.session_callbacks
            lacking.clear()
            delivery(seen.append, "the other", lacking=lambda: bool(lacking))
            await asyncio.sleep(0.01)
            call_back(document)
            lacking.append(True)
        assert seen == ["a", "the other", "b", "the other"]
        delivery(seen.append, "alone", lacking=lambda: True)
        await asyncio.sleep(0.2)
        call_back(document)

    in_a_loop(serve())
    assert seen[4:] == ["alone"]


def test_what_a_callback_adds_to_come_with_others_does_not_come_with_itself(served):
    document, _ = served
    seen, lacking = [], [True]

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        delivery(lambda: delivery(seen.append, "late", lacking=lambda: bool(lacking)))
        await asyncio.sleep(0.01)
        call_back(document)
        assert seen == []
        lacking.clear()
        delivery(seen.append, "outcome", lacking=lambda: bool(lacking))
        await asyncio.sleep(0.01)
        call_back(document)

    in_a_loop(serve())
    assert seen == ["late", "outcome"]


@pytest.mark.parametrize("wanted", [True, False])
def test_what_is_called_later_is_called_if_it_is_wanted_then(served, wanted):
    document, _ = served
    seen = []

    async def serve():
        with set_curdoc(document):
            delivery = Delivery()
        delivery.later(0.01, lambda: seen.append("later"), lambda: wanted)
        assert not document.session_callbacks
        await asyncio.sleep(0.1)
        assert bool(document.session_callbacks) == wanted, "the page is left alone where there is nothing to do"
        call_back(document)

    in_a_loop(serve())
    assert seen == ["later"] * wanted


def test_what_comes_after_the_server_has_stopped_is_let_go(served):
    document, _ = served

    async def serve():
        with set_curdoc(document):
            return Delivery()

    delivery = in_a_loop(serve())
    delivery(lambda: pytest.fail("there is nobody to show it to"))


@pytest.mark.parametrize("lacking", [False, True])
def test_what_comes_after_the_session_has_ended_is_let_go(served, monkeypatch, lacking):
    document, _ = served
    monkeypatch.setattr(event_loop, "TOGETHER", 0.01)
    complaints = []

    async def serve():
        asyncio.get_running_loop().set_exception_handler(lambda _loop, context: complaints.append(context))
        with set_curdoc(document):
            delivery = Delivery()
        document.on_change(print)
        delivery(lambda: pytest.fail("there is nobody to show it to"), lacking=lambda: lacking)
        document.destroy(print)  # the server's session listens to changes and is forgotten here
        await asyncio.sleep(0.05)

    in_a_loop(serve())
    assert complaints == []
