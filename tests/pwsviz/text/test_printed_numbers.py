"""Numbers as they are printed: on the page, and read back from it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.figures.summaries import run_warnings
from pwsviz.results.run_summary import Summary
from pwsviz.scene.validation import value_of
from pwsviz.text.numbers import printed
from pwsviz.text.tables import Numbers, table_markup
from pwsviz.text.words import as_text


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("2e-06", "2×10⁻⁶"), ("1e-6", "10⁻⁶"), ("-1e+10", "−10¹⁰"), ("1.5e0", "1.5"), ("(-3.0, -.5)", "(−3.0, −.5)"),
        ("3e+01", "30"), ("2.5e-02", "0.025"), ("6e2", "600"), ("1e3", "10³"),
        ("0.000122 to 0.125", "1.22×10⁻⁴ to 0.125"), ("-0.0001, 0.001.", "−10⁻⁴, 0.001."),
        ("1.0002, 0.000", "1.0002, 0.000"),
        ("x = -3: a-1, type-2, x2-x1, 2026-11-22", "x = −3: a-1, type-2, x2-x1, 2026-11-22"),
        ("“1e-3” is not -3", "“1e-3” is not −3"),
        ("psi = 'x-1e-3*y' of Mannshardt's 1e-5", "psi = 'x-1e-3*y' of Mannshardt's 10⁻⁵"),
    ],
)  # fmt: skip
def test_a_number_is_printed_with_powers_of_ten_and_what_is_quoted_stays(written: str, shown: str) -> None:
    assert printed(written) == shown
    assert printed(shown) == shown


@given(st.floats(1e-200, 1e200) | st.floats(-1e200, -1e-200))
def test_a_printed_number_can_be_typed(value: float) -> None:
    for spec in ("r", ".6g", ".2e"):
        text = repr(value) if spec == "r" else f"{value:{spec}}"
        assert value_of(printed(text)) == pytest.approx(float(text), rel=1e-15, abs=1e-300)


def test_paragraphs_tables_and_messages_of_runs_print_their_numbers() -> None:
    table = Numbers(("t",), (("-1e-9", "5e+16"),), caption="at -2")
    message = "t = 1e-05, x = -0.2: the solution stops. Take a smaller step size."
    stopped = Summary(
        method="dmm2", steps=1, met=core.Tally(), seconds=1.0, worst_error=2e-9,
        status=core.Status.GRAZING, message=message,
    )  # fmt: skip
    for text in (as_text("from -3 to 1e-3"), table_markup(table), run_warnings([stopped])):
        assert "−" in text
        assert "×10" in text or "10⁻" in text
        assert not re.search(r"\de-|[ (]-\d", text)
