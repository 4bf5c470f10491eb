"""The order plot: an error against the step size, one curve for each number of crossings, with fitted slopes.

A curve has the look of its integrator; how full its marks are tells the number of crossings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d, Scatter
from numpy.typing import ArrayLike, NDArray

import core
from core.studies import FIT_ABOVE
from pwsviz.figures.colours import GREY, GROUND
from pwsviz.figures.conserved import NOWHERE
from pwsviz.figures.legends import MARK_COLUMNS, legend_below, legend_marks, mark_columns
from pwsviz.figures.lines import line_of
from pwsviz.figures.slope_names import name_slopes
from pwsviz.figures.style import BELOW_RANGE, FAINT, fit_to_corners, lowest, mark_levels, plain_figure
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.numbers import printed
from pwsviz.text.tables import Numbers
from pwsviz.text.words import listed

MARK = 7
"""Pixels of the mark of a measured error."""

FILLINGS = (0.0, 0.3, 0.6, 1.0)
"""How full the marks are before the first crossing, and then of each studied one, here and in the plot of crossing
times: an opacity."""

SCATTERED = 0.05
"""Standard error of a slope from which on it is told, as the second digit of the slope then means nothing."""

OFF = 0.3
"""Root mean square of the residuals of a fit, in log error, from which on no line is drawn: points 1.3 times off it."""

UNKNOWN = "–"
"""In place of a slope that is not known."""


EXACT = "exact"
"""How the name of a reference begins that is not itself computed with an error."""

STATE_ERROR = ("state error", "‖x − x*‖₂")
TIME_ERROR = ("crossing-time error", "|t* − t̂|")
"""What an order plot may show: the error in words, and in symbols with its norm; a star marks the solution."""

ABOVE = "fits above"
"""Name of the line above which errors enter the fits."""

BELOW = "inverted_triangle"
"""Marker of an error below the plot, at its lower end."""

APART = 100.0
"""Ratio of two such limits from which on both have room for a name."""

ROOM = 2.0
"""Factor by which a line of integer slope lies above the largest error, and above all curves of about its slope."""

ALIKE = 0.5
"""Difference of slopes up to which a curve is one of those."""


@dataclass(frozen=True)
class Row:
    """One curve of an order plot."""

    name: str
    short: str
    """The name in the legend."""
    error: Floats
    """(m,) error at each step size."""
    slope: float
    window: tuple[float, float]
    """Least and greatest step size of the fit."""
    fit_above: float = 0.0
    """Errors above this enter the fit."""
    fit_below: float = np.inf
    """Errors below this enter the fit."""
    filling: float = FILLINGS[0]
    spread: float = 0.0
    """Standard error of the slope, of the residuals of the fit."""
    residual: float = 0.0
    """Root mean square of these residuals, of log error."""
    at_round_off: bool = False
    """Whether no error exceeds round-off."""
    crossing: int = 0
    """The crossing of which, or after which, the error is taken; 0 before the first."""

    @property
    def label(self) -> str:
        """Name and fitted slope, for the legend."""
        return f"{self.short}: {self.slope_text}"

    @property
    def is_off(self) -> bool:
        """Whether the errors do not follow the fitted power law."""
        return bool(np.isfinite(self.slope)) and self.residual > OFF

    @property
    def slope_text(self) -> str:
        """The fitted slope in words."""
        return f"slope {self.slope_number}" if np.isfinite(self.slope) else "no slope"

    @property
    def slope_number(self) -> str:
        """The fitted slope, with its standard error where the errors scatter."""
        if not np.isfinite(self.slope):
            return UNKNOWN
        return printed(f"{self.slope:.2f}" if self.spread < SCATTERED else f"{self.slope:.1f} ± {self.spread:.1f}")


class Studied(NamedTuple):
    """The curves of one integrator in an order plot."""

    method: str
    order: int
    taus: Floats
    rows: list[Row]
    reference: str
    """Name of the solution that it is compared with."""

    @property
    def is_exact(self) -> bool:
        """Whether no error exceeds round-off, in comparison with the exact solution."""
        return self.reference.startswith(EXACT) and all(row.at_round_off for row in self.rows)

    @property
    def label(self) -> str:
        """Name of the integrator and the least and greatest fitted slope, for the legend."""
        known = sorted((row for row in self.rows if np.isfinite(row.slope)), key=lambda row: row.slope)
        numbers = list(dict.fromkeys(row.slope_number for row in known[:1] + known[-1:]))
        return f"{self.method}: slope{'s' * (len(numbers) > 1)} {' to '.join(numbers)}" if numbers else self.method


Rows = Callable[[core.OrderStudy], list[Row]]
"""Returns the curves of a plot from a study."""


def studied(studies: Sequence[core.OrderStudy], rows: Rows) -> list[Studied]:
    """Return what an order plot shows of studies."""
    return [
        Studied(one.method, core.METHODS[one.method].order or 1, one.taus, rows(one), one.reference) for one in studies
    ]


def exact_text(shown: Sequence[Studied], drawn: bool = True) -> str:
    """Return which integrators are exact to round-off, and so what is missing: slopes or, if nothing is drawn, errors.

    Empty if none is.
    """
    exact = [one.method for one in shown if one.is_exact]
    if not exact:
        return ""
    verb = "is" if len(exact) == 1 else "are"
    where = "here: no slope to fit" if drawn else "for every τ: no error to draw"
    return f"{listed(exact)} {verb} exact to round-off {where}."


def compared_with(reference: str) -> str:
    """Return with what errors are taken: “the exact solution (linear flow)”, “the reference (power series …)”."""
    how = reference.removeprefix(f"{EXACT} ")
    return f"the exact solution {how}" if how != reference else f"the reference ({reference})"


def limits(shown: Sequence[Studied]) -> tuple[Row, Row] | None:
    """Return the curves whose fits begin above the least and above the greatest error; None if that is not known."""
    rows = [row for one in shown for row in one.rows if np.isfinite(row.fit_above)]
    ordered = sorted(rows, key=lambda row: row.fit_above)
    return (ordered[0], ordered[-1]) if ordered else None


def lower_end(shown: Sequence[Studied]) -> float:
    """Return the lower end of a plot of errors, at which smaller ones are drawn: so far below round-off as in Cost."""
    found = limits(shown)
    return ((found[0].fit_above / FIT_ABOVE if found else 0.0) or MACHINE_EPSILON) / FAINT


def filling_after(k: int) -> float:
    """Return how full the marks are after the k-th of the studied crossings, from 1; 0 is before the first."""
    first, *others = FILLINGS
    return others[(k - 1) % len(others)] if k else first


def state_rows(study: core.OrderStudy) -> list[Row]:
    """Return the curves of the state error before the first crossing and after each of the studied ones."""
    numbers = [0, *study.crossings]
    names = [("before the first crossing", "before")]
    if not study.crossings:
        names = [(f"at t = {study.times[-1]:.4g}",) * 2]
    names += [(f"after {count} crossing{'s' * (count > 1)}", f"after {count}") for count in study.crossings]
    fitted = study.state_error, study.state_slope, study.window
    above, below, round_off = study.fit_above.tolist(), study.fit_below, study.at_round_off.tolist()
    return [
        Row(*names[k], error, slope, window, above[k], below, filling_after(k), *off, round_off[k], numbers[k])
        for k, (error, slope, window, off) in enumerate(_fits(study.taus, *fitted))
    ]


def time_rows(study: core.OrderStudy) -> list[Row]:
    """Return the curves of the error of the time of each studied crossing."""
    names = [f"crossing {count}" for count in study.crossings]
    fitted = study.time_error, study.time_slope, study.time_window
    above, below, round_off = study.time_fit_above.tolist(), study.time_fit_below, study.time_at_round_off.tolist()
    full, numbers = [filling_after(k + 1) for k in range(len(names))], study.crossings
    return [
        Row(names[k], names[k], error, slope, window, above[k], below, full[k], *off, round_off[k], numbers[k])
        for k, (error, slope, window, off) in enumerate(_fits(study.taus, *fitted))
    ]


def _fits(
    taus: Floats, errors: Floats, slopes: Floats, windows: Floats
) -> Iterator[tuple[Floats, float, tuple[float, float], tuple[float, float]]]:
    """Yield error, slope and window of each curve, the standard error of the slope and the size of the residuals."""
    for error, slope, (low, high) in zip(errors, slopes, windows, strict=True):
        yield error, float(slope), (float(low), float(high)), _scatter(taus, error, float(slope), low, high)


def _scatter(taus: Floats, error: Floats, slope: float, low: float, high: float) -> tuple[float, float]:
    """Return the standard error of a least-squares slope and the root mean square of the residuals.

    Both are 0 where points are too few.
    """
    used = _within(taus, error, low, high)
    x, y = np.log(taus[used]), np.log(error[used])
    if len(x) < 3 or not np.isfinite(slope):
        return 0.0, 0.0
    x, y = x - x.mean(), y - y.mean()
    squares = ((y - slope * x) ** 2).sum()
    return float(np.sqrt(squares / (len(x) - 2) / (x**2).sum())), float(np.sqrt(squares / len(x)))


def _within(taus: Floats, error: Floats, low: float, high: float) -> NDArray[np.bool_]:
    """Return which errors lie in the window of a fit."""
    within = (taus >= low * (1 - 1e-9)) & (taus <= high * (1 + 1e-9)) & np.isfinite(error) & (error > 0)
    return np.asarray(within)


def order_tables(shown: Sequence[Studied]) -> Mapping[str, Callable[[], Mapping[str, ArrayLike]]]:
    """Return what a plot draws: the errors, a row for each curve and step size, and the fits."""
    drawn = [(one, row) for one in shown for row in one.rows]

    def errors() -> Mapping[str, ArrayLike]:
        lengths = [one.taus.size for one, _ in drawn]
        return {
            "integrator": np.repeat([one.method for one, _ in drawn], lengths),
            "curve": np.repeat([row.name for _, row in drawn], lengths),
            "tau": np.concatenate([one.taus for one, _ in drawn]),
            "error": np.concatenate([row.error for _, row in drawn]),
        }

    def fits() -> Mapping[str, ArrayLike]:
        return {
            "integrator": np.array([one.method for one, _ in drawn]),
            "curve": np.array([row.name for _, row in drawn]),
            "slope": np.array([row.slope for _, row in drawn]),
            "slope_error": np.array([row.spread if np.isfinite(row.slope) else np.nan for _, row in drawn]),
            "fit_from": np.array([row.window[0] for _, row in drawn]),
            "fit_to": np.array([row.window[1] for _, row in drawn]),
            "fit_above": np.array([row.fit_above for _, row in drawn]),
            "fit_below": np.array([row.fit_below for _, row in drawn]),
            "reference": np.array([one.reference for one, _ in drawn]),
        }

    return {"errors": errors, "fits": fits}


def guide_slopes(shown: Sequence[Studied]) -> list[int]:
    """Return the slopes of the lines with which curves are compared: orders of integrators, and lower slopes met."""
    met = {(max(1, round(row.slope)), one.order) for one in shown for row in one.rows if np.isfinite(row.slope)}
    return sorted({slope for slope, order in met if slope < order} | {one.order for one in shown})


def order_numbers(shown: Sequence[Studied]) -> list[Numbers]:
    """Return the fitted slopes of several integrators as a table; none of a single one, whose legend has them."""
    if len(shown) < 2:
        return []
    names = list(dict.fromkeys(row.short for one in shown for row in one.rows))
    slopes = [{row.short: row.slope_number for row in one.rows} for one in shown]
    rows = tuple(
        (one.method, str(one.order), *(known.get(name, UNKNOWN) for name in names))
        for one, known in zip(shown, slopes, strict=True)
    )
    return [Numbers(("integrator", "order", *names), rows, caption="Fitted slopes")]


class OrderView:
    """One fixed figure; `show` only changes its data.

    Parameters
    ----------
    error : str
        Which error it shows, in words.
    symbol : str
        The same in symbols, for the axis.
    """

    def __init__(self, error: str, symbol: str = "") -> None:
        self.figure = plain_figure(
            f"{error} against the step size, both on logarithmic axes, with fitted slopes",
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label="step size τ",
            y_axis_label=", ".join(filter(None, (error, symbol))),
            x_range=DataRange1d(range_padding=0.06),
            y_range=DataRange1d(range_padding=0.06),
        )
        self._guide_glyphs()
        self._curve_glyphs()

    def _guide_glyphs(self) -> None:
        plot = self.figure
        self.guides = ColumnDataSource({"xs": [], "ys": []})
        plot.multi_line("xs", "ys", source=self.guides, color=GREY, line_dash="dotted", line_width=1.5)
        self.floor = mark_levels(plot, {1e-15: ABOVE, 2 * NOWHERE: "", NOWHERE: BELOW_RANGE})

    def _curve_glyphs(self) -> None:
        plot = self.figure
        self.fits = ColumnDataSource({"xs": [], "ys": [], "colour": []})
        fits = plot.multi_line("xs", "ys", source=self.fits, color="colour", alpha=0.25, line_width=6, line_cap="round")
        columns = ("xs", "ys", "colour", "dash", "label", "filling", *MARK_COLUMNS)
        self.curves = ColumnDataSource({name: [] for name in columns})
        lines = plot.multi_line("xs", "ys", source=self.curves, color="colour", line_dash="dash", line_width=1.6)
        named = ("x", "y", "nowhere", "colour", "marker", "label", "filling")
        self.points = ColumnDataSource({name: [] for name in named})
        look: dict[str, Any] = {"marker": "marker", "size": MARK, "line_color": "colour"}
        plot.add_glyph(self.points, Scatter(fill_color=GROUND, **look))  # no line is seen through a mark
        plot.add_glyph(self.points, Scatter(fill_color="colour", fill_alpha="filling", **look))
        # What the marks of several integrators stand for is told in a colour of none of them.
        grey: dict[str, Any] = {"marker": "circle", "size": MARK, "fill_color": GREY, "line_color": GREY}
        keys_of_marks = plot.add_glyph(self.points, Scatter(x="nowhere", y="nowhere", fill_alpha="filling", **grey))
        self.guide_names = name_slopes(plot, self.guides, self.curves, self.points)
        self.corners = fit_to_corners(plot, [1e-4, 1e-1], [1e-15, 1.0])
        under = legend_marks(plot, self.curves, MARK, fill_color=GROUND)
        keys = legend_marks(plot, self.curves, MARK, fill_alpha="filling")
        entries = [({"field": "label"}, [lines, under, keys]), ({"field": "label"}, keys_of_marks), ("fit", fits)]
        _, self._marks, self._fit = legend_below(plot, entries, usual=2)

    def show(self, shown: Sequence[Studied]) -> None:
        """Draw the studies of one integrator or of several."""
        several = len(shown) > 1
        bottom = lower_end(shown)
        rows = [_Drawn(one, k, several, bottom) for one in shown for k in range(len(one.rows))]
        drawn = [one for one in rows if one.there.any()] or rows  # a curve without a point has no key, either
        self.curves.data = {
            "xs": [one.taus for one in drawn],
            "ys": [np.where(one.below, np.nan, one.drawn_at) for one in drawn],  # NaN leaves a gap
            "colour": [one.line.colour for one in drawn],
            "dash": [list(one.line.dash) for one in drawn],
            "label": [one.label for one in drawn],
            # Of several integrators an entry stands for all curves of one, and the marks have entries of their own.
            "filling": [1.0 if several else one.row.filling for one in drawn],
            **mark_columns([one.line.marker for one in drawn]),
        }
        counts = [int(one.there.sum()) for one in drawn]
        self.points.data = {
            "x": np.concatenate([one.taus[one.there] for one in drawn]),
            "y": np.concatenate([one.drawn_at[one.there] for one in drawn]),
            "nowhere": np.full(sum(counts), np.nan),
            "colour": np.repeat([one.line.colour for one in drawn], counts),
            "marker": np.concatenate([one.markers[one.there] for one in drawn]),
            "label": np.repeat([one.row.short for one in drawn], counts),
            "filling": np.repeat([one.row.filling for one in drawn], counts),
        }
        self._marks.visible = several
        fits = [(fitted_line(one.taus, one.row), one.line.colour) for one in drawn]
        known = [(fit, colour) for fit, colour in fits if fit is not None]
        self.fits.data = {
            "xs": [fit[0] for fit, _ in known],
            "ys": [fit[1] for fit, _ in known],
            "colour": [colour for _, colour in known],
        }
        self._fit.visible = bool(known)
        below = any(one.below.any() for one in drawn)
        floor = self._show_limits(shown, bottom if below else NOWHERE)
        heights = np.concatenate([one.drawn_at[one.there] for one in drawn])
        end = bottom / 2 if below else lowest(heights, floor)
        self._show_guides(drawn, (end, ROOM * float(heights.max(initial=floor))), guide_slopes(shown) if known else [])

    def _show_limits(self, shown: Sequence[Studied], bottom: float) -> float:
        """Draw the least and, if far above, the greatest error above which a fit begins, and return the least.

        The lower end, at which smaller errors are drawn, is marked besides.
        """
        found = limits(shown)
        if found is None:
            self.floor.move(NOWHERE, NOWHERE, bottom)
            return MACHINE_EPSILON
        least, greatest = found
        apart = greatest.fit_above > APART * least.fit_above
        names = [f"{ABOVE}:\n{row.short}" for row in found] if apart else [ABOVE, ""]
        self.floor.names.args = {**self.floor.names.args, "names": [*names, BELOW_RANGE]}
        self.floor.move(least.fit_above, greatest.fit_above if apart else NOWHERE, bottom)
        return least.fit_above

    def _show_guides(self, drawn: list[_Drawn], ends: tuple[float, float], slopes: Sequence[int]) -> None:
        """Draw lines of these slopes, each above the curves that are about as steep, and end the axes with the data."""
        bottom, top = ends
        taken = [one.taus[one.there] for one in drawn]
        used = np.concatenate(taken if any(map(len, taken)) else [one.taus for one in drawn])
        near, far = float(used.min()), float(used.max())
        powers = np.array(slopes, dtype=float)
        above = [ROOM * max((one.height(slope, far) for one in drawn), default=0.0) for slope in slopes]
        at_far = np.array([height or top for height in above])
        upper = np.minimum(at_far, top)
        right = far * (upper / at_far) ** (1 / powers)
        left = np.maximum(near, right * (bottom / upper) ** (1 / powers))
        heights = upper * (left / right) ** powers
        # Until the browser has found places, names stand at the upper ends.
        self.guide_names.data = {"x": right, "y": upper, "text": [f"slope {slope}" for slope in slopes]}
        self.guides.data = {
            "xs": [np.array(pair) for pair in zip(left, right, strict=True)],
            "ys": [np.array(pair) for pair in zip(heights, upper, strict=True)],
        }
        self.corners.data = {"x": [near, far], "y": [bottom, top]}


class _Drawn:
    """The drawn form of one curve: its look, and where it has a point."""

    def __init__(self, one: Studied, k: int, several: bool, bottom: float) -> None:
        self.taus, self.row = one.taus, one.rows[k]
        self.line = line_of(one.method)
        self.label = one.label if several else self.row.label
        error = self.row.error
        self.there = np.isfinite(error) & bool((error > 0).any())  # a curve of zeros is not drawn
        self.below = self.there & (error < bottom)
        self.drawn_at: Floats = np.where(self.there, np.maximum(error, bottom), np.nan)
        """(m,) errors as drawn, those below the plot at its lower end, and NaN for a gap."""
        self.markers = np.where(self.below, BELOW, self.line.marker)

    def height(self, slope: int, tau: float) -> float:
        """Return the error at τ on the lowest line above the fitted part, if that is about as steep, else 0."""
        used = _within(self.taus, self.row.error, *self.row.window)
        if not abs(self.row.slope - slope) < ALIKE:
            return 0.0
        return float((self.row.error[used] * (tau / self.taus[used]) ** slope).max(initial=0.0))


def fitted_line(taus: Floats, row: Row) -> tuple[Floats, Floats] | None:
    """Return the fitted power law (τ, error) at the ends of its fit; None if there is none that the errors follow."""
    used = _within(taus, row.error, *row.window)
    if not np.isfinite(row.slope) or row.is_off or used.sum() < 2:
        return None
    log_constant = np.mean(np.log(row.error[used]) - row.slope * np.log(taus[used]))
    ends = np.array([taus[used].min(), taus[used].max()])
    return ends, np.exp(log_constant) * ends**row.slope
