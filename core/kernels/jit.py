"""Compiler options of the jitted functions of the core."""

from __future__ import annotations

from typing import Any

from numba import njit

__all__ = ["OPTIONS", "always_inlined", "inlined", "internal", "jitted"]

#: No reference counting: nothing here allocates, and counting the references to a dozen arrays costs more than a step.
#: (The option is internal to numba and missing from its type stubs.) Never `fastmath`.
OPTIONS: Any = {"error_model": "numpy", "_nrt": False}
_BARE: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

# A function that does not say whether it is inlined takes that from the first one that calls it.
jitted = njit(forceinline=False, **OPTIONS)
always_inlined = njit(forceinline=True, **OPTIONS)
#: For functions that only jitted functions call: without wrappers for Python and C, they compile in a fifth less time.
internal = njit(forceinline=False, **OPTIONS, **_BARE)
inlined = njit(forceinline=True, **OPTIONS, **_BARE)
