"""Whoever opens an exported file learns from it what each column means."""

import pytest

from pwsviz.export.columns import MEANINGS
from pwsviz.export.files import csv_bytes
from pwsviz.page.explorer import Explorer
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS


@pytest.mark.parametrize("view", VIEWS)
def test_every_column_of_every_view_is_a_variable_or_has_its_meaning(view):
    page = Explorer(Scene(view=view))
    page.refresh()
    assert page.settle(120)
    named = set(page.scene.declaration.variables)
    for piece in page._pieces():
        for title, table in piece.tables.items():
            assert not set(table()) - MEANINGS.keys() - named, title
    page.close()


@pytest.mark.parametrize(("numbers", "told"), [([1.0, float("nan")], True), ([1.0, 2.0], False), ([1, 2], False)])
def test_a_header_says_what_nan_means_where_there_is_one(numbers, told):
    assert ("# nan: " in csv_bytes({"x": numbers}).decode()) == told
