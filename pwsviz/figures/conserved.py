"""The plot of the conserved quantity: |change of ψ| that each integrator has made, against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.models.glyphs import Line, Scatter
from numpy.typing import NDArray

from pwsviz.figures.crowding import Marks, attach_shades, shade_keys
from pwsviz.figures.legends import legend_below
from pwsviz.figures.marks import kind_columns
from pwsviz.figures.style import (
    BESIDE,
    LEVEL,
    OCCUPIED,
    assign,
    describe,
    fit_to_corners,
    invisible,
    legend_lines,
    line_of,
    mark_levels,
    plain_figure,
    run_lines,
    segments,
    show_methods,
    side_strips,
    tips,
    together,
    unseen,
    widths_in_time,
)
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.results.animation import Landmarks
from pwsviz.results.error_curve import ROUND_OFF, ErrorCurve
from pwsviz.text.numbers import printed
from pwsviz.text.words import rounded, rounded_up, upper_bound

FLOOR = MACHINE_EPSILON / 8
"""|Change of ψ| at which smaller ones and exact zeros are drawn, since a logarithmic axis has no place for them."""

CEILING = 1e9
"""|Δψ| at which a curve leaves the plot: a method that blows up would leave no room for the others."""

MOST_BANDS = 400
"""Most crossings for which segments and ticks are drawn; more of them could not be told apart."""

TICK = 8
"""Size in pixels of the mark of a crossing."""

TELLABLE = 3.0
"""Least ratio of two marks on the axis whose labels can be read beside each other."""

NOWHERE = 1e-300
"""Height of a mark that is not to be seen: below the axis."""

STEADY = 1e-12
"""|Δψ|, relative to the size of ψ’s terms, up to which it is round-off, whether it grows in time or not."""

SEEN_TO_RISE = 1.1
"""Ratio of |Δψ| in the last third of the time to that in the first one beyond which a curve is seen to rise: by less
it rises by a pixel or two, on an axis of so many decades."""

DRIFT = 2.0
"""The same ratio beyond which a rise is no wave any more, but a drift: one in proportion to time has 3."""

LOST = 0.1
"""|Δψ|, relative to the size of ψ’s terms, from which on no bound is told: less than a digit of ψ is right."""

NEAR_ONE = 10.0
"""Factor by which the size of ψ’s terms must differ from 1 for a drift to be stated relative to it, too."""

DRIFT_OF_PSI = "of ψ, |Δψ|"
"""Whose numerical drift the vertical axis shows."""

DRIFT_OF_G = "of g while sliding, |Δg|"
"""The same where a run slides."""

SUMMARY = "Absolute change of the conserved quantity against time, on a logarithmic axis"


class ConservedView:
    """One fixed figure; `show` only changes its data."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            SUMMARY,
            y_axis_type="log",
            x_axis_label="time t",
            y_axis_label=f"numerical drift {DRIFT_OF_PSI}",
            x_range=DataRange1d(range_padding=2 * BESIDE),
            y_range=DataRange1d(range_padding=0.06),
        )
        self._band_glyphs()
        self._curve_glyphs()
        self._tick_glyphs()
        _, *entries, _ = legend_below(
            self.figure,
            [({"field": "method"}, self.keys), *shade_keys(self.figure), ({"field": "label"}, self.ticks.key)],
        )
        self.entries = dict(zip(OCCUPIED, entries, strict=False))
        attach_shades(self.figure, self.bands, entries)

    def _band_glyphs(self) -> None:
        plot = self.figure
        self.segments, self.bands = {}, {}
        for side in OCCUPIED:
            self.segments[side] = ColumnDataSource({"start": [], "end": []})
            self.bands[side] = plot.add_glyph(self.segments[side], side_strips(side))
        self.levels = mark_levels(
            plot, {MACHINE_EPSILON: "machine ε", FLOOR: "below plot range, or 0", NOWHERE: "round-off"}
        )

    def _curve_glyphs(self) -> None:
        plot = self.figure
        columns = ("xs", "ys", "method", "colour", "dash", "width")
        self.methods, self.keys = legend_lines(plot)
        self.round_off = ColumnDataSource({"t": [], "y": []})
        plot.add_glyph(self.round_off, Line(x="t", y="y", **LEVEL))
        self.curves = ColumnDataSource({name: [] for name in columns})
        self.lines = plot.add_glyph(self.curves, run_lines())
        rows = [("integrator", "@method"), ("time", "$snap_x{6}"), ("|Δψ|", "$snap_y{3}")]
        here: dict[str, Any] = {"line_policy": "nearest", "attachment": "horizontal", "visible": False}
        plot.add_tools(tips(rows, renderers=[self.lines], **here))
        self.exits = ColumnDataSource({name: [] for name in ("t", "y", "colour", "words")})
        look: dict[str, Any] = {"marker": "triangle", "line_color": "colour", "fill_color": "colour", "size": 12}
        exits = plot.add_glyph(self.exits, Scatter(x="t", **look))
        plot.add_tools(tips([("", "@words")], renderers=[exits]))
        self.corners = fit_to_corners(plot, [0.0, 1.0], [FLOOR / 2, 1e-2])

    def _tick_glyphs(self) -> None:
        plot = self.figure
        columns = ("t", "foot", "x", "y", "label", "kind", "marker", "colour", "size", "number", "method")
        self.instants = unseen(columns)
        self.ticks = Marks(plot, self.instants, "t", "foot", width=1.8)
        reach = plot.add_glyph(self.instants, invisible(size=18, x="t", y="foot"))
        rows = [("crossing", "@number"), ("time", "@t{9}"), ("kind", "@kind"), ("integrator", "@method")]
        self.hover = tips(rows, renderers=[reach], attachment="above", visible=False, limit=3)
        plot.add_tools(self.hover)

    def show(self, errors: Sequence[ErrorCurve], landmarks: Landmarks | None = None) -> None:
        """Draw the errors of the runs of one scene.

        Parameters
        ----------
        errors : sequence of ErrorCurve
            One for each integrator.
        landmarks : Landmarks, optional
            Of the first integrator's run. Without them all crossings have the same marker, and a crossing under the
            pointer is marked in the portrait only if it has a mark there.
        """
        lines = together(line_of(curve.method) for curve in errors)
        heights = [drawable(curve.error[1:]) for curve in errors]
        lines_drawn = [_apart(curve, y) for curve, y in zip(errors, heights, strict=True)]
        assign(
            self.curves,
            xs=[t for t, _ in lines_drawn],
            ys=[y for _, y in lines_drawn],
            method=[curve.method for curve in errors],
            colour=[line.colour for line in lines],
            dash=[list(line.dash) for line in lines],
            width=widths_in_time(lines),
        )
        self.figure.yaxis[0].axis_label = axis_name(errors)
        self._show_exits(errors, heights)
        show_methods(self.methods, [curve.method for curve in errors])
        self._show_segments(errors[0])
        self._show_ticks(errors[0], landmarks)
        self._show_round_off(errors[0])
        top = max(float(np.fmax.reduce(y, initial=1e-14)) for y in (*heights, self.round_off.data["y"]))
        end = max(curve.t_end for curve in errors)
        assign(self.corners, x=[0.0, end or 1.0], y=[FLOOR / 2, 2 * top])
        describe(self.figure, f"{SUMMARY}. {conserved_text(errors)}")

    def _show_exits(self, errors: Sequence[ErrorCurve], heights: Sequence[Floats]) -> None:
        """Mark where curves leave the plot at its upper end, and say how large their |Δψ| becomes."""
        gone = [(curve, y) for curve, y in zip(errors, heights, strict=True) if np.nanmax(y, initial=0.0) >= CEILING]
        assign(
            self.exits,
            t=[curve.t[1:][np.nanargmax(y)] for curve, y in gone],
            y=[CEILING] * len(gone),
            colour=[line_of(curve.method).colour for curve, _ in gone],
            words=[f"{curve.method} leaves the plot: {_largest(curve.error)}" for curve, _ in gone],
        )

    def _show_segments(self, first: ErrorCurve) -> None:
        bounds = np.concatenate([[0.0], first.crossings, [first.t_end]])
        for side, source in self.segments.items():
            few = slice(None) if len(first.crossings) <= MOST_BANDS else slice(0)
            shaded = segments(bounds, first.sides[few], side)
            entry, name = self.entries[side], first.names.get(side, "")
            name = name if side else f"{name}: |Δg|"
            if entry.label != value(name):  # each change rebuilds the legend
                entry.label = value(name)
            entry.visible = len(shaded["start"]) > 0
            assign(source, **shaded)  # last: the browser hides the entry of shades that are too narrow

    def _show_ticks(self, first: ErrorCurve, landmarks: Landmarks | None) -> None:
        t = first.crossings if len(first.crossings) <= MOST_BANDS else first.crossings[:0]
        count = len(t)
        places = np.full((count, 2), np.nan) if landmarks is None else landmarks.places[:count]
        kinds = ("crossing",) * count if landmarks is None else landmarks.kinds[:count]
        looks = kind_columns(kinds, [TICK] * count)
        self.ticks.name(looks)
        assign(
            self.instants,
            t=t,
            foot=np.full(count, FLOOR / 1.5),
            x=places[:, 0],
            y=places[:, 1],
            **looks,
            number=np.arange(1, 1 + count),
            method=[first.method] * count,
        )

    def _show_round_off(self, first: ErrorCurve) -> None:
        """Mark the round-off of ψ at the end, unless it is too close to machine epsilon; draw it where it grows."""
        level = first.round_off
        last, grows = float(level[-1]), bool(level[-1] > TELLABLE * level[0] > 0.0)
        told = max(last / MACHINE_EPSILON, MACHINE_EPSILON / max(last, NOWHERE)) >= TELLABLE
        self.levels.move(MACHINE_EPSILON, FLOOR, max(last, FLOOR) if told else NOWHERE)
        self.levels.spans[-1].visible = not grows
        drawn = slice(None) if grows else slice(0)
        assign(self.round_off, t=first.t[drawn], y=np.clip(level, FLOOR, CEILING)[drawn])


def axis_name(curves: Sequence[ErrorCurve]) -> str:
    """Return what is drawn: |Δψ|, |Δg| where runs slide, or both."""
    slides = any(np.isfinite(curve.error[curve.sliding]).any() for curve in curves)
    other = any((~curve.sliding & np.isfinite(curve.error)).any() for curve in curves)
    return f"numerical drift {'; '.join(filter(None, (DRIFT_OF_PSI * (other or not slides), DRIFT_OF_G * slides)))}"


def meaning(curves: Sequence[ErrorCurve]) -> str:
    """Return what is drawn, in the sentences of a caption."""
    name, words = axis_name(curves), []
    if DRIFT_OF_PSI in name:
        words.append(
            "|Δψ| is the change of ψ since the start: the sum of changes over the pieces between crossings, where ψ "
            "is constant along the solution; what ψ changes by at a crossing, from one law to the next, is left out"
        )
        if any(curve.between is not None for curve in curves):
            words.append(
                "A crossing that is perturbed lies off the surface, and what ψ changes by as it does is counted"
            )
        words.append(
            f"The line “round-off” is {ROUND_OFF:g} machine ε times the size of ψ’s terms, |ψ| + Σ |xₖ ∂ψ/∂xₖ|, the "
            "greatest so far"
        )
    if DRIFT_OF_G in name:
        words.append(
            "While a run slides, |Δg| is drawn: the distance from g = 0, in units of g, counted afresh each time"
        )
    return ". ".join(words) + "."


def _apart(curve: ErrorCurve, heights: Floats) -> tuple[Floats, Floats]:
    """Return the line of a curve without its start, where the change is 0, and with gaps where sliding begins or ends.

    What changes is g there, and ψ elsewhere: no line joins the two.
    """
    gaps = 1 + np.flatnonzero(np.diff(curve.sliding[1:]))
    t = curve.t[1:]
    return np.insert(t, gaps, t[gaps]), np.insert(heights, gaps, np.nan)


def drawable(error: Floats) -> Floats:
    """Return errors raised to `FLOOR`, up to the first beyond `CEILING`, which is drawn there; NaN stays a gap."""
    beyond = np.maximum.accumulate(error > CEILING)  # for good: an envelope zigzags back
    after = np.concatenate([[False], beyond[:-1]])[: len(beyond)]
    return np.where(after, np.nan, np.clip(error, FLOOR, CEILING))


def conserved_text(curves: Sequence[ErrorCurve]) -> str:
    """Return the drift of ψ of each integrator in a sentence, and what is not drawn; empty if no ψ is known."""
    told = [words for curve in curves for words in (_drift(curve), _undefined(curve), _off_surface(curve)) if words]
    if not told:
        return ""
    words = "; ".join(told) + "."
    terms = " The size of ψ’s terms is |ψ| + Σ |xₖ ∂ψ/∂xₖ|." * ("ψ’s terms" in words)
    return words + terms + _about_marks(curves)


def _about_marks(curves: Sequence[ErrorCurve]) -> str:
    """Say that crossings are too many to be marked, or whose are marked where there are several integrators."""
    first, many = curves[0], len(curves[0].crossings)
    if many > MOST_BANDS:
        whose = f" of {first.method}" * (len(curves) > 1)
        return f" {many:,} crossings{whose} are too many to mark them or to shade the sides."
    return f" Shades and marks are those of {first.method}." * (len(curves) > 1)


def _drift(curve: ErrorCurve) -> str:
    """Say whether the error of one integrator is round-off, stays below a bound, rises or drifts; empty without ψ.

    A small error of a method that does not conserve ψ is no round-off: it is only seen to stay below a bound. Where
    crossings are perturbed, ψ may be kept between them only.
    """
    known = (np.isfinite(curve.error) | np.isinf(curve.error)) & ~curve.sliding
    t, error, round_off = curve.t[known], curve.error[known], curve.round_off[known]
    if not len(error):
        return ""
    worst, size = float(error.max()), float(curve.psi_size[-1])
    if worst > CEILING:
        left = f"leaves the plot at t = {t[np.argmax(error > CEILING)]:.4g}"
        return f"{curve.method} {left}: {_largest(error)}"
    until = _end_of(curve, known)
    early, late = (float(part.max(initial=0.0)) for part in (error[t <= t[-1] / 3], error[t >= 2 * t[-1] / 3]))
    if worst == 0:
        return f"{curve.method} conserves ψ exactly"
    small = bool((error <= round_off).all())
    if curve.keeps and (kind := _kind_of_rounding(error, round_off)):
        return f"{curve.method} conserves ψ to {kind}, |Δψ| ≤ {rounded_up(worst)}{_relative(worst, size)}"
    if curve.runs_off:
        return f"|Δψ| of {curve.method} is at most {rounded_up(worst)} up to t = {until:.4g}, where it runs off"
    if curve.keeps and curve.between is not None and (kind := _kind_of_rounding(curve.between[known], round_off)):
        change = f"that |Δψ| reaches {rounded(worst)}{_relative(worst, size, up=False)} by t = {until:.4g}"
        return f"{curve.method} conserves ψ to {kind} between crossings; the perturbed crossings change it, so {change}"
    share = _share_of_crossings(curve, known)
    if 0.0 < LOST * size <= worst:
        reached = f"{rounded(worst)}{_relative(worst, size, up=False)}"
        return f"{curve.method} does not keep ψ: |Δψ| reaches {reached}{share}"
    if small or late <= SEEN_TO_RISE * early:
        return f"{curve.method} stays below {rounded_up(worst)}{_relative(worst, size)}{share}"
    word = "drifts to" if late > DRIFT * early else "reaches"
    return f"{curve.method} {word} {rounded(worst)}{_relative(worst, size, up=False)} by t = {until:.4g}{share}"


def _share_of_crossings(curve: ErrorCurve, known: NDArray[np.bool_]) -> str:
    """Say how much of a change arises between crossings where these are perturbed; empty where they are not."""
    if curve.between is None:
        return ""
    most = float(np.nanmax(curve.between[known]))
    return f", of which at most {rounded_up(most)} between two crossings, since the perturbed crossings change ψ, too"


def _kind_of_rounding(error: Floats, round_off: Floats) -> str:
    """Say as what rounding explains an error: round-off, or accumulated round-off; empty where it does not."""
    if (error <= round_off).all():
        return "round-off"
    return "accumulated round-off" * bool((error <= STEADY / (ROUND_OFF * MACHINE_EPSILON) * round_off).all())


def _end_of(curve: ErrorCurve, known: NDArray[np.bool_]) -> float:
    """Return until when an error is known: the end of the run, or the crossing from which on it slides."""
    if known[-1]:
        return curve.t_end
    last = curve.t[known][-1]
    return float(next((t for t in curve.crossings if t >= last), last))


def _undefined(curve: ErrorCurve) -> str:
    """Say from when on ψ is not defined along a run, as where it has a logarithm of x < 0; empty if it always is."""
    if np.isnan(curve.undefined):
        return ""
    since = f" from t = {curve.undefined:.4g} on" if curve.undefined > curve.t[0] else ""
    return f"ψ is not defined where {curve.method} runs{since}, so that no |Δψ| is drawn"


def _off_surface(curve: ErrorCurve) -> str:
    """Say how far g changes while one integrator slides; empty if it does not slide."""
    error = curve.error[curve.sliding & np.isfinite(curve.error)]
    if not len(error):
        return ""
    worst = float(error.max())
    kept = f"changes g by {rounded_up(worst)} at most" if worst > 0 else "keeps g exactly"
    return f"{curve.method} {kept} while it slides"


def _relative(error: float, size: float, up: bool = True) -> str:
    """Return an error relative to the size of ψ’s terms, in brackets; empty where that is about 1, or unknown."""
    if not np.isfinite(size) or size == 0 or 1 / NEAR_ONE < size < NEAR_ONE:
        return ""
    about = f"{size:.2g}"
    # Of the numbers that are printed, so that they agree.
    share = rounded_up(upper_bound(error) / float(about)) if up else rounded(float(f"{error:.1e}") / float(about))
    return printed(f" ({share} of the size of ψ’s terms, about {about})")


def _largest(error: Floats) -> str:
    worst = float(np.fmax.reduce(error))
    return f"|Δψ| reaches {rounded(worst)}" if np.isfinite(worst) else "the numerical solution blows up"
