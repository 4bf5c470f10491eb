"""Messages of `core` as the page says them: no argument of Python, and the name of the control that there is."""

import inspect
import re

import pytest

import core
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.names import LABELS
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import never
from pwsviz.text.advice import on_page, without_advice

ENGLISH = {"system", "method", "parameters", "variables", "transition"}
ARGUMENTS = {
    name
    for made in (core.integrate, core.PiecewiseSystem, core.order_study)
    for name in inspect.signature(made).parameters
} - ENGLISH
"""Names of arguments; those left out are words of English, too."""


def of_python(words):
    """Return what only a program can follow: names of arguments in brackets, with an underscore, or with a value."""
    named = {name for name in ARGUMENTS if re.search(rf"\({name}\)|\b{name}=", words)}
    return named | {name for name in ARGUMENTS if "_" in name or name == "tau" if re.search(rf"\b{name}\b", words)}


@pytest.mark.parametrize("status", list(core.Status))
def test_no_advice_on_the_page_names_an_argument_of_python(status):
    for words in (status.advice, status.advice_while_sliding, status.advice_without_tau):
        assert not of_python(on_page(words)), on_page(words)


def test_a_run_that_stops_to_slide_names_the_control_of_the_page():
    scene = Scene(system="coulomb_friction", slide=False)
    [inputs] = run_inputs(scene)[:1]
    message = Results().summary(inputs, never).message
    assert not of_python(message)
    [quoted] = re.findall("“(.*?)”", message)
    assert LABELS["slide"].startswith(quoted)


def test_a_state_is_written_as_on_the_page():
    assert on_page("x0 = (0.5, 0.0, -10.0, 1e-05): the field has no finite value there") == (
        "(0.5, 0, -10, 1e-05): the field has no finite value there"
    )
    assert on_page("x0 = (2.0,) lies in a region") == "(2) lies in a region"


def test_bounds_and_fields_are_named_by_their_symbols():
    assert on_page("tau = 0.1 exceeds the bound tau_-^* = 0.02; take tau below 0.02") == (
        "τ = 0.1 exceeds the bound τ₋* = 0.02; take τ below 0.02"
    )
    assert on_page("f_minus is not defined: (u**2)**0.75 for u**1.5.") == "f₋ is not defined: (u^2)^0.75 for u^1.5."


def test_a_message_about_a_state_names_the_variables_by_their_symbols():
    assert (
        on_page("t = 6, phi = 1, y1 = 2, v = 3: the end", ("phi", "y1", "v")) == "t = 6, φ = 1, y₁ = 2, v = 3: the end"
    )


def test_terms_that_cancel_are_named_by_their_symbols():
    said = "The terms of omega' cancel, … write psi so that its terms do not cancel, such as (x - a)**3 in place of …"
    told = "The terms of ω' cancel, … write ψ so that its terms do not cancel, such as (x − a)³ in place of …"
    assert on_page(said, ["omega"]) == told


def test_sizes_of_variables_are_told_by_their_symbols():
    said = "phi is about 2,000 times as large as y1: write the system in units in which all are of about one size"
    assert on_page(said, ["phi", "y1"]).startswith("φ is about 2,000 times as large as y₁: write the system in units")


@pytest.mark.parametrize(
    ("message", "kept"),
    [
        (
            "The run passes the surface by less than its own error: the solution may meet, touch or miss it. If it "
            "touches it, no step size helps: change the initial condition or a parameter. Otherwise take a smaller τ.",
            "The run passes the surface by less than its own error: the solution may meet, touch or miss it.",
        ),
        ("τ exceeds the window: a second crossing cannot be excluded; take τ below 0.01.",
         "τ exceeds the window: a second crossing cannot be excluded."),
        ("The step is too long, so crossings may have been missed; take a smaller τ. Another sentence.",
         "The step is too long, so crossings may have been missed. Another sentence."),
        ("Nothing to do here.", "Nothing to do here."),
    ],
)  # fmt: skip
def test_captions_leave_out_what_a_warning_advises(message, kept):
    assert without_advice(message) == kept


@pytest.mark.parametrize("system", ["predator_prey", "coulomb_friction", "kepler", "stick_slip"])
def test_where_crossings_are_not_located_a_warning_advises_to_locate_them_and_nothing_else(system):
    scene = Scene(system=system, locate=False)
    scene.param.update(methods=["rk4"], tau=0.3)
    [words] = Results().warnings(tuple(run_inputs(scene)[:1]))
    assert words.endswith(". First switch on “Locate crossings”.")
    assert LABELS["locate"].startswith("Locate crossings")
    assert not re.search("[Tt]ake|[Gg]ive", words)
    assert not re.search("[Tt]ake|Locate", without_advice(words)), "captions have no advice"
