"""Small linear systems in generated lines, against numpy."""

import math
from typing import Any

import numpy as np
import pytest
import sympy

from core.codegen.linear_solve import by_cofactors, least_change, with_pivots

EPS = np.finfo(float).eps


def run(lines: list[str], values: dict[str, float]) -> dict[str, Any]:
    """The names after the lines have run, in Python's own floats."""
    space: dict[str, Any] = {"math": math, "state": 1.0} | values
    exec("\n".join(lines), space)  # noqa: S102 - text of our own
    return space


def matrices(n: int, count: int = 50) -> list[np.ndarray]:
    generator = np.random.default_rng(n)
    return [generator.normal(size=(n, n)) + 2 * np.eye(n) for _ in range(count)]


@pytest.mark.parametrize("n", [1, 2, 3])
def test_cofactors_solve_small_systems(n):
    symbols = sympy.Matrix(n, n, lambda i, k: sympy.Symbol(f"j{i}_{k}"))
    lines = by_cofactors(symbols, sympy.numbered_symbols("v"))
    for matrix in matrices(n):
        right = np.arange(1.0, n + 1)
        values = {f"j{i}_{k}": matrix[i, k] for i in range(n) for k in range(n)} | {f"r{i}": right[i] for i in range(n)}
        found = run(lines, values)
        wanted = np.linalg.solve(matrix, right)
        error = np.abs([found[f"r{k}"] for k in range(n)] - wanted).max()
        # Cramer's rule: the error grows with the condition, squared at worst.
        assert error <= 8 * EPS * np.linalg.cond(matrix) ** 2 * np.abs(wanted).max()


@pytest.mark.parametrize("n", [2, 4, 6])
def test_elimination_solves_larger_ones(n):
    lines = with_pivots(n, n)
    for matrix in matrices(n):
        right = np.arange(1.0, n + 1)
        values = {f"j{i}_{k}": matrix[i, k] for i in range(n) for k in range(n)} | {f"r{i}": right[i] for i in range(n)}
        found = run(lines, values)
        wanted = np.linalg.solve(matrix, right)
        error = np.abs([found[f"r{k}"] for k in range(n)] - wanted).max()
        assert error <= 8 * n * EPS * np.linalg.cond(matrix) * np.abs(wanted).max()


def changes(rows: Any, right: Any, slopes: Any = None) -> np.ndarray:
    rows = np.asarray(rows, dtype=float)
    m, d = rows.shape
    names = [[sympy.Symbol(f"a{j}_{k}") for k in range(d)] for j in range(m)]
    others = None if slopes is None else [[sympy.Symbol(f"h{j}_{k}") for k in range(d)] for j in range(m)]
    out = sympy.symbols(f"e:{d}")
    values = {str(names[j][k]): rows[j, k] for j in range(m) for k in range(d)} | {f"r{j}": right[j] for j in range(m)}
    if others is not None:
        values |= {str(others[j][k]): slopes[j][k] for j in range(m) for k in range(d)}
    found = run(least_change(names, out, sympy.numbered_symbols("v"), others), values)
    return np.array([found[str(e)] for e in out])


@pytest.mark.parametrize(("m", "d"), [(1, 2), (1, 4), (2, 3), (2, 4), (3, 4)])
@pytest.mark.parametrize("scale", [1.0, 1e-160, 1e160])
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")  # of the first try, before it is scaled
def test_the_least_change_is_that_of_the_pseudoinverse(m, d, scale):
    generator = np.random.default_rng(10 * m + d)
    for _ in range(20):
        rows = generator.normal(size=(m, d))
        right = generator.normal(size=m)
        wanted = np.linalg.pinv(rows) @ right
        error = np.abs(changes(rows * scale, right * scale) - wanted).max()
        # The normal equations square the condition.
        assert error <= 16 * EPS * np.linalg.cond(rows) ** 2 * np.abs(wanted).max()


def test_changes_along_some_rows_answer_to_others():
    rows, slopes, right = np.array([[1.0, 2.0, 0.5]]), np.array([[0.9, 2.2, 0.4]]), np.array([0.3])
    change = changes(rows, right, slopes.tolist())
    assert slopes @ change == pytest.approx(right, rel=4 * EPS)
    assert np.cross(change, rows[0]) == pytest.approx(np.zeros(3), abs=4 * EPS)


def test_rows_that_vanish_or_depend_on_others_bind_nothing():
    assert not changes([[0.0, 0.0]], [1.0]).any()
    both = changes([[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]], [1.0, 2.0])
    assert both == pytest.approx(changes([[1.0, 2.0, 0.0]], [1.0]), rel=8 * EPS)
