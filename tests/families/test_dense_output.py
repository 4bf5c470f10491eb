"""Dense output against closed forms: centres on both sides of a line, with and without a jump along it."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

import core

METHODS = {"dmm2": 0.01, "dmm4": 0.06, "rk4": 0.04, "prk8": 0.12, "taylor": 1e-9}
_FIELDS = {
    word: (f"a_{word}*(x - p_{word}) + b_{word}*(y - q_{word})", f"c_{word}*(x - p_{word}) - a_{word}*(y - q_{word})")
    for word in ("minus", "plus")
}
_PSI = {
    word: f"a_{word}*(x - p_{word})*(y - q_{word}) + b_{word}*(y - q_{word})**2/2 - c_{word}*(x - p_{word})**2/2"
    for word in ("minus", "plus")
}
_NAMES = [f"{letter}_{word}" for word in ("minus", "plus") for letter in "abcpq"]
LAWS = {
    "variables": ("x", "y"), "f_minus": _FIELDS["minus"], "f_plus": _FIELDS["plus"], "g": "m*x + n*y - s",
    "psi_minus": (_PSI["minus"],), "psi_plus": (_PSI["plus"],),
    "parameters": {**dict.fromkeys(_NAMES, 1.0), "m": 1.0, "n": 0.0, "s": 0.0, "j": 0.0},
}  # fmt: skip
SMOOTH = core.PiecewiseSystem("Centres", **LAWS)
JUMPING = core.PiecewiseSystem("Centres with a jump", jump=("x - j*n", "y + j*m"), **LAWS)


class Arc(NamedTuple):
    """A piece of the exact solution."""

    t: float
    x: np.ndarray
    side: int
    centre: np.ndarray
    matrix: np.ndarray
    rate: float

    def state(self, t):
        """State at a time."""
        angle = self.rate * (t - self.t)
        z = self.x - self.centre
        return self.centre + math.cos(angle) * z + math.sin(angle) / self.rate * (self.matrix @ z)


class Exact:
    """The solution of a drawn case: centres turn at a constant rate, and meet a line where a cosine has a value."""

    def __init__(self, values, x0, t_end):
        self.values, self.sign = values, math.copysign(1.0, t_end)
        self.normal, self.s = np.array([values["m"], values["n"]]), values["s"]
        g = self.normal @ x0 - self.s
        self.arcs, self.end = [self.arc(0.0, np.array(x0), 1 if g > 0 else -1)], t_end
        while self.follow():
            pass

    def arc(self, t, x, side):
        """The arc of a side from a state."""
        a, b, c, p, q = (self.values[f"{letter}_{'plus' if side > 0 else 'minus'}"] for letter in "abcpq")
        return Arc(t, x, side, np.array([p, q]), np.array([[a, b], [c, -a]]), math.sqrt(-a * a - b * c))

    def into(self, side, x):
        """How fast the field of a side leads into it, in parts of its size."""
        arc = self.arc(0.0, x, side)
        return side * self.sign * (self.normal @ arc.matrix @ (x - arc.centre)) / np.linalg.norm(arc.matrix)

    def follow(self):
        """Append the next arc; where what follows is not clear by a margin, the comparison ends before it."""
        arc = self.arcs[-1]
        z = arc.x - arc.centre
        u, v = self.normal @ z, self.normal @ arc.matrix @ z / arc.rate
        level, size, phase = self.s - self.normal @ arc.centre, math.hypot(u, v), math.atan2(v, u)
        if abs(level) >= size * 0.98:
            if abs(level) < size * 1.02:
                self.end = arc.t
            return False
        half = math.acos(level / size)
        on_line = len(self.arcs) > 1
        angles = [self.sign * (phase + way) % (2 * math.pi) for way in (half, -half)]
        angles = [angle for angle in angles if not on_line or 1e-7 < angle < 2 * math.pi - 1e-7]
        t = arc.t + self.sign * min(angles) / arc.rate
        if abs(t) >= abs(self.end):
            return False
        x = arc.state(t)
        after = x + self.values["j"] * np.array([-self.values["n"], self.values["m"]])
        leading = {side: self.into(side, after) for side in (-1, 1)}
        if min(abs(r) for r in leading.values()) < 0.1 or (leading[-1] > 0) == (leading[1] > 0) or len(self.arcs) > 40:
            self.end = t
            return False
        side = 1 if leading[1] > 0 else -1
        if self.values["j"] == 0.0 and side == arc.side:
            self.end = t
            return False
        self.arcs.append(self.arc(t, after, side))
        return True

    def states(self, times):
        """States (k, 2) at times."""
        starts = np.array([self.sign * arc.t for arc in self.arcs])
        rows = np.searchsorted(starts, self.sign * times, "right") - 1
        return np.array([self.arcs[k].state(t) for k, t in zip(rows, times, strict=True)])


class Case(NamedTuple):
    """A drawn system, start, direction and method."""

    system: core.PiecewiseSystem
    x0: tuple[float, float]
    t_end: float
    method: str
    exact: Exact

    def run(self, finer=1.0, **more):
        """Integrate it."""
        step = METHODS[self.method]
        key = {"tolerance": step} if self.method == "taylor" else {"tau": step / finer}
        return core.integrate(self.system, (0.0, self.t_end), self.x0, method=self.method, **key, **more)

    def __str__(self):
        values = dict(self.system.values)
        return (
            f"{self.system.name}, {values}, x0 = {self.x0}, to t = {self.t_end}, {self.method}: {METHODS[self.method]}"
        )


def drawn(rng):
    values = {}
    for word in ("minus", "plus"):
        a, b, rate = rng.normal() / 2, rng.uniform(0.5, 2.0) * rng.choice([-1, 1]), rng.uniform(0.6, 1.6)
        values |= {f"a_{word}": a, f"b_{word}": b, f"c_{word}": -(a * a + rate * rate) / b}
        values |= {f"p_{word}": rng.normal() / 2, f"q_{word}": rng.normal() / 2}
    angle = rng.uniform(0, 2 * math.pi)
    jumps = rng.random() < 0.4
    values |= {"m": math.cos(angle), "n": math.sin(angle), "s": rng.normal() / 3, "j": 0.2 * rng.normal() * jumps}
    system = (JUMPING if jumps else SMOOTH).with_parameters(**values)
    x0, t_end = tuple((rng.normal(size=2) * 1.5).tolist()), float(rng.choice([-1, 1]) * rng.uniform(4.0, 12.0))
    return Case(system, x0, t_end, str(rng.choice(list(METHODS))), Exact(system.values, x0, t_end))


def random_times(rng, case, run, count=200):
    """Times as far as the exact solution is clear and the run goes; with some just beside the crossings."""
    end = case.exact.end * 0.999
    end = math.copysign(min(abs(end), abs(run.t[-1])), case.t_end)
    beside = run.crossings.t[:, None] + np.array([-1e-9, -1e-13, 1e-13, 1e-9])
    times = np.concatenate([rng.uniform(0, 1, count) * end, beside.ravel()])
    return times[(np.abs(times) <= abs(end)) & (times * case.exact.sign >= 0)]


def off_crossings(case, times, margin):
    """Times farther from all exact crossings than a run errs in them: across a jump the states differ by all of it."""
    crossings = np.array([arc.t for arc in case.exact.arcs[1:]])
    near = np.abs(times[:, None] - crossings) <= margin
    return times[~near.any(axis=1)] if case.system.jump is not None else times


def test_between_steps_a_run_is_as_accurate_as_at_its_steps_and_of_the_same_order(draws):
    slopes = {}
    for rng in draws(24):
        case = drawn(rng)
        run = case.run()
        inside = np.abs(run.t) <= abs(case.exact.end) * 0.999
        margin = 1e-2 if case.method in ("dmm2", "rk4") else 1e-4
        steps = off_crossings(case, run.t[inside], margin)
        times = off_crossings(case, random_times(rng, case, run), margin)
        if len(steps) < 10 or len(times) < 20:
            continue
        recorded = np.abs(run.at(steps) - case.exact.states(steps)).max()
        error = np.abs(run.at(times) - case.exact.states(times)).max()
        assert error <= 4.0 * recorded + 1e-11, f"{case}: {error:.2g} between steps, {recorded:.2g} at them"
        if case.method == "taylor":
            assert error < 1e-6, f"{case}: {error:.2g}"
        elif error > 1e-10:
            finer = np.abs(case.run(2.0).at(times) - case.exact.states(times)).max()
            slopes.setdefault(case.method, []).append(math.log2(error / finer))
    for method, found in slopes.items():
        assert np.mean(found) == pytest.approx(core.METHODS[method].order, abs=0.4), (method, found)


def test_conserved_quantities_are_kept_between_steps_to_round_off(draws):
    for rng in draws(24):
        case = drawn(rng)
        if not core.METHODS[case.method].conservative:
            continue
        run = case.run()
        times = rng.uniform(0, 1, 300) * run.t[-1]
        error = np.abs(case.run(t_eval=times).conserved_error())
        size = max(float(np.abs(run.x - arc.centre).max()) ** 2 * np.abs(arc.matrix).max() for arc in case.exact.arcs)
        assert error.max() <= 32 * 2.0**-52 * max(size, 1.0), f"{case}: {error.max():.2g} of {size:.2g}"


def test_recorded_times_give_recorded_states_and_sampling_gives_what_the_whole_run_gives(draws):
    for rng in draws(24):
        case = drawn(rng)
        run = case.run()
        assert (run.at(run.t) == run.x).all(), case
        k = len(run.crossings)
        later = np.array([*run.crossings.t[1:], np.nan])[:k] != run.crossings.t
        assert (run.at(run.crossings.t)[later] == run.crossings.x_after[later]).all(), case
        first = np.array([np.nan, *run.crossings.t[:-1]])[:k] != run.crossings.t
        assert (run.at(run.crossings.t, before=True)[first] == run.crossings.x[first]).all(), case
        times = rng.uniform(0, 1, 50) * run.t[-1]
        sampled = case.run(t_eval=times, record=str(rng.choice(["steps", "crossings", "end"])))
        assert (sampled.at(times) == run.at(times)).all(), case
        assert (sampled.t[0], sampled.t[-1], len(sampled.t)) == (run.t[0], run.t[-1], 52), case


def test_states_go_on_without_a_gap_between_crossings(draws):
    for rng in draws(12):
        case = drawn(rng)
        run = case.run()
        kept = np.concatenate([run.t, run.crossings.t])
        speed = max(np.linalg.norm(arc.matrix) * np.abs(run.x - arc.centre).max() for arc in case.exact.arcs)
        for t in rng.choice(kept, 20):
            before, after = t - 1e-9 * case.exact.sign, t + 1e-9 * case.exact.sign
            if min(0, run.t[-1]) <= min(before, after) and max(before, after) <= max(0, run.t[-1]):
                gaps = np.abs(run.at([before, after]) - np.stack([run.at(t, before=True), run.at(t)])).max()
                assert gaps <= 4e-9 * max(speed, 1.0), f"{case}: gap of {gaps:.2g} at t = {t!r}"


def test_steps_a_run_has_made_are_whole_numbers_of_its_own(draws):
    # A step halved is two of the same method from the same places: dense output is on the scheme itself.
    for rng in draws(12):
        case = drawn(rng)
        run = case.run()
        k = int(rng.integers(0, max(len(run.t) - 2, 1)))
        if case.method == "taylor" or run.segment[k] != run.segment[k + 1] or run.side[k] == 0:
            continue
        t = float(run.t[k] + (run.t[k + 1] - run.t[k]) * rng.random())
        one = core.integrate(case.system, (run.t[k], t), run.x[k], tau=1.0, method=case.method, record="end")
        assert np.abs(run.at(t) - one.x[-1]).max() <= 64 * 2.0**-52 * np.abs(run.x).max(), case


def test_pairs_of_times_are_independent_of_the_order_they_are_asked_in(draws):
    for rng in draws(8):
        case = drawn(rng)
        run = case.run()
        times = rng.uniform(0, 1, (7, 5)) * run.t[-1]
        together = run.at(times)
        assert together.shape == (7, 5, 2)
        assert all((run.at(times[i, j]) == together[i, j]).all() for i in range(7) for j in range(5)), case
        assert all((run.at([a, b]) == run.at([b, a])[::-1]).all() for a, b in pairwise(times.ravel())), case
