"""The two levels of the tests: the quick one, which a plain run is, and the deep one, which tries further cases."""

from collections.abc import Hashable, Iterable
from typing import Any

import pytest
from hypothesis import settings


def deep_but(quick: Iterable[Hashable], cases: Iterable[Any]) -> list[Any]:
    """Mark the cases of a parametrisation as deep, but for those that are `quick`, or whose first value is."""
    quick = set(quick)
    marked = []
    for case in cases:
        values = case if isinstance(case, tuple) else (case,)
        marks = () if values[0] in quick or values in quick else (pytest.mark.deep,)
        marked.append(pytest.param(*values, marks=marks))
    return marked


#: One method of each kind: a conservative one that is implicit, a plain one, a conservative one that is explicit, and
#: the one that chooses its steps.
QUICK_METHODS = ("dmm2", "rk4", "prk8", "taylor")


def tries(count: int) -> settings:
    """Settings of a property that takes long: a third of so many examples, and with --draws N, N times as many."""
    return settings(max_examples=-(-count * settings.default.max_examples // 300))
