"""METHODS: what each says of itself is so."""

import numpy as np
import pytest
import sympy

import core
from core.methods import ButcherTableau, Composition, method_named

OF = {kind: [m for m in core.METHODS.values() if isinstance(m.scheme, kind)] for kind in (Composition, ButcherTableau)}


@pytest.mark.parametrize("method", OF[Composition], ids=lambda m: m.name)
def test_weights_of_the_compositions_meet_the_order_conditions(method):
    # Necessary for a symmetric composition of a symmetric method (Hairer, Lubich, Wanner, Theorem V.3.1 and after):
    # the sums of the odd powers below the order vanish, but for the first, which is one.
    weights = method.scheme.weights
    assert weights == weights[::-1]
    assert abs(sum(weights) - 1) < 1e-24
    for power in range(3, method.order, 2):
        assert abs(sympy.N(sum(w**power for w in weights), 30)) < 1e-23  # they are given to 26 digits


@pytest.mark.parametrize("method", OF[ButcherTableau], ids=lambda m: m.name)
def test_tableaux_meet_the_conditions_of_quadrature(method):
    # B(p): Σ bᵢ cᵢᵏ⁻¹ = 1/k for k ≤ p (Hairer, Nørsett, Wanner, Solving ODEs I, IV.5); the weights have 28 digits.
    nodes, weights = method.scheme.nodes, method.scheme.weights
    for k in range(1, method.order + 1):
        total = sum(b * (c ** (k - 1) if k > 1 else 1) for b, c in zip(weights, nodes, strict=True))
        assert abs(sympy.N(total - sympy.Rational(1, k), 35)) < 1e-24, k


def test_only_implicit_tableaux_are_symmetric():
    # A step back undoes a step forward where a_ij + a_(s+1−i)(s+1−j) = b_j (Hairer, Lubich, Wanner, V.2.3).
    for method in OF[ButcherTableau]:
        tableau, s = method.scheme, len(method.scheme.weights)
        rows = [[*row, *[0] * (s - len(row))] for row in tableau.rows]
        undone = all(
            sympy.simplify(rows[i][j] + rows[-1 - i][-1 - j] - tableau.weights[j]) == 0
            for i in range(s)
            for j in range(s)
        )
        assert undone == method.symmetric, method.name


def test_gauss_keeps_a_quadratic_invariant_and_no_other():
    # Cooper's condition: b_i a_ij + b_j a_ji = b_i b_j (Hairer, Lubich, Wanner, Theorem IV.2.2).
    settings = {"tau": 0.05, "method": "gauss4"}
    kept = core.integrate("harmonic_oscillator", (0.0, 50.0), **settings)
    lost = core.integrate("pendulum", (0.0, 50.0), **settings)
    assert np.abs(kept.conserved_error()).max() < 64 * np.finfo(float).eps  # a rounding of each of a thousand steps
    assert 1e-12 < np.nanmax(np.abs(lost.conserved_error())) < 1e-4


def test_names_are_keys():
    assert all(name == method.name for name, method in core.METHODS.items())


def test_an_unknown_method_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="known are dmm2"):
        method_named("euler")


@pytest.mark.parametrize(
    ("system", "method", "kept"),
    [
        ("harmonic_oscillator", "gauss4", True),  # quadratic
        ("harmonic_oscillator", "rk4", False),
        ("elliptic_curve", "gauss4", False),  # cubic
        ("damped_oscillator", "gauss4", False),  # depends on time
        ("elliptic_curve", "dmm2", True),
    ],
)
def test_which_conserved_quantities_a_method_keeps_follows_from_its_scheme_and_their_form(system, method, kept):
    chosen = core.CATALOGUE[system]
    assert all(core.METHODS[method].keeps(mode) for mode in chosen.laws.regions) is kept
    run = core.integrate(chosen, (0.0, 20.0), tau=0.05, method=method)
    assert bool(np.nanmax(run.change_of_psi()) < 1e-13 * run.psi_size()) is kept
