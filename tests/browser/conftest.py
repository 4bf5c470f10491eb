"""A server with the real page, and a headless Chromium to look at it."""

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run",
]  # fmt: skip


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
            server.wait(10)
    said = log.read_text()  # tornado complains of visitors who leave; only what concerns this package counts
    assert "pwsviz/" not in said, said
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


@pytest.fixture(scope="session")
def chromium():
    """Start Chromium with a fresh profile; without one the tests are skipped, except in continuous integration."""
    path = shutil.which("chromium")
    if path is None:
        reason = "no chromium on the PATH: install the package of that name to run the browser tests"
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(reason)
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield browser.new_context()
        browser.close()


@pytest.fixture
def visit(chromium, address):
    """Open the page in a window of a given size; afterwards, no script may have complained."""
    complaints, pages = [], []

    def open_page(width=1400, height=900):
        page = chromium.new_page()
        pages.append(page)
        page.set_viewport_size({"width": width, "height": height})
        page.set_default_timeout(20_000)
        page.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(address)
        return page

    yield open_page
    for page in pages:
        page.close()
    assert complaints == []
