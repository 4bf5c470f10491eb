"""Pointing at a crossing in one figure marks it in all; what the browser makes of it is tested in tests/browser."""

from bokeh.events import MouseLeave

from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.linking import link_crossings, link_portrait
from pwsviz.figures.portrait import PortraitView


def test_links_of_all_figures_name_the_marks_in_the_portrait_and_the_instant_that_all_show():
    portrait, conserved = PortraitView(*[lambda *_told: None] * 5), ConservedView()
    link_portrait(portrait)
    link_crossings(portrait, conserved, conserved.instants)
    for view in (portrait, conserved):
        *_, left = view.figure.js_event_callbacks[MouseLeave.event_name]
        for callback in (view.hover.callback, left):
            assert callback.args["portrait"] is portrait.pointed
            assert callback.args["instant"] is portrait.pointed_time
    assert portrait.pointed_time in conserved.figure.references()
