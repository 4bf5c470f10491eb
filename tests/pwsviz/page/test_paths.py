"""What the page shows follows from its scene, by whichever path of systems, views and settings that was reached."""

import re
from contextlib import suppress

import pytest

import core
from pwsviz.figures.style import described
from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import PLAIN

METHODS = ("rk2", "dmm2", "rk4")
SYSTEMS = 8
VIEWS = ("conserved", "state", "scheme", "order", "time")


def without_times(words):
    """Return words without run times, which differ from run to run."""
    return re.sub(r"[\d.]+ (ms|s)\b", "", words)


def entries(plot):
    """Return labels of a legend, and which of them are seen."""
    return [(str(item.label), item.visible) for legend in plot.legend for item in legend.items]


def look(page):
    """Return what the page says and which figures it shows, with their axes and legends."""
    panel, view = page.portrait_panel, page.view
    panes = view._panels.objects if page.scene.view == "state" else view.plots
    seen = [pane for pane in (panel.pane, *panes) if pane.visible and pane.styles["opacity"] == PLAIN["opacity"]]
    assert all(pane.object.visible and pane.styles["visibility"] == "inherit" for pane in seen)
    return {
        "words": [without_times(one.object) for one in (panel.status, panel.note, panel.trouble, view.words)],
        "notice": page.notice.object,
        "curves": [len(source.data["x"]) for source in (panel.portrait.crossings, panel.portrait.ends)],
        "figures": [(plot.xaxis.axis_label, plot.yaxis[0].axis_label, entries(plot)) for plot in
                    (pane.object for pane in seen)],
        "name": described(panel.portrait.figure),
    }  # fmt: skip


def changes(rng):
    """Yield settings for a visit of some systems, each in one view or two, with integrators and starts."""
    for system in rng.permutation(list(core.CATALOGUE))[:SYSTEMS].tolist():
        yield "system", lambda _, system=system: system
        yield "slide", lambda _: bool(rng.integers(2))
        yield "view", lambda _: str(rng.choice(VIEWS, p=[0.5, 0.2, 0.1, 0.1, 0.1]))
        yield (
            "methods",
            lambda scene: [one for one in ("rk2", "dmm2", "rk4") if one in scene.offered][: rng.integers(1, 4)],
        )
        yield "x0.0", lambda scene: float(scene.starts[0][0] * rng.choice([1.0, 1.1, 0.9, -1.0]))
        yield "view", lambda _: str(rng.choice(VIEWS[:2]))


@pytest.mark.deep
def test_a_page_shows_what_a_fresh_one_shows_of_the_same_scene(draws):
    results = Results()
    for rng in draws(1):
        page = Explorer(Scene(), results)
        page.refresh()
        for name, value in changes(rng):
            with suppress(ValueError):  # no run can begin there, say: the scene stays
                page.scene.accept(name, value(page.scene))
            assert page.settle(300)
            if name != "view":
                continue
            fresh = Explorer(Scene(), results)
            fresh.scene.restore(page.scene.settings())
            fresh.refresh()
            assert fresh.settle(300)
            assert look(page) == look(fresh), (page.scene.system, page.scene.view)
            fresh.close()
        page.close()
