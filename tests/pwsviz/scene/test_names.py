"""Names and expressions as the page prints them."""

import pytest

import core
from pwsviz.scene.names import readable


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
