"""How the jitted functions of the core are compiled."""

from __future__ import annotations

from typing import Any

from numba import njit

__all__ = ["OPTIONS", "always_inlined", "inlined", "internal", "jitted"]

#: Without reference counts: nothing here allocates, and counting the references to a dozen arrays costs more than a
#: step. (The option is numba's own, and its type stubs do not have it.) Never `fastmath`.
OPTIONS: Any = {"error_model": "numpy", "_nrt": False}
_BARE: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

jitted = njit(**OPTIONS)
always_inlined = njit(forceinline=True, **OPTIONS)
#: For what is called from jitted functions only: a fifth of the compile time less.
internal = njit(**OPTIONS, **_BARE)
inlined = njit(forceinline=True, **OPTIONS, **_BARE)
