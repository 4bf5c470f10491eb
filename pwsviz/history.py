"""Undo: what the scene was before."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

import param

from pwsviz.scene import Scene

MAX_STEPS_BACK = 100
ONE_GESTURE = 0.8
"""Seconds; changes of the same settings that follow one another faster are one step, as of a dragged slider."""

AT_ONCE = 0.05
"""Seconds; what follows faster follows from the change before, as another system brings its own start."""

NOT_UNDONE = ("name", "view")
"""Looking at another view changes nothing."""


class History(param.Parameterized):
    """Remembers the settings of a scene, as far back as `MAX_STEPS_BACK` gestures."""

    possible = param.Boolean(default=False, doc="Whether there is anything to undo.")

    def __init__(self, scene: Scene, clock: Callable[[], float] = monotonic) -> None:
        super().__init__()
        self.scene, self._clock = scene, clock
        self._past: list[dict[str, Any]] = []
        self._now = scene.settings()
        self._gesture: tuple[frozenset[str], float] = (frozenset(), -ONE_GESTURE)
        scene.param.watch(self._remember, [name for name in scene.param if name not in NOT_UNDONE])

    def _remember(self, *events: Any) -> None:
        names, at = frozenset(event.name for event in events), self._clock()
        same, when = self._gesture
        follows = at - when < AT_ONCE and bool(self._past)
        if not follows and (names != same or at - when > ONE_GESTURE):
            self._past = [*self._past, self._now][-MAX_STEPS_BACK:]
        self._gesture, self._now = (same if follows else names, at), self.scene.settings()
        self.possible = True

    def undo(self) -> None:
        """Go one gesture back; nothing where there is none."""
        if not self._past:
            return
        *earlier, before = self._past
        self.scene.restore({**before, **{name: getattr(self.scene, name) for name in NOT_UNDONE if name != "name"}})
        self._past, self._now, self._gesture = earlier, self.scene.settings(), (frozenset(), -ONE_GESTURE)
        self.possible = bool(earlier)
