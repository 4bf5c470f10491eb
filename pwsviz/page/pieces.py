"""What can be exported of a page: the portrait, and the view beside it, each with what its caption says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pwsviz.export.endings import endings
from pwsviz.export.tables import DrawnRun, drawn_runs, drawn_table, portrait_tables
from pwsviz.figures.lines import line_of
from pwsviz.figures.portrait_text import bodies_text, marks_text, portrait_note, scale_note
from pwsviz.page.export_dialog import NOT_YET, Piece
from pwsviz.page.portrait_panel import PortraitPanel
from pwsviz.results.results import Pictures, PortraitInputs, Results
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS
from pwsviz.tabs import Tab
from pwsviz.text.words import STEPS_MARKED

__all__ = ["pieces_of", "symbols_text"]


def pieces_of(scene: Scene, results: Results, panel: PortraitPanel, view: Tab) -> list[Piece]:
    """Return the portrait and the view; of one that shows other settings, or is not whole yet, that it lacks."""
    shown, runs = panel.shown, list[DrawnRun]()
    portrait = Piece("Phase portrait", {}, [], lack=NOT_YET)
    if shown is not None and shown.inputs == PortraitInputs.of(scene):
        all_runs = drawn_runs(shown.inputs, scene.selected, results.run)
        tables, runs = {**portrait_tables(all_runs), **drawn_table(shown)}, list(all_runs())
        meaning, drawn = _meaning(scene, panel, shown), (scene.declaration, shown.plane)
        said: dict[str, Any] = {
            "meaning": meaning,
            "key": " ".join(filter(None, (scale_note(*drawn), bodies_text(scene.declaration, shown.plane.axes)))),
            **_course(runs),
        }
        portrait = Piece("Phase portrait", tables, [panel.portrait.figure], **said)
    title = VIEWS[scene.view].title
    if view.outcome is None or view.shown != view.inputs():
        return [portrait, Piece(title, {}, [], lack=NOT_YET)]
    said = {"how": view.how(view.outcome), "every_start": view.every_start, "free": view.free()}
    said |= {name: getattr(view, name)(view.outcome) for name in ("meaning", "key", "heading")}
    said["note"] = view.not_saved(view.outcome)
    if not said["how"]:
        said["meaning"] = f"{said['meaning']} {panel.warned if runs else ''}".strip()
        said |= _course([one for one in runs if view.every_start or one.start == scene.selected + 1])
    return [portrait, Piece(title, view.tables(), view.pictures(), **said)]


def _meaning(scene: Scene, panel: PortraitPanel, shown: Pictures) -> str:
    """Return what the lines and marks of the portrait are, and what it leaves out, in sentences."""
    several = len(scene.starts) > 1
    name = "the trajectory" + f" from initial state {scene.selected + 1}" * several
    told = [
        panel.portrait.ground.meaning(name),
        marks_text(shown),
        "Dash-dotted lines join the states before and after jumps." * panel.portrait.joins_jumps,
        STEPS_MARKED * panel.portrait.marks_steps,
        symbols_text(scene.used, panel.portrait.marks_steps),
        panel.warned,
        scale_note(scene.declaration, shown.plane),
        portrait_note(scene.declaration, shown.plane.axes, caption=True),
    ]
    return " ".join(filter(None, told))


def symbols_text(methods: Sequence[str], steps: bool) -> str:
    """Say what the symbols on curves in print tell; that one of them may be a dot, too, where dots mark `steps`."""
    dots = ", larger dots among them," * (steps and any(line_of(name).marker == "circle" for name in methods))
    return f"Other symbols on a curve{dots} tell its integrator." * (len(methods) > 1)


def _course(runs: Sequence[DrawnRun]) -> dict[str, Any]:
    """Return what captions are told of runs of the scene: whether one meets a surface or slides, and early ends."""
    met = any(one.run.crossing_count for one in runs)
    return {"met": met, "slid": any(one.run.sliding.any() for one in runs), "endings": endings(runs)}
