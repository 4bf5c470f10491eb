"""What all tests share: how random cases are drawn, and a headless Chromium.

A plain run draws the same cases every time: a third of those that a test asks for. ``--draws N`` draws N times what
the test asks for, from the seed that ``--seed`` names or, without one, from a fresh seed; the summary prints it, and
with it the same cases come again. Properties that hypothesis tries, always the same way, are tried on as many more.
"""

import hashlib
import os
import secrets
import shutil
import zlib
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.browser.looking import PATIENCE

_COMMON = {"database": None, "deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("fixed", derandomize=True, **_COMMON)
settings.register_profile("drawn", print_blob=True, **_COMMON)  # for --hypothesis-profile, with --hypothesis-seed
settings.load_profile("fixed")

#: Files and folders that take longest; those before the browser compile what its servers need.
LONGEST = (
    "tests/pwsviz/page/", "tests/core/compilation/", "tests/browser/test_console.py", "tests/browser/",
    "tests/pwsviz/server/", "tests/pwsviz/bench/", "tests/families/test_functions.py",
    "tests/families/test_near_zeros.py", "tests/families/test_singularities.py", "tests/families/",
)  # fmt: skip

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run",
]  # fmt: skip


class Driver(NamedTuple):
    """Playwright's Chromium, and what each start of it is given."""

    chromium: Any
    options: dict[str, Any]


def pytest_addoption(parser):
    group = parser.getgroup("random cases")
    group.addoption("--draws", type=int, metavar="N", help="draw N times the cases that every test asks for")
    group.addoption("--seed", default=None, metavar="S", help="seed of these cases, in hexadecimal")
    group.addoption("--part", metavar="N:S", help="run one in N of the deep tests, which follow from S, a text")


def pytest_configure(config):
    """Choose the seed, before the workers of a parallel run inherit it, and how many examples hypothesis tries."""
    option = config.option
    if option.seed is None:
        option.seed = secrets.token_hex(4) if option.draws else "0"
    if option.draws:
        settings.register_profile("fixed", settings.get_profile("fixed"), max_examples=300 * option.draws)
        settings.load_profile("fixed")


def pytest_terminal_summary(terminalreporter, config):
    option = config.option
    number = f"--draws {option.draws} " if option.draws else ""
    part = f"; of the deep tests --part {option.part}" if option.part is not None else ""
    terminalreporter.write_line(f"random cases: {number}--seed {option.seed}{part}")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(config, items):
    """Leave out the other parts of the deep tests, and begin with what takes longest: no process waits for another.

    All random families are deep.
    """
    for item in items:
        if item.nodeid.startswith("tests/families/"):
            item.add_marker("deep")
    parts, _, text = (config.option.part or "1:").partition(":")

    def is_left_out(item):
        name = hashlib.sha256(f"{text} {item.nodeid}".encode())
        return item.get_closest_marker("deep") is not None and name.digest()[0] % int(parts) != 0

    def place(item):
        return next((k for k, folder in enumerate(LONGEST) if item.nodeid.startswith(folder)), len(LONGEST))

    config.hook.pytest_deselected(items=[item for item in items if is_left_out(item)])
    items[:] = sorted((item for item in items if not is_left_out(item)), key=place)


@pytest.fixture
def draws(request):
    """Return a function: count -> one numpy Generator a case, its own for each test, seed and case."""
    option, test = request.config.option, zlib.crc32(request.node.nodeid.encode())

    def generators(count):
        for k in range(count * option.draws if option.draws else -(-count // 3)):
            yield np.random.default_rng([int(option.seed, 16), test, k])

    return generators


# One driver for all browsers of a process: a second one beside it is refused.
@pytest.fixture(scope="session")
def driver():
    """Drive Chromium by Playwright; without a Chromium the tests are skipped, except in continuous integration."""
    path = shutil.which("chromium")
    if path is None:
        reason = "no chromium on the PATH: install the package of that name to run the browser tests"
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(reason)
    sync_api = pytest.importorskip("playwright.sync_api")
    sync_api.expect.set_options(timeout=PATIENCE)
    with sync_api.sync_playwright() as playwright:
        yield Driver(playwright.chromium, {"executable_path": path, "args": FLAGS})


@pytest.fixture(scope="session")
def chromium(driver):
    """Start Chromium; each of its contexts is that of somebody who was never here."""
    browser = driver.chromium.launch(**driver.options)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def window(driver):
    """A window with a fresh profile, whose pages share what they fetched and compiled, as a visitor's tabs do."""
    context = driver.chromium.launch_persistent_context("", **driver.options)
    yield context
    context.close()
