"""Solutions to measure others against: exact ones where a closed form is known, else a peer integrator's."""

from core.reference.declared import reference_solution
from core.reference.exact import ExactSolution, exact_solution
from core.reference.peer import peer_solution
from core.reference.solution import ReferenceSolution, Solution

__all__ = ["ExactSolution", "ReferenceSolution", "Solution", "exact_solution", "peer_solution", "reference_solution"]
