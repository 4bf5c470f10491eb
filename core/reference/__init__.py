"""Solutions to measure others against: exact ones where a closed form is known, else an external solver's."""

from core.reference.declared import reference_solution
from core.reference.exact import ExactSolution, exact_solution
from core.reference.external import external_solution
from core.reference.solution import ReferenceSolution, Solution

__all__ = [
    "ExactSolution",
    "ReferenceSolution",
    "Solution",
    "exact_solution",
    "external_solution",
    "reference_solution",
]
