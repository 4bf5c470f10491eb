"""The digest under which machine code is kept: a change of anything that is compiled in makes another."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from core.kernels.digest import source_digest

ROOT = Path(__file__).parents[3]
CACHED = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in ROOT.glob("core/**/*.py")
    if "cache=True" in path.read_text(encoding="utf-8") and path.name != "native.py"  # there the file's name has it
)
#: What has no part in a loop: the growth of a solution is followed without a record.
WITHOUT = {("core.integration.growth_loop", "core.transition.records")}


@pytest.fixture
def change(monkeypatch):
    """Return a function that makes the source of a module read as if it had another line."""

    def changed(name):
        own, read = Path(import_module(name).__file__), Path.read_text
        monkeypatch.setattr(Path, "read_text", lambda p, **k: read(p, **k) + ("\nx = 0\n" if p == own else ""))
        source_digest.cache_clear()

    yield changed
    monkeypatch.undo()
    source_digest.cache_clear()


@pytest.mark.parametrize("loop", CACHED)
def test_a_loop_that_is_kept_on_disk_has_the_digest_in_its_key(loop):
    """numba makes a closed-over variable that a function names a part of the key."""
    text = Path(import_module(loop).__file__).read_text(encoding="utf-8")
    assert "source_digest(__name__)" in text
    assert len(re.findall(r"cache=True", text)) == len(re.findall(r"^ +_ = sources\b", text, re.MULTILINE))


@pytest.mark.parametrize("name", ["core.kernels.abi", "core.kernels.jit", "core.transition.records"])
@pytest.mark.parametrize("loop", CACHED)
def test_a_change_of_the_table_of_functions_or_of_a_record_is_another_key(loop, name, change):
    before = source_digest(loop)
    change(name)
    assert (source_digest(loop) != before) == ((loop, name) not in WITHOUT)


def test_what_a_loop_does_not_call_leaves_its_key(change):
    before = source_digest("core.integration.time_loop")
    change("core.systems.pendulum")
    assert source_digest("core.integration.time_loop") == before
