"""One panel of a figure: the scene of a preset, computed and drawn as on the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bokeh.plotting import figure

from pwsviz.export.about import about
from pwsviz.export.files import Tables
from pwsviz.export.tables import DrawnRun, conserved_tables, drawn_runs, drawn_table, portrait_tables
from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.framing import extent
from pwsviz.figures.order import STATE_ERROR, TIME_ERROR, OrderView, Rows, order_tables, state_rows, studied, time_rows
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.style import describe, described
from pwsviz.report.numbers import run_numbers, slope_numbers
from pwsviz.results.requests import RunInputs, other_inputs, run_inputs, study_inputs
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.permalink import query
from pwsviz.scene.presets import Preset
from pwsviz.scene.scene import Scene
from pwsviz.text.tables import Numbers

__all__ = ["Panel", "draw_panel"]

PORTRAITS = ("fig:vftypes", "fig:portraits")
"""Figures of the paper that are phase portraits; the others are views beside the portrait on the page."""

HEIGHT = {"plot": 420, "portrait": 460}
"""Heights in pixels, fixed since there is no window to fit."""


@dataclass(frozen=True)
class Panel:
    """A figure, the numbers measured for it, and its data."""

    preset: Preset
    plot: figure
    numbers: Numbers
    tables: Tables
    link: str
    """The scene as the query string of the page's address."""
    about: Mapping[str, str]
    """The scene and how it was integrated."""

    @property
    def summary(self) -> str:
        """Description of the figure in words."""
        return described(self.plot)


def draw_panel(preset: Preset, results: Results) -> Panel:
    """Compute and draw what a preset shows of its figure in the paper.

    Raises
    ------
    ValueError
        If the settings of the preset are not those of a scene.
    """
    scene = Scene()
    scene.load(preset.settings)
    draw = _portrait if preset.figure in PORTRAITS else _DRAW[scene.view]
    plot, numbers, tables = draw(scene, results)
    plot.name = preset.key
    runs = [results.run(one) for one in (*run_inputs(scene), *other_inputs(scene))]
    met, slid = any(run.crossing_count for run in runs), any(run.sliding.any() for run in runs)
    return Panel(preset, plot, numbers, tables, query(scene), about(scene, met=met, slid=slid))


Drawn = tuple[figure, Numbers, Tables]


def _portrait(scene: Scene, results: Results) -> Drawn:
    inputs = PortraitInputs.of(scene)
    pictures = results.pictures(inputs)
    view = PortraitView(_ignore, _ignore, _ignore, _ignore, _ignore)
    starts = list(map(pictures.plane.place, scene.starts))
    view.show_orbits(scene.declaration, pictures, starts, scene.selected)
    view.fit()
    ground = inputs.selected[0].problem
    window = extent(pictures).scaled(2.0)
    view.show_backdrop(results.backdrop(ground, window, pictures.orbits[0].levels, pictures.plane))
    _make_static(view.figure, HEIGHT["portrait"])
    tables = {**portrait_tables(drawn_runs(inputs, scene.selected, results.run)), **drawn_table(pictures)}
    return view.figure, _measured((*inputs.selected, *inputs.others), results), tables


def _conserved(scene: Scene, results: Results) -> Drawn:
    inputs = run_inputs(scene)
    view = ConservedView()
    view.show(results.error_curves(inputs), results.landmarks(inputs[0], results.plane(scene.declaration, scene.axes)))
    _make_static(view.figure, HEIGHT["plot"])
    tables = conserved_tables(lambda: [DrawnRun(scene.selected + 1, results.run(one)) for one in inputs])
    return view.figure, _measured(inputs, results), tables


def _measured(inputs: Sequence[RunInputs], results: Results) -> Numbers:
    return run_numbers({one: results.summary(one) for one in inputs})


def _order(error: tuple[str, str], rows: Rows) -> Callable[[Scene, Results], Drawn]:
    def draw(scene: Scene, results: Results) -> Drawn:
        view, shown = OrderView(*error), studied(results.studies(study_inputs(scene)), rows)
        view.show(shown)
        slopes = ("; ".join(f"{row.name}, {row.slope_text}" for row in one.rows) for one in shown)
        told = " ".join(f"Of {one.method}: {words}." for one, words in zip(shown, slopes, strict=True))
        describe(view.figure, f"{error[0].capitalize()} against the step size. {told}")
        _make_static(view.figure, HEIGHT["plot"])
        return view.figure, slope_numbers(shown), order_tables(shown)

    return draw


#: View of a scene -> the function that draws it.
_DRAW: Mapping[str, Callable[[Scene, Results], Drawn]] = {
    "conserved": _conserved,
    "order": _order(STATE_ERROR, state_rows),
    "time": _order(TIME_ERROR, time_rows),
}


def _make_static(plot: figure, height: int) -> None:
    """Give a figure of the page a fixed height, and remove its callbacks.

    On the page, moving a start requests another trajectory from the server, and here there is none.
    """
    plot.update(height=height, styles={})
    plot.update(js_property_callbacks={}, js_event_callbacks={}, subscribed_events=set())


def _ignore(*_: Any) -> None:
    """Callback of a figure of the report, which is static."""
