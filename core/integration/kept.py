"""Crossings and events of many members, as far as they are kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Integers
from core.kernels.arrays import Floats
from core.transition.status import CROSSING_KINDS

__all__ = ["EnsembleCrossings", "EnsembleEvents"]

_KINDS = np.array(CROSSING_KINDS)


@dataclass(frozen=True, eq=False)
class EnsembleCrossings:
    """Crossings, member after member; those of member k are ``offsets[k]`` to ``offsets[k + 1]``."""

    t: Floats
    """(c,) times."""
    x: Floats
    """(c, d) states on the surface (off it, if displaced by a perturbation)."""
    x_after: Floats
    """(c, d) states from which the members continued: x, or the states after jumps."""
    mode: NDArray[np.int16]
    """(c,) index into `PiecewiseSystem.modes` of the mode entered; −1 if the member stopped there."""
    kind_code: NDArray[np.int8]
    """(c,) index into `core.transition.status.CROSSING_KINDS`."""
    surface_met: NDArray[np.int8]
    """(c,) index into `PiecewiseSystem.surfaces` of the surface met; −1 where sliding ended by itself."""
    offsets: Integers
    """(n + 1,) where the crossings of each member begin, and where the last end."""
    sides: Integers
    """(modes + 1, surfaces) sides of each mode; of those of one that has stopped, the last row."""

    def __len__(self) -> int:
        return len(self.t)

    @property
    def side(self) -> Integers:
        """(c,) side entered, −1 or +1, or 0 where a member slides or stops; (c, surfaces) of several surfaces."""
        side: Integers = self.sides[self.mode]
        return side[:, 0] if side.shape[1] == 1 else side

    @property
    def kind(self) -> NDArray[np.str_]:
        """(c,) kinds in words, as in `Crossings`."""
        kinds: NDArray[np.str_] = _KINDS[self.kind_code]
        return kinds

    @property
    def member(self) -> Integers:
        """(c,) number of the member."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


@dataclass(frozen=True, eq=False)
class EnsembleEvents:
    """Events, member after member; those of member k are ``offsets[k]`` to ``offsets[k + 1]``."""

    t: Floats
    """(c,) times."""
    x: Floats
    """(c, d) states."""
    number: NDArray[np.int16]
    """(c,) index of the event function."""
    direction: NDArray[np.int8]
    """(c,) 1 where the function increases with time, −1 where it decreases."""
    mode: NDArray[np.int16]
    """(c,) index into `PiecewiseSystem.modes` of the mode occupied before."""
    offsets: Integers
    """(n + 1,) where the events of each member begin, and where the last end."""

    def __len__(self) -> int:
        return len(self.t)

    @property
    def member(self) -> Integers:
        """(c,) number of the member."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))
