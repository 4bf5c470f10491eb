"""Undo and redo of changes to a scene."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

import param

from pwsviz.scene.scene import Scene

MAX_STEPS_BACK = 100
"""Gestures that can be undone, so that a long session does not grow without bound."""

ONE_GESTURE = 0.8
"""Seconds; changes of the same settings at shorter intervals are undone together, such as those of a dragged slider."""

AT_ONCE = 0.05
"""Seconds; a change that follows sooner is a consequence of the last, such as the start that a new system brings."""

_NONE: tuple[frozenset[str], float] = (frozenset(), -ONE_GESTURE)  #: no gesture that could go on

NOT_UNDONE = ("name", "view")
"""Settings that undo leaves alone: opening another view changes no result."""


class History(param.Parameterized):
    """Remembers the settings of a scene before each of the last `MAX_STEPS_BACK` gestures that changed something."""

    can_undo = param.Boolean(default=False, doc="Whether there is anything to undo.")
    can_redo = param.Boolean(default=False, doc="Whether there is anything to redo.")

    def __init__(self, scene: Scene, clock: Callable[[], float] = monotonic) -> None:
        super().__init__()
        self.scene, self._clock = scene, clock
        self._past: list[dict[str, Any]] = []
        self._future: list[dict[str, Any]] = []
        self._dropped = self._future  # by the last gesture
        self._now = scene.settings()
        self._gesture: tuple[frozenset[str], float] = _NONE
        self._held = False
        scene.param.watch(self._remember, [name for name in scene.param if name not in NOT_UNDONE])

    def _remember(self, *events: Any) -> None:
        names, at = frozenset(event.name for event in events), self._clock()
        same, when = self._gesture
        follows = at - when < AT_ONCE and bool(self._past)
        continues = bool(names & same) if self._held else names == same and at - when <= ONE_GESTURE
        if not follows and not continues:
            self._past = [*self._past, self._now][-MAX_STEPS_BACK:]
            self._dropped, self._future = self._future, []
        self._gesture, self._now = (same if follows else names, at), self.scene.settings()
        if _without_view(self._now) == _without_view(self._past[-1]):  # the gesture has taken itself back
            self._past, self._future, self._gesture = self._past[:-1], self._dropped, _NONE
        self.param.update(can_undo=bool(self._past), can_redo=bool(self._future))

    def hold(self, held: bool) -> None:
        """Begin or end a gesture whose changes are undone together, however late they come: a machine may be busy."""
        if held != self._held:
            self._held, self._gesture = held, _NONE

    def undo(self) -> list[str]:
        """Undo the last gesture, if there is one; returns the settings that change."""
        if not self._past:
            return []
        *earlier, before = self._past
        return self._go(before, earlier, [*self._future, self._now])

    def redo(self) -> list[str]:
        """Redo what the last `undo` undid, unless a change has been made since; returns the settings that change."""
        if not self._future:
            return []
        *later, after = self._future
        return self._go(after, [*self._past, self._now], later)

    def _go(self, settings: dict[str, Any], past: list[dict[str, Any]], future: list[dict[str, Any]]) -> list[str]:
        changed = [name for name, value in _without_view(settings).items() if value != self._now[name]]
        self.scene.restore(_without_view(settings))
        self._past, self._future, self._held = past, future, False  # what was held may be gone
        self._now, self._gesture = self.scene.settings(), _NONE
        self.param.update(can_undo=bool(past), can_redo=bool(future))
        return changed


def _without_view(settings: dict[str, Any]) -> dict[str, Any]:
    """Return the settings that undo brings back."""
    return {name: value for name, value in settings.items() if name not in NOT_UNDONE}
