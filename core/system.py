"""PiecewiseSystem, Region, Transition, Parameter: a system is data, from which everything else is derived."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias, overload

import numpy as np
import sympy
from numpy.typing import ArrayLike

from core.interface.arguments import listed, number, plain_numbers
from core.kernels.arrays import Floats
from core.symbolic.declaration import Declaration, accepted
from core.symbolic.declared_texts import RegionText, TransitionText
from core.symbolic.entry_checks import miscounted
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode
from core.symbolic.parts import Parameter, Region, Transition, latex_of_name, text_of, texts_of
from core.symbolic.switching_terms import read_switching

__all__ = ["Parameter", "PiecewiseSystem", "Region", "Start", "Transition"]

#: Side of the only surface -> name of the mode.
_SIDES = {-1: "-", 0: "0", 1: "+"}

#: Initial state: d numbers, or a mapping from the name of each variable to its number.
Start: TypeAlias = "Iterable[float] | Mapping[str, float]"


@dataclass(frozen=True)
class PiecewiseSystem:
    """x' = f₋(t, x) where g < 0 and f₊(t, x) where g > 0, each side with its own conserved quantities; or more regions.

    Expressions are text, or sympy, in the variables, the parameters and time ``t``; see `core.symbolic.expressions` for
    the syntax. A system is frozen; `with_parameters` returns a new one. There are four ways to declare one: two sides
    of one surface; `surfaces` and `regions`; one field `f` that says by sign, abs and so on where it switches, in which
    surfaces and regions are found; or, where the way back is another than the way there, `regions` and `transitions`,
    the general form from which the others are derived.

    Parameters
    ----------
    name
        Name for display.
    variables
        The d names of the state's coordinates.
    f_minus, f_plus
        d expressions each: regions "-" and "+" of the surface g.
    g
        The switching function, whose gradient in (t, x) is not zero where g = 0. It may name time alone, as sin(t): the
        law then switches at instants, wherever the state is.
    psi_minus, psi_plus
        0 to d − 1 conserved quantities of each side, () where none is known. For a planar divergence-free field the
        stream function is then found, where that is easy (see `stream_function`).
    parameters
        name -> value, name -> `Parameter`, or a sequence of `Parameter`.
    x0
        Default initial state, d numbers; zeros where not given.
    jump
        d expressions: the state after reaching the surface, for impacts and kicks. None or (): the state is continuous.
    doc
        Description of the system, in a sentence or two.
    surfaces
        Up to six switching functions.
    regions
        Key -> `Region`. A key has one sign a surface: “+-” is where the first function is positive and the second
        negative. Regions that are never reached need no law; a run that reaches one stops. Where `transitions` are
        declared, keys are any names; a run then begins in the first region whose guards are all positive.
    jumps
        Number of the surface, from 0 -> d expressions: the state after reaching it.
    transitions
        The ways between regions that have names, for hysteresis.
    f
        d expressions with sign, abs, max, min, Heaviside or Piecewise, as in ``("v", "-x - mu*sign(v - 1)")``, in place
        of the laws of regions; kept as given.
    psi
        Conserved quantities of `f`, in which such terms may stand as well.

    Raises
    ------
    ValueError
        On unknown names, syntax outside the whitelist, wrong dimensions, constants that are not finite, or a ψ that the
        field does not conserve everywhere in its region. The message names the text and what would be accepted.
    """

    name: str
    variables: tuple[str, ...]
    f_minus: tuple[str, ...] = ()
    f_plus: tuple[str, ...] = ()
    g: str = ""
    psi_minus: tuple[str, ...] = ()
    psi_plus: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    x0: tuple[float, ...] = ()
    jump: tuple[str, ...] | None = None
    doc: str = ""
    values: Mapping[str, float] = field(default_factory=dict, hash=False)
    """Current value of each parameter; the default where none is given."""
    surfaces: tuple[str, ...] = ()
    regions: Mapping[str, Region] = field(default_factory=dict, hash=False)
    jumps: Mapping[int, tuple[str, ...]] = field(default_factory=dict, hash=False)
    transitions: tuple[Transition, ...] = ()
    f: tuple[str, ...] = ()
    psi: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "name", str(self.name))
        set_(self, "parameters", self._check_parameters())
        for name in ("variables", "f_minus", "f_plus", "psi_minus", "psi_plus", "surfaces", "f", "psi"):
            set_(self, name, texts_of(getattr(self, name), name))
        set_(self, "jump", None if self.jump is None else texts_of(self.jump, "jump") or None)
        set_(self, "g", text_of(self.g))
        set_(self, "values", MappingProxyType(self._check_values(self.values)))
        self._check_regions()
        if self.f_minus or self.f_plus or self.g:
            self._take_sides()
        if self.f or self.psi:
            self._take_field()
        self._complete()
        start = self.check_state((0.0,) * self.dimension if isinstance(self.x0, tuple) and not self.x0 else self.x0)
        set_(self, "x0", start)

    def _check_regions(self) -> None:
        """Bring regions, jumps and transitions into their standard form."""
        set_, regions, jumps = object.__setattr__, self.regions, self.jumps
        if not isinstance(regions, Mapping) or not all(isinstance(law, Region) for law in regions.values()):
            raise ValueError(f"regions = {regions!r}: a mapping is needed, as {{'+-': Region(f=('y', '-x'))}}")
        if not isinstance(jumps, Mapping):
            raise ValueError(f"jumps = {jumps!r}: a mapping from numbers of surfaces to expressions is needed")
        given = listed(self.transitions, "transitions", "a tuple of Transition is needed", Transition)
        if wrong := [part for part in given if not isinstance(part, Transition)]:
            raise ValueError(f"transitions: {wrong[0]!r} is no Transition; give Transition(mode, guard, to)")
        if odd := [name for name in regions if not isinstance(name, str)]:
            raise ValueError(f"regions: the key {odd[0]!r} is not text; write its signs, as in '+-'")
        names = list(regions)
        order = names if given else sorted(names, key=lambda name: name.replace("-", "\0"))  # - before +
        set_(self, "regions", MappingProxyType({name: regions[name] for name in order}))
        set_(self, "jumps", MappingProxyType({k: texts_of(jump, f"jumps[{k}]") for k, jump in sorted(jumps.items())}))
        set_(self, "transitions", tuple(given))

    def _take_sides(self) -> None:
        """Read the sides of one surface as its regions “-” and “+”."""
        regions = {"-": Region(self.f_minus, self.psi_minus), "+": Region(self.f_plus, self.psi_plus)}
        jumps = {} if self.jump is None else {0: self.jump}
        declared = ((self.g,), regions, jumps)
        if (self.regions or self.surfaces or self.jumps or self.transitions) and declared != (
            self.surfaces, dict(self.regions), dict(self.jumps),
        ):  # fmt: skip
            raise ValueError("give either f_minus, f_plus, g and so on, or surfaces and regions, or transitions")
        for name, value in zip(("surfaces", "regions", "jumps"), declared, strict=True):
            object.__setattr__(self, name, MappingProxyType(value) if isinstance(value, dict) else value)

    def _take_field(self) -> None:
        """Find surfaces and regions of the one field; those that are given as well must be the same."""
        if not self.f:
            raise ValueError(f"psi = {self.psi!r}: there is no f that it is of; give psi_minus, psi_plus or regions")
        given, set_ = (self.surfaces, dict(self.regions)), object.__setattr__
        names, bounds = tuple(q.name for q in self.parameters), tuple(q.bounds for q in self.parameters)
        found = read_switching(self.variables, names, self.f, self.psi, bounds)
        set_(self, "surfaces", found.surfaces)
        set_(self, "regions", {key: Region(law, found.quantities[key]) for key, law in found.fields.items()})
        full = {law.name: Region(law.f, law.psi) for law in self._declared.regions}
        if self.jumps or self.transitions or (any(given) and given != (self.surfaces, full)):
            raise ValueError("give either f, in which surfaces and regions are found, or these themselves")

    def _complete(self) -> None:
        """Check the declaration, and add the ψ that are found for it; name the sides of one surface."""
        declared, set_ = self._declared, object.__setattr__
        set_(self, "regions", MappingProxyType({law.name: Region(law.f, law.psi) for law in declared.regions}))
        if declared.two_sided:
            for word, region in (("minus", self.regions["-"]), ("plus", self.regions["+"])):
                set_(self, f"f_{word}", region.f)
                set_(self, f"psi_{word}", region.psi)
            set_(self, "g", self.surfaces[0])
            set_(self, "jump", self.jumps.get(0))

    def __reduce__(self) -> tuple[Any, ...]:
        given = (getattr(self, f.name) for f in fields(self))
        return PiecewiseSystem, tuple(dict(value) if isinstance(value, Mapping) else value for value in given)

    @classmethod
    def from_field(
        cls, variables: Sequence[str], f: Sequence[str], psi: Sequence[str] | None = None,
        parameters: Mapping[str, float | Parameter] | Sequence[Parameter] = (), x0: Sequence[float] = (),
        name: str = "system", doc: str = "",
    ) -> PiecewiseSystem:  # fmt: skip
        """Declare a system by one field with sign, abs, max, min, Heaviside or Piecewise; its surfaces are found.

        Parameters
        ----------
        f
            d expressions, as in ``("v", "-x - mu*sign(v - 1)")``.
        psi
            Conserved quantities, in which such terms may stand as well; None for none.
        variables, parameters, x0, name, doc
            As of the class.

        Raises
        ------
        ValueError
            Also where nothing switches, or more than six surfaces are found; see `core.symbolic.switching_terms`.
        """
        laws: dict[str, Any] = {"f": f, "psi": () if psi is None else psi, "parameters": parameters}
        return cls(name=name, variables=tuple(variables), x0=tuple(x0), doc=doc, **laws)

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
        regions = tuple(RegionText(name, law.f, law.psi) for name, law in self.regions.items())
        ways = tuple(TransitionText(way.mode, way.guard, way.to, way.jump or ()) for way in self.transitions)
        jumps = tuple(self.jumps.items())
        return accepted(Declaration(self.variables, names, bounds, self.surfaces, regions, jumps, ways))

    @cached_property
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
    def modes(self) -> Modes:
        """The modes that a run may be in, `Trajectory.mode` their index: the regions, then sliding between two of them.

        Of one surface: g < 0, g > 0, and sliding along g = 0.
        """
        return Modes(self.laws)

    def law_arguments(self) -> dict[str, Any]:
        """Return the arguments that declare the laws, without those that are empty.

        They are f and psi; or f_minus, f_plus, g and so on; or surfaces and regions; or regions and transitions.
        """
        sides = ("f_minus", "f_plus", "g", "psi_minus", "psi_plus", "jump")
        several = ("surfaces", "regions", "jumps", "transitions")
        names: tuple[str, ...] = ("f", "psi") if self.f else sides if self.two_sided else several
        given = {name: getattr(self, name) for name in names}
        return {name: dict(part) if isinstance(part, Mapping) else part for name, part in given.items() if part}

    @property
    def two_sided(self) -> bool:
        """Whether there is one surface, with a region on either side."""
        return self.laws.two_sided

    def with_parameters(self, **values: float) -> PiecewiseSystem:
        """The same system with other parameter values.

        Raises
        ------
        ValueError
            On an unknown name, or a value that is not finite or out of bounds.
        """
        other = replace(self, values={**self.values, **self._check_values(values)})
        other.__dict__["laws"] = self.laws  # which depend on no value
        return other

    # Values at states ------------------------------------------------------------------------------------------------

    def field(self, side: int | str, t: ArrayLike, x: ArrayLike) -> Floats:
        """f of a side, −1 or +1, or of sliding, 0, at states (..., d) -> (..., d); a mode may be given by its name."""
        mode = self._side(side)
        return self._evaluate(("f", mode.name), mode.written.field, t, x)

    def switching(self, t: ArrayLike, x: ArrayLike) -> Floats:
        """g at states (..., d) -> (...)."""
        return self._evaluate("g", (self.laws.g,), t, x)[..., 0]

    def switching_gradient(self, t: ArrayLike, x: ArrayLike) -> Floats:
        """∇g at states (..., d) -> (..., d)."""
        return self._evaluate("grad g", self.laws.gradient, t, x)

    def switching_rate(self, side: int | str, t: ArrayLike, x: ArrayLike) -> Floats:
        """ġ = g_t + ∇g·f with the field of a side, at states (..., d) -> (...)."""
        mode = self._side(side)
        return self._evaluate(("g'", mode.name), (mode.rate_of(self.laws.g),), t, x)[..., 0]

    def conserved(self, side: int | str, t: ArrayLike, x: ArrayLike) -> Floats:
        """ψ of a side, or what sliding (side 0) keeps, at states (..., d) -> (..., m)."""
        mode = self._side(side)
        return self._evaluate(("psi", mode.name), mode.conserved, t, x)

    def heights(self, mode: int, t: ArrayLike, x: ArrayLike) -> Floats:
        """The guards of a mode, given by its number, positive inside it: at states (..., d) -> (..., guards)."""
        return self._evaluate(("heights", mode), self.laws.mode(mode).heights, t, x)

    def latex(self) -> dict[str, str]:
        """The declaration as LaTeX: keys f_minus, f_plus, g, psi_minus, psi_plus; of more regions surfaces,
        regions['-+'].f and so on.
        """
        names = {sympy.Symbol(q.name): q.symbol for q in self.parameters}
        names |= {v: latex_of_name(str(v)) for v in self.laws.x}

        def typeset(expressions: Sequence[sympy.Expr]) -> str:
            return r",\; ".join(sympy.latex(e, symbol_names=names) for e in expressions)

        texts = {"g" if self.two_sided else "surfaces": typeset(self.laws.surfaces)}
        for mode in self.laws.regions:
            for part, expressions in (("f", mode.field), ("psi", mode.conserved)):
                texts[self._declared.field_of(mode.name, part)] = typeset(expressions)
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

    def _side(self, side: int | str) -> Mode:
        """A mode by its name; of one surface, by its side."""
        numbers = self.laws.numbers_of_modes
        if isinstance(side, str) and side in numbers:
            return self.laws.mode(numbers[side])
        if not self.two_sided:
            raise ValueError(f"side = {side!r}: it is one of the modes {', '.join(map(repr, numbers))}")
        if np.ndim(side) or side not in (-1, 0, 1):
            raise ValueError(f"side = {side!r}: it is -1 where g < 0, +1 where g > 0, and 0 for sliding along g = 0")
        return self.laws.mode(numbers[_SIDES[int(side)]])

    # Checks ----------------------------------------------------------------------------------------------------------

    def check_state(self, x: Start, what: str = "x0") -> tuple[float, ...]:
        """Return a state as d finite floats; ValueError if it is not one.

        Parameters
        ----------
        x
            d numbers, or a mapping from the name of every variable to its number.
        """
        if (plain := plain_numbers(x, len(self.variables))) is not None:
            return plain
        names = ", ".join(self.variables)
        if isinstance(x, Mapping):
            wrong = [f"{v!r} is missing" for v in self.variables if v not in x]
            wrong += [f"{v!r} is not a variable" for v in x if v not in self.variables]
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


class Modes(Sequence[Mode]):
    """The modes of a system; one of sliding is derived when it is first asked for."""

    def __init__(self, laws: Laws) -> None:
        self._laws = laws

    def __len__(self) -> int:
        return self._laws.count

    @overload
    def __getitem__(self, number: int) -> Mode: ...

    @overload
    def __getitem__(self, number: slice) -> tuple[Mode, ...]: ...

    def __getitem__(self, number: int | slice) -> Mode | tuple[Mode, ...]:
        if isinstance(number, slice):
            return tuple(self[k] for k in range(len(self))[number])
        return self._laws.mode(range(len(self))[number])
