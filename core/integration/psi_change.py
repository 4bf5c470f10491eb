"""The largest |Δψ| of a run: what the compiled part needs, and that of a run in progress."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from core.compilation.compiled import Compiled, compile_run, modes_entered
from core.compilation.guards import guard_table
from core.integration.psi_loop import FOLLOWED, PsiArrays, compiled_psi
from core.integration.run import Run
from core.kernels.abi import Frame
from core.methods import Method
from core.symbolic.laws import Laws
from core.transition.records import NO_MODE, ROW

__all__ = ["compile_psi", "largest_change", "psi_arrays", "size_of_psi"]


def size_of_psi(laws: Laws, slides: bool) -> int:
    """Largest number of conserved quantities of a mode that runs may enter."""
    return laws.most_conserved_sliding if slides else laws.most_conserved


def compile_psi(laws: Laws, method: Method, modes: Iterable[int] = ()) -> Compiled:
    """Compile ψ of the modes that runs of a method have entered so far, and of `modes`."""
    known = modes_entered(laws, method, True)
    known.update(modes_entered(laws, method), modes)
    return compile_run(laws, method, True, tuple(sorted(known)))


def psi_arrays(laws: Laws, functions: Compiled, slides: bool) -> PsiArrays:
    """Make the arguments of the loop; it is the caller who keeps the functions alive."""
    frame, sums = Frame(len(laws.x), laws.most_conserved_sliding), np.zeros((2, size_of_psi(laws, slides)))
    first_rows, followed = guard_table(laws).first_rows, np.zeros(1, dtype=FOLLOWED)
    return PsiArrays(functions.addresses, first_rows, frame.empty(), sums, followed)


def largest_change(run: Run) -> float:
    """Largest |Δψ| off the surface of a run that has recorded its steps, and kept its crossings."""
    laws, (hits, places), last = run.system.laws, run.hits(), run.last
    end = np.array([(last.t, last.mode, run.segment)], dtype=ROW)
    rows = np.concatenate([*(rows for rows, _ in run.rows), end])
    x = np.concatenate([*(x for _, x in run.rows), [last.x]])
    modes = np.unique(np.concatenate([[run.first_mode], rows["mode"], hits["mode"]]))
    functions = compile_psi(laws, run.method, modes[modes != NO_MODE].tolist())
    arrays = psi_arrays(laws, functions, run.settings.slides)
    compiled_psi()(
        *arrays, len(laws.regions), run.system.parameter_array.copy(), np.empty((1, 1)), len(run.start), run.t0,
        np.array(run.start), run.first_mode, rows, x, hits, places,
    )  # fmt: skip
    return float(arrays.followed["largest"][0])
