"""A field for a number shows it as it was typed, or as short as it can be written."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pwsviz.scene.validation import value_of
from pwsviz.text.numbers import shortest
from pwsviz.widgets.number_field import NumberField


class Number:
    """A number of the scene, and its field."""

    def __init__(self, value):
        self.value = value
        self.field = NumberField("k", lambda: self.value, self.accept, bounds=(0.0, 20.0))

    def accept(self, value):
        """Take a number, or a text."""
        self.value = value_of(str(value))

    @property
    def shown(self):
        """What the field says."""
        return self.field.entry.text, self.field.entry.note


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("1/3", ("1/3", "≈ 0.3333333")),
        (" sqrt(2) ", ("sqrt(2)", "≈ 1.414214")),
        ("0.50", ("0.5", "")),
        ("2×10⁻⁶", ("2×10⁻⁶", "")),
    ],
)
def test_a_formula_stays_in_its_field_with_its_value_beside_until_the_number_changes(typed, shown):
    number = Number(1.0)
    number.field.type(typed)
    assert number.shown == shown
    assert number.value == value_of(typed)
    number.field.entry.place = 7.25
    assert number.shown == ("7.25", "")


def test_a_refusal_names_the_number_that_is_used_still():
    number = Number(0.25)
    number.field.type("0.25 apples")
    assert number.field.entry.text == "0.25 apples"
    assert number.field.entry.complaint.endswith(". Still in use: 0.25.")
    number.field.type("0.5")
    assert not number.field.entry.complaint
    number.field.type("2pi")
    number.field.type("2pj")
    assert number.field.entry.complaint.endswith(". Still in use: 2pi."), "as it was typed"


def test_a_ratio_is_shown_as_one():
    number = Number(100 / 7)
    assert number.shown == ("100/7", "≈ 14.28571")
    number.value = 14.2857142857
    number.field.sync()
    assert number.shown == ("14.2857142857", "")


@given(st.floats(allow_nan=False, allow_infinity=False) | st.fractions(max_denominator=99).map(float))
def test_the_shortest_text_of_a_number_determines_it(value):
    text = shortest(value)
    assert len(text) <= len(repr(value))
    over, _, under = text.partition("/")
    assert float(over) / float(under or 1) == value
