"""Numbers at the axes: as a journal prints them, with as few digits as tell them apart."""

from __future__ import annotations

from bokeh.models import CustomJSTickFormatter, LogAxis
from bokeh.plotting import figure

from pwsviz.text.numbers import PRINTED

__all__ = ["print_ticks"]

LINEAR = (
    PRINTED
    + """
const SPARE = 1e-6  // of the distance between ticks, which is no digit but rounding
const exact = Math.abs(ticks[1] - ticks[0]) || Math.abs(tick)
if (Math.abs(tick) <= SPARE * exact) { return "0" }
const largest = Math.max(...ticks.map(Math.abs))
const power = largest >= 1e5 || largest < 1e-3 ? Math.floor(Math.log10(largest) + 1e-9) : 0
let digits = 0
while (digits < 15 && ticks.some(one => {
  const scaled = one * 10 ** (digits - power)
  return Math.abs(scaled - Math.round(scaled)) > SPARE * exact * 10 ** (digits - power)
})) { digits += 1 }
const factor = String(Number((tick / 10 ** power).toFixed(digits)))
return printed(power == 0 ? factor : Number(`${factor}e${power}`).toExponential())
"""
)
"""JavaScript that prints one of the ``ticks`` of an axis: plainly, or all of them with powers of ten."""


LOGARITHMIC = f"{PRINTED}return printed(Number(tick.toPrecision(3)).toExponential())"
"""JavaScript that prints one of the ticks of a logarithmic axis, with its own power of ten."""


def print_ticks(plot: figure) -> None:
    """Let the axes of a figure print their numbers as the rest of the page does: 5×10⁴ and 0, not 5.000e+4."""
    for axis in (*plot.xaxis, *plot.yaxis):
        code = LOGARITHMIC if isinstance(axis, LogAxis) else LINEAR
        axis.formatter = CustomJSTickFormatter(code=code)
