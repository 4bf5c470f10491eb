"""The largest |Δψ| that the loop over members finds is that along the trajectory of `integrate`, to the last bit."""

import numpy as np
import pytest

import core
from core.integrate import checked_settings
from core.integration.members import Members, Wanted, integrate_members
from core.interface.tasks import GivenUp

SYSTEMS = (
    "elliptic_curve", "damped_oscillator", "bouncing_ball", "relay_feedback", "stick_slip", "chua", "kepler",
    "two_walls", "thermostat", "rigid_body",
)  # fmt: skip
SETTINGS = (
    {},
    {"sliding": "continue"},
    {"transition": "none"},
    {"perturbation_order": 1},
    {"max_crossings": 3},
    {"max_steps": 700},  # more than the loop records in one call
)
TAUS = (0.01, 0.1, 0.7)


def members(system, method, x0, t_end, **settings):
    each = [checked_settings(method, tau, **settings) for tau in TAUS for _ in x0]
    x, p = np.tile(x0, (len(TAUS), 1)), np.empty((len(each), len(system.parameters)))
    p[:] = system.parameter_array
    return Members.of(system, method, each[0], each, (0.0, t_end), x, p, Wanted(psi=1), GivenUp())


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", ["rk2", "prk8"])
def test_it_is_that_along_the_run(name, method):
    system, chosen = core.CATALOGUE[name], core.METHODS[method]
    if not system.laws.most_conserved and method == "prk8":
        pytest.skip("it has no ψ to keep")
    x0 = np.array(system.x0) + np.random.default_rng(0).uniform(-0.3, 0.3, (3, system.dimension))
    for settings in SETTINGS:
        settings = {"max_crossings": 300, **settings}
        block = integrate_members(members(system, chosen, x0, 9.0, **settings))
        for k, (tau, start) in enumerate((tau, start) for tau in TAUS for start in x0):
            run = core.integrate(system, (0.0, 9.0), start, tau, method, **settings)
            largest = np.fmax.reduce(run.change_of_psi()[~run.sliding], initial=np.nan)
            assert np.array_equal(block.ends["change_of_psi"][k], largest, equal_nan=True), (settings, tau, start)
            assert block.ends["status"][k] == run.status
            assert block.ends["first_mode"][k] == run.mode[0]


def test_a_run_that_goes_on_from_a_corner_counts_to_its_end():
    law = core.Region(f=("1", "1"), psi=("x - y",))
    system = core.PiecewiseSystem(
        "Corner", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
        regions={**dict.fromkeys(("--", "-+", "+-"), law), "++": core.Region(f=("1", "x"), psi=("x**2/2 - y",))},
    )  # fmt: skip
    block = integrate_members(members(system, core.METHODS["rk2"], np.array([system.x0]), 3.0))
    for k, tau in enumerate(TAUS):
        run = core.integrate(system, (0.0, 3.0), tau=tau, method="rk2")
        assert run.crossings.kind.tolist() == ["corner"]
        assert block.ends["change_of_psi"][k] == run.change_of_psi().max()
