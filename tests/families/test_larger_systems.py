"""Larger systems, drawn at random: right, and ψ kept to round-off, whatever their dimension."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import core
from tests.families.larger_systems import FAMILIES
from tests.levels import deep_but

EPS = np.finfo(float).eps
#: Dimensions that a family has, up to 8.
DIMENSIONS = {
    "bodies": (8,),
    "springs": (2, 6, 8),
    "dense": (2, 3, 5, 8),
    "vortices": (4, 6, 8),
    "lotka_volterra": (2, 5, 7),
}
END = 1.0
METHODS = {"prk8": {"tau": 0.01}, "taylor": {"tolerance": 1e-14}}


def smooth(system):
    """The system with the field of its minus side on both, so that SciPy can follow it, too."""
    return core.PiecewiseSystem(
        name=system.name, variables=system.variables, f_minus=system.f_minus, f_plus=system.f_minus, g=system.g,
        psi_minus=system.psi_minus, psi_plus=system.psi_minus,
        parameters=dict(system.values), x0=system.x0,
    )  # fmt: skip


def drawn(rng, family):
    d = int(rng.choice(DIMENSIONS[family]))
    return smooth(FAMILIES[family](rng, d))


def described(system, method):
    return f"{method}: {system.name}, f = {system.f_minus}, psi = {system.psi_minus}, g = {system.g}, x0 = {system.x0}"


def kept(run, system):
    """Whether ψ is held to a few roundings of its terms: no more than d² of them, of size 10, in the state squared."""
    terms = 10.0 * system.dimension * max(1.0, np.abs(run.x).max()) ** 2
    return bool(np.nanmax(np.abs(run.conserved_error())) <= 4 * EPS * terms)


def followed(system):
    """SciPy's solution."""
    return solve_ivp(
        lambda t, x: system.field(-1, t, x), (0.0, END), system.x0, method="DOP853", rtol=1e-13, atol=1e-13
    )  # fmt: skip


def crossing_springs(rng):
    """Springs whose solution, by SciPy, clearly leaves the side where it starts before t = 6."""
    while True:
        system = FAMILIES["springs"](rng, 2 * int(rng.integers(3, 6)))
        side = 1 if system.x0[0] > 0.1 else -1
        field = partial(system.field, side)
        if (side * (solve_ivp(field, (0.0, 6.0), system.x0, max_step=0.1).y[0] - 0.1)).min() < -0.05:
            return system


@pytest.mark.parametrize("family", deep_but(["springs", "lotka_volterra"], FAMILIES))
def test_runs_agree_with_scipy_and_keep_every_psi(family, draws):
    for rng in draws(1):
        system = drawn(rng, family)
        peer = followed(system)
        exact, size = peer.y[:, -1], np.abs(peer.y).max()
        for method, settings in METHODS.items():
            run = core.integrate(system, (0.0, END), method=method, record="steps", **settings)
            assert run.status is core.Status.COMPLETED, described(system, method)
            # DOP853's own error at its finest tolerance, some hundred steps of it.
            assert np.abs(run.x[-1] - exact).max() <= 1e-10 * size, described(system, method)
            assert kept(run, system), described(system, method)
        runs = [core.integrate(system, (0.0, END), tau=tau) for tau in (0.02, 0.01)]
        coarse, fine = (np.abs(run.x[-1] - exact).max() for run in runs)
        assert 3.0 <= coarse / fine <= 5.0, described(system, "dmm2")  # order 2
        assert kept(runs[1], system), described(system, "dmm2")


@pytest.mark.deep
@pytest.mark.parametrize("method", ["dmm8", "prk8"])
def test_a_long_linear_field_has_the_flow_of_its_matrix_exponential(method, draws):
    """Of fourteen variables: Newton's matrix is in an array, and the field a function of its own."""
    for rng in draws(1):
        system = smooth(FAMILIES["dense"](rng, 14))
        matrix = np.transpose([system.field(-1, 0.0, e) for e in np.eye(14)])
        run = core.integrate(system, (0.0, END), method=method, tau=0.02)
        assert run.status is core.Status.COMPLETED, described(system, method)
        exact = expm(END * matrix) @ np.array(system.x0)
        assert np.abs(run.x[-1] - exact).max() <= 1e-10 * np.abs(run.x).max(), described(system, method)
        assert kept(run, system), described(system, method)


@pytest.mark.parametrize("method", deep_but(["dmm2"], ["dmm2", "taylor"]))
def test_psi_is_kept_on_both_sides_of_a_surface(method, draws):
    for rng in draws(1):
        system = crossing_springs(rng)
        settings = {} if method == "taylor" else {"tau": 0.02}
        run = core.integrate(system, (0.0, 6.0), method=method, **settings)
        assert run.status is core.Status.COMPLETED, described(system, method)
        assert run.crossing_count >= 1, described(system, method)
        assert kept(run, system), described(system, method)


@pytest.mark.parametrize("method", ["dmm2", "prk8", "taylor"])
def test_gradients_that_become_dependent_cost_no_accuracy(method, draws):
    """Oscillators in the plane: on a circle energy and angular momentum have parallel gradients, at rest none."""
    x, y, u, v = (("x1", "x2"), ("y1", "y2"), ("u1", "u2"), ("v1", "v2"))
    names = (*x, *y, *u, *v)
    field = (*u, *v, *(f"-k{i}**2*{a}{i}" for a in "xy" for i in (1, 2)))
    psi = tuple(
        e for i in (1, 2) for e in (f"k{i}**2*(x{i}**2 + y{i}**2) + u{i}**2 + v{i}**2", f"x{i}*v{i} - y{i}*u{i}")
    )
    for rng in draws(3):
        k, angle, radius = rng.integers(2, 6, 2) / 4, rng.uniform(0, 2 * np.pi, 2), rng.uniform(0.5, 1.5, 2)
        if rng.random() < 0.3:
            radius[0] = rng.choice([0.0, 1e-9, 1e-5])
        place = radius * np.exp(1j * angle)
        speed = 1j * k * place * (1.0 if rng.random() < 0.7 else 0.5)
        x0 = tuple(map(float, (*place.real, *place.imag, *speed.real, *speed.imag)))
        system = core.PiecewiseSystem(
            "oscillators in the plane", names, field, field, "x1 - 5", psi, psi,
            {"k1": float(k[0]), "k2": float(k[1])}, x0,
        )  # fmt: skip
        settings = {} if method == "taylor" else {"tau": 0.01}
        run = core.integrate(system, (0.0, 2.0), method=method, **settings)
        assert run.status is core.Status.COMPLETED, described(system, method)
        # 24 eps of ψ a step at most where a multiplier has been left alone, as in `test_stepcode`.
        assert np.nanmax(np.abs(run.conserved_error())) <= 24 * EPS * 4 * 4.5, described(system, method)
        exact = place * np.cos(2.0 * k) + speed / k * np.sin(2.0 * k)
        # Of dmm2: h² k³ T / 12 of the radius, and half as much again.
        error = 0.01**2 * k.max() ** 3 * 2.0 / 12 * 1.5 * 1.5 if method == "dmm2" else 1e-11
        assert np.abs(run.x[-1][:4] - [*exact.real, *exact.imag]).max() <= error, described(system, method)


@pytest.mark.parametrize("method", ["dmm2", "dmm4", "prk8", "taylor"])
def test_circular_orbits_keep_energy_and_angular_momentum(method, draws):
    """On a circle their gradients are parallel: both ψ are kept by keeping one, and cannot be kept apart."""
    kepler = core.CATALOGUE["kepler"]
    system = core.PiecewiseSystem(
        "circular orbits", kepler.variables, kepler.f_minus, kepler.f_minus, "x - 9", kepler.psi_minus,
        kepler.psi_minus, {"mu_minus": 1.0}, (1.0, 0.0, 0.0, 1.0),
    )  # fmt: skip
    for rng in draws(5):
        angle, radius, tau = rng.uniform(0.0, 2 * np.pi), rng.uniform(0.6, 2.0), float(10 ** rng.uniform(-4, -1.5))
        speed = radius**-0.5 * (1.0 + rng.choice([0.0, 1e-10, 1e-7, 1e-4]))
        x0 = (radius * np.cos(angle), radius * np.sin(angle), -speed * np.sin(angle), speed * np.cos(angle))
        settings = {} if method == "taylor" else {"tau": tau}
        run = core.integrate(system, (0.0, 500 * tau), tuple(map(float, x0)), method=method, **settings)
        told = f"{method}, tau = {tau}, x0 = {x0}: {run.message}"
        assert run.status is core.Status.COMPLETED, told
        # Beside a circle a step may leave 64 eps of ψ, until it is given back; dmm4 is composed of five.
        left = 64 * EPS * (5 if method == "dmm4" else 1)
        assert np.nanmax(np.abs(run.conserved_error())) <= 4 * left * max(1.0, radius), told
        rate = radius**-1.5
        error = {"dmm2": (rate * tau) ** 2 / 4, "dmm4": (rate * tau) ** 4}.get(method, 0.0) * rate * 500 * tau
        apart = np.abs(np.hypot(*run.x[-1][:2]) / radius - 1.0)
        assert apart <= 1e-6 + 4 * error + 5 * abs(speed * radius**0.5 - 1.0), told
