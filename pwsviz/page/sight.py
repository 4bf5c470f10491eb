"""What of its plane the portrait shows: the window of the scene, what the user pans to, or what suits the curves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.window import Window
from pwsviz.page.starts_by_hand import digits_of
from pwsviz.page.window_fields import Ends, WindowFields
from pwsviz.results.results import Pictures, PortraitInputs
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import window

__all__ = ["Sight"]


class Sight:
    """The part of the plane that a portrait shows.

    Parameters
    ----------
    scene : Scene
        The settings, with the window if the user has chosen one.
    portrait : PortraitView
        The figure.
    on_change : callable
        Called when another part is seen.
    """

    def __init__(self, scene: Scene, portrait: PortraitView, on_change: Callable[[], None]) -> None:
        self.scene, self.portrait, self._on_change = scene, portrait, on_change
        self.covered: Window | None = None  # by the backdrop, since the view was last set
        self.limits = WindowFields(scene, self.ends, self.fit)
        self._shown: Pictures | None = None
        self._visible: Window | None = None  # as the browser tells
        self._fitted: Window | None = None  # what was shown last while the scene had no window
        self._told: Any = None  # the window of the scene, if it was read off the view
        self._aimed_at: tuple[Any, Any, int] = (None, None, -1)  # system, plane, and loads of the scene
        scene.param.watch(self._take_window, "window")

    @property
    def plane(self) -> Plane:
        """The variables that span the plane, with their units."""
        return self._shown.plane if self._shown is not None else XY

    @property
    def visible(self) -> Window | None:
        """What is visible of the plane; None before the first picture."""
        return self._visible or self.portrait.frame

    def show(self, shown: Pictures) -> None:
        """Set the view if these are the first pictures of a system, of a plane, or of a scene that was loaded."""
        self._shown = shown
        if self.keeps(shown.inputs):
            return
        current, before = self._is_current(shown), self._aimed_at[:2]
        if current or before != (shown.inputs.declaration, shown.inputs.axes):
            self._aimed_at = (shown.inputs.declaration, shown.inputs.axes, self.scene.loads if current else -1)
            self._aim()

    def keeps(self, inputs: PortraitInputs) -> bool:
        """Whether the view stays as it is when these pictures come, if they are those of the present scene."""
        return self._aimed_at == (inputs.declaration, inputs.axes, self.scene.loads)

    def fit(self) -> None:
        """Let the view show the present trajectories; again when they are computed, if they are not yet."""
        if self._shown is not None and not self._is_current(self._shown):
            self._aimed_at = (*self._aimed_at[:2], -1)
        moved = self.scene.window is not None
        self._told = None
        self.scene.window = None
        self._aim(moved=moved)
        self._on_change()

    def look_at(self, seen: Window) -> None:
        """Take what the browser shows."""
        self._visible = seen
        self.limits.sync()
        self._on_change()

    def keep(self, seen: Window) -> None:
        """Keep what the user looks at after panning or zooming, rounded to about a pixel."""
        self._visible = seen
        try:
            self._told = window(self.ends())
        except ValueError:  # farther out than a link can say
            return
        self.scene.window = self._told
        self.limits.sync()
        self._on_change()

    def ends(self) -> Ends:
        """Return the ends of what is visible, as values of the two variables, rounded to about a pixel."""
        seen = self.visible or Window(-1.0, 1.0, -1.0, 1.0)
        ends = self.plane.values(np.array([seen[::2], seen[1::2]])).T.tolist()
        return tuple(
            round(end, digits) for pair, digits in zip(ends, digits_of(seen, self.plane), strict=True) for end in pair
        )

    def covering(self) -> Window | None:
        """Return the window of a backdrop for the visible part of the plane; None if nothing is visible yet.

        What is seen at rest, and so its level sets and arrows, follows from the window of the scene alone, not from the
        way on which it was reached; while the user pans, the backdrop that is there serves as long as it suffices.
        """
        kept, frame, visible = self.scene.window, self.portrait.frame, self.visible
        if visible is None:
            return None
        at_rest = frame if kept is None else self._drawn(kept)
        offered = [at_rest.surroundings()] if at_rest is not None else []
        offered += [self.covered] if self.covered is not None else []
        return next((one for one in offered if one.shows_well(visible)), visible.surroundings())

    def _take_window(self, event: Any) -> None:
        """Show the window of the scene, unless it was read off the view."""
        if event.new != self._told:
            self._aim(self._fitted, moved=event.old is not None)
            self._on_change()

    def _aim(self, usual: Window | None = None, moved: bool = False) -> None:
        """Let the view show the window of the scene; without one, the usual one or what suits the trajectories.

        `moved` tells that the user has panned or zoomed since the view was last set.
        """
        self._told, before, self.covered = self.scene.window, self.portrait.frame, None
        if self.scene.window is not None:
            self.portrait.look_at(self._drawn(self.scene.window))
        elif usual is not None:
            self.portrait.look_at(usual)
        else:
            self.portrait.fit()
            self._fitted = self.portrait.frame
        if moved or self.portrait.frame != before:  # else the browser, which shows it already, has nothing to report
            self._visible = None
        self.limits.sync()

    def _drawn(self, ends: Ends) -> Window:
        """Return the window with these ends, which are values of the two variables."""
        across, up = self.plane.units
        left, right, low, high = ends
        return Window(left / across, right / across, low / up, high / up)

    def _is_current(self, shown: Pictures) -> bool:
        return bool(shown.inputs == PortraitInputs.of(self.scene))
