"""The explorer of a fresh scene."""

import pytest

from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene


@pytest.fixture
def explorer():
    page = Explorer(Scene(), Results())
    page.refresh()
    assert page.settle(120), "the first of them waits for the time loop to be compiled"
    yield page
    page.close()
