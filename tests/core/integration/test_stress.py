"""Random systems, steps, scales and starts: a run keeps what it claims, or says truthfully why it stopped."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import core
from core import Status
from tests.core.polynomials import CONIC, FULL, SEPARABLE, Case, terms
from tests.levels import QUICK_METHODS, deep_but, tries

EPS = 2.0**-52
METHODS = list(core.METHODS)
any_of = pytest.mark.parametrize(
    "methods", [QUICK_METHODS, pytest.param(METHODS, marks=pytest.mark.deep)], ids=["one of each kind", "all"]
)
#: Dense polynomials take long to compile: one implicit, one explicit and one variable-step method stand for their kind.
OF_FULL = ("dmm2", "rk4", "taylor")
SEVERAL = settings(tries(150), suppress_health_check=list(HealthCheck))

number = st.floats(-2.0, 2.0, allow_nan=False).map(lambda a: round(a, 3))


def scaled(case: Case, length: float, time: float, height: float) -> Case:
    """The same case in other units: of x, of t, and of g."""
    hamiltonian = [
        tuple(a * length**2 / length ** (i + j) / time for a, (i, j) in zip(c, case.powers, strict=True))
        for c in (case.minus, case.plus)
    ]
    conic = tuple(a * height / length ** (i + j) for a, (i, j) in zip(case.conic, CONIC, strict=True))
    x0 = (case.x0[0] * length, case.x0[1] * length)
    return Case(case.powers, *hamiltonian, conic, x0, case.t_end * time, case.tau * time)


def stiffness(case, x):
    """Tau times the sum of the sizes of the second derivatives of H, at its largest over states (n, 2)."""
    x = np.abs(x)
    total = 0.0
    for coefficients in (case.minus, case.plus):
        for a, (i, j) in zip(coefficients, case.powers, strict=True):
            for p, q in ((2, 0), (1, 1), (0, 2)):
                factor = math.perm(i, p) * math.perm(j, q)
                if factor:
                    total = total + abs(a) * factor * x[:, 0] ** (i - p) * x[:, 1] ** (j - q)
    return case.tau * float(np.max(total))


def lifted(case: Case, delta: float, tangent: bool) -> Case:
    """The surface moved so that g(x0) = delta, and turned so that it is tangent to the motion of the minus side."""
    conic = list(case.conic)
    if tangent:
        slopes = [float(terms(CONIC, case.conic, case.x0, *d).sum()) for d in ((1, 0), (0, 1))]
        wanted = [float(terms(case.powers, case.minus, case.x0, *d).sum()) for d in ((1, 0), (0, 1))]
        conic[1] += wanted[0] - slopes[0]
        conic[2] += wanted[1] - slopes[1]
    conic[0] += delta - float(terms(CONIC, conic, case.x0).sum())
    return replace(case, conic=tuple(conic))


@st.composite
def cases(draw, powers=SEPARABLE, least=-4.0, most=1.0, resolved=False):
    """Coefficients of either side, a line or a conic, a start anywhere, on the surface or tangent to it.

    Step sizes spread over powers of ten; of the time of the motion at the start, if it is to be resolved.
    """
    coefficients = st.tuples(*[number] * len(powers))
    minus = draw(coefficients)
    plus = draw(st.just(minus) | coefficients)
    curved = draw(st.booleans())
    conic = tuple(draw(number) if curved or k < 3 else 0.0 for k in range(len(CONIC)))
    tau = 10.0 ** draw(st.floats(least, most))
    t_end = tau * draw(st.integers(1, 300)) * draw(st.sampled_from([1.0, -1.0, 0.37]))
    case = Case(powers, minus, plus, conic, draw(st.tuples(number, number)), t_end, tau)
    if resolved:
        rate = max(1e-3, stiffness(case, np.array([case.x0]))) / tau
        case = replace(case, tau=tau / rate, t_end=t_end / rate)
    how = draw(st.sampled_from(["anywhere", "surface", "tangent"]))
    if how != "anywhere":
        delta = draw(st.sampled_from([0.0, *(s * 10.0**-k for s in (1, -1) for k in (1, 4, 8, 12, 15, 16))]))
        case = lifted(case, delta, how == "tangent")
    return case


def try_run(case, method):
    """A run, bounded; None where the start is refused at the door."""
    try:
        return case.run(method, max_steps=1000, max_crossings=5000)
    except ValueError:
        return None


def check_finite_and_ordered(case, run):
    crossings = run.crossings
    for values in (run.t, run.x, crossings.t, crossings.x, crossings.x_after, crossings.surface, crossings.g):
        assert np.isfinite(values).all()
    direction = math.copysign(1.0, case.t_end)
    assert (direction * np.diff(run.t) >= 0.0).all()
    assert (direction * np.diff(crossings.t) >= 0.0).all()
    within = direction * crossings.t
    assert ((within >= 0.0) & (within <= abs(case.t_end))).all()
    assert run.status is not Status.COMPLETED or run.t[-1] == case.t_end
    sides = [run.side[0], *crossings.side[crossings.side != 0]]
    assert (np.diff(sides) != 0).all()


def check_places(case, run):
    """Rows lie on their side, crossings on the surface, but for round-off.

    That is 64 eps of the largest of six terms of g, each with three roundings, and the state's own. A start counts as
    on the surface if g is there below 16 bounds on its rounding, which are those of 42 roundings.
    """
    height, largest = case.height(np.array(case.x0))
    bound = 64 * EPS if abs(height) > 16 * 42 * EPS * largest else 16 * 42 * EPS
    height, largest = case.height(run.x)
    assert (run.side * height >= -bound * largest).all()
    if len(run.crossings):
        height, largest = case.height(run.crossings.x)
        speed = np.maximum(*(np.abs(case.rate(side, run.crossings.x)[0]) for side in (-1, 1)))
        # A time that is rounded moves the state by as much as the motion in that time.
        assert (np.abs(height) <= bound * (largest + speed * np.abs(run.crossings.t))).all()


def check_kept(case, run, bound):
    """H stays at its level within each visit of a side, to so many eps of its largest term at either end of a step.

    A coordinate that has become 0 is so to eps² of the others: the states are pairs of numbers.
    """
    for side in (-1, 1):
        rows = run.side == side
        now, largest = case.hamiltonian(side, run.x[rows])
        entered, at_entry = case.hamiltonian(side, run.entered_x[run.segment[rows]])
        before = np.concatenate([largest[:1], largest[:-1]])  # of which a long step from there has a rounding left
        corner = np.abs(run.x[rows]).max(axis=1, keepdims=True, initial=0.0) * np.ones(2)
        scale = np.maximum.reduce([largest, before, at_entry, EPS * case.hamiltonian(side, corner)[1]])
        assert (np.abs(now - entered) <= bound * EPS * scale).all()


def check_truthful(case, run):
    """Both fields do point to the surface where it is said to attract, and away where it is said to repel."""
    if run.status in (Status.SLIDING, Status.REPELLING):
        sign = math.copysign(1.0, case.t_end) * (1 if run.status is Status.SLIDING else -1)
        for side in (-1, 1):
            rate, size = case.rate(side, run.x[-1])
            assert -side * sign * rate >= -64 * EPS * size


def check_every_claim(case, method):
    """What holds of a run whose steps resolve the motion."""
    run = try_run(case, method)
    if run is None or stiffness(case, run.x) > 1.0:
        return
    check_finite_and_ordered(case, run)
    check_places(case, run)
    check_truthful(case, run)
    if core.METHODS[method].conservative:
        check_kept(case, run, 64)


@any_of
@SEVERAL
@given(case=cases(), draw=st.data())
def test_any_run_is_finite_and_ordered_and_keeps_psi_if_it_completes_whatever_its_steps(methods, case, draw):
    method = draw.draw(st.sampled_from(methods))
    run = try_run(case, method)
    if run is None:
        return
    check_finite_and_ordered(case, run)
    assert run.status is not Status.RUNNING
    if core.METHODS[method].conservative and run.status is Status.COMPLETED:
        # Long steps multiply a rounding by the ratio of the gradients at their ends: measured, up to 346 eps.
        check_kept(case, run, 1024)


@any_of
@SEVERAL
@given(case=cases(most=-0.5, resolved=True), draw=st.data())
def test_a_run_that_resolves_the_motion_keeps_every_claim(methods, case, draw):
    check_every_claim(case, draw.draw(st.sampled_from(methods)))


@pytest.mark.deep
@settings(SEVERAL, max_examples=100)
@given(case=cases(FULL, most=-0.5, resolved=True), method=st.sampled_from(OF_FULL))
def test_dense_hamiltonians_keep_every_claim(case, method):
    check_every_claim(case, method)


#: Powers of two, which round nothing. To 1e±60: the fourth power of a state, in double-double, is a number.
UNITS = ((200, 0, 0), (-200, 0, 0), (0, 200, 0), (0, -200, 0), (0, 0, 100), (0, 0, -100), (130, -170, 90))


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, METHODS))
@settings(SEVERAL, max_examples=15)
@given(case=cases(least=-2.0, most=-1.0, resolved=True))
def test_units_of_length_time_and_surface_make_no_difference(method, case):
    run = try_run(case, method)
    if run is None:
        return
    for powers in UNITS:
        length, time, height = (2.0**k for k in powers)
        other = try_run(scaled(case, length, time, height), method)
        assert other is not None
        assert other.status is run.status
        assert np.array_equal(other.crossings.side, run.crossings.side)
        if not core.METHODS[method].adaptive:
            assert np.array_equal(other.x / length, run.x)
            assert np.array_equal(other.t / time, run.t)
        elif run.status is Status.COMPLETED:  # the logarithms by which it chooses its steps do round
            assert np.abs(other.x[-1] / length - run.x[-1]).max() <= 1e-9 * np.abs(run.x).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("distance", [0.0, 1e-16, 1e-12, 1e-8, 1e-4])
@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0, 0.0)], ids=["saddle", "centre"])
def test_starts_near_an_equilibrium_complete(method, distance, place):
    case = Case(SEPARABLE, *[(0.5, 0.0, -0.5, 0.0, 0.25)] * 2, (-9.0, 1.0, 0.0, 0.0, 0.0, 0.0),
                (place[0] + distance, distance / 3), 30.0, 0.05)  # fmt: skip
    run = case.run(method)
    assert run.status is Status.COMPLETED
    if core.METHODS[method].conservative:
        # Long steps of the variable method take it e³ times as far from the saddle: 13 eps by the median, 32 at most.
        check_kept(case, run, 64 if core.METHODS[method].adaptive else 16)


def test_a_motion_of_a_few_ulps_a_step_far_from_the_surface_is_no_failure():
    # Rates that are round-off change sign between any two looks: that is no sign of a dip.
    case = Case(
        SEPARABLE,
        (1.3742629533908246, 0.6059514183291346, -1.1995756916419236, -1.3411173078807936, 0.15970534307367285),
        (1.3742629533908246, 0.6059514183291346, -1.1995756916419236, -1.3411173078807936, 0.15970534307367285),
        (0.13122269006495163, 0.37977885975123876, 0.5946816814615442, 0.0, 0.0, 0.0),
        (-0.7220903427746013, -2.7557290370728174e-14), 3.6352886082158262, 0.011151192049741798,
    )  # fmt: skip
    assert case.run("rk4").status is Status.COMPLETED


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed", [1e-16, 1e-15, 1e-14, 1e-12])
def test_a_start_on_the_surface_and_tangent_to_it_never_walks_through(method, speed):
    # x = 1 + (v² − v0²)/2: it leaves g = 1 − x upwards by v0²/2 < eps, and is back.
    law = ("y", "1")
    system = core.PiecewiseSystem("tangent", ("x", "y"), law, law, "1 - x", ("y**2/2 - x",), ("y**2/2 - x",))
    run = core.integrate(system, (0.0, 1.0), (1.0, -speed), None if method == "taylor" else 0.01, method)
    assert run.status in (Status.GRAZING, Status.COMPLETED)
    assert (np.diff(run.t) > 0.0).all()
    assert (run.side * (1.0 - run.x[:, 0]) >= -4 * EPS).all()


# Against others ------------------------------------------------------------------------------------------------------


def peer(case):
    """End state and number of crossings by SciPy's DOP853, restarted at each: steps so short that none has two."""
    t, x, crossings = 0.0, np.array(case.x0), 0
    side = 1 if float(case.height(x)[0]) > 0 else -1
    while t < case.t_end:

        def event(_, x, side=side):
            return side * float(case.height(x)[0])

        def field(_, x, side=side):
            dx, dy = (float(terms(case.powers, case.of(side), x, *d).sum()) for d in ((1, 0), (0, 1)))
            return dy, -dx

        event.terminal, event.direction = True, -1.0
        part = solve_ivp(field, (t, case.t_end), x, "DOP853", events=event, rtol=1e-12, atol=1e-13, max_step=0.05)
        t, x = part.t[-1], part.y[:, -1]
        if part.status == 1:
            side, crossings = -side, crossings + 1
    return x, crossings


@pytest.mark.parametrize("seed", range(12))
def test_taylor_agrees_with_scipy_restarted_at_every_crossing(seed):
    # Confining, and of one sign of ġ on the line: f = (y, ·) and g = x + c in common, so that all crossings are
    # transversal but for y = 0.
    rng = np.random.default_rng(seed)
    minus, plus = ((0.5, *rng.normal(size=3), 0.5 + rng.random()) for _ in range(2))
    conic = (0.3 * rng.normal(), 1.0, 0.0, 0.0, 0.0, 0.0)
    case = Case(SEPARABLE, minus, plus, conic, (float(rng.normal()), 1.0 + rng.random()), 4.0, 0.1)
    run = case.run("taylor", tolerance=1e-12)
    x, crossings = peer(case)
    assert run.status is Status.COMPLETED
    assert len(run.crossings) == crossings
    # Tolerances of 1e-12 a step, some hundred of them, on motion that parts no faster than exp(4).
    assert np.abs(run.x[-1] - x).max() < 1e-8


# Long runs -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "psi", "x0", "bound"),
    [
        (("y", "-x"), "(x**2 + y**2)/2", (1.0, 0.5), 8),
        (("2*y", "3*x**2 - 2"), "y**2 - x**3 + 2*x", (-1.0, 0.3), 64),
    ],
    ids=["oscillator", "elliptic"],
)
def test_a_million_steps_of_dmm2_and_back_return_to_round_off(law, psi, x0, bound):
    # Symmetric steps undo each other but for their roundings, which compensated sums keep: measured 1.25 and 28 eps.
    system = core.PiecewiseSystem("long", ("x", "y"), law, law, "x - 50", (psi,), (psi,))
    on = core.integrate(system, (0.0, 1e4), x0, 0.01, record="end")
    back = core.integrate(system, (1e4, 0.0), on.x[-1], 0.01, record="end")
    assert (on.steps, back.steps) == (10**6, 10**6)
    assert np.abs(back.x[-1] - x0).max() <= bound * EPS
