"""Numbers at axes as a browser prints them."""

import pytest

from pwsviz.figures.ticks import LINEAR, LOGARITHMIC

pytestmark = [pytest.mark.browser, pytest.mark.deep]

RUN = """([code, ticks]) => {
    const label = new Function("tick", "index", "ticks", code)
    return ticks.map((tick, index) => label(tick, index, ticks))
}"""


@pytest.fixture
def labels(window):
    page = window.new_page()
    yield lambda code, ticks: page.evaluate(RUN, [code, ticks])
    page.close()


@pytest.mark.parametrize(
    ("ticks", "wanted"),
    [
        ([-50000, 0, 50000, 100000], ["−5×10⁴", "0", "5×10⁴", "10⁵"]),
        ([-40000, -20000, 0, 20000, 40000], ["−40000", "−20000", "0", "20000", "40000"]),
        ([0, 2e5, 4e5], ["0", "2×10⁵", "4×10⁵"]),
        ([-1, -0.5, 0, 0.5, 1], ["−1", "−0.5", "0", "0.5", "1"]),
        ([0.1 * k for k in range(4)], ["0", "0.1", "0.2", "0.3"]),
        ([-2e-5, -2.7e-20, 2e-5], ["−2×10⁻⁵", "0", "2×10⁻⁵"]),
        ([1.0000002, 1.0000004], ["1.0000002", "1.0000004"]),
        ([123456.25, 123456.5], ["1.2345625×10⁵", "1.234565×10⁵"]),
        ([0, 5], ["0", "5"]),
        ([3e7], ["3×10⁷"]),
        ([0], ["0"]),
    ],
)
def test_a_linear_axis_prints_its_numbers_plainly_or_all_with_powers_of_ten_and_no_more_digits_than_they_have(
    labels, ticks, wanted
):
    assert labels(LINEAR, ticks) == wanted


def test_a_logarithmic_axis_prints_each_number_with_its_power_of_ten(labels):
    assert labels(LOGARITHMIC, [1e-16, 1e-3, 1, 1e5]) == ["10⁻¹⁶", "10⁻³", "10⁰", "10⁵"]
    assert labels(LOGARITHMIC, [2e-7, 5e-7, 1e-6]) == ["2×10⁻⁷", "5×10⁻⁷", "10⁻⁶"]
