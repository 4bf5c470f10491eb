"""Every compiled step against the same scheme in 34 digits, and the orders that doubles hide."""

import numpy as np
import pytest

import core
from tests.core.exact import EPS
from tests.core.methods.schemes_in_digits import crossings_in_digits, slopes_in_digits
from tests.levels import deep_but

FIXED = [method.name for method in core.METHODS.values() if not method.adaptive]
#: Every method on one system, and one method on every system; the others are deep.
QUICK = ["elliptic_curve", ("pendulum", "dmm2"), ("rigid_body", "dmm2"), ("predator_prey", "dmm2")]
CASES = [(name, m) for name in ("elliptic_curve", "pendulum", "rigid_body", "predator_prey") for m in FIXED]


@pytest.mark.parametrize(("name", "method"), deep_but(QUICK, CASES))
def test_a_compiled_run_is_the_scheme_to_round_off(name, method):
    # Times up to 4.4 and states up to 2, a few dozen steps: each rounds once. Long steps, so that the scheme is far
    # from the solution, and only the scheme will do. rk8's weights have both signs and sizes up to 40.
    system, tau = core.CATALOGUE[name], 0.1
    exact = crossings_in_digits(system, method, tau, 2)
    run = core.integrate(system, (0.0, float(exact[-1].t) + 1e-3), tau=tau, method=method, record="crossings")
    assert len(run.crossings) == 2
    bound = (64 if "rk8" in method else 16) * EPS
    for k, met in enumerate(exact):
        assert abs(float(met.t - run.crossings.t[k])) <= bound
        assert max(abs(float(a - b)) for a, b in zip(met.x, run.crossings.x[k], strict=True)) <= bound


@pytest.mark.deep
@pytest.mark.parametrize(("method", "coarsest"), [("dmm6", 0.04), ("rk8", 0.01), ("prk8", 0.01)])
def test_orders_show_below_the_round_off_of_doubles(method, coarsest):
    slopes = slopes_in_digits(core.CATALOGUE["elliptic_curve"], method, (coarsest, coarsest / 2, coarsest / 4), (1, 2))
    assert slopes == pytest.approx(np.full((2, 1), core.METHODS[method].order), abs=0.2)
