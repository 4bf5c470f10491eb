"""Studies stop soon after they are cancelled, also in the middle of one long run, and their threads with them."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import core
from core.reference import Cancelled

#: Seconds after which a study is cancelled, here in the middle of a run that takes many times as long.
AFTER = 0.7
#: Seconds within which it and its threads have to stop; on an idle machine they take a twentieth of this.
SOON = 5.0

HARMONIC, KEPLER = core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["kepler"]
#: A trajectory that never reaches the surface, for which the solution is known at once, and a step is as long as any.
CIRCLES = core.PiecewiseSystem("Circles", ("x", "y"), ("y", "-x"), ("y", "-x"), "y - 5", x0=(1.0, 0.0))
#: A fall past the centre, in which coarse steps fail and the solution is followed to see why.
FALL = KEPLER.x0[1:]
VALUES = (-0.14, -0.139)
TAUS = np.geomspace(0.1, 2.0, 25)


def cancelled_soon(study, **options):
    """Run a study on one thread, cancel it, and return it once the thread is free."""
    began = time.monotonic()
    with ThreadPoolExecutor(1) as pool:
        executor = {} if study is core.order_study else {"executor": pool}
        found = study(cancel=lambda: time.monotonic() - began > AFTER, **executor, **options)
        pool.submit(abs, -1).result()
    assert AFTER <= time.monotonic() - began < AFTER + SOON
    return found


@pytest.fixture(autouse=True, scope="module")
def compiled():
    """What there is to compile cannot be cancelled."""
    core.stability_study(KEPLER, (0, 1), methods=("dmm8",), taus=(0.1, 0.2), values=(1.0, 1.1), parts="map")
    for method in ("rk2", "rk4", "taylor"):
        core.integrate(HARMONIC, (0.0, 1.0), method=method)


def test_a_column_of_the_map_is_left_in_the_middle():
    options = {"methods": ("dmm8",), "taus": TAUS, "values": VALUES, "parts": "map"}
    study = cancelled_soon(core.stability_study, system=KEPLER, t_span=(0, 20), x0=(1.0, *FALL), **options)
    assert not study.complete


def test_a_run_of_an_external_solver_is_left_in_the_middle():
    options = {"methods": ("rk4",), "settings": {"rk4": (0.1,), "scipy": (1e-13,)}, "budget": 60.0}
    study = cancelled_soon(core.work_precision, system=CIRCLES, t_span=(0.0, 5000.0), **options)
    assert not study.complete


def test_a_run_of_a_method_is_left_in_the_middle():
    study = cancelled_soon(core.order_study, system=HARMONIC, taus=(1e-2, 1e-9), crossings=(1,), method="rk2")
    assert np.isfinite(study.state_error[:, 0]).all(), "what was computed stays"
    assert np.isnan(study.state_error[:, 1]).all()


def test_a_reference_solution_is_left_in_the_middle():
    study = cancelled_soon(core.order_study, system=HARMONIC, taus=(1e-2, 1e-3), crossings=(20_000,), method="rk2")
    assert np.isnan(study.state_error).all()
    cost = cancelled_soon(core.work_precision, system=HARMONIC, t_span=(0.0, 1e5), methods=("rk2",), peers=())
    assert not cost.complete


@pytest.mark.parametrize("system", ["harmonic_oscillator", "kepler"])
@pytest.mark.parametrize("independent", [False, True])
def test_once_cancelled_a_reference_solution_says_so(system, independent):
    asked = []
    solution = core.reference_solution(system, independent=independent, cancel=lambda: bool(asked))
    solution.state(0.5)
    asked.append(True)
    with pytest.raises(Cancelled):
        solution.crossing(50)
