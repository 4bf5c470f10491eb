"""Expressions: the whitelist parser, tests whether one is zero, laws, the discrete gradient and multiplier."""

from core.symbolic.declaration import Declaration, Verdict
from core.symbolic.declared_texts import SIDES, Problem, RegionText, TransitionText
from core.symbolic.entry_checks import miscounted
from core.symbolic.expressions import OPERATORS, TIME, parse
from core.symbolic.impacts import keeps
from core.symbolic.laws import Laws, Way
from core.symbolic.mode import Mode
from core.symbolic.multiplier import DIFFERENCES, DividedDifference
from core.symbolic.sliding import eliminated
from core.symbolic.source_text import quoted, to_text
from core.symbolic.switching_terms import Found, read_switching
from core.symbolic.zero_testing import is_larger

__all__ = [
    "DIFFERENCES",
    "OPERATORS",
    "SIDES",
    "TIME",
    "Declaration",
    "DividedDifference",
    "Found",
    "Laws",
    "Mode",
    "Problem",
    "RegionText",
    "TransitionText",
    "Verdict",
    "Way",
    "eliminated",
    "is_larger",
    "keeps",
    "miscounted",
    "parse",
    "quoted",
    "read_switching",
    "to_text",
]
