"""Machine code of generated text: made, loaded and freed."""

import gc

import numpy as np

import core
from core.compilation import compiled
from core.llvm.native import Native


def test_machine_code_is_freed_without_harm_to_other_code():
    system = core.CATALOGUE["harmonic_oscillator"]
    before = core.integrate(system, (0.0, 1.0), method="rk4").x
    (source, *_) = sorted((compiled._folder() / "__pycache__").glob("pws_*.step.*.o"))
    code = source.read_bytes()
    for _ in range(4):
        kept = [Native(code, "step", 1) for _ in range(5)]
        assert len({one.address for one in kept}) == 5
        del kept
        gc.collect()
    assert np.array_equal(core.integrate(system, (0.0, 1.0), method="rk4").x, before)
