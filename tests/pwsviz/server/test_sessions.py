"""How pages, their sessions and messages reach a browser."""

import asyncio
import gc
import re
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from itertools import count
from threading import get_ident
from unittest.mock import patch

import numpy as np
import panel as pn
import pytest
from panel.io.state import set_curdoc
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.iostream import IOStream
from tornado.websocket import WebSocketClosedError, WebSocketHandler, websocket_connect

from pwsviz.server.sessions import send_every_message, send_messages_at_once

SERVE = """
import os, socket, time, urllib.request
import panel as pn
from pwsviz.server import sessions

made = []

def application():
    sessions.send_pages_at_once()
    made.append(None)
    return pn.pane.Str("page")

with socket.socket() as probe:
    probe.bind(("127.0.0.1", 0))
    port = probe.getsockname()[1]
pn.serve(application, port=port, threaded=True, show=False, verbose=False)

def fetch():
    for _ in range(300):
        try:
            return urllib.request.urlopen(f"http://localhost:{port}/").read()
        except OSError:
            time.sleep(0.1)

fetch()
fetch()
sessions.LOADING = 1.0
fetch()
print(len(made))
time.sleep(3.0)
print(len(made), flush=True)
os._exit(0)  # the server runs on
"""


@asynccontextmanager
async def _open(pane):
    """Serve a page, connect to it as a browser does, and give both ends of the connection."""
    server = pn.serve({"/app": lambda: pane}, port=0, show=False, start=False)
    server.start()
    try:
        page = await AsyncHTTPClient().fetch(f"http://localhost:{server.port}/app")
        token = re.search(r'"token":\s*"([^"]+)"', page.body.decode())[1]
        request = HTTPRequest(f"ws://localhost:{server.port}/app/ws")
        connection = await websocket_connect(request, subprotocols=["bokeh", token])
        await connection.read_message()  # the first, by which the server acknowledges the connection
        yield connection, list(server._tornado._clients)
        connection.close()
    finally:
        server.stop()


async def _open_a_page() -> list[bool]:
    """Return whether each of the server's sockets delays small parts."""
    async with _open(pn.pane.Str("Text")) as (_, clients):
        return [_delays(client._socket.ws_connection.stream) for client in clients]


NAMED = ("lock", "change", "unlock", "wait", "taken", "change")
"""The second change comes when the browser has just taken the first, which had to wait for the connection."""

ORDER = ("lock", "change", "change", "unlock", "turn", "wait", "wait", "taken", "turn", "change", "taken", "change")
"""Of a drawn schedule, which leaves out any of these acts, and goes through them up to three times."""


def _draw(rng):
    acts = ORDER * int(rng.integers(1, 4))
    return tuple(act for act, kept in zip(acts, rng.random(len(acts)) < 0.6, strict=True) if kept)


async def _play(schedules, complaints) -> list[tuple[list[int], list[int]]]:
    """Return, for each schedule of acts on one connection, the changes made and those written; collect complaints."""
    asyncio.get_running_loop().set_exception_handler(lambda _, context: complaints.append(context))
    pane, found = pn.pane.Str("none"), []
    async with _open(pane) as (_, (client,)):
        socket, document, loop = client._socket, client.session.document, asyncio.get_running_loop()
        await asyncio.sleep(0.1)
        with set_curdoc(document):  # as when a browser has reported that the page is complete
            pn.state._loaded[document] = pn.state._connected[document] = True
            pn.state._thread_id = get_ident()
        made, written, pending, held, left, numbers = [], [], [], [], [], count()

        def write(_socket, part, binary=False):
            if left:
                raise WebSocketClosedError
            written.extend(int(number) for number in re.findall(r"change (\d+)", str(part)))
            pending.append(loop.create_future())
            return pending[-1]

        def change():
            made.append(next(numbers))
            with set_curdoc(document), pn.io.hold(document):
                pane.object = f"change {made[-1]}"

        async def act(name):
            if name == "change":
                change()
            elif name == "lock" and not held:
                held.append(await socket.write_lock.acquire())
            elif name == "unlock" and held:
                held.pop().__exit__(None, None, None)
            elif name == "taken":
                while pending:
                    pending.pop().set_result(None)
            elif name == "left":
                left.append(name)
            elif name in ("turn", "wait"):
                await asyncio.sleep(0.0 if name == "turn" else 0.03)

        change()  # the first also sends what is common to all
        await asyncio.sleep(0.1)
        with patch.object(WebSocketHandler, "write_message", write):
            for schedule in schedules:
                made, written = [], []
                for name in (*schedule, "unlock", *["wait", "taken"] * 4):
                    await act(name)
                found.append((made, written))
    gc.collect()  # a task complains of what nobody asked it for when it is thrown away
    return found


def _played(*schedules):
    complaints = []
    with ThreadPoolExecutor(1) as beside:  # a browser of other tests may leave a loop running in this thread
        return beside.submit(lambda: asyncio.run(_play(schedules, complaints))).result(), complaints


def _delays(stream: IOStream) -> bool:
    return not stream.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_no_part_of_a_message_waits_for_an_acknowledgement_of_the_one_before():
    send_messages_at_once()
    with ThreadPoolExecutor(1) as beside:  # a browser of other tests may leave a loop running in this thread
        assert beside.submit(lambda: asyncio.run(_open_a_page())).result() == [False]


@pytest.mark.deep
def test_every_change_is_sent_in_order_whenever_the_connection_is_in_use_and_messages_are_taken(request):
    send_every_message()
    rng = np.random.default_rng(int(request.config.getoption("seed") or "0", 16))
    schedules = [NAMED, *(_draw(rng) for _ in range(100))]
    for schedule, (made, written) in zip(schedules, _played(*schedules)[0], strict=True):
        assert written == made, schedule


def test_a_visitor_who_leaves_while_messages_are_under_way_is_no_failure():
    send_every_message()
    ((_, written),), complaints = _played(("lock", "change", "left"))
    assert written == []
    assert complaints == []


def test_a_session_is_made_soon_after_its_page_though_no_browser_has_connected_yet():
    done = subprocess.run([sys.executable, "-c", SERVE], check=True, capture_output=True, text=True, timeout=120)
    assert done.stdout.split() == ["2", "3"], "the third page is the first of which another one is known"
