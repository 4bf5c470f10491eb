"""A list to choose one of."""

import pytest

from pwsviz.widgets.dropdown import Dropdown


@pytest.mark.parametrize(
    ("options", "value", "told"),
    [
        ({"first": 1, "second": 2}, 1, 0),  # as it was: a visitor may just have chosen another entry
        ({"one": 1, "two": 2}, 1, 1),  # the entry shown has another name
        ({"second": 2, "first": 1}, 1, 1),
        ({"first": 1, "second": 2}, 2, 1),
    ],
)
def test_the_browser_is_told_of_a_value_if_it_or_its_name_has_changed(options, value, told):
    chosen, heard = Dropdown("Number", options={"first": 1, "second": 2}, value=1), []
    chosen.param.watch(heard.append, "value")
    chosen.offer(options, value)
    assert len(heard) >= told
    assert bool(heard) == bool(told)
    assert (chosen.options, chosen.value) == (options, value)


def test_entries_are_offered_where_there_were_none():
    chosen = Dropdown("Number")
    chosen.offer({"first": 1}, 1)
    assert chosen.value == 1
