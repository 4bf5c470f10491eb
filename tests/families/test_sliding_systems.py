"""Systems drawn at random that slide: what a run says of them is what their exact solutions do."""

import mpmath as mp
import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import core
from core import Status
from tests.core.sliding_solutions import Exact
from tests.families.oracles import silent
from tests.levels import deep_but

#: Method -> its settings, and the error allowed at the end time and in the times of events, relative to the state.
METHODS = {
    "rk8": ({"tau": 0.02}, 1e-12), "taylor": ({"tolerance": 1e-12}, 1e-12), "rk4": ({"tau": 2e-3}, 1e-10),
    "gauss4": ({"tau": 4e-3}, 1e-10),
}  # fmt: skip
END = 8.0
#: An event whose rates are below this part of the largest is a tangency: round-off may decide what follows.
TANGENT = 1e-3
#: Largest state.
LARGEST = 100.0


def drawn(rng):
    """A linear plant with a relay, pushed to and fro, in coordinates bent by a shear: the system and its solution."""
    d = int(rng.integers(2, 5))
    a = np.round(rng.normal(size=(d, d)) - np.eye(d), 3)
    k, n, load, offset = (np.round(rng.normal(size=d), 3) for _ in range(4))
    n[np.abs(n) < 0.1] = 0.5
    k *= -np.sign(n @ k) * rng.uniform(0.5, 3.0)  # the fields differ by k, towards the surface
    k, w = np.round(k, 3), round(float(rng.uniform(0.5, 3.0)), 3)
    x0 = np.round(rng.normal(size=d) * 1.5, 3)
    bend, (i, j) = round(float(rng.uniform(-0.4, 0.4)), 3), rng.choice(d, 2, replace=False)

    def law(part):
        rows = [[*map(repr, map(float, a[r])), repr(float(load[r])), "0", repr(float(offset[r]))] for r in range(d)]
        rows = [[mp.mpf(v) for v in row] for row in rows]
        for r in range(d):
            rows[r][-1] += part * mp.mpf(repr(float(k[r])))
        forcing = [[0] * d + [0, -mp.mpf(repr(w)), 0], [0] * d + [mp.mpf(repr(w)), 0, 0], [0] * (d + 3)]
        return [*rows, *forcing]

    start = [*(mp.mpf(repr(float(v))) for v in x0), 1, 0, 1]
    normal = [*(mp.mpf(repr(float(v))) for v in n), 0, 0, 0]
    exact = Exact(law(0), law(1), normal, start, END)

    def system():
        y = sympy.symbols(f"y:{d}")
        z = [v - sympy.Float(bend) * y[j] ** 2 if r == i else v for r, v in enumerate(y)]
        rates = {}
        for side, part in ((-1, 0), (1, 1)):
            zdot = [
                sum(sympy.Float(float(a[r, c])) * z[c] for c in range(d))
                + sympy.Float(float(load[r])) * sympy.cos(w * sympy.Symbol("t")) + float(offset[r]) + part * float(k[r])
                for r in range(d)
            ]  # fmt: skip
            rates[side] = [q + 2 * sympy.Float(bend) * y[j] * zdot[j] if r == i else q for r, q in enumerate(zdot)]
        return core.PiecewiseSystem(
            name="Drawn", variables=tuple(map(str, y)), f_minus=tuple(rates[-1]), f_plus=tuple(rates[1]),
            g=sum(sympy.Float(float(m)) * v for m, v in zip(n, z, strict=True)), x0=tuple(bent(x0, i, j, bend)),
        )  # fmt: skip

    return system, exact, lambda x: bent(x, i, j, bend)


def bent(x, i, j, bend):
    out = np.array(x, dtype=float)
    out[i] += bend * out[j] ** 2
    return out


def is_clear(exact):
    """Whether every event is far from a tangency, and from the one before it."""
    times = np.array([0.0, *exact.times, END])
    rates = [exact.rates(z) for _, z, *_ in exact.arcs[1:]]
    largest = max((abs(float(r)) for pair in rates for r in pair), default=1.0)
    for (below, above), kind in zip(rates, exact.kinds, strict=True):
        least = max(abs(below), abs(above)) if kind == "leaving" else min(abs(below), abs(above))
        if least < TANGENT * largest:
            return False
    # What grows for long after the last event, unlike what events keep in bounds, magnifies the error without bound.
    states = [z for _, z, *_ in exact.arcs] + [exact.state(END, len(exact.z0))]
    size = max(abs(float(v)) for z in states for v in z)
    return len(times) < 60 and np.diff(times).min() > 0.05 and size < LARGEST


def clear(rng):
    """A drawn case that slides, and of which every event can be told."""
    while True:
        system, exact, place = drawn(rng)
        if "sliding" in exact.kinds and is_clear(exact):
            return system(), exact, place


@pytest.mark.parametrize("method", deep_but(("rk8", "taylor"), METHODS))
def test_runs_slide_where_the_exact_solution_does(method, draws):
    settings, allowed = METHODS[method]
    for rng in draws(2):
        system, exact, place = clear(rng)
        run = core.integrate(system, (0.0, END), method=method, sliding="continue", **settings)
        assert run.status is Status.COMPLETED, run.message
        assert run.crossings.kind.tolist() == exact.kinds
        allowance = 20 * allowed * float(np.abs(run.x).max()) * (1.0 + len(exact.kinds))
        assert np.abs(run.crossings.t - exact.times).max(initial=0.0) < allowance
        for t in (*(0.5 * (exact.times[1:] + exact.times[:-1])), END):
            assert np.abs(run.at(t) - place(exact.state(float(t), system.dimension))).max() < allowance, (t, system)


@pytest.mark.parametrize("above", [True, False])
def test_a_start_where_one_field_is_tangent_and_both_lead_to_the_surface_slides(above, draws):
    """Filippov's speed along y = 0, where the tangent field comes to point to it with the rate −b x."""
    up = "+" if above else "-"  # the fold lies above the surface, or, mirrored, below it
    tangent, pointing = ("s*a", f"-s*b*({up}x)"), ("s*c", f"{up}s*d")
    minus, plus = (pointing, tangent) if above else (tangent, pointing)
    system = core.PiecewiseSystem(
        "Fold", ("x", "y"), f_minus=minus, f_plus=plus, g="y", x0=(0.0, 0.0),
        parameters=dict.fromkeys("abcds", 1.0),
    )  # fmt: skip
    for rng in draws(12):
        a, b, d = rng.uniform(0.3, 2.0, 3).tolist()
        c, sign = float(rng.uniform(-0.2, 2.0)), float(rng.choice([-1.0, 1.0]))
        run = core.integrate(
            system.with_parameters(a=a, b=b, c=c, d=d, s=sign), (0.0, 0.5 * sign), tau=0.005, method="rk4",
            sliding="continue",
        )  # fmt: skip
        case = (a, b, c, d, sign, run.message)
        speed = lambda _, x, a=a, b=b, c=c, d=d: (b * c * x + a * d) / (b * x + d)  # noqa: E731
        wanted = solve_ivp(speed, (0.0, 0.5), [0.0], rtol=1e-11, atol=1e-13)
        assert run.status is Status.COMPLETED, case
        assert (run.mode == 2).all(), case
        assert run.x[-1] == pytest.approx([wanted.y[0, -1], 0.0], abs=1e-7), case
        assert core.integrate(run.system, (0.0, 0.5 * sign), tau=0.02, method="rk4").status is Status.SLIDING


#: Both sides differ in the push towards the surface alone, so that x and y are those of either side; z follows them.
BENT = core.PiecewiseSystem(
    "Bent", ("x", "y", "z"), f_minus=("-r*x + b*x**2", "-u*y", "k"), f_plus=("-r*x + b*x**2", "-u*y", "-k"),
    g="z - q*x**2 - a*x - y - n", x0=(1.0, 1.0, 1.0), parameters=dict.fromkeys("rbukqan", 1.0),
)  # fmt: skip
#: A relay that switches on a line: it slides with v' = -v/lead to (rest, 0), and its field does not depend on x.
LINE = core.PiecewiseSystem(
    "Line", ("x", "v"), f_minus=("v", "1 - c*v"), f_plus=("v", "-1 - c*v"), g="x + lead*v - rest", x0=(4.0, 0.0),
    parameters={"c": 0.05, "lead": 0.15, "rest": 0.0},
)  # fmt: skip
#: e-foldings after which e⁻ʳᵗ is zero in double precision: ln 2¹⁰⁷⁵ = 745.1.
TO_UNDERFLOW = 760.0


def drawn_bend(rng):
    """A curved surface along which x and y decay, to the origin or to (0, 0, n): system, least rate, exact states."""
    r, b, q, a = 10.0 ** rng.uniform(-1.0, 1.5), rng.uniform(-0.5, 0.5), *rng.uniform(-1.0, 1.0, 2)
    u, n = r * 10.0 ** rng.uniform(-1.0, 1.0), rng.choice([0.0, rng.uniform(-2.0, 2.0)])
    values = {"r": r, "b": b * r, "u": u, "k": 10.0 + 9.0 * r + 2.0 * u, "q": q, "a": a, "n": n}
    system = BENT.with_parameters(**{name: float(v) for name, v in values.items()})

    def exact(t, _):
        x, y = np.exp(-r * t) / (1.0 - b + b * np.exp(-r * t)), np.exp(-u * t)
        return np.stack([x, y, q * x * x + a * x + y + n], axis=-1)

    return system, (1.0, 1.0, q + a + 1.0 + n + rng.uniform(0.1, 1.0)), min(r, u), exact


def drawn_line(rng):
    """The relay on a line to the origin or to another place: system, start, rate, and exact states from the first."""
    lead, rest = float(rng.uniform(0.1, 0.6)), float(rng.choice([0.0, rng.uniform(-2.0, 2.0)]))

    def exact(t, first):
        v = first[1] * np.exp(-(t - t[0]) / lead)
        return np.stack([rest - lead * v, v], axis=-1)

    return LINE.with_parameters(lead=lead, rest=rest), (4.0 + rest, 0.0), 1.0 / lead, exact


@pytest.mark.parametrize("drawn_decay", [drawn_bend, drawn_line])
def test_what_decays_along_a_surface_keeps_its_relative_accuracy_down_to_underflow(drawn_decay, draws):
    for rng in draws(15):
        system, start, rate, exact = drawn_decay(rng)
        tau = {"tau": rng.uniform(0.05, 3.0) / rate} if rng.random() < 0.6 else {}
        run = core.integrate(
            system, (0.0, TO_UNDERFLOW / rate), x0=start, method="taylor", tolerance=1e-13, sliding="continue", **tau
        )  # fmt: skip
        case = (system.parameters, tau, run.message)
        assert run.status is Status.COMPLETED, case
        assert "too long" not in run.warning, case
        t, x = (values[run.mode == 2][1:] for values in (run.t, run.x))
        wanted = exact(t, x[0])
        # The error of a step is relative, and adds up over all of them; below 1e-300 underflow loses digits.
        allowed = 100 * 1e-13 * len(t) * np.abs(wanted).max(axis=1) + 1e-300
        assert (np.abs(x - wanted).max(axis=1) <= allowed).all(), case


@pytest.mark.parametrize("method", deep_but(("gauss4",), ("rk2", "rk4", "rk8", "gauss4")))
@pytest.mark.parametrize("drawn_decay", [drawn_bend, drawn_line])
def test_what_decays_along_a_surface_comes_to_rest(method, drawn_decay, draws):
    """Methods that do not keep g leave the surface by their error, 1e-2 at most here, and rest beside it."""
    for rng in draws(6):
        system, start, rate, exact = drawn_decay(rng)
        tau = 0.1 / max(rate, float(system.parameter_array[:3].max()) if drawn_decay is drawn_bend else rate)
        run = core.integrate(
            system, (0.0, TO_UNDERFLOW / rate), x0=start, tau=tau, method=method, sliding="continue", max_steps=10**6
        )  # fmt: skip
        assert run.status is Status.COMPLETED, (system.parameters, run.message)
        assert "too long" not in run.warning, (system.parameters, run.message)
        slid = run.mode == 2
        assert np.abs(run.x[-1] - exact(run.t[slid][1:], run.x[slid][1])[-1]).max() < 1e-2, system.parameters


def _resting(rng):
    """Fields that push to a curve from both sides, and along it to a rest; and the place of that."""
    a, b = rng.uniform(0.5, 1.5, 2)
    bend, p, q = rng.uniform(-1.0, 1.0), *rng.uniform(-0.4, 0.4, 2)
    values = {"a": a, "b": b, "c": bend, "p": p, "q": q}
    rest = (b * p + a * q) / (a + b)
    system = core.PiecewiseSystem(
        "resting", ("x", "y"), ("a", "p - y"), ("-b", "q - y"), "x + c*y**2", parameters=values, x0=(-0.5, 0.3)
    )
    return system, (-bend * rest**2, rest)


@pytest.mark.parametrize("method", deep_but(("rk4", "taylor"), ("rk2", "rk4", "rk8", "gauss4", "taylor")))
def test_a_slide_along_a_curve_comes_to_rest_and_stays_there(draws, method):
    for rng in draws(12):
        system, rest = _resting(rng)
        step = {} if method == "taylor" else {"tau": float(rng.uniform(0.005, 0.03))}
        run = core.integrate(system, (0.0, 60.0), method=method, sliding="continue", **step)
        about = f"{system.values}, {step}: {run.message}"
        assert run.status is Status.COMPLETED, about
        assert silent(run), about
        assert run.x[-1] == pytest.approx(rest, abs=1e-4), about  # g drifts by the error of the method


def test_a_slide_to_a_rest_near_the_origin_takes_few_steps_of_taylor(draws):
    """There x is a small part of y² and its rate the difference of two of size 1: their rounding must not move y.

    A step is as long as the motion allows, and none is made again: 15 at most but for the last digits of a tiny rest.
    """
    for rng in draws(60):
        system, _ = _resting(rng)
        values = {name: value * 10.0 ** rng.uniform(-4, 0) for name, value in system.values.items() if name in "cpq"}
        system = system.with_parameters(**values)
        run = core.integrate(system, (0.0, 60.0), method="taylor", sliding="continue")
        a, b, c, p, q = (system.values[name] for name in "abcpq")
        rest = (b * p + a * q) / (a + b)
        assert run.status is Status.COMPLETED, f"{system.values}: {run.message}"
        assert silent(run), f"{system.values}: {run.message}"
        assert run.steps < 1000, system.values
        assert run.x[-1] == pytest.approx([-c * rest**2, rest], abs=1e-12), system.values


@pytest.mark.parametrize("method", METHODS)
def test_the_end_of_a_slide_on_a_moving_surface_is_exact_and_no_slow_crossing(method):
    # x' = ±1 holds the state at x = t² until the surface is as fast: from t = 1/2 on x = t - 1/4, and y = t/2 to there.
    system = core.PiecewiseSystem("leaving", ("x", "y"), ("1", "0"), ("-1", "1"), "x - t**2", x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 2.0), method=method, sliding="continue", **METHODS[method][0])
    assert run.x[-1] == pytest.approx([1.75, 0.125], abs=1e-9)
    assert silent(run), run.message


def drawn_beside(rng):
    """A slide along a wave in time, of which y is moved by both fields in turn: texts, start, and the exact y."""
    turn, fall, rise, r_minus, r_plus, q1, q2 = rng.uniform(
        (0.6, 0.5, 0.5, -3, -3, -1, -1), (1.5, 2, 2, 3, 3, 1, 1)
    ).tolist()
    met = float(rng.uniform(0.1, 0.4))
    f_minus = (f"{q1!r} + {q2!r}*cos(t) + {rise!r}*({turn!r} - t)", f"{r_minus!r}*k")
    f_plus = (f"{q1!r} + {q2!r}*cos(t) - {fall!r}", f"{r_plus!r}*k")

    def slide(t):
        h_minus, h_plus = rise * (turn - t), -fall
        return (h_minus * r_plus - h_plus * r_minus) / (h_minus - h_plus)

    y = r_plus * met + float(mp.quad(slide, [met, turn])) + r_minus * (2.0 - turn)
    g = f"x - {q1!r}*t - {q2!r}*sin(t)"
    return f_minus, f_plus, g, (fall * met, 0.0), y


@pytest.mark.parametrize(
    ("method", "most"),
    deep_but(("rk4",), [("rk2", 1e-2), ("rk4", 1e-6), ("gauss4", 1e-6), ("rk8", 1e-9), ("taylor", 1e-11)]),
)
def test_where_sliding_on_a_moving_surface_ends_variables_of_any_size_are_not_moved(draws, method, most):
    for rng in draws(6):
        f_minus, f_plus, g, x0, exact = drawn_beside(rng)
        system = core.PiecewiseSystem("beside", ("x", "y"), f_minus, f_plus, g, parameters={"k": 1.0}, x0=x0)
        for k in (1.0, float(10 ** rng.uniform(-6, 2))):
            run = core.integrate(system.with_parameters(k=k), (0, 2), method=method, tau=0.02, sliding="continue")
            assert [str(kind) for kind in run.crossings.kind] == ["sliding", "leaving"], (run.message, k)
            assert abs(run.x[-1, 1] / k - exact) < most, (k, run.x[-1, 1] / k - exact, system.law_arguments())


#: A closed surface that moves, and values of its parameters at which a slide leads to where both rates of g vanish.
FOLDS = {
    "a": 0.2545081979917142, "w": 1.6897671292173195, "q": 0.9815102090964463, "R": 1.312754673525622,
    "p1": 1.240641549095546, "p2": -1.3957584843036597, "h": 0.49517526552511937, "n": 0.04646537395526229,
    "s": 0.35853317416936376, "r": 1.2563980830970212, "m": -0.6843598866131448,
}  # fmt: skip


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_a_slide_to_where_both_rates_vanish_ends_on_the_surface(draws, method):
    """The field of sliding is 0/0 there, so that a step beyond leads anywhere: up to g = 193 in two of five draws."""
    system = core.PiecewiseSystem(
        "Folds", ("x", "y"), ("p1 + h*y", "p2 - h*x + n*x**2"), ("r*y - s*x", "m*sin(t) - s*y - r*x"),
        "(x - a*cos(w*t))**2 + q*y**2 - R**2", parameters=FOLDS, x0=(1.5743427354475386, 0.09281470919879942),
    )  # fmt: skip
    ended = 0
    for rng in draws(45):
        drawn = system.with_parameters(**{name: value * rng.uniform(0.98, 1.02) for name, value in FOLDS.items()})
        tau = float(rng.choice([0.001, 0.01, 0.02, 0.05]))
        run = core.integrate(drawn, (0.0, 10.0), method=method, tau=tau, sliding="continue")
        slid = np.flatnonzero(run.sliding)
        g = np.array([drawn.switching(t, x) for t, x in zip(run.t[slid], run.x[slid], strict=True)])
        assert np.abs(g).max(initial=0.0) < 0.05, (drawn.values, tau, run.message)
        ended += run.status is Status.GRAZING and "both fields turn at once" in run.message
    assert ended, "some draws lead there"
