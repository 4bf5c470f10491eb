"""Whatever is given for an argument of the public functions, they take it or refuse it with a ValueError."""

from __future__ import annotations

import pathlib
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import core

SYSTEM = core.CATALOGUE["harmonic_oscillator"]
RUN = {"t_span": (0.0, 0.5), "x0": (1.0, 1.0), "tau": 0.1, "method": "rk2"}

#: What people, and programs that pass things on, have been known to give.
ODDITIES = (
    None, True, False, np.True_, "", "1", "12", "a", b"12", bytearray(b"12"), 0, 1, -1, 2.5, 1e400, -1e400, 1e-320,
    1e300, float("nan"), 10**400, 1 + 1j, np.complex128(1 + 1j), np.float32(0.1), np.int8(1), np.longdouble(0.1),
    np.array(0.1), Decimal("0.1"), Fraction(1, 10), [], (), [1], [1, 2], [1, 2, 3], [[1, 2]], [1, [2, 3]], ["a", "b"],
    [None, None], [1j, 1], [True, 1], {}, {"x": 1}, {"x": 1, "y": 2}, {"x": 1, "y": 2, "z": 3}, {1, 2}, range(2),
    iter([1, 2]), iter([]), np.zeros(0), np.zeros(2), np.ones((2, 2)), np.array(["a", "b"]), np.array([1 + 1j, 2]),
    np.array([None, 1]), np.array(["2026-01-01"], dtype="datetime64[D]"), pathlib.Path("x"), object(), int, len, ...,
    slice(1, 2), SYSTEM, core.METHODS["rk4"], core.METHODS["dmm2"], core.Status.COMPLETED, "rk4", "elliptic_curve",
    ["rk4", "rk2"], ("rk4", 1), (0.0, 1.0), (1.0, 0.0), (0.0, 1e-300), (None, 1.0), ("0", "1"), (float("nan"), 1.0),
)  # fmt: skip


def declared(**changes):
    laws = {"name": "s", "variables": ("x", "y"), "f_minus": ("y", "-x"), "f_plus": ("y", "-x"), "g": "y"}
    return core.PiecewiseSystem(**{**laws, "parameters": {"k": 1.0}, "x0": (1.0, 1.0), **changes})


def _quick(**arguments):
    return core.integrate(SYSTEM, **{**RUN, "max_steps": 200, **arguments})


_TRAJECTORY = core.integrate(SYSTEM, **RUN)
_STUDIED = {"system": SYSTEM, "taus": (0.1, 0.05), "crossings": (1,), "method": "rk2"}
_COST = {
    "system": SYSTEM,
    "t_span": (0.0, 0.5),
    "methods": ("rk2",),
    "settings": {"rk2": (0.1,)},
    "peers": (),
    "repeats": 1,
}
_STABILITY = {
    "system": SYSTEM, "t_span": (0.0, 1.0), "methods": ("rk2",), "taus": (0.1, 0.2), "values": (0.9, 1.1), "tau": 0.1,
    "parts": ("largest_tau",), "steps": 10,
}  # fmt: skip

#: name -> (function, arguments that may be replaced)
CALLS = {
    "integrate": (_quick, "t_span x0 tau method tolerance transition perturbation_order perturbation_scale record "
                          "max_crossings max_steps t_eval envelope"),
    "integrate a system": (lambda system: core.integrate(system, **{**RUN, "x0": None, "max_steps": 9}), "system"),
    "at": (lambda t: _TRAJECTORY.at(t), "t"),
    "columns": (lambda variables: _TRAJECTORY.crossings.columns(variables), "variables"),
    "diagnose": (core.diagnose, "run"),
    "reference_solution": (lambda **a: core.reference_solution(**{"system": SYSTEM, **a}), "system x0 t0"),
    "order_study": (lambda **a: core.order_study(**{**_STUDIED, **a}), "system taus x0 method crossings t0 transition "
                                                                      "perturbation_order perturbation_scale"),
    "work_precision": (lambda **a: core.work_precision(**{**_COST, **a}), "system t_span x0 methods settings peers "
                                                                         "repeats budget"),
    "stability_study": (lambda **a: core.stability_study(**{**_STABILITY, **a}), "system t_span x0 methods taus "
                                                                                "coordinate values parts tau steps"),
    "PiecewiseSystem": (declared, "variables f_minus f_plus g psi_minus psi_plus parameters x0 jump values"),
    "Parameter": (lambda **a: core.Parameter(**{"name": "k", "default": 1.0, **a}), "name default bounds"),
    "with_parameters": (SYSTEM.with_parameters, "omega2_minus nothing"),
    "field": (lambda **a: SYSTEM.field(**{"side": 1, "t": 0.0, "x": (1.0, 1.0), **a}), "side t x"),
    "switching": (lambda **a: SYSTEM.switching(**{"t": 0.0, "x": (1.0, 1.0), **a}), "t x"),
    "conserved": (lambda **a: SYSTEM.conserved(**{"side": 1, "t": 0.0, "x": (1.0, 1.0), **a}), "side t x"),
}  # fmt: skip
#: Studies that take an odd value for good run for a while: as many oddities of them are drawn a time.
DRAWN, SLOW = 12, ("order_study", "work_precision", "stability_study", "PiecewiseSystem")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_every_argument_is_taken_or_refused_with_a_value_error(name, draws):
    function, arguments = CALLS[name]
    wrong = []
    for rng in draws(1):
        for argument in arguments.split():
            chosen = rng.choice(len(ODDITIES), DRAWN if name in SLOW else len(ODDITIES), replace=False)
            cases = [ODDITIES[k] for k in chosen if not _is_long(name, argument, ODDITIES[k])]
            wrong += [
                f"{argument} = {value!r}: {why}" for value in cases if (why := _raised(function, argument, value))
            ]
    assert not wrong, f"{name}: {wrong}"


def _raised(function, argument, value):
    """What a call raises that is no ValueError with a reason; empty where there is nothing to say against it."""
    try:
        function(**{argument: value})
    except ValueError as why:
        return "" if len(str(why)) > 10 else f"no reason: {why}"
    except Exception as why:
        return f"{type(why).__name__}: {why}"
    return ""


def _is_long(name, argument, value):
    """Whether a value makes sense and asks for a run of hours."""
    return name == "stability_study" and argument == "steps" and not isinstance(value, str)
