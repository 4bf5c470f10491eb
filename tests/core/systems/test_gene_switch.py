"""Gene switch, against the matrix exponential of its linear sides."""

import numpy as np
from scipy.linalg import expm

import core
from tests.core.systems.arcs import crossings

GENES = core.CATALOGUE["gene_switch"]
SUPPLY, THRESHOLD, DECAY = 2.0, 0.8, 1.5
CHAIN = DECAY * np.array([[-1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])


def flow(side, s, state):
    resting = SUPPLY if side < 0 else 0.0  # all three levels tend to it
    return resting + expm(CHAIN * s) @ (state - resting)


def test_the_genes_switch_when_the_matrix_exponential_says():
    run = core.integrate(GENES, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    t, x = crossings(flow, lambda _, u: u[2] - THRESHOLD, GENES.x0, -1, 39, stride=0.1)
    assert len(run.crossings) == 39
    # tau**4 times a factor of 10; the limit cycle attracts, so that errors do not add up but in time.
    assert np.abs(run.crossings.t - t).max() < 1e-11
    assert np.abs(run.crossings.x - x).max() < 1e-11


def test_the_levels_settle_to_a_cycle_and_go_round_for_ever():
    run = core.integrate(GENES, (0.0, 500.0), tau=1e-2, method="rk4", record="crossings")
    assert run.status is core.Status.COMPLETED
    assert len(run.crossings) > 390
    late = run.crossings.x[100::2]
    # Each round forgets the one before; steps that fall otherwise on the cycle change it by tau**4 / 1000.
    assert np.abs(late - late[0]).max() < 1e-11
    assert np.abs(run.crossings.rate_after).min() > 0.3


def test_a_gene_whose_repressor_stays_low_is_never_switched_off():
    run = core.integrate(GENES.with_parameters(supply=0.7), (0.0, 50.0), tau=1e-2, method="rk4")
    assert len(run.crossings) == 0
    assert np.abs(run.x[-1] - 0.7).max() < 1e-12  # exp(-75) away
