"""Random arrangements of three lines with a constant field in each cell: the path is a polygon, found in ratios."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import core
from core import Status
from core.reference import Solution
from tests.levels import deep_but

KEYS = tuple("".join(signs) for signs in product("-+", repeat=3))
T_END = Fraction(8)
#: Crossings from which on a path may be found to wind into a corner; its ratios grow without end.
MANY = 40
#: How many times shorter its turns then are than when it was half as far; those of a cycle stay as they are.
SHORTER = 100
#: Heights above a line, as part of its terms, that doubles may not tell from 0: 16 bounds on rounding in two states.
ROUNDING = 2.0**-44
Vector = tuple[Fraction, Fraction]


def system() -> core.PiecewiseSystem:
    """Every line and every field is a parameter, so that all arrangements are one compiled system."""
    lines = tuple(f"a{k}*x + b{k}*y + c{k}" for k in range(3))
    regions = {key: core.Region(f=(f"u{n}", f"v{n}")) for n, key in enumerate(KEYS)}
    names = [f"{letter}{k}" for k in range(3) for letter in "abc"] + [f"{w}{n}" for n in range(8) for w in "uv"]
    return core.PiecewiseSystem(
        "Lines", ("x", "y"), surfaces=lines, regions=regions, parameters=dict.fromkeys(names, 1.0), x0=(0.3, 0.2)
    )


LINES = system()


@dataclass
class Path:
    """The exact path: times of crossings, the regions entered, how it ends, and whether it nearly ends at a corner."""

    times: list[Fraction] = field(default_factory=list)
    entered: list[str] = field(default_factory=list)
    status: str = "COMPLETED"
    end: Vector = (Fraction(0), Fraction(0))
    nearly: bool = False


def exact(values: dict[str, float], x0: tuple[float, float], slides: bool = False) -> Path:
    """Follow the path in ratios: from line to line, along a line where both fields point to it, and out of corners."""
    q = {name: Fraction(value) for name, value in values.items()}
    lines = [(q[f"a{k}"], q[f"b{k}"], q[f"c{k}"]) for k in range(3)]
    fields = {key: (q[f"u{n}"], q[f"v{n}"]) for n, key in enumerate(KEYS)}
    place = tuple(map(Fraction, x0))
    key, on = "".join("+" if a * place[0] + b * place[1] + c > 0 else "-" for a, b, c in lines), None
    t, path = Fraction(0), Path()
    while True:
        u, v = fields[key] if on is None else along(key, on, lines, fields)[2]
        ahead = {}
        for k, (a, b, c) in enumerate(lines):
            rate = a * u + b * v
            if k != on and (1 if key[k] == "+" else -1) * rate < 0:
                ahead[k] = -(a * place[0] + b * place[1] + c) / rate
        step = min(ahead.values(), default=None)
        if step is None or t + step > T_END:
            path.end = (place[0] + (T_END - t) * u, place[1] + (T_END - t) * v)
            return path
        before, t, place = place, t + step, (place[0] + step * u, place[1] + step * v)
        path.end = place
        if winds_in(path.times):
            path.status = "ZENO"
            return path
        path.times.append(t)
        met = [k for k in range(3) if k == on or a_zero(lines[k], *place)]
        path.nearly |= any(is_nearly_met(line, before, place) for line in lines)
        key, on, path.status = (out_of_corner if len(met) == 2 else beyond)(key, met, lines, fields)
        if on is not None and not slides:
            path.status = "SLIDING"
        if path.status != "COMPLETED":
            return path
        path.entered.append(key if on is None else f"{key[:on]}0{key[on + 1 :]}")


def winds_in(times: list[Fraction]) -> bool:
    """Whether the last turn, of four crossings, is much shorter than the one at half of them."""
    half = len(times) // 2
    return len(times) >= MANY and SHORTER * (times[-1] - times[-5]) < times[half] - times[half - 4]


def out_of_corner(key, met, lines, fields):
    """The one exit from the corner of two lines, if no weights of the fields, each line's apart, are an equilibrium."""
    around = {}
    for signs in product((-1, 1), repeat=2):
        near = list(key)
        for k, s in zip(met, signs, strict=True):
            near[k] = "+" if s > 0 else "-"
        u, v = fields["".join(near)]
        around[signs] = ("".join(near), [lines[k][0] * u + lines[k][1] * v for k in met])
    exits = [
        (near, None) for signs, (near, rates) in around.items()
        if all(s * rate >= 0 for s, rate in zip(signs, rates, strict=True))
    ]  # fmt: skip
    clear = all(0 not in around[signs][1] for signs in around if (around[signs][0], None) in exits)
    for k, side in product((0, 1), (-1, 1)):
        low, high = (around[(s, side) if k == 0 else (side, s)] for s in (-1, 1))
        (rate_low, on_low), (rate_high, on_high) = ((r[k], r[1 - k]) for _, r in (low, high))
        onward = side * (rate_low * on_high - rate_high * on_low)
        if rate_low >= 0 >= rate_high and onward >= 0:
            exits.append((low[0], met[k]))
            clear &= 0 not in (rate_low, rate_high, onward)
    if len(exits) != 1 or not clear or balanced([rates for _, rates in around.values()]):
        return key, None, "CORNER"
    return *exits[0], "COMPLETED"


def balanced(rates):
    """Whether the bilinear interpolant of the two rates at the corners of a square has a common zero in it."""
    one, other = (
        [c.dot([float(r[k]) for r in rates]) / 4 for c in np.array([[1, 1, 1, 1], [-1, -1, 1, 1], [-1, 1, -1, 1],
                                                                     [1, -1, -1, 1]])]
        for k in (0, 1)
    )  # fmt: skip
    resultant = np.polysub(
        np.polymul([other[2], other[0]], [one[3], one[1]]), np.polymul([other[3], other[1]], [one[2], one[0]])
    )
    if not np.any(resultant):  # the rates vanish together, or nowhere in common
        return all(min(r[k] for r in rates) <= 0 <= max(r[k] for r in rates) for k in (0, 1))
    for v in np.roots(resultant):
        slopes = [one[1] + one[3] * v.real, other[1] + other[3] * v.real]
        heights = [one[0] + one[2] * v.real, other[0] + other[2] * v.real]
        steeper = int(abs(slopes[1]) > abs(slopes[0]))
        near = abs(v.imag) < 1e-7 and abs(v.real) <= 1 + 1e-9
        if near and abs(heights[steeper]) <= (1 + 1e-9) * abs(slopes[steeper]):
            return True
    return False


def along(key, k, lines, fields):
    """Rates of line k with the fields on both sides, and the field of sliding; (0, 0) where there is none."""
    below, above = (fields[key[:k] + s + key[k + 1 :]] for s in "-+")
    low, high = (lines[k][0] * u + lines[k][1] * v for u, v in (below, above))
    if low == high:
        return low, high, (Fraction(0), Fraction(0))
    u, v = ((low * b - high * a) / (low - high) for a, b in zip(below, above, strict=True))
    return low, high, (u, v)


def a_zero(line: tuple[Fraction, Fraction, Fraction], x: Fraction, y: Fraction) -> bool:
    return line[0] * x + line[1] * y + line[2] == 0


def is_nearly_met(line: tuple[Fraction, Fraction, Fraction], before: Vector, here: Vector) -> bool:
    """Whether a place is as near a line as the rounding of the way there from the place before."""
    terms = [(line[0] * x, line[1] * y, line[2]) for x, y in (before, here)]
    return 0 < abs(sum(terms[1])) < ROUNDING * sum(max(map(abs, those)) for those in terms)


def beyond(key, met, lines, fields):
    """The region that follows where one line is met, or three at once, the line along which it slides, and the status.

    Where three meet, all fields around have to lead to one region.
    """
    if len(met) == 1:
        (k,) = met
        other = key[:k] + ("+" if key[k] == "-" else "-") + key[k + 1 :]
        out = lines[k][0] * fields[other][0] + lines[k][1] * fields[other][1]
        way = 1 if other[k] == "+" else -1
        return other if way * out > 0 else key, k if way * out < 0 else None, "COMPLETED" if out else "GRAZING"
    ways = {tuple(int(np.sign(a * u + b * v)) for a, b, _ in lines) for u, v in fields.values()}
    if len(ways) > 1 or 0 in next(iter(ways)):
        return key, None, "CORNER"
    return "".join("+" if s > 0 else "-" for s in ways.pop()), None, "COMPLETED"


def drawn(rng: np.random.Generator, near: float | None) -> tuple[dict[str, float], tuple[float, float]]:
    """Lines near the start and fields, in numbers of few digits; if `near` is given, the start aims at a corner.

    It then misses the corner of the first two lines by that distance, 0 for not at all.
    """
    values = {f"{w}{n}": float(rng.integers(-12, 13) or 1) / 8 for n in range(8) for w in "uv"}
    for k in range(3):
        a, b = (float(rng.integers(-8, 9)) for _ in range(2))
        values |= {f"a{k}": a or 1.0, f"b{k}": b or 1.0, f"c{k}": float(rng.integers(-8, 9)) / 4}
    x0 = (float(rng.integers(-16, 17)) / 8, float(rng.integers(-16, 17)) / 8)
    if near is not None:
        for k in (0, 1):  # both lines pass through the origin, exactly
            values[f"c{k}"] = 0.0
        values["c2"] = 20.0
        side = [1 if values[f"a{k}"] * x0[0] + values[f"b{k}"] * x0[1] > 0 else -1 for k in (0, 1)]
        n = KEYS.index("".join("+" if s > 0 else "-" for s in side) + "+")
        values |= {f"u{n}": -x0[0], f"v{n}": -x0[1]}
        x0 = (x0[0] - near * x0[1], x0[1] + near * x0[0])
    return values, x0


def on_a_line(values: dict[str, float], x0: tuple[float, float]) -> bool:
    return any(abs(values[f"a{k}"] * x0[0] + values[f"b{k}"] * x0[1] + values[f"c{k}"]) < 1e-9 for k in range(3))


def agrees(run: core.Trajectory, path: Path) -> bool:
    """Whether a run follows the path; one that winds into a corner may say that, or that its crossings accumulate."""
    if path.nearly and run.status is Status.CORNER:
        return True
    count = len(path.times)
    if path.status == "ZENO":
        first, last = run.crossings.t[:count], float(path.times[-1])
        turn = float(path.times[-1] - path.times[-5])  # a turn around the corner or more; the next ones are shorter
        ended = run.status in (Status.ZENO, Status.CORNER) and abs(run.t[-1] - last) < 100 * turn
        return ended and bool(np.abs(first - np.array(path.times, float)[: len(first)]).max() < 2e-12)
    # Where three lines meet, a run that slides may go beyond one of them before it finds that it cannot go on.
    there = run.crossings.t[count:] - run.crossings.t[count - 1] if path.status == "CORNER" else run.crossings.t[count:]
    if run.status.name != path.status or run.crossing_count < count or np.abs(there).max(initial=0.0) > 1e-11:
        return False
    size = 1 + float(np.abs(run.x).max()) + float(np.abs(run.crossings.x).max(initial=0.0))
    names = [LINES.laws.name(mode) for mode in run.crossings.mode[: len(path.entered)].tolist()]
    times = np.abs(run.crossings.t[:count] - np.array(path.times, dtype=float)).max(initial=0.0)
    return (
        names == path.entered
        and times < 2e-12 * size
        and np.abs(run.x[-1] - np.array(path.end, float)).max() < 2e-11 * size
    )


def passes_as_warned(run: core.Trajectory, path: Path, slid: Path) -> bool:
    """Whether a run passes a corner beside which the path slides and ends, says so, and goes on as one that slides."""
    if not (path.nearly and path.status == "SLIDING" and "solutions beside it slide" in run.warning):
        return False
    away = np.abs(run.x[-1] - np.array(slid.end, float)).max() if run.status.name == slid.status else 0.0
    return bool(np.abs(run.crossings.t - float(path.times[-1])).min() < 2e-12 and away < 1e-10)


def ends_before_meeting(run: core.Trajectory, path: Path) -> bool:
    """Whether the path meets a line at the end time itself, and the run ends there before it meets it."""
    if path.times[-1:] != [T_END] or run.status is not Status.COMPLETED or run.crossing_count != len(path.times) - 1:
        return False
    times = np.abs(run.crossings.t - np.array(path.times[:-1], dtype=float)).max(initial=0.0)
    return bool(times < 1e-11 and np.abs(run.x[-1] - np.array(path.end, float)).max() < 1e-10)


METHODS = {
    "rk2": {"tau": 0.75}, "taylor": {}, "dmm2": {"tau": 0.4}, "gauss4": {"tau": 3.0}, "prk8": {"tau": 0.3},
}  # fmt: skip
#: What a plain run tries: every other method, and every mode of sliding, is compiled anew.
QUICK = [("rk2", "stop"), ("taylor", "stop")]
ALL = [*((method, "stop") for method in METHODS), ("rk2", "continue")]


@pytest.mark.parametrize(("method", "sliding"), deep_but(QUICK, ALL))
def test_paths_cross_the_lines_of_an_arrangement_as_in_ratios(method, sliding, draws):
    """Steps are longer than cells, so that one step crosses several lines; corners are missed by little or nothing."""
    ends: Counter[str] = Counter()
    for rng in draws(12):
        for near in (None, 0.0, 1e-3, 1e-7, 1e-10, 1e-12):
            values, x0 = drawn(rng, near)
            if on_a_line(values, x0):
                continue
            path, lines = exact(values, x0, sliding == "continue"), LINES.with_parameters(**values)
            run = core.integrate(lines, (0.0, float(T_END)), x0, method=method, sliding=sliding, **METHODS[method])
            ends[run.status.name] += 1
            right = agrees(run, path) or passes_as_warned(run, path, exact(values, x0, slides=True))
            right = right or ends_before_meeting(run, path)
            assert right, (near, values, x0, run.status.name, path.status, run.message)
    assert len(ends) > 1


#: What a reference solution says where a path ends.
#: What a reference says of an end. A corner that it misses by its last digit only, it may meet again without end.
WORDS = {
    "SLIDING": "slides along", "GRAZING": "tangent", "CORNER": "surface|accumulate",
    "ZENO": "accumulate|surfaces at once",
}  # fmt: skip


def follows(solution: Solution, path: Path) -> bool:
    """Whether a reference solution is the path to the last digit, and ends where and as that does."""
    for k, name in enumerate(() if path.status == "ZENO" else path.entered, start=1):
        t, _ = solution.crossing(k)
        if LINES.laws.name(solution.entered(k)) != name or abs(Fraction(t) - path.times[k - 1]) > np.spacing(t):
            return False
    if path.status == "COMPLETED":
        end = np.array(path.end, dtype=float)
        return bool(np.abs(solution.state(float(T_END)) - end).max() <= 4e-16 * np.abs(end).max()) and solution.exact
    with pytest.raises(ValueError, match=f"ends at t = .*({WORDS[path.status]})"):
        solution.state(float(T_END))
    return solution.exact


@pytest.mark.parametrize("sliding", ["stop", "continue"])
def test_reference_solutions_are_these_paths_to_the_last_digit(sliding, draws):
    ends: Counter[str] = Counter()
    for rng in draws(9):
        for near in (None, 0.0, 1e-7, 1e-12, 1e-15):
            values, x0 = drawn(rng, near)
            if on_a_line(values, x0):
                continue
            path = exact(values, x0, sliding == "continue")
            solution = core.reference_solution(LINES.with_parameters(**values), x0, sliding=sliding)
            assert follows(solution, path), (near, values, x0, path)
            ends[path.status] += 1
    assert len(ends) > 1
