"""What the user does with the starts in the portrait: place, move, remove and select them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.window import Window
from pwsviz.scene.checks import Start
from pwsviz.scene.scene import Scene

__all__ = ["StartsByHand", "at_point", "digits_of"]


class StartsByHand:
    """The starts of a scene, as gestures in a plane change them.

    Parameters
    ----------
    scene : Scene
        The settings.
    plane : callable
        Returns what is visible of the plane, and the variables that span it with their units.
    on_refused : callable
        Called with the reason why a start cannot be there.
    """

    def __init__(
        self, scene: Scene, plane: Callable[[], tuple[Window, Plane]], on_refused: Callable[[ValueError], None]
    ) -> None:
        self.scene, self._plane, self._on_refused = scene, plane, on_refused
        self._placed: tuple[dict[str, Any], ...] = ({}, {})  # the starts before and after the last click

    def place(self, x: float, y: float) -> None:
        """Add a trajectory that starts at a point of the plane."""
        before = self._starts()
        self._try(lambda: self.scene.place(self._state(x, y, self.scene.x0)))
        self._placed = before, self._starts()

    def take_back(self) -> bool:
        """Take back what the last click has placed; return whether it was the last change of the starts."""
        before, after = self._placed
        if self._starts() != after:
            return False
        self.scene.param.update(**before)
        return True

    def move(self, index: int, x: float, y: float) -> None:
        """Move the start of a trajectory to a point of the plane."""
        if index < len(self.scene.starts):
            self._try(lambda: self.scene.move(index, self._state(x, y, self.scene.starts[index])))

    def remove(self, index: int) -> None:
        """Remove a trajectory."""
        if index < len(self.scene.starts):
            self._try(lambda: self.scene.remove(index))

    def select(self, index: int) -> None:
        """Select a trajectory."""
        if index < len(self.scene.starts):
            self.scene.selected = index

    def _starts(self) -> dict[str, Any]:
        return {"starts": self.scene.starts, "selected": self.scene.selected}

    def _state(self, x: float, y: float, others: Start) -> Start:
        """Return the state at a point, rounded to about a pixel; coordinates that are not shown come from `others`."""
        view, plane = self._plane()
        return at_point(x, y, view, others, plane)

    def _try(self, change: Callable[[], None]) -> None:
        try:
            change()
        except ValueError as reason:
            self._on_refused(reason)


def at_point(x: float, y: float, view: Window, others: Start, plane: Plane = XY) -> Start:
    """Return the state at a point of the plane, rounded to about a pixel; the other coordinates come from `others`."""
    digits = digits_of(view, plane)
    (values,) = plane.values(np.array([[x, y]])).tolist()
    shown = {axis: round(value, count) for axis, value, count in zip(plane.axes, values, digits, strict=True)}
    return tuple(shown.get(k, value) for k, value in enumerate(others))


def digits_of(view: Window, plane: Plane = XY) -> tuple[int, int]:
    """Return to how many digits each variable has to be rounded to keep about a pixel of a view."""
    across, up = (3 - math.floor(math.log10(view.longest * unit)) for unit in plane.units)
    return across, up
