"""What the page is, where its method comes from, and how it is used: a line, a citation, and half a page of help."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.scene.presets import Preset
from pwsviz.text.numbers import printed
from pwsviz.text.words import as_text
from pwsviz.widgets.dialog import dialog
from pwsviz.widgets.panes import PLAIN_SX, markup_pane
from pwsviz.widgets.widths import NARROW

__all__ = ["ABOUT", "CHANGED", "CITATION", "FIRST", "GREETING_CSS", "Help", "greeting", "look_of", "note_of"]

ABOUT = (
    "Integrate systems whose vector field changes across a surface, and see what each integrator conserves. "
    "For teaching and research."
)
"""What this is, and for whom."""

FIRST = (
    "New here? Choose an example above, click or tap in the portrait to start a trajectory there, or enlarge the step "
    "size τ and see which integrators drift."
)
"""The first thing to try; shown until an example is chosen."""

CHANGED = " (changed). Choose it under Examples to restore it."
"""What follows the title of an example whose scene is another one now."""

GREETING_CSS = f"""
.greeting {{ font: 13px/18px Roboto, Helvetica, Arial, sans-serif; min-height: 36px; margin: 0; opacity: 0.8; }}
@media (width >= {NARROW}px) {{ .greeting {{ display: none; }} }}
"""


def greeting(example: Preset | None, changed: bool = False) -> str:
    """Return what the page is, how to begin, and what an example shows, as markup; `changed` as in `look_of`.

    On a narrow screen it stands above the portrait: the controls, and what to try, are out of sight there.
    """
    words = (
        "Integrate systems whose vector field changes across a surface. Tap in the portrait to start a trajectory; "
        "examples are behind ☰."
    )
    if example is None:
        return f'<p class="greeting">{words}</p>'
    return f'<p class="greeting">{words} {_title(example, changed)} {escape(_words(example, changed)[0])}</p>'


def look_of(example: Preset, changed: bool = False) -> str:
    """Return what to look at in an example, and what to try, as markup.

    Once the scene is `changed`, this is said of the example as it was opened.
    """
    look, hint = _words(example, changed)
    return f"{_title(example, changed)} {escape(look)} {escape(hint)}"


def note_of(example: Preset, changed: bool) -> str:
    """Return the same in three paragraphs, and how to restore the example; for the place below the list of examples."""
    restore = CHANGED * changed
    return f"<p><b>{escape(example.title)}</b>{restore}</p>" + "".join(
        as_text(words, "about") for words in _words(example, changed)
    )


def _title(example: Preset, changed: bool) -> str:
    return f"<b>{escape(example.title)}{' (changed)' * changed}.</b>"


def _words(example: Preset, changed: bool) -> tuple[str, str]:
    if changed:
        return f"As opened: {example.look}", f"From there: {example.try_}"
    return example.look, example.try_


CITATION = (
    "A. N. Hirani, A. T. S. Wan, N. Wojtalewicz, "
    '<a href="https://doi.org/10.3934/jcd.2023009" target="_blank" rel="noopener"><cite>Conservative integrators for '
    "piecewise smooth systems with transversal dynamics</cite></a>, Journal of Computational Dynamics, 2023."
)
"""The paper whose method this is, as markup."""

_USE = (
    "Click in the portrait to start a trajectory; drag a star to move the start, and press Delete to remove it. "
    "Double-click beside the stars to fit the portrait to the trajectories.",
    "Choose integrators to compare them: dmm2 to dmm8 (Discrete Multiplier Method), prk8 and taylor conserve ψ; "
    "Runge–Kutta methods (rk) in general do not, and gauss4 conserves linear and quadratic ψ only.",
    "Views of a run: Conserved quantity (is ψ conserved?) and State (how do the variables change in time?). Of the "
    "integrators: Order (how fast do errors fall with τ?), Crossing time (how accurate are the times of crossings?), "
    "Cost (what does accuracy cost?) and Stability (which step sizes work?). Of the system: Section (where do "
    "trajectories meet a surface?) and Sweep (what does a parameter change?). Scheme: what is computed?",
    "Section shows where the trajectories of all starts meet a surface, or any h(t, x) = 0. Colours distinguish the "
    "starts, or the surfaces if there are several. A click there starts a trajectory on the surface, with the "
    "conserved quantities of the selected one.",
    "Sweep draws a bifurcation diagram: for each value of a parameter, the points at which the run meets the surface "
    "once a transient is over. Click in it to set the parameter. Under “more”: which surface, how many points, and "
    "whether each run starts where the run of the previous value ended.",
    "Where both fields point towards the surface, the solution slides along it (Filippov), as a block sticks under dry "
    "friction. The run follows it, or stops there if “Slide along the surface” is not ticked. A thick green line marks "
    "the sliding part of the surface, a dashed one the repelling part.",
    "Numbers may be formulas, such as 1/3, sqrt(2) or 2pi. Point at a field to see what it means.",
    "Where there are several surfaces, a region is named by the signs of their functions: in +− the first is "
    "positive and the second negative. Shades tell neighbouring regions apart.",
    "“Write your own …” takes the laws of both sides of a surface, or one law with sign, abs, max and so on, in which "
    "up to six surfaces are found; or, behind “Several surfaces, walls, hysteresis”, the law of each region. Conserved "
    "quantities are checked as you type.",
    "The address contains the scene and the settings of the current view; opening it restores them.",
)

_KEYS = {
    "?": "this help",
    "Ctrl+Z, Ctrl+Y": "undo, redo",
    "Tab, arrow keys, Enter": "go through the controls, choose, press",
    "Arrow keys, + and −, 0": "pan, zoom and refit the figure that has keyboard focus",
    "Shift+arrow keys": "move the selected start, with the keyboard focus on the portrait; with Ctrl in finer steps. "
    "The button + beside “Starts” adds one",
    "Space": "play or pause the animation while it is open; in the lecture mode, also open it",
    "L": "lecture mode, as the button above: full screen and large type, fewer words; Esc leaves it",
    "Ctrl+wheel": "zoom a figure around the pointer; the wheel alone scrolls the page",
    "Delete": "remove the selected start, with the pointer over the portrait; a button beside its number does the same",
    "Esc": "close a window such as this",
    "One finger, two fingers": "scroll the page; move and zoom the figure under them",
}

_CSS = """
ul { margin: 4px 0 12px; padding-left: 18px; } li { margin: 3px 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 3px 14px; margin: 4px 0 12px; } dd { margin: 0; }
h2 { font-size: 0.95rem; margin: 10px 0 2px; } a { color: inherit; }
"""


class Help(pn.viewable.Viewer):
    """The help in a dialog; its text is made when it is first opened.

    Parameters
    ----------
    turn : callable
        Turns the lecture mode on and off.
    """

    def __init__(self, turn: Callable[[], None]) -> None:
        super().__init__()
        self.text = markup_pane(_CSS)
        self.lecture = lecture = pmui.Button(
            label="Lecture mode", icon="co_present", variant="text", size="small", margin=0, sx=PLAIN_SX
        )  # fmt: skip
        lecture.on_click(lambda _: self._give_a_lecture(turn))
        self.dialog = dialog("Help", lecture, self.text, width="sm")

    def open(self, lecture: bool = False) -> None:
        """Open the dialog, which offers to leave the lecture mode if it is on."""
        self.lecture.label = "Leave the lecture mode" if lecture else "Lecture mode"
        self.text.object = self.text.object or _markup()
        self.dialog.open = True

    def _give_a_lecture(self, turn: Callable[[], None]) -> None:
        self.dialog.open = False
        turn()

    def __panel__(self) -> pn.viewable.Viewable:
        """The dialog, closed until it is opened."""
        return self.dialog


def _markup() -> str:
    use = "".join(f"<li>{escape(words)}</li>" for words in _USE)
    methods = {name: printed(method.doc) for name, method in core.METHODS.items()}
    keys, integrators = (
        "".join(f"<dt><b>{escape(name)}</b></dt><dd>{escape(words)}</dd>" for name, words in part.items())
        for part in (_KEYS, methods)
    )
    return (
        f"<p>{escape(ABOUT)}</p><h2>Keyboard and touch</h2><dl>{keys}</dl><h2>How to use it</h2><ul>{use}</ul>"
        f"<h2>Integrators</h2><dl>{integrators}</dl><h2>The method</h2><p>{CITATION}</p>"
    )
