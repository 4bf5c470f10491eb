"""The short caption, and where runs ended: what a reader has to know, in few lines."""

import pytest

import core
from pwsviz.export.about import about
from pwsviz.export.caption import caption, short_caption
from pwsviz.export.endings import endings
from pwsviz.export.tables import DrawnRun
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import OWN_SYSTEMS

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}


def scene_of(system):
    scene = Scene()
    scene.use(system)
    return scene


@pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))
def test_it_is_short_for_every_system_and_names_every_parameter(system):
    told = short_caption(scene_of(system), "Phase portrait")
    assert told.startswith(f"Phase portrait of the system “{system.name}”")
    assert len(told) < 270, "six lines of a column"
    assert sum(told.count(f" {sign} ") for sign in "=≈≤") >= len(system.parameters) + 2


def test_a_rounded_value_of_a_parameter_is_marked_as_such():
    scene = scene_of(core.CATALOGUE["chua"])
    assert "α = 9, β = 100/7," in short_caption(scene, "State")
    scene.accept("values.beta", 14.2345678)
    assert "β ≈ 14.235," in short_caption(scene, "State")


def test_crossings_that_are_perturbed_or_not_located_are_told():
    scene = Scene(perturbation_order=2)
    assert "times perturbed by τ²" in short_caption(scene, "Phase portrait")
    scene = Scene(locate=False)
    assert "Crossings not located." in short_caption(scene, "Phase portrait")
    assert "rossings" not in short_caption(Scene(), "Phase portrait")


def test_what_happens_at_crossings_is_told_only_if_there_are_some():
    assert "Crossings located by Mannshardt’s transition scheme." in caption(Scene(), "Phase portrait")
    assert "rossings" not in caption(Scene(), "Phase portrait", met=False, slid=False)


def test_each_part_of_a_caption_is_a_sentence():
    told = caption(Scene(), "Phase portrait")
    begins = [one.split()[0] for one in told.split(". ")]
    assert begins == ["Phase", "For", "For", "S", "Parameters:", "Initial", "Integrated", "Crossings", "On"]


def test_of_a_study_it_has_the_first_clause_and_the_integrator():
    told = short_caption(Scene(), "Order", how="integrated by dmm2; reference: exact. A rule.")
    assert told.endswith("Integrated by dmm2.")
    told = short_caption(Scene(), "Sweep", how="diagram of x; each run begins at the start; integrated by dmm2 with τ")
    assert told.endswith("Diagram of x. Integrated by dmm2 with τ.")


def test_a_run_that_ended_early_is_told_with_its_time_everywhere():
    system = core.CATALOGUE["bouncing_ball"]
    run = core.integrate(system, (0.0, 5.0), tau=0.01)
    told = endings([DrawnRun(1, run)])
    assert told == "The run ends at t = 1.35526, where jumps accumulate (Zeno)"
    scene = scene_of(system)
    for words in (caption(scene, "State", endings=told), short_caption(scene, "State", endings=told)):
        assert "ends at t = 1.35526" in words
    assert "ends at t = 1.35526" in about(scene, endings=told)["integration"]
    whole = core.integrate(system, (0.0, 1.0), tau=0.01)
    assert endings([DrawnRun(1, whole)]) == ""
    assert endings([DrawnRun(1, whole), DrawnRun(2, run)]).startswith("dmm2 from start 2 ends at t = 1.35526, ")
    assert endings([DrawnRun(1, run), DrawnRun(2, run)]) == told.replace("The run ends", "Both runs end")
    assert endings([DrawnRun(k, run) for k in range(1, 6)]) == "All 5 runs end before that, at t = 1.35526"
