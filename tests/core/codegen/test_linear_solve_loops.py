"""Linear systems in loops over arrays, against numpy, and against the lines that are written out for a few unknowns."""

import math

import numpy as np
import pytest
import sympy

from core.codegen.linear_solve import DEPENDENT, LEVEL_TOLERANCE, least_change, with_pivots
from core.codegen.linear_solve_loops import change_along, solve_with_pivots

EPS = np.finfo(float).eps


def solved(matrix, right, d=None):
    """Solution, and what else `solve_with_pivots` tells."""
    n = len(right)
    a, r = matrix.ravel().copy(), np.array(right, dtype=float)
    told = solve_with_pivots(a, r, np.empty(n), n, n if d is None else d, False, 1.0)
    return r, told


def written_out(lines, values):
    space = dict(values)
    exec("\n".join(lines), space)  # noqa: S102 - text of our own
    return space


@pytest.mark.parametrize("n", [1, 2, 5, 13, 28])
def test_solutions_are_as_good_as_those_of_numpy(n, draws):
    for rng in draws(20):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
        found, _ = solved(matrix, right)
        wanted = np.linalg.solve(matrix, right)
        # Wilkinson: n ulp of growth a row, times the condition; both make such an error.
        assert np.abs(found - wanted).max() <= 8 * n * EPS * np.linalg.cond(matrix) * np.abs(wanted).max(), matrix


@pytest.mark.parametrize("n", [2, 5, 13, 28])
def test_badly_scaled_rows_leave_a_small_residual(n, draws):
    for rng in draws(20):
        scale = 10.0 ** rng.uniform(-8, 8, (n, 1))
        matrix, right = rng.normal(size=(n, n)) * scale, rng.normal(size=n) * scale[:, 0]
        found, _ = solved(matrix, right)
        residual = np.abs(matrix @ found - right)
        # Backward stable, by the norm of the matrix: with partial pivoting rows of little weight may have lost more.
        assert (residual <= 8 * n * EPS * np.abs(matrix).max() * np.abs(found).max() + n * EPS * np.abs(right)).all(), (
            matrix
        )


@pytest.mark.parametrize(("d", "m"), [(3, 1), (6, 2), (8, 4)])
def test_saddle_points_are_those_that_are_written_out(d, m, draws):
    for rng in draws(20):
        n, rows = d + m, rng.normal(size=(m, d))
        if m > 1 and rng.random() < 0.5:
            rows[-1] = 2 * rows[0]  # a gradient that depends on another one
        matrix = np.block([[np.eye(d) + 0.1 * rng.normal(size=(d, d)), rows.T], [rows, np.zeros((m, m))]])
        right = np.concatenate([rng.normal(size=d), rows @ rng.normal(size=d)])
        found, (independent, residual, largest) = solved(matrix, right, d)
        values = {f"j{i}_{k}": matrix[i, k] for i in range(n) for k in range(n)} | {f"r{i}": right[i] for i in range(n)}
        wanted = written_out(with_pivots(n, d), values | {"corrections": 1, "state": 1.0, "math": math})
        error = np.abs(found - [wanted[f"r{k}"] for k in range(n)]).max()
        # The same operations but for the order of rows that are never pivots; the condition of Λ Λᵗ is some hundreds.
        assert error <= 2.0**14 * n * EPS * np.abs(found).max(), (matrix, right)
        if m > 1:
            assert independent == wanted["independent"]
            assert (residual, largest) == (wanted["residual"], max(wanted[f"s{k}"] for k in range(d, n)))
        assert (
            np.abs(rows @ found[:d] - right[d:]).max()
            <= max(LEVEL_TOLERANCE, 64 * n * EPS) * np.abs(rows).max() * np.abs(found).max()
        )


def test_a_gradient_that_vanishes_binds_nothing():
    rows = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    matrix = np.block([[np.eye(3), rows.T], [rows, np.zeros((2, 2))]])
    found, (independent, *_) = solved(matrix, [1.0, 2.0, 3.0, 0.0, 0.0], 3)
    assert found.tolist() == [0.0, 2.0, 3.0, 0.0, 1.0]
    assert not independent


def test_a_gradient_nearly_dependent_on_another_binds_unless_its_psi_is_kept_but_for_rounding():
    rows = np.array([[1.0, 0.0, 0.0], [1.0, 1e-5, 0.0]])
    matrix = np.block([[np.eye(3), rows.T], [rows, np.zeros((2, 2))]])
    for residual, sought in ((1e-9, 1e-4), (1e-16, 0.0)):
        found, (independent, *_) = solved(matrix, [0.0, 0.0, 0.0, 0.0, residual], 3)
        assert np.allclose(found[:3], [0.0, sought, 0.0], rtol=1e-5, atol=0.0)
        assert not independent


def changed(rows, slopes, right):
    m, d = rows.shape
    e = np.empty(d)
    change_along(rows.ravel().copy(), slopes.ravel().copy(), right.copy(), np.empty(m * m), e, m, d, 1.0, DEPENDENT)
    return e


@pytest.mark.parametrize(("m", "d"), [(1, 5), (2, 6), (5, 12), (5, 24)])
@pytest.mark.parametrize("scale", [1.0, 1e-160, 1e160])
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")  # of the first try, before it is scaled
def test_changes_along_rows_are_those_of_the_pseudoinverse(m, d, scale, draws):
    for rng in draws(10):
        rows, right = rng.normal(size=(m, d)), rng.normal(size=m)
        wanted = np.linalg.pinv(rows) @ right
        error = np.abs(changed(rows * scale, rows * scale, right * scale) - wanted).max()
        assert error <= 16 * EPS * np.linalg.cond(rows) ** 2 * np.abs(wanted).max(), rows  # the normal equations


def test_rows_that_depend_on_others_bind_nothing(draws):
    for rng in draws(20):
        rows = rng.normal(size=(4, 9))
        both = np.vstack([rows, 2 * rows[:1]])
        right = rng.normal(size=4)
        wanted = changed(rows, rows, right)
        found = changed(both, both, np.append(right, 2 * right[0]))
        assert np.abs(found - wanted).max() <= 64 * EPS * np.linalg.cond(rows) ** 2 * np.abs(wanted).max(), rows


def test_changes_in_loops_are_those_that_are_written_out(draws):
    m, d = 3, 5
    names = [[sympy.Symbol(f"a{j}_{k}") for k in range(d)] for j in range(m)]
    others = [[sympy.Symbol(f"h{j}_{k}") for k in range(d)] for j in range(m)]
    lines = least_change(names, sympy.symbols(f"e:{d}"), sympy.numbered_symbols("v"), others)
    for rng in draws(20):
        rows, right = rng.normal(size=(m, d)), rng.normal(size=m)
        slopes = rows + 0.01 * rng.normal(size=(m, d))
        values = {f"{s}{j}_{k}": a[j, k] for s, a in (("a", rows), ("h", slopes)) for j in range(m) for k in range(d)}
        wanted = written_out(lines, values | {f"r{j}": right[j] for j in range(m)} | {"state": 1.0, "math": math})
        error = np.abs(changed(rows, slopes, right) - [wanted[f"e{k}"] for k in range(d)]).max()
        assert error <= 16 * EPS * np.linalg.cond(rows) ** 2 * np.abs(right).max(), (rows, slopes)
