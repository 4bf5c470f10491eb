"""The time loop, runs in progress and completed, the error of ψ along a run, dense output, and how often a run
meets surfaces.
"""

from core.integration.conserved_error import largest_size
from core.integration.loops import LOOPS_BESIDE
from core.integration.runner import Runner
from core.integration.tally import KINDS
from core.integration.time_loop import compiled_march, march_signature
from core.integration.trajectory import COMPARED
from core.kernels.abi import Frame
from core.transition.records import HIT, ROW

__all__ = [
    "COMPARED", "HIT", "KINDS", "LOOPS_BESIDE", "ROW", "Frame", "Runner", "compiled_march", "largest_size",
    "march_signature",
]  # fmt: skip
