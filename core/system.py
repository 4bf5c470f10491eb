"""PiecewiseSystem and Parameter: a system is data, from which everything else is derived."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike

from core.interface.arguments import listed, number
from core.kernels.arrays import Floats
from core.symbolic.declaration import Declaration, accepted, miscounted
from core.symbolic.expressions import check_name, to_text
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode
from core.transition.records import SIDES_OF_MODES

__all__ = ["Parameter", "PiecewiseSystem", "Start"]

#: Initial state: d numbers, or a mapping from the name of each variable to its number.
Start: TypeAlias = "Iterable[float] | Mapping[str, float]"


@dataclass(frozen=True)
class Parameter:
    """A number in a system that can be changed without compiling it anew."""

    name: str
    """Identifier, as used in the expressions."""
    default: float
    """Initial value."""
    bounds: tuple[float, float] | None = None
    """Least and greatest allowed value."""
    doc: str = ""
    """Its meaning, in a few words."""
    latex: str | None = None
    """LaTeX for it; derived from the name where not given."""

    def __post_init__(self) -> None:
        check_name(self.name, "parameter")
        if self.bounds is not None:
            if not isinstance(self.bounds, Sequence) or len(self.bounds) != 2:
                raise ValueError(f"bounds of parameter {self.name} are {self.bounds!r}: two numbers are needed")
            low, high = (number(b, f"bound of parameter {self.name}") for b in self.bounds)
            if not low < high:
                raise ValueError(f"bounds of parameter {self.name} are {self.bounds}: the first must be the smaller")
            object.__setattr__(self, "bounds", (low, high))
        object.__setattr__(self, "default", self.check(self.default))

    @property
    def symbol(self) -> str:
        """LaTeX for it."""
        return self.latex or _latex_name(self.name)

    def check(self, value: float) -> float:
        """Return `value` as a float if the parameter may take it, else raise ValueError."""
        found = number(value, f"parameter {self.name}")
        if self.bounds is not None and not self.bounds[0] <= found <= self.bounds[1]:
            raise ValueError(f"parameter {self.name} = {found!r} is outside {self.bounds[0]:g} … {self.bounds[1]:g}")
        return found


@dataclass(frozen=True)
class PiecewiseSystem:
    """x' = f₋(t, x) where g < 0 and f₊(t, x) where g > 0, each side with its own conserved quantities.

    Expressions are text, or sympy, in the variables, the parameters and time ``t``; see `core.symbolic.expressions` for
    the syntax. A system is frozen; `with_parameters` returns a new one.

    Parameters
    ----------
    name
        Name for display.
    variables
        The d names of the state's coordinates.
    f_minus, f_plus
        d expressions each.
    g
        The switching function; ∇g ≠ 0.
    psi_minus, psi_plus
        0 to d − 1 conserved quantities of each side, () where none is known. For a planar divergence-free field the
        stream function is then found, where that is easy (see `stream_function`).
    parameters
        name -> value, name -> `Parameter`, or a sequence of `Parameter`.
    x0
        Default initial state, d numbers; zeros where not given.
    jump
        d expressions: the state after reaching the surface, for impacts. None or (): the state is continuous.
    doc
        Description of the system, in a sentence or two.

    Raises
    ------
    ValueError
        On unknown names, syntax outside the whitelist, wrong dimensions, constants that are not finite, or a ψ that the
        field does not conserve everywhere on its side. The message names the text and what would be accepted.
    """

    name: str
    variables: tuple[str, ...]
    f_minus: tuple[str, ...]
    f_plus: tuple[str, ...]
    g: str
    psi_minus: tuple[str, ...] = ()
    psi_plus: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    x0: tuple[float, ...] = ()
    jump: tuple[str, ...] | None = None
    doc: str = ""
    values: Mapping[str, float] = field(default_factory=dict, hash=False)
    """Current value of each parameter; the default where none is given."""

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "name", str(self.name))
        set_(self, "parameters", self._check_parameters())
        for name in ("variables", "f_minus", "f_plus", "psi_minus", "psi_plus"):
            set_(self, name, _texts(getattr(self, name), name))
        set_(self, "jump", None if self.jump is None else _texts(self.jump, "jump") or None)
        set_(self, "g", _text(self.g))
        set_(self, "values", MappingProxyType(self._check_values(self.values)))
        set_(self, "psi_minus", self._declared.psi_minus)
        set_(self, "psi_plus", self._declared.psi_plus)
        start = self.check_state((0.0,) * self.dimension if isinstance(self.x0, tuple) and not self.x0 else self.x0)
        set_(self, "x0", start)

    def __reduce__(self) -> tuple[Any, ...]:
        given = [getattr(self, f.name) for f in fields(self)]
        return PiecewiseSystem, (*given[:-1], dict(self.values))

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {value:g}" for name, value in self.values.items())
        return f"<PiecewiseSystem {self.name!r} in {', '.join(self.variables)}{values and '; ' + values}>"

    # Declaration -----------------------------------------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        """d, the number of variables."""
        return len(self.variables)

    @cached_property
    def _declared(self) -> Declaration:
        """The checked declaration, shared by all systems that differ in parameter values only."""
        names, bounds = tuple(q.name for q in self.parameters), tuple(q.bounds for q in self.parameters)
        texts = (self.f_minus, self.f_plus, (self.g,), self.psi_minus, self.psi_plus, self.jump or ())
        return accepted(Declaration(self.variables, names, bounds, *texts))

    @property
    def laws(self) -> Laws:
        """The laws as sympy expressions, shared by all systems that differ in parameter values only."""
        return self._declared.laws

    @cached_property
    def parameter_array(self) -> Floats:
        """Values in the order of `parameters`, read-only."""
        values = np.array([self.values[q.name] for q in self.parameters], dtype=float)
        values.flags.writeable = False
        return values

    @property
    def modes(self) -> tuple[Mode, ...]:
        """The modes that a run may be in, `Trajectory.mode` their index: g < 0, g > 0, and sliding along g = 0."""
        return tuple(self.laws.mode(side) for side in SIDES_OF_MODES.tolist())

    def with_parameters(self, **values: float) -> PiecewiseSystem:
        """The same system with other parameter values.

        Raises
        ------
        ValueError
            On an unknown name, or a value that is not finite or out of bounds.
        """
        return replace(self, values={**self.values, **self._check_values(values)})

    # Values at states ------------------------------------------------------------------------------------------------

    def field(self, side: int, t: ArrayLike, x: ArrayLike) -> Floats:
        """f of a side, −1 or +1, or of sliding, 0, at states (..., d) -> (..., d)."""
        return self._evaluate(("f", side), self._side(side).field, t, x)

    def switching(self, t: ArrayLike, x: ArrayLike) -> Floats:
        """g at states (..., d) -> (...)."""
        return self._evaluate("g", (self.laws.g,), t, x)[..., 0]

    def switching_gradient(self, t: ArrayLike, x: ArrayLike) -> Floats:
        """∇g at states (..., d) -> (..., d)."""
        return self._evaluate("grad g", self.laws.gradient, t, x)

    def switching_rate(self, side: int, t: ArrayLike, x: ArrayLike) -> Floats:
        """ġ = g_t + ∇g·f with the field of a side, at states (..., d) -> (...)."""
        return self._evaluate(("g'", side), (self._side(side).rate_of(self.laws.g),), t, x)[..., 0]

    def conserved(self, side: int, t: ArrayLike, x: ArrayLike) -> Floats:
        """ψ of a side, or what sliding (side 0) keeps, at states (..., d) -> (..., m)."""
        return self._evaluate(("psi", side), self._side(side).conserved, t, x)

    def latex(self) -> dict[str, str]:
        """The declaration as LaTeX: keys f_minus, f_plus, g, psi_minus, psi_plus."""
        names = {sympy.Symbol(q.name): q.symbol for q in self.parameters}
        names |= {v: _latex_name(str(v)) for v in self.laws.x}

        def typeset(expressions: Sequence[sympy.Expr]) -> str:
            return r",\; ".join(sympy.latex(e, symbol_names=names) for e in expressions)

        texts = {"g": typeset((self.laws.g,))}
        for side, word in ((self.laws.modes[-1], "minus"), (self.laws.modes[1], "plus")):
            texts |= {f"f_{word}": typeset(side.field), f"psi_{word}": typeset(side.conserved)}
        return texts

    def _evaluate(self, key: object, expressions: Sequence[sympy.Expr], t: ArrayLike, x: ArrayLike) -> Floats:
        """Values of expressions at times and states, whose types and shapes are checked."""
        times, states = np.asarray(t), np.asarray(x)
        for what, array in (("t", times), ("x", states)):
            if array.dtype.kind not in "fiu":
                raise ValueError(f"{what} = {array!r}: numbers are needed")
        if states.shape[-1:] != (self.dimension,):
            raise ValueError(f"x has shape {states.shape}: states (..., {self.dimension}) are needed")
        return self.laws.evaluate(key, expressions, times, states, self.parameter_array)

    def _side(self, side: int) -> Mode:
        if np.ndim(side) or side not in (-1, 0, 1):
            raise ValueError(f"side = {side!r}: it is -1 where g < 0, +1 where g > 0, and 0 for sliding along g = 0")
        return self.laws.mode(int(side))

    # Checks ----------------------------------------------------------------------------------------------------------

    def check_state(self, x: Start, what: str = "x0") -> tuple[float, ...]:
        """Return a state as d finite floats; ValueError if it is not one.

        Parameters
        ----------
        x
            d numbers, or a mapping from the name of every variable to its number.
        """
        names = ", ".join(self.variables)
        if isinstance(x, Mapping):
            wrong = [f"{v!r} is missing" for v in self.variables if v not in x]
            wrong += [f"{v!r} is no variable" for v in x if v not in self.variables]
            if wrong:
                raise ValueError(f"{what} = {dict(x)!r}: {wrong[0]}; a number for each of {names} is needed")
            x = [x[v] for v in self.variables]
        given = listed(x, what, f"{self.dimension} numbers are needed ({names})")
        if wrong_count := miscounted(given, "number", self.variables):
            raise ValueError(f"{what} = {given!r}: {wrong_count}")
        wanted = f"{what} = {given!r}: {self.dimension} numbers are needed ({names}), and each must be finite; "
        return tuple(number(value, wanted + v) for v, value in zip(self.variables, given, strict=True))

    def _check_parameters(self) -> tuple[Parameter, ...]:
        given: Any = self.parameters
        if isinstance(given, Mapping):
            given = [q if isinstance(q, Parameter) else Parameter(name, q) for name, q in given.items()]
            if renamed := [name for name, q in zip(self.parameters, given, strict=True) if name != q.name]:
                raise ValueError(f"parameters: {renamed[0]!r} is given a Parameter of another name; names must agree")
        given = listed(given, "parameters", "give name: value or Parameter(name, default)", Parameter)
        for q in given:
            if not isinstance(q, Parameter):
                raise ValueError(f"parameters: {q!r} is no Parameter; give name: value or Parameter(name, default)")
        return tuple(given)

    def _check_values(self, values: Mapping[str, float]) -> dict[str, float]:
        known = {q.name: q for q in self.parameters}
        if not isinstance(values, Mapping):
            raise ValueError(f"values = {values!r}: a mapping from names of parameters is needed")
        if unknown := set(values) - set(known):
            raise ValueError(f"unknown parameter {sorted(unknown)[0]!r}; known are {', '.join(known) or 'none'}")
        defaults = {name: self.values.get(name, q.default) for name, q in known.items()}
        return {name: known[name].check(value) for name, value in {**defaults, **values}.items()}


def _texts(given: Any, what: str) -> tuple[str, ...]:
    return tuple(map(_text, listed(given, what, "a tuple is needed, as in ('y', '-x')")))


def _text(expression: Any) -> str:
    return to_text(expression) if isinstance(expression, sympy.Basic) else str(expression)


def _latex_name(name: str) -> str:
    """LaTeX of a name; the endings _minus and _plus become the subscripts − and +."""
    for word, sign in (("_minus", "-"), ("_plus", "+")):
        if name.endswith(word):
            return rf"{sympy.latex(sympy.Symbol(name.removesuffix(word)))}_{{{sign}}}"
    return str(sympy.latex(sympy.Symbol(name)))
