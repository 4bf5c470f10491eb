"""The crossings of a run: one, and the sequence of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from core.interface.arguments import listed
from core.kernels.arrays import Floats
from core.transition.records import NO_MODE

__all__ = ["Crossing", "Crossings", "Integers", "side_columns", "with_columns"]

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Crossing:
    """One of `Crossings`."""

    t: float
    """Time t̂."""
    x: Floats
    """(d,) state x̂ on the surface (off it, if displaced by a perturbation)."""
    x_after: Floats
    """(d,) state from which the run continued: x, or the state after the jump."""
    surface: Floats
    """(d,) state where the scheme itself met the surface: x, unless it was perturbed or stepped over."""
    mode: int
    """Index into `PiecewiseSystem.modes` of the mode entered; −1 if the run stopped there."""
    g: float
    """Residual of the switching function at x."""
    kind: str
    """One of `core.transition.status.CROSSING_KINDS`."""
    rate_before: float
    """∇g·f + g_t of the side left, at the surface."""
    rate_after: float
    """The same of the side entered."""
    side: Any
    """Side entered, −1 or +1; 0 if the run slides from there, or stopped there. (k,) of several surfaces."""
    surface_met: int
    """Index into `PiecewiseSystem.surfaces` of the surface met; −1 where sliding ended by itself."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """The crossings of a run: a sequence of `Crossing`, stored as one array for each field.

    ``crossings[k]`` is the k-th, from 0 (−1: the last); ``crossings[10:20]`` and ``crossings[crossings.side == 1]`` are
    selections; ``for crossing in crossings`` iterates over all.
    """

    t: Floats
    """(k,) times t̂."""
    x: Floats
    """(k, d) states x̂ on the surface (off it, if displaced by a perturbation)."""
    x_after: Floats
    """(k, d) states from which the run continued: x, or the states after the jump."""
    surface: Floats
    """(k, d) states where the scheme itself met the surface: x, unless it was perturbed or stepped over."""
    mode: Integers
    """(k,) index into `PiecewiseSystem.modes` of the mode entered; −1 if the run stopped there."""
    g: Floats
    """(k,) residual of the switching function at x."""
    kind: NDArray[np.str_]
    """(k,) one of `core.transition.status.CROSSING_KINDS` each."""
    rate_before: Floats
    """(k,) ∇g·f + g_t of the side left, at the surface."""
    rate_after: Floats
    """(k,) the same of the side entered."""
    side: Integers
    """(k,) side entered, −1 or +1; 0 if the run slides from there, or stopped there. (k, surfaces) of several surfaces;
    without columns where regions have names."""
    surface_met: Integers
    """(k,) index into `PiecewiseSystem.surfaces` of the surface met; −1 where sliding ended by itself."""

    def __repr__(self) -> str:
        if not len(self):
            return "<Crossings: none>"
        kinds = ", ".join(f"{n} {kind}" for kind, n in zip(*np.unique(self.kind, return_counts=True), strict=True))
        return f"<Crossings: {len(self)}, t = {self.t[0]:.6g} … {self.t[-1]:.6g}; {kinds}>"

    def __len__(self) -> int:
        return len(self.t)

    def __iter__(self) -> Iterator[Crossing]:
        return (self[k] for k in range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Crossing: ...

    @overload
    def __getitem__(self, which: slice | Integers | NDArray[np.bool_]) -> Crossings: ...

    def __getitem__(self, which: Any) -> Crossing | Crossings:
        parts = [getattr(self, f.name)[which] for f in fields(self)]
        if np.ndim(parts[0]):
            return Crossings(*parts)
        return Crossing(*(part.item() if np.ndim(part) == 0 else part for part in parts))

    @property
    def passed(self) -> Crossings:
        """The crossings after which the run continued: where it stops on the surface it does not cross."""
        continued: NDArray[np.bool_] = self.mode != NO_MODE
        return self[continued]

    @property
    def crossed(self) -> Crossings:
        """The crossings at which the run went through the surface or jumped: no beginnings and ends of sliding."""
        through: NDArray[np.bool_] = (self.mode != NO_MODE) & (self.kind != "sliding") & (self.kind != "leaving")
        return self[through]

    def first(self, count: int) -> Crossings:
        """The first `count` crossings."""
        return self[:count]

    def columns(self, variables: tuple[str, ...] | None = None) -> dict[str, NDArray[Any]]:
        """One (k,) array a column, as data frames take them: ``pandas.DataFrame(run.crossings.columns())``.

        Parameters
        ----------
        variables
            Names of the d coordinates; x0, x1, … by default.
        """
        d = self.x.shape[1]
        usual = [f"x{i}" for i in range(d)]
        names = listed(usual if variables is None else variables, "variables", f"{d} names are needed")
        if len(names) != d or not all(isinstance(name, str) for name in names):
            raise ValueError(f"variables = {variables!r}: {d} names are needed")
        columns: dict[str, NDArray[Any]] = {"t": self.t}
        for part, ending in ((self.x, ""), (self.x_after, " after")):
            columns |= {f"{name}{ending}": part[:, i] for i, name in enumerate(names)}
        columns = with_columns(columns, side_columns(self.side))
        return with_columns(columns, {n: getattr(self, n) for n in ("g", "kind", "rate_before", "rate_after")})


def side_columns(side: Integers) -> dict[str, NDArray[Any]]:
    """Name -> column of sides: "side" of one surface; "side 1", "side 2" … of several."""
    if side.ndim == 1:
        return {"side": side}
    return {f"side {k + 1}": side[:, k] for k in range(side.shape[1])}


def with_columns(columns: dict[str, NDArray[Any]], more: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Add columns; an underscore is appended to names that variables have taken."""
    for name, column in more.items():
        while name in columns:
            name += "_"
        columns[name] = column
    return columns
