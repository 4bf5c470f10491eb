"""Words on the page: exact figures, and never markup from outside."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.figures.summaries import method_notes, run_lines, run_warnings
from pwsviz.results.run_summary import Summary
from pwsviz.scene.names import LABELS, short_name
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import value_of
from pwsviz.text.words import as_text, complaint, duration, listed, plural, rounded_up


def summary(**changes):
    values = {
        "method": "dmm2", "steps": 60000, "met": core.Tally(1), "seconds": 0.00481,
        "worst_error": 8.2e-16, "status": core.Status.COMPLETED, "message": "",
    }  # fmt: skip
    return Summary(**(values | changes))


def test_a_run_in_one_line():
    words = re.sub("<.*?>", "", run_lines([summary()]))
    assert words == "dmm2: 60,000 steps, 1 crossing, max |Δψ| = 8.2×10⁻¹⁶", "a short time varies by far"
    words = re.sub("<.*?>", "", run_lines([summary(seconds=0.0481)]))
    assert words == "dmm2: 60,000 steps, 1 crossing, 48 ms, max |Δψ| = 8.2×10⁻¹⁶"
    words = re.sub("<.*?>", "", run_lines([summary(met=core.Tally(3, slides=2, ends=1))]))
    assert words.startswith("dmm2: 60,000 steps, 3 crossings, 2 slides, max")


def test_runs_that_stopped_say_why_once():
    stopped = summary(status=core.Status.ESCAPED, message="t = 1: ran away <b>")
    later = summary(method="rk2", status=core.Status.ESCAPED, message="t = 1.1: ran away <b>", t_end=1.1)
    lines = run_warnings([stopped, later, summary(message="fine")])
    assert lines.count("ran away &lt;b&gt;") == 1
    assert "dmm2: t = 1:" in lines
    assert "Likewise rk2 at t = 1.1." in lines
    touched = summary(method="rk4", status=core.Status.GRAZING, message="touched")
    assert run_warnings([touched, stopped]).index("touched") < run_warnings([touched, stopped]).index("ran away")
    assert "fine" not in lines
    other = summary(method="rk2", status=core.Status.ESCAPED, message="t = 1.1: blew up", t_end=1.1)
    lines = run_warnings([stopped, other])
    assert "Likewise" not in lines, "of one status, but not for one reason"
    assert "rk2: t = 1.1: blew up" in lines


def test_a_run_that_stops_early_refers_to_the_words_above_its_figures():
    stopped = summary(status=core.Status.ESCAPED, message="t = 1: ran away", t_end=1.0)
    assert "ends at t = 1 (see above)" in run_lines([stopped])
    assert "ran away" not in run_lines([stopped]), "the warnings come before all figures"


def test_what_several_messages_end_with_is_said_once():
    runs = [summary(), summary(method="rk2"), summary(method="rk4")]
    said = ["From t = 9 on, errors grow. Averages may be right.", "From t = 8 on, errors grow. Averages may be right."]
    lines = run_warnings(runs, [*said, "From t = 8 on, errors grow. Take a smaller τ."])
    assert lines.count("Averages may be right.") == 1
    assert "rk2: From t = 8 on, errors grow." in lines
    assert "rk4: From t = 8 on, errors grow." in lines
    assert lines.count("Take a smaller τ.") == 1


def test_integrators_that_are_left_out_are_named_with_the_reason():
    assert "dmm2, dmm4, dmm6, dmm8, prk8 and taylor conserve ψ to round-off." in method_notes(Scene())
    assert "conserve ψ" not in method_notes(Scene(system="gene_switch")), "none is known"
    assert "dmm2, dmm4, dmm6, dmm8 and prk8 need a conserved" in method_notes(Scene(system="gene_switch"))
    free = Scene(methods=["taylor"])
    assert "taylor chooses its own steps" in method_notes(free)
    assert "perturb" not in method_notes(free)
    free.perturbation_order = 2
    assert "perturb" in method_notes(free)


def test_names_are_listed_as_one_says_them():
    assert [listed(names) for names in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["", "a", "a and b", "a, b and c"]


def test_without_a_conserved_quantity_there_is_no_bound():
    assert "Δψ" not in run_lines([summary(worst_error=math.nan)])


def test_nothing_is_taken_for_markup():
    assert as_text("<script>alert(1)</script> & more") == (
        '<p class="">&lt;script&gt;alert(1)&lt;/script&gt; &amp; more</p>'
    )
    assert "<img" not in complaint(ValueError("<img src=x>"))
    assert "<img" not in complaint(RuntimeError("<img src=x>"))


@given(st.floats(1e-300, 1e300))
def test_a_bound_rounded_up_is_still_a_bound(value):
    assert value_of(rounded_up(value)) >= value * (1 - 1e-11)
    assert value_of(rounded_up(value)) <= 2.01 * value


def test_words_for_counts_and_times():
    assert plural(1, "step") == "1 step"
    assert plural(2000, "step") == "2,000 steps"
    assert duration(0.0048) == "4.8 ms"
    assert duration(0.0000984) == "0.098 ms"
    assert duration(0.2512) == "250 ms"
    assert duration(2.5) == "2.5 s"


@pytest.mark.parametrize(
    ("parameter", "shown"),
    [
        (core.Parameter("a_minus", 1.0), "a₋"),
        (core.Parameter("omega2_plus", 1.0, latex=r"\omega^2_{+}"), "ω₊²"),
        (core.Parameter("radius", 1.0, latex="r"), "r"),
        (core.Parameter("k", 1.0), "k"),
        (core.Parameter("k12", 1.0), "k₁₂"),
        (core.Parameter("strange", 1.0, latex=r"\frac{1}{2}"), "strange"),
    ],
)
def test_parameters_are_named_as_plain_text_can(parameter, shown):
    assert short_name(parameter) == shown


def test_texts_of_systems_presets_and_integrators_have_the_apostrophe_of_print():
    systems = [
        text for one in core.CATALOGUE.values() for text in (one.name, one.doc, *(q.doc for q in one.parameters))
    ]
    presets = [text for one in PRESETS.values() for text in (one.title, one.look, one.try_)]
    texts = [*systems, *presets, *(one.doc for one in core.METHODS.values()), *LABELS.values()]
    assert [text for text in texts if "'" in text] == []
