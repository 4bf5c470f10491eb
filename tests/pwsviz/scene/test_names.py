"""Names and expressions as the page prints them."""

import pytest

import core
from pwsviz.scene.names import as_met, met_at_surfaces, readable, tally_of, told
from tests.pwsviz.own_systems import KICKED, SQUARE_WAVE


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        ("1e12*y", "10¹²·y"), ("-r*1e-12*x", "−r·10⁻¹²·x"), ("(x-y/22)/47e-6", "(x − y/22)/(47·10⁻⁶)"),
        ("x**2/2000000000000", "x²/(2·10¹²)"), ("y/1e-5", "y/10⁻⁵"), ("1.5e3**x", "(1.5·10³)^x"),
        ("1e-2*x + 2e1", "0.01x + 20"), ("250000*x", "250000x"), ("e5 + x", "e5 + x"),
    ],
)  # fmt: skip
def test_large_and_small_numbers_are_printed_with_powers_of_ten(typed, printed):
    assert readable(typed, core.CATALOGUE["elliptic_curve"]) == printed


@pytest.mark.parametrize(("system", "met", "words"), [
    (KICKED, "jumps", "4 jumps"), (SQUARE_WAVE, "crossings", "4 crossings"),
])  # fmt: skip
def test_what_marks_call_a_jump_is_counted_as_one(system, met, words):
    run = core.integrate(system, (0.0, 4.5), tau=0.05, method="rk4")
    assert met_at_surfaces(system) == met
    assert str(tally_of(run)) == words


def test_words_on_crossings_are_words_on_jumps_where_runs_meet_nothing_else():
    words = "Crossings are located; crossings or jumps come closer; error of the last crossing time"
    assert as_met(words, "jumps") == "Jumps are located; jumps come closer; error of the last jump time"
    assert as_met("crossings or jumps come closer", "crossings and jumps") == "crossings and jumps come closer"
    assert as_met("3 crossings", "crossings") == "3 crossings"
    assert told(core.Tally(), "jumps") == "0 jumps"
