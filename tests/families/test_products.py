"""Taylor coefficients of sums of products, quotients and roots that share their parts, in any order."""

from __future__ import annotations

import ctypes
from typing import Any

import mpmath as mp
import numpy as np
import sympy

from core.codegen.functions import function_text, module_text
from core.codegen.taylor_series import series_code
from core.compilation.compiled import _load
from core.kernels.abi import ORDER as ORDER_SLOT
from core.kernels.abi import UNIT, Frame
from core.symbolic.declaration import Declaration

EPS = 2.0**-52
ORDER = 14
X, Y = 0.6, 0.8
#: Of size 1 and analytic within a radius of ½ around where the paths start.
_PARTS = ("x", "y", "(2 + x*y)", "(1 + x**2)", "exp(-x/2)", "(1 + tanh(y))")
_EXPONENTS = ("1", "2", "3", "-1", "-2", "-3", "1/2", "-1/2", "3/2", "-3/2", "1/3")
_TERMS = 3
_POINTER = ctypes.POINTER(ctypes.c_double)


def _drawn(rng: np.random.Generator) -> str:
    """A sum of products of powers of a few parts, so that they have factors in common; less 7, lest it has one sign.

    A switching function that is seen to keep its sign has no surface.
    """
    parts = rng.choice(_PARTS, size=3, replace=False)
    terms = []
    for _ in range(_TERMS):
        factors = rng.choice(parts, size=int(rng.integers(1, 4)), replace=False)
        terms.append("*".join(f"({part})**({rng.choice(_EXPONENTS)})" for part in factors))
    return " + ".join(terms) + " - 7"


def _computed(text: str) -> np.ndarray:
    """Coefficients of g = text while (x, y) turns on the unit circle."""
    laws = Declaration.of_sides(("x", "y"), (), (), ("y", "-x"), ("y", "-x"), (text,)).laws
    code = series_code(laws, laws.modes[1])
    lines = [f"order = int(w[{ORDER_SLOT}])", f"c = carray(scratch, ({code.rows}, {ORDER + 1}))", "shrink = 1.0"]
    module = _load(module_text([function_text("series", [*lines, *code.lines, f"w[{UNIT}] = unit", "return 0"])]))
    c, frame = np.zeros((code.rows, ORDER + 1)), Frame(2, 0)
    w = frame.empty()
    w[ORDER_SLOT], w[frame.x : frame.x + 2] = ORDER, (X, Y)
    module.series.ctypes(0.0, 0.0, *(a.ctypes.data_as(_POINTER) for a in (np.zeros(1), w, c)))
    return c[2] / w[UNIT] ** np.arange(ORDER + 1.0)


def _exact(text: str) -> list[Any]:
    """The same coefficients, by mpmath."""
    x, y = sympy.symbols("x y", positive=True)
    function = sympy.lambdify((x, y), sympy.sympify(text, {"x": x, "y": y}), "mpmath")

    def along(s: Any) -> Any:
        return function(X * mp.cos(s) + Y * mp.sin(s), Y * mp.cos(s) - X * mp.sin(s))

    with mp.workdps(60):
        return mp.taylor(along, 0, ORDER)  # type: ignore[no-any-return]


def test_products_that_share_their_parts_have_the_derivatives_of_mpmath(draws) -> None:
    for rng in draws(6):
        text = _drawn(rng)
        computed, exact = _computed(text), _exact(text)
        size = max(1.0, float(abs(exact[0])))
        rate = max(4.0, *(float(abs(u) / size) ** (1 / k) for k, u in enumerate(exact) if k))
        for k, u in enumerate(exact):
            assert abs(computed[k] - u) <= 16 * EPS * size * rate**k, (text, k)
