"""Find the surfaces of an ordinary field with sign, abs, max, …, and the smooth law of each of its regions.

A text is read once for each combination of signs that its switching functions can have. Terms within terms need no
care: where the sign of x is known, abs(abs(x) - 1) asks for the sign of x − 1, or of −x − 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import product, zip_longest
from types import MappingProxyType
from typing import NamedTuple

import sympy
from sympy import Add, Expr, Integer, Mul, Symbol

from core.symbolic.algebra import factor_list, together
from core.symbolic.contradictions import Signs, contradict
from core.symbolic.entry_checks import MAX_SURFACES
from core.symbolic.expressions import SWITCHING, TIME, check_name, parse
from core.symbolic.source_text import quoted, to_text
from core.symbolic.zero_testing import is_zero, size_expanded

__all__ = ["Found", "read_switching"]

#: Most terms, expanded, of a switching function that is factored: a longer one is taken as it stands.
_MAX_TERMS = 100
#: Largest degree of a switching function in several unknowns that is factored: x**64 - v**64 takes seconds.
_MAX_DEGREE = 12

#: Signs of the surfaces, in their order -> the text of each expression where they hold.
Regions = dict[tuple[int, ...], tuple[str, ...]]


class Found(NamedTuple):
    """A field taken apart: its surfaces, and its law in each region."""

    surfaces: tuple[str, ...]
    """Expressions that vanish on the surfaces, in the order in which the field names them."""
    fields: Mapping[str, tuple[str, ...]]
    """Key of each region that can occur, with one sign a surface as in ``"+-"`` -> the field there."""
    quantities: Mapping[str, tuple[str, ...]]
    """Key of each region -> the given quantities there."""


def read_switching(
    variables: Sequence[str],
    parameters: Sequence[str],
    f: Sequence[str],
    psi: Sequence[str] = (),
    bounds: Sequence[tuple[float, float] | None] = (),
) -> Found:
    """Find the surfaces and smooth laws of a field written with sign, abs, max, min, Heaviside or Piecewise.

    A switching function is the argument of one of these, or a difference that is compared. Each of its factors over the
    rationals that changes its sign is a surface. Left out are surfaces with the same laws on both sides, and regions
    that cannot occur. This is decided exactly where surfaces differ by a constant or are linear with rational
    coefficients, for all values within the bounds of the parameters. Elsewhere each term of a surface counts as an
    unknown of its own, so that a region may be kept that does not occur.

    Parameters
    ----------
    variables, parameters
        Their names.
    f, psi
        Field and quantities, in the syntax that `parse` has where it is given signs. A smooth text stays as it is.
    bounds
        Least and greatest value of each parameter, None where it has none; () if none has any.

    Raises
    ------
    ValueError
        If a text cannot be read, nothing switches, there are more than 6 surfaces, or the sign of a switching function
        depends on parameters alone. The message says what would do.
    """
    return _read(tuple(variables), tuple(parameters), tuple(f), tuple(psi), tuple(bounds) or (None,) * len(parameters))


@lru_cache(maxsize=256)
def _read(
    variables: tuple[str, ...], parameters: tuple[str, ...], f: tuple[str, ...], psi: tuple[str, ...],
    bounds: tuple[tuple[float, float] | None, ...],
) -> Found:  # fmt: skip
    """Find surfaces and laws as `read_switching`; cached, so that another parameter value does not repeat it."""
    x, p = [check_name(v, "variable") for v in variables], [check_name(v, "parameter") for v in parameters]
    ranges = {Symbol(name): ends for name, ends in zip(p, bounds, strict=True) if ends}
    field = _Field((*x, *p), [Symbol(name) for name in x], ranges)
    laws = [list(field.laws(u, f"{of}[{k}]")) for of, texts in (("f", f), ("psi", psi)) for k, u in enumerate(texts)]
    needed, regions = _needed(len(field.surfaces), field.regions(laws))
    if not needed:
        seen, words = ", ".join(field.surfaces.values()), f"{', '.join(SWITCHING[:-1])} or {SWITCHING[-1]}"
        why = f"the laws are the same on both sides of {seen}" if seen else "the field contains no switching term"
        raise ValueError(f"nothing switches: {why}; write {words} where the law changes, as in -x - mu*sign(v - 1)")
    keyed = {"".join("+" if s > 0 else "-" for s in signs): law for signs, law in regions.items()}
    surfaces = tuple(text for k, text in enumerate(field.surfaces.values()) if k in needed)
    fields, quantities = ({k: law[part] for k, law in keyed.items()} for part in (slice(len(f)), slice(len(f), None)))
    return Found(surfaces, MappingProxyType(fields), MappingProxyType(quantities))


def _needed(count: int, regions: Regions) -> tuple[list[int], Regions]:
    """Numbers of the surfaces without those on both sides of which the laws are the same, and the regions between."""
    needed = list(range(count))
    for k in reversed(range(count)):
        merged: dict[tuple[int, ...], set[tuple[str, ...]]] = {}
        for signs, law in regions.items():
            merged.setdefault(signs[:k] + signs[k + 1 :], set()).add(law)
        if all(len(laws) == 1 for laws in merged.values()):
            needed.remove(k)
            regions = {signs: laws.pop() for signs, laws in merged.items()}
    return needed, regions


class _Field:
    """The surfaces found so far, and what is needed to read further texts.

    Attributes
    ----------
    surfaces
        Surface -> its text.
    """

    def __init__(self, names: Sequence[str], x: Sequence[Symbol], ranges: Mapping[Symbol, tuple[float, float]]) -> None:
        self.names, self.x, self.ranges = names, x, ranges
        self.surfaces: dict[Expr, str] = {}
        self._texts: dict[Expr, str] = {}
        self._silent: dict[Expr, Expr] = {}  # factor -> the parameters that multiply it in its surface
        self._known: dict[Expr, tuple[int, list[Expr]]] = {}  # results of _factors
        self._excluded: dict[frozenset[tuple[Expr, int]], bool] = {}

    def laws(self, text: str, what: str) -> Iterator[tuple[Signs, str]]:
        """Yield the law of a text for each combination of signs that it tells apart."""
        with suppress(ValueError):
            parse(text, self.names, what)
            yield {}, to_text(text) if isinstance(text, sympy.Basic) else str(text)
            return
        called, pending = f"{what} = {quoted(str(text))}", [Signs()]
        while pending:
            signs = pending.pop()
            law = to_text(parse(text, self.names, what, self._reader(signs, pending, called)))
            where = " and ".join(f"{self._texts[g]} {'>' if s > 0 else '<'} 0" for g, s in signs.items())
            parse(law, self.names, f"{what} where {where}")  # it may be longer than the text
            yield signs, law

    def regions(self, laws: Sequence[Sequence[tuple[Signs, str]]]) -> Regions:
        """The regions that can occur."""
        found = {}
        for signs in product((-1, 1), repeat=len(self.surfaces)):
            here = dict(zip(self.surfaces, signs, strict=True))
            there = [[law for known, law in each if known.items() <= here.items()] for each in laws]
            if here and all(there) and not self._excludes(here):
                found[signs] = tuple(law[0] for law in there)
        return found

    def _reader(self, signs: Signs, pending: list[Signs], called: str) -> Callable[[Expr], int]:
        """For `parse`: the signs of expressions. One that may be either is taken as +1, and the other made pending."""

        def sign_of(u: Expr) -> int:
            sign, surfaces = self._factors(u, called)
            for g in surfaces if sign else []:
                possible = [signs[g]] if g in signs else self._possible(g, signs)
                if len(possible) > 1:
                    self._add(g, called)
                    pending.append({**signs, g: -1})
                    signs[g] = 1
                sign *= possible[0]
            return sign

        return sign_of

    def _add(self, g: Expr, called: str) -> None:
        self.surfaces[g] = self._texts[g]
        if len(self.surfaces) > MAX_SURFACES:
            seen = ", ".join(self.surfaces.values())
            raise ValueError(
                f"{called}: at most {MAX_SURFACES} surfaces are possible, but the field switches on {seen}, at least"
            )

    def _possible(self, g: Expr, signs: Signs) -> list[int]:
        """The signs that g can have where other surfaces have the given signs."""
        return [s for s in (1, -1) if not self._excludes({**signs, g: s})] or [1]

    def _excludes(self, signs: Signs) -> bool:
        key = frozenset(signs.items())
        if key not in self._excluded:
            self._excluded[key] = contradict(signs, self.ranges)
        return self._excluded[key]

    # Factors ---------------------------------------------------------------------------------------------------------

    def _factors(self, u: Expr, called: str) -> tuple[int, list[Expr]]:
        """The sign of all factors of u that have one sign, 0 where u vanishes, and the surfaces of the others."""
        if u not in self._known:
            sign, changing, silent = 1, [], Integer(1)
            for factor, written in _odd_factors(u):
                g, s = _with_leading_one(factor, self.x)
                possible = [1] if _is_definite(g) else self._possible(g, {})
                sign *= s * (possible[0] if len(possible) == 1 else 1)
                if len(possible) == 2 and g.has(*self.x, TIME):
                    changing.append(g)
                    self._texts.setdefault(g, min(map(to_text, (g, g.primitive()[1], s * written)), key=len))
                elif len(possible) == 2:
                    silent *= g
            changing.sort(key=lambda g: [not g.has(v) for v in self.x])
            self._check_silent(silent, changing, called)
            if silent != 1:
                changing[0] *= silent
                self._texts[changing[0]] = to_text(changing[0])
            self._known[u] = sign, changing
        return self._known[u]

    def _check_silent(self, silent: Expr, changing: list[Expr], called: str) -> None:
        """Refuse factors of parameters alone, unless they multiply one surface wherever it occurs."""
        names, shown = ", ".join(sorted(map(str, silent.free_symbols))), quoted(to_text(silent))
        if names and not changing:
            remedy = f"give {names} bounds within which it stays"
            raise ValueError(f"{called}: the sign of {shown} depends on parameters alone, at no surface; {remedy}")
        for g, factor in zip_longest(changing, [silent], fillvalue=Integer(1)):
            if self._silent.setdefault(g, factor) != factor:
                pair = " and ".join(quoted(to_text(g * u)) for u in (self._silent[g], factor))
                names = ", ".join(sorted(map(str, (self._silent[g] * factor).free_symbols)))
                remedy = f"give {names} bounds within which the sign stays"
                raise ValueError(f"{called}: {pair} are one surface, but may differ in sign; {remedy}")


def _odd_factors(u: Expr) -> Iterator[tuple[Expr, Expr]]:
    """Yield the factors, over the rationals, with an odd power in numerator or denominator; each also as written."""
    u = u.replace(sympy.tan, lambda v: sympy.sin(v) / sympy.cos(v))
    whole = together(u) if size_expanded(u) <= _MAX_TERMS else u
    for factor in (v for part in sympy.fraction(whole) for v in Mul.make_args(part)):
        base, power = factor.as_base_exp()
        if not power.is_number:
            yield factor, factor
        elif power.is_Integer and power % 2:  # a root is positive where it is real
            yield from _polynomial_factors(base)


def _polynomial_factors(u: Expr) -> Iterator[tuple[Expr, Expr]]:
    if not u.is_Add or not _is_short(u):
        yield (Integer(0) if is_zero(u) else u), u
        return
    try:
        content, factors = factor_list(u)
    except sympy.BasePolynomialError:  # u is a constant
        content, factors = sympy.expand(u), []
    content = Integer(0) if any(not g.is_polynomial() and is_zero(g) for g, _ in factors) else content
    if len(factors) == 1 and factors[0][1] == 1:
        yield content * factors[0][0], u
    else:
        yield content, content
        yield from ((g, g) for g, power in factors if power % 2)


def _is_short(u: Expr) -> bool:
    """Whether sympy factors u in a moment."""
    return size_expanded(u) <= _MAX_TERMS and (len(u.free_symbols) == 1 or _degree(u) <= _MAX_DEGREE)


def _degree(u: Expr) -> int:
    """Bound on the total degree of u, in whatever stands in it in place of a symbol."""
    if u.is_Add or u.is_Mul:
        return (max if u.is_Add else sum)(map(_degree, u.args))
    return int(u.exp) * _degree(u.base) if u.is_Pow and u.exp.is_Integer and u.exp > 0 else int(not u.is_number)


def _is_definite(g: Expr) -> bool:
    """Whether g, with leading coefficient 1, is a constant or a polynomial that is known to be negative nowhere."""
    if not g.free_symbols:
        return True
    if not g.is_polynomial() or not _is_short(g):
        return False
    polynomial = sympy.Poly(g, *sorted(g.free_symbols, key=str))
    if not polynomial.domain.is_ZZ and not polynomial.domain.is_QQ:
        return False
    if polynomial.is_univariate:
        return bool(polynomial.degree() % 2 == 0 and polynomial.count_roots() == 0)
    if polynomial.total_degree() != 2:
        return False
    form = polynomial.homogenize(sympy.Dummy())
    return bool(sympy.hessian(form.as_expr(), form.gens).is_positive_semidefinite)


def _with_leading_one(u: Expr, x: Sequence[Symbol]) -> tuple[Expr, int]:
    """u divided by the coefficient of the highest power of the first variable, or t, in it, and the sign of that."""
    if not u.free_symbols:
        value = float(u.evalf())
        return Integer(1), (value > 0) - (value < 0)
    name = next((v for v in (*x, TIME) if u.has(v)), min(u.free_symbols, key=str))

    def rank(term: Expr) -> tuple[bool, Expr]:
        power = Integer(0) + term.as_powers_dict()[name]
        return term.has(name), power if power.is_number else Integer(0)

    terms = u.as_ordered_terms()
    lead = max(terms, key=rank).as_coeff_Mul()[0]
    return Add(*(v / lead for v in terms)), 1 if lead > 0 else -1
