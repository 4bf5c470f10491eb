"""What the person chose, and nothing else: no widgets, no arrays.

Every setting is checked here, in the units and words of the person who typed it. `Scene.accept` either takes
a value over or raises a ValueError whose text can stand beside the field; a scene is therefore valid at all times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import param

import core
from core.integrate import checked_method, checked_start
from pwsviz.names import short_name

MAX_STEPS = 2_000_000
"""The most steps the page asks of one run, so that a slip of the keyboard cannot keep it busy."""

MAX_COORDINATE = 1e6
VIEWS = {"conserved": "Conserved quantity", "order": "Order", "time": "Crossing time"}
"""The views beside the portrait, one at a time: key and title, in display order."""

TOLERANCES = (1e-15, 1e-3)
"""Least and greatest tolerance of an integrator that chooses its own steps."""

END_TIMES = {"type_upward": 40.0, "type_downward": 40.0, "type_sliding": 40.0}
"""Least end times of systems that are slow: by the usual one they would just have reached the surface."""

PERTURBATION_ORDERS = (None, 1, 2, 3, 4, 6, 8)


class Scene(param.Parameterized):
    """The settings of one page: a system, where it starts, and how it is integrated."""

    system: Any = param.Selector(default="elliptic_curve", objects=list(core.CATALOGUE), doc="Key in `core.CATALOGUE`.")
    values = param.Dict(default={}, doc="Value of each parameter of the system.")
    x0 = param.ClassSelector(default=(), class_=tuple, doc="Initial state.")
    methods = param.ListSelector(default=["dmm2", "rk2"], objects=list(core.METHODS), doc="Integrators side by side.")
    tau = param.Number(default=1e-2, bounds=(1e-6, 1.0), doc="Step size.")
    tolerance = param.Number(default=1e-12, bounds=TOLERANCES, doc="Of an integrator that chooses its own steps.")
    t_end = param.Number(default=20.0, bounds=(1e-3, 1e5), doc="End time; the run starts at 0.")
    locate = param.Boolean(default=True, doc="Land on the surface at crossings (Mannshardt), or step over it.")
    perturbation_order: Any = param.Selector(
        default=None, objects=list(PERTURBATION_ORDERS), doc="Order p of the disturbance c·τᵖ of crossing times."
    )
    perturbation_scale = param.Number(default=1.0, bounds=(-10.0, 10.0), doc="Its factor c.")
    view: Any = param.Selector(default="conserved", objects=list(VIEWS), doc="The view beside the portrait.")
    study_method: Any = param.Selector(default="dmm2", objects=list(core.METHODS), doc="Integrator of the order study.")

    def __init__(self, **params: Any) -> None:
        super().__init__(**params)
        chosen = core.CATALOGUE[self.system]
        self._follow_methods()
        missing = {"values": dict(chosen.values), "x0": tuple(chosen.x0), "t_end": self._long_enough()}
        self.param.update(**{name: value for name, value in missing.items() if name not in params})

    @param.depends("system", watch=True)
    def _start_afresh(self) -> None:
        chosen = core.CATALOGUE[self.system]
        start = tuple(float(x) for x in chosen.x0)
        self.param.update(values=dict(chosen.values), x0=start, t_end=self._long_enough())

    def _long_enough(self) -> float:
        """Return the end time, later where the system is slow, but no later than the step size allows."""
        wanted = max(self.t_end, END_TIMES.get(self.system, 0.0))
        return float(max(self.t_end, min(wanted, self.tau * MAX_STEPS)))

    @property
    def offered(self) -> list[str]:
        """Integrators that can be used with the system."""
        return [name for name in core.METHODS if _can_use(core.CATALOGUE[self.system], name)]

    @property
    def used(self) -> list[str]:
        """The chosen integrators that can be used with the system; one that can, where none of them can.

        The others stay chosen: another system brings them back.
        """
        offered = self.offered
        return [name for name in self.methods if name in offered] or offered[:1]

    @param.depends("system", "methods", watch=True)
    def _follow_methods(self) -> None:
        """Offer the order study what it can measure: methods with an order."""
        steady = [name for name in self.offered if not core.METHODS[name].adaptive]
        objects = [name for name in self.used if name in steady] or steady[:1]
        self.param["study_method"].objects = objects
        if self.study_method not in objects:
            self.study_method = objects[0]

    def build(self) -> core.PiecewiseSystem:
        """Return the chosen system at the chosen parameter values."""
        return core.CATALOGUE[self.system].with_parameters(**self.values)

    def accept(self, field: str, value: object) -> None:
        """Take over one setting.

        Parameters
        ----------
        field : str
            ``"tau"``, ``"tolerance"``, ``"t_end"``, ``"perturbation_scale"``, ``"methods"``, ``"x0"``,
            ``"x0.<index>"`` or ``"values.<name>"``.
        value : object
            A number, its text, a tuple of numbers for ``"x0"``, or a list of names for ``"methods"``: which of those
            offered to use.

        Raises
        ------
        ValueError
            Where the value makes no sense, in plain words; the scene is then unchanged.
        """
        name, _, part = field.partition(".")
        checks: dict[str, Callable[[str, object], Any]] = {
            "tau": self._checked_tau,
            "tolerance": self._checked_tolerance,
            "t_end": self._checked_end,
            "perturbation_scale": self._checked_scale,
            "methods": self._checked_methods,
            "x0": self._checked_x0,
            "values": self._checked_values,
        }
        self.param.update(**{name: checks[name](part, value)})

    def _checked_tau(self, _: str, value: object) -> float:
        tau = number(value, "The step size", *self.param["tau"].bounds)
        require_few_steps(self.t_end, tau)
        return tau

    def _checked_tolerance(self, _: str, value: object) -> float:
        return number(value, "The tolerance", *self.param["tolerance"].bounds)

    def _checked_end(self, _: str, value: object) -> float:
        t_end = number(value, "The end time", *self.param["t_end"].bounds)
        require_few_steps(t_end, self.tau)
        return t_end

    def _checked_scale(self, _: str, value: object) -> float:
        return number(value, "The factor", *self.param["perturbation_scale"].bounds)

    def _checked_methods(self, _: str, value: object) -> list[str]:
        if not isinstance(value, list) or not value:
            raise ValueError("Choose at least one integrator.")
        resting = set(self.methods) - set(self.offered)
        return [name for name in core.METHODS if name in value or name in resting]

    def _checked_x0(self, index: str, value: object) -> tuple[float, ...]:
        wanted: list[Any] = list(self.x0)
        if index:
            wanted[int(index)] = value
        else:
            wanted = list(value) if isinstance(value, tuple) else []
        names = core.CATALOGUE[self.system].variables
        if len(wanted) != len(names):
            raise ValueError(f"A start needs {len(names)} numbers: {', '.join(names)}.")
        start = tuple(number(x, name, -MAX_COORDINATE, MAX_COORDINATE) for name, x in zip(names, wanted, strict=True))
        return checked_start(self.build(), 0.0, start)

    def _checked_values(self, name: str, value: object) -> dict[str, float]:
        parameter = next(p for p in core.CATALOGUE[self.system].parameters if p.name == name)
        low, high = parameter.bounds or (-MAX_COORDINATE, MAX_COORDINATE)
        return {**self.values, name: number(value, short_name(parameter), low, high)}


def _can_use(system: core.PiecewiseSystem, method: str) -> bool:
    try:
        checked_method(system, method)
    except ValueError:
        return False
    return True


def number(value: object, subject: str, low: float, high: float) -> float:
    """Read a number and check its range.

    Raises
    ------
    ValueError
        Naming the subject, the text and what would do.
    """
    try:
        result = float(str(value).strip().replace("−", "-"))
    except ValueError:
        raise ValueError(f"“{value}” is not a number. Type one such as 0.01 or 1e-3.") from None
    if not math.isfinite(result):
        raise ValueError(f"“{value}” is not a finite number. Type one such as 0.01 or 1e-3.")
    if not low <= result <= high:
        raise ValueError(f"{subject} has to lie between {low:g} and {high:g}.")
    return result


def require_few_steps(t_end: float, tau: float) -> None:
    """Refuse a run longer than `MAX_STEPS`, saying what to change."""
    steps = t_end / tau
    if steps > MAX_STEPS * (1 + 1e-9):
        raise ValueError(
            f"{steps:,.0f} steps are more than this page runs ({MAX_STEPS:,}): "
            f"take τ ≥ {_rounded_up(t_end / MAX_STEPS)} or an end time ≤ {tau * MAX_STEPS:g}."
        )


def _rounded_up(value: float) -> str:
    """`value` with two digits, never less than itself."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1 - 1e-12)) * power:.2g}"
