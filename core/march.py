"""The time loop: compiled once for all systems and methods, which it calls through pointers of fixed signature."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numba
from numba import njit, types

from core import arithmetic, crossing, signatures, state, trajectory
from core.arithmetic import two_sum
from core.crossing import BOUND, RUNNING, Log, Scheme, is_plain, take_step
from core.trajectory import Status

__all__ = ["compiled_march"]

_COMPLETED = int(Status.COMPLETED)

#: The last step may be this much longer than τ (relatively), so that rounding leaves no sliver of a step at the end.
_STRETCH = 1.0 + 1e-9


def _signature() -> Any:
    pointer, vector = signatures.FunctionType, signatures.vector
    matrix = types.Array(types.float64, 2, "C")
    run, row, hit = (numba.from_dtype(d)[::1] for d in (state.RUN, state.ROW, state.HIT))
    functions = [pointer(signatures.STEP)] * 2 + [
        pointer(s) for s in (signatures.SWITCHING, signatures.RATE, signatures.JUMP)
    ]
    places = types.Array(types.float64, 3, "C")
    return types.int64(*functions, vector, run, vector, vector, matrix, types.int64, row, matrix, hit, places)


@lru_cache(maxsize=1)
def compiled_march() -> Callable[..., int]:
    """Compile the loop, or load it from numba's cache.

    Returns
    -------
    march(step_minus, step_plus, switching, rate, jump, p, run, x, carry, work, budget, rows, rows_x, hits, places)
    -> Status as int
        Takes up to `budget` steps from the state it is given, and leaves that state ready to go on: RUNNING means
        that the budget or a buffer is used up. x and carry are (d,), work is (2, d) scratch; see `state` for the
        records.
    """
    # numba looks for changes in this file only. The loop inlines others: a hash of them, being a closed-over
    # variable, becomes part of the key that numba caches under.
    modules = (arithmetic, crossing, signatures, state, trajectory)
    text = "\0".join(Path(str(m.__file__)).read_text(encoding="utf-8") for m in modules)
    inlined = hashlib.sha256(text.encode()).hexdigest()

    @njit(_signature(), cache=True, nogil=True, error_model="numpy")
    def march(
        step_minus, step_plus, switching, rate, jump, p, state, x, carry, work, budget,
        rows, rows_x, hits, places,
    ):  # fmt: skip
        inlined  # noqa: B018 - see above
        run = state[0]
        dx, trial = work[0], work[1]
        run.rows = 0
        run.hits = 0
        for _ in range(budget):
            if run.rows == rows.size or run.hits + 64 > hits.size:
                return RUNNING
            h = (run.t_end - run.t) - run.t_carry
            last = abs(h) <= abs(run.tau) * _STRETCH
            if not last:
                h = run.tau
            # Nearly every step is plain, and taken right here: a call with so many arrays costs more than the step.
            step = step_plus if run.side > 0 else step_minus
            t = run.t + run.t_carry
            count = step(t, h, x, carry, p, dx)
            bounded = count >= 0
            for i in range(x.size):
                trial[i] = x[i] + (carry[i] + dx[i])
                bounded = bounded and abs(trial[i]) < BOUND
            height, climb = run.side * switching(t + h, trial, p), run.side * rate(run.side, t + h, trial, p)
            if bounded and is_plain(run, height, climb):
                run.evaluations += count
                for i in range(x.size):
                    x[i], carry[i] = two_sum(x[i], carry[i] + dx[i])
            else:
                scheme = Scheme(step, switching, rate, run, x, carry, p, dx, trial)
                status = take_step(step_minus, step_plus, jump, scheme, Log(hits, places), h)
                if status != RUNNING:
                    return status
            run.steps += 1
            run.t, low = two_sum(run.t, h + run.t_carry)
            run.t_carry = low
            if last:
                run.t, run.t_carry = run.t_end, 0.0
            if run.record == 1:
                rows[run.rows].t = run.t
                rows[run.rows].side = run.side
                rows[run.rows].segment = run.crossings
                for i in range(x.size):
                    rows_x[run.rows, i] = x[i]
                run.rows += 1
            if last:
                return _COMPLETED
        return RUNNING

    return march  # type: ignore[no-any-return]
