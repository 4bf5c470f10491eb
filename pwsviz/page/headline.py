"""What the page is, or what it shows, at its head: in the header, and above the portrait on a narrow screen."""

from __future__ import annotations

from html import escape

from param.parameterized import Watcher

from pwsviz.figures.portrait_text import law_line, run_line
from pwsviz.page.help import ABOUT, GREETING_CSS, greeting, look_of
from pwsviz.page.look import TAGLINE_CSS
from pwsviz.scene.presets import Preset
from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import markup_pane

__all__ = ["Headline"]

SHOWN = ["values", "tau", "t_end", "locate", "perturbation_order", "perturbation_scale"]
"""What of a scene a lecture shows beside the equations."""


class Headline:
    """Two panes that follow the system of a scene, which may be that of an example from the beginning.

    Attributes
    ----------
    tagline
        In the header: what the page is; in a lecture, which leaves out the controls, the system.
    greeting
        Above a narrow portrait, as the controls are out of sight there: what the page is, and what to try; once a
        system is chosen its name, and with an example what to look at.
    """

    def __init__(self, scene: Scene, example: Preset | None = None) -> None:
        self.scene = scene
        self._of_lecture: Watcher | None = None
        self.tagline, self.greeting = markup_pane(TAGLINE_CSS), markup_pane(GREETING_CSS)
        self.greeting.object = greeting(example)
        if scene.system != Scene.param.system.default:
            self.show()
        self._write_tagline()
        scene.param.watch(lambda *_: self.show(), ["system", "own"])

    def give_lecture(self, begun: bool) -> None:
        """Show the laws, the values of the parameters and the step size as long as a lecture lasts."""
        if self._of_lecture is not None:
            self.scene.param.unwatch(self._of_lecture)
        self._of_lecture = self.scene.param.watch(lambda *_: self._write_tagline(), SHOWN) if begun else None
        self._write_tagline()

    def show(self, preset: Preset | None = None) -> None:
        """Show the name of the system, and what to look at in an example that has just been loaded."""
        self._write_tagline()
        words = f"<b>{escape(self.scene.declaration.name)}</b>" if preset is None else look_of(preset)
        self.greeting.object = f'<p class="greeting">{words}</p>'

    def _write_tagline(self) -> None:
        name = escape(self.scene.declaration.name)
        laws = ""
        if self._of_lecture is not None:
            laws = f"<div>{law_line(self.scene.declaration)}{run_line(self.scene)}</div>"
        self.tagline.object = f'<p>{escape(ABOUT)}</p><div class="lecture"><b>{name}</b>{laws}</div>'
