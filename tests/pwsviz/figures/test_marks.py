"""Every run drawn has its crossings marked by kind, and its end if it stops early."""

import pytest

import core
from pwsviz.figures.marks import ENDS, crossing_columns, end_columns
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene


def pictures(preset, **changes):
    scene = Scene()
    scene.load({**PRESETS[preset].settings, **changes})
    return Results().pictures(PortraitInputs.of(scene))


def test_every_status_that_stops_a_run_has_a_mark():
    assert set(core.Status) - set(ENDS) == {
        core.Status.RUNNING, core.Status.COMPLETED, core.Status.CANCELLED, core.Status.CROSSING_LIMIT,
    }  # fmt: skip


@pytest.mark.parametrize("selected", [0, 2])
def test_every_start_has_its_marks_whichever_is_selected(selected):
    drawn = pictures("grazing", selected=selected)
    marks, ends = crossing_columns(drawn.numbered, 1 + selected), end_columns(drawn.numbered)
    assert 2 in marks["start"]
    assert 1 not in marks["start"], "it falls short"
    assert marks["chosen"] == [number == 1 + selected for number in marks["start"]]
    assert list(zip(ends["start"], ends["label"], strict=True)) == [(3, "end: grazing")]
    assert abs(ends["x"][0] - 0.5) < 1e-6


def test_each_of_six_sliding_runs_has_its_end_on_the_surface():
    ends = end_columns(pictures("vf_sliding").numbered)
    assert sorted(ends["start"]) == [1, 2, 3, 4, 5, 6]
    assert set(ends["label"]) == {"end: sliding"}
    assert max(map(abs, ends["y"])) < 1e-9
