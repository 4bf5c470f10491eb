"""How pages, their sessions and messages reach a browser."""

import asyncio
import re
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import panel as pn
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.iostream import IOStream
from tornado.websocket import websocket_connect

from pwsviz.server.sessions import send_messages_at_once

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


async def _open_a_page() -> list[bool]:
    """Connect to a page as a browser does, and return whether each of the server's sockets delays small parts."""
    server = pn.serve({"/app": lambda: pn.pane.Str("Text")}, port=0, show=False, start=False)
    server.start()
    try:
        page = await AsyncHTTPClient().fetch(f"http://localhost:{server.port}/app")
        token = re.search(r'"token":\s*"([^"]+)"', page.body.decode())[1]
        request = HTTPRequest(f"ws://localhost:{server.port}/app/ws")
        connection = await websocket_connect(request, subprotocols=["bokeh", token])
        await connection.read_message()  # the first, by which the server acknowledges the connection
        streams = [client._socket.ws_connection.stream for client in server._tornado._clients]
        connection.close()
        return [_delays(stream) for stream in streams]
    finally:
        server.stop()


def _delays(stream: IOStream) -> bool:
    return not stream.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_no_part_of_a_message_waits_for_an_acknowledgement_of_the_one_before():
    send_messages_at_once()
    with ThreadPoolExecutor(1) as beside:  # a browser of other tests may leave a loop running in this thread
        assert beside.submit(lambda: asyncio.run(_open_a_page())).result() == [False]


def test_a_session_is_made_soon_after_its_page_though_no_browser_has_connected_yet():
    done = subprocess.run([sys.executable, "-c", SERVE], check=True, capture_output=True, text=True, timeout=120)
    assert done.stdout.split() == ["2", "3"], "the third page is the first of which another one is known"
