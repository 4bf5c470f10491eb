"""The catalogue as a whole: every system runs as it is given, and at the ends of its parameters' bounds."""

import pickle

import numpy as np
import pytest
import sympy

import core
from core import Status
from tests.levels import QUICK_METHODS, deep_but

EPS = np.finfo(float).eps
NAMES = list(core.CATALOGUE)
ENDINGS = {
    "coulomb_friction": Status.SLIDING, "bouncing_ball": Status.ZENO, "relay_feedback": Status.SLIDING,
    "stick_slip": Status.SLIDING, "type_sliding": Status.SLIDING,
}  # fmt: skip
#: Least |rate| at the first 30 crossings; where a run ends sliding or its bounces die, its speeds have to fall.
LEAST_RATE = {"damped_oscillator": 0.05, "coulomb_friction": 0.1, "relay_feedback": 0.1, "type_upward": 0.04,
              "type_downward": 0.04, "type_sliding": 0.04}  # fmt: skip
BOUNCING = [name for name in NAMES if core.CATALOGUE[name].laws.jumps]
ONE_WAY = {"thermostat"}  # the field after a switch points back to where it took place


def method_for(system):
    return "dmm2" if system.laws.most_conserved else "rk4"


@pytest.fixture(scope="module")
def runs():
    """The default run of every system."""
    return {
        name: core.integrate(system, (0.0, 50.0), tau=1e-2, method=method_for(system))
        for name, system in core.CATALOGUE.items()
    }


def test_systems_stand_in_display_order():
    assert NAMES == [
        "harmonic_oscillator", "elliptic_curve", "pendulum", "predator_prey", "rigid_body", "kepler", "henon_heiles",
        "three_bodies", "damped_oscillator", "coulomb_friction", "stick_slip", "bouncing_ball", "vibrating_table",
        "diode_circuit", "relay_feedback", "gene_switch", "type_upward", "type_downward", "type_repelling",
        "type_sliding", "moving_interface", "chua", "two_walls", "thermostat", "gene_ring", "diode_bridge",
    ]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_default_run_ends_as_the_system_is_meant_to(runs, name):
    run = runs[name]
    assert run.status is ENDINGS.get(name, Status.COMPLETED)
    assert np.isfinite(run.x).all()
    turning = [k for k, x in enumerate(core.CATALOGUE[name].variables) if x == "phi"]  # counts whole turns
    assert np.abs(np.delete(run.x, turning, axis=1)).max() < 10  # it stays in sight
    assert len(run.crossings) > 0 or name == "type_repelling"


@pytest.mark.parametrize("name", [name for name in NAMES if name not in BOUNCING])
def test_the_first_thirty_crossings_are_transversal(runs, name):
    crossings = runs[name].crossings.first(30)
    passed = crossings.mode >= 0
    before, after = crossings.rate_before, crossings.rate_after
    assert (before[passed] * after[passed] > 0).all() or name in ONE_WAY
    assert (before[~passed] * after[~passed] < 0).all()  # where it ends sliding
    assert set(crossings.kind[passed]) <= {"transversal"}
    assert np.minimum(np.abs(before), np.abs(after)).min(initial=np.inf) > LEAST_RATE.get(name, 0.25)


@pytest.mark.parametrize("name", [name for name, system in core.CATALOGUE.items() if system.laws.most_conserved])
def test_dmm2_keeps_psi_to_round_off(runs, name):
    # Evaluating psi rounds by some eps of its largest term; so does each landing, and the compensated sum once.
    run = runs[name]
    error = np.abs(run.conserved_error())
    for number, mode in enumerate(run.system.laws.regions):
        rows = run.mode == number
        for k, psi in enumerate(mode.conserved if rows.any() else ()):
            terms = sympy.Add.make_args(sympy.expand(psi))
            values = run.system.laws.evaluate(
                ("terms", number, k), terms, run.t[rows], run.x[rows], run.system.parameter_array
            )
            assert error[rows, k].max() <= 16 * EPS * np.abs(values).max()


@pytest.mark.parametrize("name", NAMES)
def test_a_system_runs_at_both_ends_of_every_parameter(name):
    system = core.CATALOGUE[name]
    for parameter in system.parameters:
        for value in parameter.bounds:
            at = system.with_parameters(**{parameter.name: value})
            run = core.integrate(at, (0.0, 10.0), tau=1e-2, method=method_for(at))
            assert run.status is not Status.NO_CONVERGENCE
            assert run.status is not Status.ESCAPED or name == "elliptic_curve"  # its orbits may have poles
            assert np.isfinite(run.x).all()


@pytest.mark.parametrize("name", NAMES)
def test_a_system_is_documented(name):
    system = core.CATALOGUE[name]
    assert system.name
    assert system.doc.endswith(".")
    assert all(q.doc and q.bounds for q in system.parameters)


@pytest.mark.parametrize("name", [name for name, system in core.CATALOGUE.items() if system.two_sided])
def test_a_system_is_typeset(name):
    system = core.CATALOGUE[name]
    texts = system.latex()
    assert all(texts[key] for key in ("f_minus", "f_plus", "g"))
    assert bool(texts["psi_minus"]) == bool(system.psi_minus)
    everything = " ".join(texts.values())
    jump_only = {"restitution"}
    assert all(q.symbol in everything for q in system.parameters if q.name not in jump_only)


@pytest.mark.parametrize("name", NAMES)
def test_a_pickled_system_is_the_same_system(name):
    system = core.CATALOGUE[name]
    again, third = (pickle.loads(pickle.dumps(system)) for _ in range(2))  # noqa: S301 - our own
    assert again == third == system
    assert again.laws is third.laws


SEVERAL = [
    (name, method.name)
    for name, system in core.CATALOGUE.items()
    for method in core.METHODS.values()
    if not system.two_sided and (system.laws.most_conserved or not method.needs_conserved)
]
#: Each method compiles each region: of up to eight regions a plain run tries a method of each kind.
FEW_REGIONS = [case for case in SEVERAL if case[1] in QUICK_METHODS or len(core.CATALOGUE[case[0]].laws.regions) < 3]


@pytest.mark.parametrize(("name", "method"), deep_but(FEW_REGIONS, SEVERAL))
def test_a_system_of_several_surfaces_runs_by_every_method_that_it_admits(name, method):
    tau = None if core.METHODS[method].adaptive else 1e-2
    run = core.integrate(core.CATALOGUE[name], (0.0, 10.0), tau=tau, method=method)
    assert run.status is Status.COMPLETED
    assert len(run.crossings) > 1
    assert np.isfinite(run.x).all()
