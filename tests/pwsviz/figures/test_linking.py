"""Pointing at a crossing in one view marks it in the other; what the browser makes of it is tested in tests/browser."""

from bokeh.events import MouseLeave

from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.linking import link_crossings
from pwsviz.figures.portrait import PortraitView


def test_links_of_the_views_name_the_sources_of_both():
    portrait, conserved = PortraitView(*[lambda *_told: None] * 5), ConservedView()
    link_crossings(portrait, conserved)
    for view in (portrait, conserved):
        *_, left = view.figure.js_event_callbacks[MouseLeave.event_name]
        for callback in (view.hover.callback, left):
            assert callback.args["portrait"] is portrait.pointed
            assert callback.args["conserved"] is conserved.pointed
