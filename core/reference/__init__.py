"""Reference solutions: exact where a closed form is known, else by the Taylor method or an external solver."""

from core.interface.cancelling import Cancelled
from core.reference.declared import reference_solution
from core.reference.exact import ExactSolution, exact_solution
from core.reference.external import Functions, external_solution, functions_of
from core.reference.laws_in_numbers import two_sides
from core.reference.solution import ReferenceSolution, Solution

__all__ = [
    "Cancelled",
    "ExactSolution",
    "Functions",
    "ReferenceSolution",
    "Solution",
    "exact_solution",
    "external_solution",
    "functions_of",
    "reference_solution",
    "two_sides",
]
