"""Gestures are attached where the browser can do so; what they do there is tested in tests/browser."""

from bokeh.events import MouseEnter
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from pwsviz.figures.gestures import GESTURES, attach_gestures


def test_gestures_are_attached_once_there_is_an_element_and_wherever_it_may_be_another():
    plot, starts = figure(), ColumnDataSource({name: [] for name in ("x", "y", "chosen", "heard")})
    hand = attach_gestures(plot, starts)
    callbacks = [*plot.js_property_callbacks["change:inner_width"], *plot.js_event_callbacks[MouseEnter.event_name]]
    assert [callback.code for callback in callbacks] == [GESTURES] * 2
    assert all(callback.args == {"plot": plot, "starts": starts, "hand": hand} for callback in callbacks)


def test_nothing_is_said_before_a_hand_has_acted():
    hand = attach_gestures(figure(), ColumnDataSource())
    assert (hand.data["act"], hand.data["count"]) == ([""], [0])
