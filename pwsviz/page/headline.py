"""What the page is, or what it shows, at its head: in the header, and above the portrait on a narrow screen."""

from __future__ import annotations

from html import escape

from param.parameterized import Watcher

from pwsviz.figures.portrait_text import law_line, run_line
from pwsviz.page.help import ABOUT, GREETING_CSS, greeting, look_of
from pwsviz.page.look import TAGLINE_CSS
from pwsviz.page.shown_example import ShownExample
from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import markup_pane

__all__ = ["Headline"]

SHOWN = ["values", "tau", "t_end", "locate", "perturbation_order", "perturbation_scale"]
"""What of a scene a lecture shows beside the equations."""


class Headline:
    """Two panes that follow the system of a scene, and the example that it may be.

    Attributes
    ----------
    tagline
        In the header: what the page is; in a lecture, which leaves out the controls, the system.
    greeting
        Above a narrow portrait, as the controls are out of sight there: what the page is, and what to try; once a
        system is chosen its name, and with an example what to look at.
    """

    def __init__(self, scene: Scene, example: ShownExample | None = None) -> None:
        self.scene, self._example = scene, example or ShownExample(scene)
        self._of_lecture: Watcher | None = None
        self._fresh = scene.system == Scene.param.system.default  # nothing has been chosen yet
        self.tagline, self.greeting = markup_pane(TAGLINE_CSS), markup_pane(GREETING_CSS)
        self.show()
        self._write_tagline()
        scene.param.watch(lambda *_: self._choose(), ["system", "own"])
        self._example.param.watch(lambda *_: self._choose(), "preset")
        self._example.param.watch(lambda *_: self.show(), "changed")

    def give_lecture(self, begun: bool) -> None:
        """Show the laws, the values of the parameters and the step size as long as a lecture lasts."""
        if self._of_lecture is not None:
            self.scene.param.unwatch(self._of_lecture)
        self._of_lecture = self.scene.param.watch(lambda *_: self._write_tagline(), SHOWN) if begun else None
        self._write_tagline()

    def show(self) -> None:
        """Show what to look at in the example, or the name of the system; on a fresh page also what to try."""
        example, changed = self._example.preset, self._example.changed
        words = f"<b>{escape(self.scene.declaration.name)}</b>" if example is None else look_of(example, changed)
        self.greeting.object = greeting(example, changed) if self._fresh else f'<p class="greeting">{words}</p>'

    def _choose(self) -> None:
        """Show another system, or another example."""
        self._fresh = False
        self._write_tagline()
        self.show()

    def _write_tagline(self) -> None:
        name = escape(self.scene.declaration.name)
        laws = ""
        if self._of_lecture is not None:
            laws = f"<div>{law_line(self.scene.declaration)}{run_line(self.scene)}</div>"
        self.tagline.object = f'<p>{escape(ABOUT)}</p><div class="lecture"><b>{name}</b>{laws}</div>'
