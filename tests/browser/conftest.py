"""A server with the real page, and visits to it."""

import socket
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import pytest

from tests.browser.looking import PATIENCE, await_built

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def address(tmp_path_factory):
    """Serve app.py as a user does, on a free port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    url = f"http://localhost:{port}/app"
    log = tmp_path_factory.mktemp("server") / "log"
    command = [sys.executable, "-m", "panel", "serve", "app.py", "--port", str(port)]
    with log.open("w") as sink:
        server = subprocess.Popen(command, cwd=ROOT, stdout=sink, stderr=subprocess.STDOUT)
        try:
            _await_server(url, server, log)
            yield url
        finally:
            server.terminate()
            server.wait(60)  # a machine at work on something else takes long to end it
    said = log.read_text()  # tornado complains of visitors who leave; only what concerns this package counts
    assert f"{ROOT}/pwsviz/" not in said, said
    assert "failed with following error" not in said, said


def _await_server(url, server, log):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and server.poll() is None:
        try:
            urllib.request.urlopen(url, timeout=30).close()  # noqa: S310  (our own server)
        except (urllib.error.URLError, OSError):
            time.sleep(0.1)
        else:
            return
    pytest.fail(f"the page was not served:\n{log.read_text()}")


def _is_ours(url):
    """Whether a visitor who is not on the internet gets it."""
    return urllib.parse.urlsplit(url.removeprefix("blob:")).hostname in ("localhost", None)


def _complains(message):
    """Whether a message in the console is an error, or of rows that do not exist."""
    return message.type == "error" or "out of bounds" in message.text


@pytest.fixture
def visit(window, address):
    """Open a scene of the page in a window of a given size; afterwards, no script may have complained.

    It is the scene of a link that changes nothing; with an empty query, that of a page opened without a link.

    Media features, such as ``color_scheme="dark"``, hold from the first paint on.
    """
    complaints, pages = [], []

    def open_page(width=1400, height=900, query="v=2", **media):
        page = window.new_page()
        pages.append(page)
        page.set_viewport_size({"width": width, "height": height})
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda message: complaints.append(message.text) if _complains(message) else None)
        page.on("request", lambda sent: None if _is_ours(sent.url) else complaints.append(sent.url))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.emulate_media(**media)
        page.goto(f"{address}?{query}" if query else address)
        await_built(page)
        return page

    yield open_page
    for page in pages:
        page.close()
    assert complaints == []
