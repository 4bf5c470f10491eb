"""Steps that leap over a fast stretch are warned of, also by runs that record no steps, and by ensembles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import core
from tests.families.oracles import silent

_FIELD = ("1/((x - a)**2 + b**2)", "-y")


def drawn(rng: np.random.Generator) -> tuple[core.PiecewiseSystem, float, float]:
    """x passes x = a at the speed 1/b²; the time to x is a cubic: the system, an end time, and the state then."""
    a, b, end = float(rng.uniform(0.5, 2.0)), float(10 ** rng.uniform(-3, -0.5)), float(rng.uniform(3, 5))
    system = core.PiecewiseSystem("Fast", ("x", "y"), _FIELD, _FIELD, "x + 1e9", parameters={"a": a, "b": b}, x0=(0, 1))
    way = lambda x: (x - a) ** 3 / 3 + b * b * (x - a)  # noqa: E731
    return system, end, brentq(lambda x: way(x) - way(0.0) - end, 0.0, 10.0, xtol=1e-13)


@pytest.mark.parametrize("record", [{"record": "end"}, {"record": "crossings"}, {"t_eval": (1.0, 2.0)}])
def test_a_run_that_records_no_steps_warns_of_one_that_leaps(draws, record):
    for rng in draws(20):
        system, end, right = drawn(rng)
        run = core.integrate(
            system,
            (0.0, end),
            method=str(rng.choice(["rk4", "rk8"])),
            tau=float(10 ** rng.uniform(-3.3, -1.7)),
            **record,
        )
        assert abs(run.x[-1, 0] - right) < 0.1 * right or not silent(run), f"{run.x[-1]}, not {right}: {system.values}"


def test_an_ensemble_a_section_and_a_sweep_warn_of_a_member_whose_step_leaps(draws):
    for rng in draws(6):
        system, end, right = drawn(rng)
        tau, starts = float(10 ** rng.uniform(-3.3, -1.7)), np.array([[0.0, 1.0], [0.0, 2.0]])
        found = core.ensemble(system, (0.0, end), starts, tau=tau, method="rk4")
        if (np.abs(found.x[:, 0] - right) < 0.1 * right).all():
            continue
        of = {"points": 3, "of": "y - 1e-9", "tau": tau, "method": "rk4"}
        section = core.section(system, (0.0, end), starts, **of)
        sweep = core.sweep(system, (0.0, end), "b", [system.values["b"]], "x", **of)
        for told in (found.message, section.message, sweep.message):
            assert "too long" in told, f"{system.values}, tau = {tau}: {told}"
