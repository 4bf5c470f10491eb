"""A declaration is walked over once, whoever asks: everything wrong is told by its field."""

from dataclasses import replace
from typing import Any

import pytest

from core import PiecewiseSystem
from core.symbolic import Declaration, Problem, to_text
from tests.bounds import bounded_time

FIELDS = {
    "variables": ("x", "y"), "parameters": ("k",), "bounds": ((0.1, 10.0),),
    "f_minus": ("y", "-k*x"), "f_plus": ("y", "-x"), "g": ("y",), "psi_minus": ("k*x**2 + y**2",),
}  # fmt: skip


def oscillator(**changes: Any) -> Declaration:
    return Declaration.of_sides(**(FIELDS | changes))


def test_what_makes_sense_has_no_problems():
    assert oscillator().problems == ()
    assert [[verdict.objection for verdict in side] for side in oscillator().verdicts.values()] == [[""], []]


def test_all_problems_are_told_each_by_its_field_and_the_system_raises_the_first():
    changes: dict[str, Any] = {
        "parameters": ("k", "x"), "bounds": (None, None), "f_minus": ("y", "2x"), "f_plus": ("y",), "g": ("k",),
        "psi_plus": ("x", "y"), "jump": ("x", "-q*y"),
    }  # fmt: skip
    wrong = oscillator(**changes)
    assert [(problem.field, problem.entry) for problem in wrong.problems] == [
        ("parameters", None), ("f_plus", None), ("psi_plus", None), ("f_minus", 1), ("g", 0), ("jump", 1),
    ]  # fmt: skip
    laws = {name: changes[name] for name in ("f_minus", "f_plus", "psi_plus", "jump")}
    with pytest.raises(ValueError, match=r"parameters = \('k', 'x'\): the name 'x' is used twice") as caught:
        PiecewiseSystem("wrong", wrong.variables, g="k", parameters={"k": 1.0, "x": 1.0}, **laws)
    assert str(caught.value).endswith(wrong.problems[0].message)


def test_what_is_conserved_is_judged_on_each_side_whose_law_can_be_read():
    wrong = oscillator(f_plus=("y", "2x"), psi_minus=("x**2 + y**2",), psi_plus=("x",))
    assert [problem.field for problem in wrong.problems] == ["f_plus", "psi_minus"]
    assert wrong.verdicts["+"] == ()
    assert to_text(wrong.verdicts["-"][0].left_over) in wrong.verdicts["-"][0].objection


@pytest.mark.parametrize(
    ("g", "words"),
    [
        ("t - 3", None), ("sin(k*t)", None), ("t*(t - k)", None), ("y - t", None),
        ("k - 3", "names no variable and not t, so it has no zero: it has to contain one of t, x, y"),
        ("(t - 3)**2", "nowhere negative"), ("t**2 + 1", "positive everywhere"),
    ],
)  # fmt: skip
def test_a_law_may_switch_where_a_function_of_time_changes_its_sign(g, words):
    problems = oscillator(g=(g,)).problems
    assert len(problems) == (words is not None)
    assert all(problem.field == "g" and words in problem.message for problem in problems)


def test_messages_call_the_parts_as_they_are_asked_to():
    called = oscillator(psi_minus=("x",), called=lambda field, entry: f"<{field} {entry}>")
    (problem,) = called.problems
    assert problem.message.startswith("<psi_minus 0> = 'x' is not conserved by <f_minus None>")


def test_expressions_whose_derivatives_are_long_are_refused_where_that_is_asked_for():
    long = oscillator(f_plus=("y", "sin(x*y)*sin(x + y)*sin(x - y)"))
    assert long.problems == ()
    (problem,) = replace(long, longest=20).problems
    assert problem.field == "f_plus"
    assert "its derivatives are too long" in problem.message


def test_a_declaration_of_any_size_is_refused_soon():
    many = tuple(f"x{k}" for k in range(50_000))
    with bounded_time():
        problems = Declaration.of_sides(many, (), (), many, many, ("x1",), many, many).problems
    assert problems == (Problem("variables", "50000 variables: from 1 to 24 are possible"),)
