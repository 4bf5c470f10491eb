"""Families of larger systems, drawn at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np

import core

__all__ = ["FAMILIES", "bodies", "dense", "lotka_volterra", "springs", "vortices"]

Generator = np.random.Generator


def bodies(rng: Generator, d: int) -> core.PiecewiseSystem:
    """d/4 bodies in the plane that attract each other, more where the first is to the right: four ψ."""
    n = d // 4
    masses = _eighths(rng.uniform(0.5, 2.0, n))
    x, y, u, v = (_named(name, n) for name in "xyuv")

    def pull(q: Sequence[str], i: int) -> str:
        others = (j for j in range(n) if j != i)
        return f"k*({'+'.join(f'{masses[j]}*({q[j]}-{q[i]})/({_square(x, y, i, j)})**(3/2)' for j in others)})"

    field = [*u, *v, *(pull(x, i) for i in range(n)), *(pull(y, i) for i in range(n))]
    motion = "+".join(f"{m / 2}*({a}**2+{b}**2)" for m, a, b in zip(masses, u, v, strict=True))
    bound = "+".join(f"{masses[i] * masses[j]}/sqrt({_square(x, y, i, j)})" for i in range(n) for j in range(i))
    momenta = ["+".join(f"{m}*{q}" for m, q in zip(masses, w, strict=True)) for w in (u, v)]
    spin = "+".join(f"{m}*({a}*{f}-{b}*{e})" for m, a, b, e, f in zip(masses, x, y, u, v, strict=True))
    kept = (f"{motion}-k*({bound})", *momenta, spin)
    # On a circle, that none comes close to another for a while.
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    speed = rng.uniform(0.5, 1.0)
    start = [np.cos(angle), np.sin(angle), -speed * np.sin(angle), speed * np.cos(angle)]
    return _system(
        f"{n} bodies", (*x, *y, *u, *v), field, kept, f"{x[0]} - {_number(rng.uniform(-0.5, 0.5))}",
        np.concatenate(start) * _size(n),
    )  # fmt: skip


def springs(rng: Generator, d: int) -> core.PiecewiseSystem:
    """A chain of d/2 masses between walls, on springs that are not linear; stiffer beyond a stop: the energy."""
    n = d // 2
    q, p = _named("q", n), _named("p", n)
    stretched = [q[0], *(f"({b} - {a})" for a, b in pairwise(q)), f"(-{q[-1]})"]
    linear, cubic = ([_number(a) for a in rng.uniform(0.5, 1.5, n + 1)] for _ in range(2))
    masses = [_number(m) for m in rng.uniform(0.5, 2.0, n)]
    tension = [f"(k*{a}*{s} + {b}*{s}**3)" for a, b, s in zip(linear, cubic, stretched, strict=True)]
    forces = [f"{b} - {a}" for a, b in pairwise(tension)]
    field = [*(f"{w}/{m}" for w, m in zip(p, masses, strict=True)), *forces]
    stored = [f"k*{a}*{s}**2/2 + {b}*{s}**4/4" for a, b, s in zip(linear, cubic, stretched, strict=True)]
    energy = " + ".join([*stored, *(f"{w}**2/(2*{m})" for w, m in zip(p, masses, strict=True))])
    return _system(f"{n} springs", (*q, *p), field, (energy,), f"{q[0]} - 0.1", rng.uniform(-0.7, 0.7, d))


def dense(rng: Generator, d: int) -> core.PiecewiseSystem:
    """x' = A S x of a dense A = −Aᵀ and S = D + u uᵀ, other ones on each side of x1 = 0.3: ψ = xᵀSx/2 is kept."""
    x = _named("x", d)
    sides = []
    for _ in range(2):
        # Of few binary digits, so that every product is exact and ψ kept to the last of them.
        skew, u, diagonal = (
            np.round(16 * a) / 16 for a in (rng.normal(size=(d, d)), rng.normal(size=d), 1 + rng.random(d))
        )
        skew, u = np.round(8 * (skew - skew.T) / np.sqrt(d)) / 8, np.round(8 * u / np.sqrt(d)) / 8
        field = [_linear(row, x) for row in skew @ (np.diag(diagonal) + np.outer(u, u))]
        squares = [f"{_number(a)}*{v}**2" for a, v in zip(diagonal, x, strict=True)]
        sides.append((field, (f"(({_linear(u, x)})**2 + {_sum(squares)})/2",)))
    (below, kept_below), (above, kept_above) = sides
    return core.PiecewiseSystem(
        name=f"Dense quadratic form in {d}", variables=x, f_minus=tuple(below), f_plus=tuple(above), g=f"{x[0]} - 0.3",
        psi_minus=kept_below, psi_plus=kept_above, x0=tuple(rng.uniform(-1.0, 1.0, d)),
    )  # fmt: skip


def vortices(rng: Generator, d: int) -> core.PiecewiseSystem:
    """d/2 point vortices, stronger where the first is to the right: energy, both impulses, angular impulse."""
    n = d // 2
    x, y = _named("x", n), _named("y", n)
    strength = [int(s) for s in rng.integers(1, 3, n)]

    def drift(q: Sequence[str], i: int) -> str:
        return "+".join(f"{strength[j]}*({q[i]}-{q[j]})/({_square(x, y, i, j)})" for j in range(n) if j != i)

    field = [*(f"-k*({drift(y, i)})" for i in range(n)), *(f"k*({drift(x, i)})" for i in range(n))]
    energy = "+".join(f"{strength[i] * strength[j]}*log({_square(x, y, i, j)})" for i in range(n) for j in range(i))
    impulses = ["+".join(f"{s}*{q}" for s, q in zip(strength, w, strict=True)) for w in (x, y)]
    spin = "+".join(f"{s}*({a}**2+{b}**2)" for s, a, b in zip(strength, x, y, strict=True))
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    start = np.concatenate([np.cos(angle), np.sin(angle)]) * _size(n)
    kept = (energy, *impulses, spin)[: d - 1]
    return _system(f"{n} vortices", (*x, *y), field, kept, f"{x[0]} - {_number(rng.uniform(-0.5, 0.5))}", start)


def lotka_volterra(rng: Generator, d: int) -> core.PiecewiseSystem:
    """A food chain of d species, each preying on the one before: ψ = Σ wᵢ (xᵢ − eᵢ log xᵢ) with an equilibrium e."""
    x = _named("x", d)
    rates = [round(a, 3) for a in rng.uniform(0.5, 1.5, d - 1)]
    rest = [round(a, 3) for a in rng.uniform(0.5, 1.5, d)]
    weights = [round(a, 1) for a in rng.uniform(0.5, 2.0, d)]
    field = []
    for i in range(d):
        parts = []
        if i > 0:
            parts.append(f"{rates[i - 1]}*({x[i - 1]} - {rest[i - 1]})")
        if i + 1 < d:
            parts.append(f"-{rates[i]}*({x[i + 1]} - {rest[i + 1]})")
        field.append(f"k*{x[i]}*({' '.join(f'+ {part}' for part in parts)})/{weights[i]}")
    psi = " + ".join(f"{w}*({a} - {e}*log({a}))" for w, a, e in zip(weights, x, rest, strict=True))
    return _system(f"Food chain of {d}", x, field, (psi,), f"{x[0]} - {rest[0]}", rng.uniform(0.3, 1.7, d))


#: Families by name: (generator, dimension) -> system. The plane's need d = 4n (bodies) or 2n (springs, vortices).
FAMILIES: Mapping[str, Callable[[Generator, int], core.PiecewiseSystem]] = MappingProxyType(
    {"bodies": bodies, "springs": springs, "dense": dense, "vortices": vortices, "lotka_volterra": lotka_volterra}
)


def _system(
    name: str, variables: Sequence[str], field: Sequence[str], psi: Sequence[str], g: str, start: np.ndarray
) -> core.PiecewiseSystem:
    """A system whose sides differ in the coefficient that is called k in its laws."""
    field_minus, field_plus, psi_minus, psi_plus = (
        tuple(e.replace("k*", f"k_{side}*") for e in given) for given in (field, psi) for side in ("minus", "plus")
    )
    parameters = (core.Parameter("k_minus", 1.0), core.Parameter("k_plus", 1.5))
    return core.PiecewiseSystem(
        name=name, variables=tuple(variables), f_minus=field_minus, f_plus=field_plus, g=g, psi_minus=psi_minus,
        psi_plus=psi_plus, parameters=parameters, x0=tuple(map(float, start)),
    )  # fmt: skip


def _named(stem: str, n: int) -> tuple[str, ...]:
    return tuple(f"{stem}{i + 1}" for i in range(n))


def _number(value: float) -> str:
    return repr(round(float(value), 15))


def _eighths(values: np.ndarray) -> list[float]:
    """Numbers whose products are short."""
    return [float(v) for v in np.round(8 * values) / 8]


def _square(x: Sequence[str], y: Sequence[str], i: int, j: int) -> str:
    """The square of a distance, the same text for i, j and j, i."""
    i, j = max(i, j), min(i, j)
    return f"({x[i]}-{x[j]})**2+({y[i]}-{y[j]})**2"


def _sum(terms: Sequence[str]) -> str:
    return " + ".join(terms) or "0"


def _linear(row: np.ndarray, x: Sequence[str]) -> str:
    return _sum([f"{_number(a)}*{v}" for a, v in zip(row, x, strict=True) if a])


def _size(n: int) -> float:
    """Radius of a circle on which n neighbours are about a unit apart."""
    return max(1.0, n / np.pi)
