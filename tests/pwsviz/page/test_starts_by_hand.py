"""Gestures in the portrait change the starts, and what cannot be is said."""

import pytest

from pwsviz.geometry.plane import Plane
from pwsviz.geometry.window import Window
from pwsviz.page.starts_by_hand import at_point


def counts(explorer):
    return dict(explorer.results.computed)


def test_a_click_places_one_more_trajectory(explorer):
    explorer.portrait_panel.starts.place(-0.123456, 0.654321)
    explorer.settle(60)
    assert explorer.scene.starts == ((-1.0, -1.0), (-0.123, 0.654))
    assert explorer.scene.selected == 1
    assert list(explorer.portrait_panel.portrait.starts.data["x"]) == [-1.0, -0.123]
    assert len(explorer.portrait_panel.portrait.others.data["xs"]) == 2
    assert explorer.sidebar.fields["x0.0"].entry.text == "-0.123"


def test_a_dragged_start_moves_and_an_older_complaint_goes(explorer):
    coordinate = explorer.sidebar.fields["x0.0"]
    coordinate.type("?")
    assert coordinate.entry.complaint
    explorer.portrait_panel.starts.move(0, -0.8, 0.5)
    explorer.settle(60)
    assert explorer.scene.starts == ((-0.8, 0.5),)
    assert not coordinate.entry.complaint


def test_the_last_trajectory_cannot_be_removed_and_that_is_said(explorer):
    explorer.portrait_panel.starts.place(-0.5, 0.5)
    explorer.portrait_panel.starts.remove(0)
    assert explorer.scene.starts == ((-0.5, 0.5),)
    explorer.settle(60)
    explorer.portrait_panel.starts.remove(0)
    assert "has to stay" in explorer.portrait_panel.trouble.object


def test_looking_into_another_trajectory_computes_no_run(explorer):
    explorer.portrait_panel.starts.place(-0.5, 0.5)
    explorer.settle(60)
    runs = counts(explorer)["run"]
    explorer.scene.selected = 0
    explorer.settle(60)
    assert counts(explorer)["run"] == runs


@pytest.mark.parametrize("wait", [0, 20])
def test_a_double_click_fits_the_view_and_takes_back_what_its_first_click_placed(explorer, monkeypatch, wait):
    panel, scene, later = explorer.portrait_panel, explorer.scene, []
    frame, before = panel.portrait.frame, scene.settings()
    scene.window = (-9.0, 9.0, -9.0, 9.0)
    panel.starts.place(-1.5, 0.5)
    explorer.settle(wait)  # the second click may come before or after the first one's trajectory
    monkeypatch.setattr(explorer.scheduler, "call_soon", later.append)  # as where there is a server
    panel.portrait.hand.data = {"act": ["fit"], "index": [0], "x": [0.0], "y": [0.0], "count": [1]}
    for call in later:
        call()
    explorer.settle(60)
    assert scene.settings() == before
    assert panel.portrait.frame == frame
    monkeypatch.undo()
    panel.starts.place(-0.5, 0.5)
    explorer.settle(60)
    assert panel.portrait.frame == frame, "the next start does not move it"


def test_a_place_is_rounded_to_about_a_pixel_and_what_is_not_shown_stays():
    window = Window(0, 5000, 0, 10)
    assert at_point(1.23456, 2.0, window, (0.0, 0.0, 7.0)) == (1.0, 2.0, 7.0)
    assert at_point(1.23456, 2.0, window, (5.0, 6.0, 7.0), Plane((2, 0))) == (2.0, 6.0, 1.0)
