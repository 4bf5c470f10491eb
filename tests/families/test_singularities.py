"""Solutions that end where their field is not bounded: no run goes on behind in silence, whatever its steps."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest
import sympy
from scipy.integrate import quad

import core
from core import Status
from tests.levels import QUICK_METHODS, deep_but

_PLAIN = ("rk2", "rk4", "rk8", "gauss4", "taylor")
_STOPS = (Status.SINGULAR, Status.ESCAPED, Status.NO_CONVERGENCE, Status.UNSTABLE)


@dataclass(frozen=True)
class Case:
    """A system whose solution ends at a known time."""

    system: core.PiecewiseSystem
    end: float
    zero: str
    """The expression that vanishes there."""


def in_time(rng: np.random.Generator) -> tuple[str, float, str]:
    """A field of time alone: its text, its pole, and the expression that vanishes there."""
    a, c, b = rng.uniform(0.3, 3.0), rng.uniform(0.2, 2.0) * rng.choice([-1, 1]), rng.uniform(-1.0, 1.0)
    if rng.integers(2):
        return f"({c})*tan({a}*t + ({b}))", (math.pi / 2 - b) / a, "cos("
    return f"({c})/({a} - t)**{rng.integers(1, 5)}", a, "t"


def in_state(rng: np.random.Generator) -> Case:
    """x' = −k/xⁿ."""
    return root(rng, rng.uniform(0.5, 2.0))


def root(rng: np.random.Generator, x: float) -> Case:
    """The same from a start x; it is at 0 at the time xⁿ⁺¹/(k (n + 1))."""
    k, n = rng.uniform(0.3, 3.0), int(rng.integers(1, 6))
    f = (f"-({k})/x**{n}",)
    return Case(core.PiecewiseSystem("Root", ("x",), f, f, "x + 100", x0=(x,)), x ** (n + 1) / (k * (n + 1)), "x")


def fall(rng: np.random.Generator) -> Case:
    """A fall into a centre of attraction, at the speed of a fall from infinity."""
    k, x = rng.uniform(0.3, 3.0), rng.uniform(0.5, 2.0)
    f, psi = ("v", f"-({k})/x**2"), (f"v**2/2 - ({k})/x",)
    start = (x, -math.sqrt(2 * k / x))
    system = core.PiecewiseSystem("Fall", ("x", "v"), f, f, "x + 100", psi, psi, x0=start)
    return Case(system, 2 * x / (-3 * start[1]), "x")


def flow(rng: np.random.Generator) -> Case:
    """x' = 1, y' = c/(a − x)ⁿ, with its conserved quantity."""
    a, c, n = rng.uniform(0.3, 3.0), rng.uniform(0.2, 2.0), int(rng.integers(2, 5))
    f, psi = ("1", f"({c})/({a} - x)**{n}"), (f"y - ({c})/({n - 1}*({a} - x)**{n - 1})",)
    return Case(core.PiecewiseSystem("Flow", ("x", "y"), f, f, "x + 100", psi, psi, x0=(0.0, 0.3)), a, "x")


def of_time(rng: np.random.Generator) -> Case:
    f, end, zero = in_time(rng)
    return Case(core.PiecewiseSystem("Time", ("x",), (f,), (f,), "x + 1000", x0=(0.5,)), end, zero)


def steps(rng: np.random.Generator, method: str, end: float) -> dict[str, float]:
    """A step size of no, or of a simple, relation to the end; none for a method that chooses its own."""
    if core.METHODS[method].adaptive:
        return {}
    return {"tau": abs(end) * (rng.uniform(0.003, 0.7) if rng.integers(2) else 1.0 / rng.integers(2, 100))}


def assert_it_ends(run: core.Trajectory, case: Case, tau: float) -> None:
    about = f"{case.system.regions}, tau = {tau}: {run.status!r} {run.message}"
    assert run.status in _STOPS, about
    assert abs(run.t[-1]) <= abs(case.end) + 2 * tau + 1e-9, about
    assert run.status is not Status.SINGULAR or case.zero in run.message, about


@pytest.mark.parametrize("method", _PLAIN)
@pytest.mark.parametrize("family", [of_time, in_state])
def test_a_run_ends_where_its_field_is_not_bounded(draws, family, method):
    for rng in draws(9):
        case = family(rng)
        step = steps(rng, method, case.end)
        run = core.integrate(case.system, (0.0, 3.7 * case.end), method=method, record="end", **step)
        assert_it_ends(run, case, step.get("tau", 0.0))


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, tuple(core.METHODS)))
@pytest.mark.parametrize("family", [fall, flow])
def test_a_run_that_conserves_ends_where_its_field_is_not_bounded(draws, family, method):
    for rng in draws(6):
        case = family(rng)
        step = steps(rng, method, case.end)
        run = core.integrate(case.system, (0.0, 3.7 * case.end), method=method, record="end", **step)
        assert_it_ends(run, case, step.get("tau", 0.0))


def with_clock(name: str, first: tuple[str, int], then: tuple[str, int], switch: float) -> core.PiecewiseSystem:
    """Two laws of x, one after the other; a clock s tells when the second begins. Each goes forward or backward."""
    fields = [("1", f if sign > 0 else re.sub(r"\bt\b", "(-t)", f)) for f, sign in (first, then)]
    return core.PiecewiseSystem(name, ("s", "x"), *fields, f"({then[1]})*s - ({switch})", x0=(0.0, 0.5))


@pytest.mark.parametrize("method", _PLAIN)
def test_a_run_ends_at_a_singularity_behind_a_crossing_forward_and_backward(draws, method):
    for rng in draws(6):
        f, end, zero = in_time(rng)
        switch, sign = rng.uniform(0.1, 0.9) * end, int(rng.choice([-1, 1]))
        case = Case(with_clock("Behind", ("0.5", sign), (f, sign), switch), end, zero)
        step = steps(rng, method, end)
        run = core.integrate(case.system, (0.0, sign * 3.7 * end), method=method, **step)
        assert_it_ends(run, case, step.get("tau", 0.0))
        assert len(run.crossings) == 1
        assert abs(run.crossings.t[0] - sign * switch) < 1e-9


@pytest.mark.parametrize("method", _PLAIN)
def test_a_singularity_of_a_law_that_has_ended_before_stops_no_run(draws, method):
    for rng in draws(6):
        f, end, _ = in_time(rng)
        switch, sign = rng.uniform(0.1, 0.95) * end, int(rng.choice([-1, 1]))
        system = with_clock("Before", (f, sign), ("0.5", sign), switch)
        run = core.integrate(system, (0.0, sign * 2 * end), method=method, **steps(rng, method, end))
        assert run.status is Status.COMPLETED, f"{f}, {switch}: {run.message}"
        assert abs(run.crossings.t[0] - sign * switch) < 1e-9


def test_members_of_an_ensemble_end_as_runs_do_with_and_without_events(draws):
    for rng in draws(3):
        starts = rng.uniform(0.3, 3.0, (5, 1))
        case = root(rng, float(starts.max()))  # the last that comes to 0
        end = 1.5 * case.end
        for more in ({}, {"events": ("x - 0.2", "sin(9*x)")}):
            found = core.ensemble(case.system, (0.0, end), starts, tau=0.02, method="rk4", **more)
            for k, x0 in enumerate(starts):
                run = core.integrate(case.system, (0.0, end), tuple(x0), tau=0.02, method="rk4", record="end", **more)
                assert (run.status, run.t[-1]) == (found.status[k], found.t[k])
                assert run.status in _STOPS, run.message


@pytest.mark.parametrize("method", ["rk4", "dmm2", "taylor"])
def test_a_field_that_stays_bounded_where_a_denominator_vanishes_ends_no_run(draws, method):
    laws = (("1", "sin(a*x)/x"), ("1", "(x**2 - a**2)/(x - a)"), ("1", "x/(exp(x) - 1)"), ("1", "a/(1 + 1/x)**2"))
    for rng, f in zip(draws(12), laws, strict=False):
        psi = ("x - t",)
        system = core.PiecewiseSystem(
            "Limit", ("x", "y"), f, f, "y + 1000", psi, psi, {"a": rng.uniform(0.3, 3.0)}, x0=(-0.7123, 0.0)
        )
        step = {} if method == "taylor" else {"tau": rng.uniform(0.01, 0.2)}
        run = core.integrate(system, (0.0, 2.0), method=method, record="end", **step)
        assert run.status is Status.COMPLETED, f"{f}: {run.message}"


@pytest.mark.parametrize("method", _PLAIN)
def test_a_factor_common_to_numerator_and_denominator_is_cancelled(draws, method):
    """The steps meet its zero to within rounding, where the quotient as it is written is 0/0 or noise."""
    for rng in draws(12):
        a, tau = float(np.round(rng.uniform(0.3, 2.5), 1)), float(rng.choice([0.05, 0.025, 0.02, 0.01]))
        roots, c = rng.uniform(-3, 3, rng.integers(0, 3)), float(rng.uniform(0.3, 2.0))
        polynomial = np.polynomial.Polynomial.fromroots(roots) if len(roots) else np.polynomial.Polynomial([1.0])
        kept = "*".join(f"(t - ({r!r}))" for r in roots.tolist()) or "1"
        above, below = [("t**2 - a**2", "(t + a)"), ("t**2 - 2*a*t + a**2", "(t - a)"), ("t - a", "1")][rng.integers(3)]
        f, right = f"({above})*({kept})/(c*(t - a))", polynomial.integ()
        if below != "1":
            right = (polynomial * np.polynomial.Polynomial([a if "+" in below else -a, 1.0])).integ()
        system = core.PiecewiseSystem("Common", ("x",), (f,), (f,), "x - 1e6", parameters={"a": a, "c": c}, x0=(0.0,))
        step = {} if method == "taylor" else {"tau": tau}
        run = core.integrate(system, (0.0, 3.0), method=method, record="end", **step)
        off = abs(run.x[-1, 0] - (right(3.0) - right(0.0)) / c)
        assert run.status is Status.COMPLETED, f"{f}, a = {a}: {run.message}"
        # A field of time alone makes each method a quadrature: rk2 is no worse than the trapezoidal rule,
        # τ²/12 ∫|f''|, and the others take a cubic exactly.
        bend = right.deriv(3)(np.linspace(0.0, 3.0, 301)) / c
        own = tau**2 / 12 * 3.0 * np.abs(bend).max() if method == "rk2" else 0.0
        assert off < 1e-9 + own, f"{f}, a = {a}, tau = {tau}: off by {off}"


#: Quotients of two functions that vanish together, and the same in numpy beside that place, with the limit there.
LIMITS = {
    "(1 - cos({u}))/({u})**2": (lambda u: 0.5 * np.sinc(u / (2 * np.pi)) ** 2, 0.5),
    "(exp({u}) - 1)/({u})": (lambda u: np.expm1(u) / u, 1.0),
    "({u})/(1 - exp({u}))": (lambda u: -u / np.expm1(u), -1.0),
    "sin({u})/({u})": (lambda u: np.sin(u) / u, 1.0),
    "({u})/tan({u})": (lambda u: u / np.tan(u), 1.0),
    "b*({u})/sin(b*({u}))": (lambda u: 0.8 * u / np.sin(0.8 * u), 1.0),
    "sin(b*({u}))/sin({u})": (lambda u: np.sin(0.8 * u) / np.sin(u), 0.8),
    # Functions that lose their digits there, as they are written.
    "log(4 + {u} - 3)/({u})": (lambda u: np.log1p(u) / u, 1.0),
    "({u} - sin({u}))/({u})**3": (lambda u: (u - np.sin(u)) / u**3 if abs(u) > 0.01 else 1 / 6 - u**2 / 120, 1 / 6),
    "(cosh({u}) - 1)/({u})**2": (lambda u: 2 * (np.sinh(u / 2) / u) ** 2, 0.5),
}


#: Errors of the largest step, of the midpoint rule, of Simpson's and of Gauss's (two points: 2.54e-6), where log(1 + u)
#: starts at u = −0.9.
TRUNCATION = {"rk2": 3e-3, "rk4": 1e-5, "gauss4": 1e-5}


@pytest.mark.parametrize("method", _PLAIN)
@pytest.mark.parametrize("f", LIMITS)
def test_a_quotient_that_is_0_over_0_where_a_step_ends_has_its_limit_there(draws, f, method):
    value, limit = LIMITS[f]
    speed = lambda u: value(u) if abs(u) > 1e-9 else limit  # noqa: E731
    for rng in draws(6):
        a, tau = float(np.round(rng.uniform(0.3, 0.9), 1)), float(rng.choice([0.05, 0.025, 0.02, 0.01]))
        start, end, u = (a, 2.0, "x - a") if rng.integers(2) else (0.1, 1.7, "t - a")
        text = f.format(u=u)
        system = core.PiecewiseSystem(
            "Limit", ("x",), (text,), (text,), "x - 1e6", parameters={"a": a, "b": 0.8}, x0=(start - 0.5,)
        )
        if u == "x - a":  # the time from place to place is the integral of 1/f
            to = start + (0.3 if limit > 0 else -0.7)
            end = quad(lambda x, a=a, speed=speed: 1.0 / speed(x - a), start - 0.5, to, epsabs=1e-12)[0]
        else:
            to = start - 0.5 + quad(lambda t, a=a, speed=speed: speed(t - a), 0.0, end, epsabs=1e-12)[0]
        run = core.integrate(system, (0.0, end), method=method, **({} if method == "taylor" else {"tau": tau}))
        assert run.status is Status.COMPLETED, f"{text}, a = {a}, tau = {tau}: {run.message}"
        assert abs(run.x[-1, 0] - to) < TRUNCATION.get(method, 1e-6), f"{text}, a = {a}: {run.x[-1]}, not {to}"


@pytest.mark.parametrize("f", LIMITS)
def test_a_quotient_that_is_0_over_0_at_an_oblique_surface_has_its_limit_there(draws, f):
    value, limit = LIMITS[f]
    speed = lambda u: value(u) if abs(u) > 1e-9 else limit  # noqa: E731
    for rng in draws(2):
        angle, offset = rng.uniform(0.0, 2.0 * np.pi), round(rng.uniform(-2.0, 2.0), int(rng.choice([0, 1, 3, 15])))
        offset *= float(rng.choice([0.0, 1.0]))
        a, b = (float(u) for u in (round(np.cos(angle), 3), round(np.sin(angle), 3)))
        g = f"({a!r}*x + ({b!r})*y - ({offset!r}))"
        # The distance u changes at the speed 2 + f/5 on one side, or on both, else at 2.
        fast = (f"2 + 0.2*({f.format(u=g)})", "2")
        sides = [fast[k] for k in ((0, 1), (1, 0), (0, 0))[rng.integers(3)]]
        laws = [tuple(f"({c / (a * a + b * b)!r})*({side})" for c in (a, b)) for side in sides]
        x0 = tuple(float(c * (offset - 0.5) / (a * a + b * b)) for c in (a, b))
        system = core.PiecewiseSystem("Limit", ("x", "y"), *laws, g, parameters={"b": 0.8}, x0=x0)
        rates = [(lambda u: 1.0 / (2.0 + 0.2 * speed(u))) if side is fast[0] else (lambda u: 0.5) for side in sides]
        end = quad(rates[0], -0.5, 0.0, epsabs=1e-12)[0] + quad(rates[1], 0.0, 0.4, epsabs=1e-12)[0]
        for method in _PLAIN:
            run = core.integrate(system, (0.0, end), method=method, **({} if method == "taylor" else {"tau": 0.02}))
            assert run.status is Status.COMPLETED, f"{method}: {g}, {sides}: {run.message}"
            reached = a * run.x[-1, 0] + b * run.x[-1, 1] - offset
            assert abs(reached - 0.4) < TRUNCATION.get(method, 1e-6), f"{method}: {g}, {sides}: {reached}"


@pytest.mark.parametrize("f", LIMITS)
def test_a_quotient_that_is_0_over_0_at_a_moving_surface_has_its_limit_there(draws, f):
    value, limit = LIMITS[f]
    time = sympy.Symbol("t")
    for rng in draws(1):
        a, b = (round(rng.uniform(0.3, 0.9), 2) for _ in "ab")
        ways = (
            f"{a}*sin(t)",
            f"{a}*tan({b}*sin(t))",
            f"{a}/(2 + cos(t))",
            f"{a}*exp({b}*sin(t))",
            f"{a}*sqrt(1 + {b}*t)",
        )
        place = sympy.sympify(str(rng.choice(ways)), {"t": time})
        # The distance u from the surface x = c(t) changes at the speed 2 + f/5, or 2 beyond it.
        g, moved = f"(x - {place})", f"({place.diff(time)})"
        system = core.PiecewiseSystem(
            "Limit", ("x",), (f"{moved} + 2 + 0.2*({f.format(u=g)})",), (f"{moved} + 2",), g,
            parameters={"b": 0.8}, x0=(float(place.subs(time, 0.0)) - 0.5,),
        )  # fmt: skip
        inverse = lambda u: 1.0 / (2.0 + 0.2 * (value(u) if abs(u) > 1e-9 else limit))  # noqa: E731
        end = quad(inverse, -0.5, 0.0, epsabs=1e-12)[0] + 0.2
        for method in _PLAIN:
            run = core.integrate(system, (0.0, end), method=method, **({} if method == "taylor" else {"tau": 0.02}))
            assert run.status is Status.COMPLETED, f"{method}: {system.f_minus}, {g}: {run.message}"
            reached = run.x[-1, 0] - float(place.subs(time, end))
            assert abs(reached - 0.4) < TRUNCATION.get(method, 1e-6), f"{method}: {system.f_minus}: {reached}"


def pulled_to_the_surface(rng: np.random.Generator, power: float) -> tuple[core.PiecewiseSystem, float]:
    """A point that is pulled to a line by a force k/sⁿ, s the distance, and the speed with which it gets there."""
    angle, k, v = rng.uniform(0.0, 2.0 * np.pi), round(rng.uniform(0.5, 2.0), 2), round(rng.uniform(-0.3, 0.5), 2)
    a, b = (float(u) for u in (round(np.cos(angle), 3), round(np.sin(angle), 3)))
    offset, size = round(rng.uniform(-0.5, 0.5), 2), float(np.hypot(a, b))
    g = f"({a!r}*x + ({b!r})*y - ({offset!r}))"
    force = f"{k!r}*(-{g})**(-{power:g})"
    pull = tuple(f"({u / size!r})*{force}" for u in (a, b))
    start = np.array([a, b]) * (offset - 0.8) / size**2
    system = core.PiecewiseSystem(
        "Pulled", ("x", "y", "u", "v"), ("u", "v", *pull), ("u", "v", "0", "0"), g,
        x0=(*map(float, start), v * a / size, v * b / size),
    )  # fmt: skip
    work = k * 0.8 ** (1.0 - power) / (1.0 - power) / size if power < 1.0 else np.inf
    return system, math.sqrt(v * v + 2.0 * work)


@pytest.mark.parametrize("method", _PLAIN)
@pytest.mark.parametrize("power", [1.0, 1.5, 2.0])
def test_no_run_crosses_a_surface_at_which_the_speed_is_not_bounded(draws, method, power):
    for rng in draws(4):
        system, _ = pulled_to_the_surface(rng, power)
        run = core.integrate(system, (0.0, 5.0), tau=0.01, method=method)
        assert run.status in _STOPS, f"{system.regions}: {run.message}"
        assert not len(run.crossings), run.crossings
        member = core.ensemble(system, (0.0, 5.0), x0=np.array([system.x0]), tau=0.01, method=method)
        assert list(member.outcomes) == [run.status]


def test_a_run_crosses_a_surface_at_which_the_force_is_not_bounded_but_the_speed_is(draws):
    for rng in draws(6):
        system, speed = pulled_to_the_surface(rng, 0.5)
        run = core.integrate(system, (0.0, 5.0), tau=1e-3, method="rk4")
        assert run.status is Status.COMPLETED, f"{system.regions}: {run.message}"
        assert np.hypot(*run.x[-1, 2:]) == pytest.approx(speed, rel=0.02)


@pytest.mark.parametrize("f", ["{u}/tan({u})", "{u}*cos({u})/sin({u})"])
@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4"])
def test_a_zero_at_which_the_field_is_bounded_keeps_no_run_from_its_surface(draws, method, f):
    for rng in draws(3):
        u = f"(x - ({round(rng.uniform(-0.3, 0.3), 3)}))"
        force = f.format(u=u)
        system = core.PiecewiseSystem("Bounded", ("x", "v"), ("v", force), ("v", f"-{force}"), u, x0=(-0.5, 0.8))
        run = core.integrate(system, (0.0, 2.0), tau=0.005, method=method)
        assert run.status is Status.COMPLETED, f"{u}: {run.message}"
        assert len(run.crossings) == 1
