"""The portrait draws what the arrays say, and passes on what the hand does."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from bokeh.core.properties import value
from bokeh.document import Document
from bokeh.events import Tap
from bokeh.models import ColumnDataSource

import core
from core.transition.status import CROSSING_KINDS
from pwsviz.figures.framing import OTHERS, extent
from pwsviz.figures.marks import KIND_MARKERS
from pwsviz.figures.orbit_lines import STRONG, starts_of_thin
from pwsviz.figures.portrait import POINTED_WIDTH, PortraitView
from pwsviz.figures.style import described
from pwsviz.geometry.phase_plane import backdrop
from pwsviz.geometry.plane import XY
from pwsviz.geometry.window import Window
from pwsviz.page.player import Player
from pwsviz.results.animation import frames
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene

TWO = ((-1.0, -1.0), (-0.5, 0.2))


@cache
def pictured(starts=TWO[:1], selected=0, axes=(0, 1), system="elliptic_curve", tau=0.01, t_end=20.0):
    scene = Scene(system=system, starts=starts, selected=selected, axes=axes, tau=tau, t_end=t_end)
    inputs = PortraitInputs.of(scene)
    return scene.declaration, Results().pictures(inputs)


class Watched(PortraitView):
    """A portrait that writes down what it passes on."""

    def __init__(self):
        self.told = []
        super().__init__(
            lambda window: None,
            lambda *place: self.told.append(("place", *place)),
            lambda *move: self.told.append(("move", *move)),
            lambda index: self.told.append(("remove", index)),
            lambda index: self.told.append(("select", index)),
        )

    def draw(self, starts=TWO[:1], selected=0, **options):
        """Show a picture of these starts."""
        system, pictures = pictured(starts, selected, **options)
        a, b = pictures.inputs.axes
        self.show_orbits(system, pictures, [(start[a], start[b]) for start in starts], selected)

    def do(self, act, index, x=0.0, y=0.0):
        """Say what the browser would."""
        count = self.hand.data["count"][0] + 1
        self.hand.data = {"act": [act], "index": [index], "x": [x], "y": [y], "count": [count]}


def test_the_view_holds_the_first_orbit_and_a_closed_surface():
    _, pictures = pictured()
    assert extent(pictures).covers(Window.around(pictures.orbits[0].path))
    assert extent(pictures).covers(Window(-1.0, 1.0, -1.0, 1.0))


def test_the_view_holds_trajectories_from_other_starts_but_none_that_is_far():
    _, pictures = pictured(TWO, 1)
    assert extent(pictures).covers(Window.around(pictures.others[0].path))
    first = Window.around(pictures.orbits[0].path)
    far = np.array([[first.x_high + OTHERS * 5 * first.width, 0.0]])
    away = [replace(one, path=far, focus=far) for one in pictures.others]
    there = [replace(one, path=at, focus=at) for one in pictures.others for at in [np.array([one.start])]]
    assert extent(replace(pictures, others=away)) == extent(replace(pictures, others=there))


def test_the_view_suits_the_trajectory_that_stays_though_another_is_selected():
    _, one = pictured(((-1.0, -1.0),))
    _, pictures = pictured(((-1.0, -1.0), (1.4, 1.4)), 1)
    assert pictures.orbits[0].runs_off
    assert extent(pictures).width < 2 * extent(one).width


def test_the_view_holds_every_start():
    starts = ((1.5, 2.0), (-1.0, -0.5), (-1.2, 0.0))
    for selected in range(3):
        _, pictures = pictured(starts, selected)
        assert extent(pictures).holds(np.array(starts)).all()


def test_a_curve_that_runs_off_leaves_the_view_and_its_end_is_marked_where_it_is():
    scene = Scene(starts=((1.5, 2.0),), methods=["dmm2", "rk2"], t_end=5.0)
    pictures = Results().pictures(PortraitInputs.of(scene))
    view = extent(pictures).scaled(3.0)
    for orbit in pictures.orbits:
        assert orbit.end.status is core.Status.ESCAPED
        assert orbit.end.place[1] > 1e4
        assert not view.holds(orbit.path[-1:]).any(), "nor does it end on a screen three times as wide as high"
        pieces = np.linalg.norm(np.diff(orbit.path, axis=0), axis=1)
        assert np.isfinite(pieces).all()


def test_other_starts_are_drawn_thinner_and_the_legend_names_each_integrator_once():
    view = Watched()
    view.draw(TWO, 1)
    assert view.orbits.data["method"] == view.others.data["method"] == ["dmm2", "rk2"]
    assert all(np.less(view.others.data["width"], view.orbits.data["width"]))
    named = [renderer for item in view.figure.legend[0].items for renderer in item.renderers]
    assert [renderer.data_source for renderer in named].count(view.methods) == 1
    assert view.methods.data["method"] == ["dmm2", "rk2"]


def test_stars_are_numbered_and_the_selected_one_is_the_largest():
    view = Watched()
    view.draw(TWO, 1)
    stars = view.starts.data
    assert list(zip(stars["x"], stars["y"], strict=True)) == list(TWO)
    assert (stars["number"], stars["chosen"]) == (["1", "2"], [False, True])
    assert stars["size"][1] > stars["size"][0]


def test_marks_tell_number_time_kind_and_integrator():
    view = Watched()
    view.draw()
    _, pictures = pictured()
    marks = view.crossings.data
    assert set(marks["start"]) == {1}
    assert list(marks["method"]) == [orbit.method for orbit in pictures.orbits for _ in orbit.kinds]
    assert np.array_equal(marks["time"], np.concatenate([orbit.times for orbit in pictures.orbits]))
    assert np.array_equal(marks["number"], np.concatenate([orbit.numbers for orbit in pictures.orbits]))
    assert set(marks["marker"]) == {KIND_MARKERS["transversal"]}
    assert set(KIND_MARKERS) == set(CROSSING_KINDS)


def test_the_legend_explains_the_dots_of_steps_where_there_are_some():
    view = Watched()
    (entry,) = [one for one in view.figure.legend[0].items if one.label == value("step")]
    for tau, marked in ((0.01, False), (0.3, True), (0.01, False)):
        view.draw(tau=tau)
        assert (len(view.steps.data["x"]) > 0) is marked
        assert entry.visible is marked


def test_steps_are_marked_until_a_run_returns_to_its_own_path_and_the_legend_says_so():
    view, period = Watched(), np.pi + np.pi / np.sqrt(3.0)  # half a turn at each of the two frequencies
    (entry,) = [one for one in view.figure.legend[0].items if one.label == value("step")]
    start = ((1.0, 0.0),)
    for end, label in ((4.0, "step"), (20.0, "step (first ones)")):
        system, pictures = pictured(start, system="harmonic_oscillator", tau=0.5, t_end=end)
        view.show_orbits(system, pictures, list(start), 0)
        first = pictures.orbits[0]
        assert first.method == "dmm2"
        assert len(first.steps) == 1 + int(min(end, period) / 0.5)
        assert entry.label == value(label)


def test_a_projection_is_named_on_the_axes():
    view, start = Watched(), ((0.0, 2.0, 1.0),)
    view.draw(start, system="rigid_body")
    view.draw(start, system="rigid_body", axes=(0, 2))
    assert view.figure.yaxis[0].axis_label == "y₃"
    assert "y₂ not shown" in view.figure.xaxis[0].axis_label
    assert view.starts.data["y"] == [1.0]


@pytest.mark.parametrize(
    ("act", "told"),
    [
        ("drag", ("move", 0, 0.5, -0.5)),
        ("drop", ("move", 0, 0.5, -0.5)),
        ("remove", ("remove", 0)),
        ("select", ("select", 0)),
    ],
)
def test_what_the_hand_does_is_passed_on(act, told):
    view = Watched()
    view.draw()
    view.do(act, 0, 0.5, -0.5)
    assert view.told == [told]


@pytest.mark.parametrize(
    ("act", "index", "x"), [("drag", 1, 0.0), ("remove", -1, 0.0), ("drag", 0, np.nan), ("explode", 0, 0.0)]
)
def test_what_cannot_be_is_not_passed_on(act, index, x):
    view = Watched()
    view.draw()
    view.do(act, index, x)
    assert view.told == []


def test_a_click_is_passed_on_unless_it_is_beside_the_frame():
    view = Watched()
    view.figure.x_range.update(start=-2.0, end=2.0)
    view.figure.y_range.update(start=-1.0, end=1.0)
    for x, y in ((0.5, 0.5), (-2.1, 0.0), (0.0, 1.1)):
        view.figure._trigger_event(Tap(view.figure, x=x, y=y))
    assert view.told == [("place", 0.5, 0.5)]


def test_the_view_stays_whatever_is_drawn_until_it_is_fitted():
    view, near, far = Watched(), TWO[:1], ((-1.0, -6.0),)
    view.draw(near)
    view.fit()
    before = view.frame
    view.do("drag", 0, *far[0])
    view.draw(far)
    view.do("drop", 0, *far[0])
    view.draw(far)
    assert view.frame == before
    view.fit()
    assert view.frame != before


def test_stars_are_sent_again_though_the_server_knows_no_change():
    view = Watched()
    view.draw()
    sent = []
    view.starts.on_change("data", lambda _attribute, _old, new: sent.append(new))
    view.do("drop", 0, 5.0, 5.0)  # a move the scene may have refused: only the browser has it
    view.show_starts(TWO[:1], 0)
    assert [(one["x"], one["heard"]) for one in sent] == [([-1.0], [1])]


def test_the_sentence_for_screen_readers_is_of_what_is_drawn():
    view = Watched()
    view.draw()
    assert "one trajectory, which starts at (−1, −1). dmm2: 21 crossings" in described(view.figure)
    view.draw(TWO, 1)
    assert "2 trajectories; number 2 starts at (−0.5, 0.2)" in described(view.figure)
    assert view.figure.html_attributes["role"] == "application"


def test_a_closed_player_makes_and_sends_nothing():
    player = Player(Watched())
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 1.0), tau=1e-2)
    player.show([frames(run, XY)])
    assert not player.wanted
    assert player.bar is None
    player.open = True
    assert player.wanted
    player.show([frames(run, XY)])
    assert np.array_equal(player.bar.ways[0]["t"], frames(run, XY).t)
    player.open = False
    player.show([frames(run, XY)])
    assert player.bar.ways == []


def test_what_a_parameter_does_not_change_in_the_backdrop_is_not_sent_again():
    view, system, window = Watched(), pictured()[0], Window(-2.0, 2.0, -2.0, 2.0)
    ground = view.ground
    sources = [*ground.levels.values(), *ground.arrows.values(), ground.side, ground.surface]
    before, after = [], []
    for a_minus, seen in ((-3.0, before), (-2.5, after)):
        view.show_backdrop(backdrop(system.with_parameters(a_minus=a_minus), window, {}))
        seen += [source.data for source in sources]
    assert [old is new for old, new in zip(before, after, strict=True)] == [False, True, False, True, True, True]


def test_a_surface_that_the_browser_may_have_moved_is_sent_again():
    view, system, window = Watched(), core.CATALOGUE["moving_interface"], Window(-2.0, 2.0, -2.0, 2.0)
    sent = []
    for source in (view.ground.side, view.ground.surface):
        source.on_change("data", lambda _attribute, _old, new: sent.append(new))
    for _ in range(2):
        view.show_backdrop(backdrop(system, window, {}))
    assert len(sent) == 4


def test_what_a_move_of_a_slider_leaves_as_it_is_is_not_sent_again():
    view, sent = Watched(), []
    view.draw(TWO)
    for source in (view.starts, view.others, view.crossings, view.methods):
        source.on_change("data", lambda _attribute, _old, new: sent.append(new))
    view.draw(TWO)
    assert sent == []


def test_every_source_of_the_portrait_is_sent_so_that_the_browser_hears_of_its_changes():
    view = PortraitView(*[lambda *_: None] * 5)
    document = Document()
    document.add_root(view.figure)
    held = {name: one for part in (view, view.ground) for name, one in vars(part).items()}
    sources = {name: one for name, one in held.items() if isinstance(one, ColumnDataSource)}
    apart = {"pointed_time", "played_time"}  # of the figures whose horizontal axis is time
    assert {name for name, source in sources.items() if source.document is not document} == apart


def test_the_legend_says_which_ends_lie_outside_the_view():
    view = Watched()
    view.draw(system="type_repelling", starts=((0.0, 0.0),))
    x, y, name = (view.ends.data[column][0] for column in ("x", "y", "label"))
    assert name.startswith("end: ")
    view.look_at(Window(x + 1, x + 2, y + 1, y + 2))
    assert set(view.ends.data["label"]) == {f"{name}, out of view"}
    view.look_at(Window(x - 1, x + 2, y - 1, y + 2))
    assert set(view.ends.data["label"]) == {name}


def test_a_curve_of_another_start_tells_its_number_and_the_selected_one_is_strong():
    view = Watched()
    view.draw(tuple((0.1 * k - 1.0, -1.0) for k in range(9)), 3, t_end=2.0)
    numbers = [1, 2, 3, 5, 6, 7, 8, 9]
    assert list(view.others.data["start"]) == [number for number in numbers for _ in ("dmm2", "rk2")]
    assert min(view.orbits.data["width"]) == pytest.approx(STRONG)
    hover = next(tool for tool in view.figure.tools if getattr(tool, "renderers", None) == [view.beside])
    assert "start @start" in hover.tooltips
    assert view.beside.hover_glyph.line_width == POINTED_WIDTH > max(view.others.data["width"])


def test_curves_of_bodies_alongside_tell_the_numbers_of_their_starts():
    scene = Scene(system="three_bodies", methods=["rk4"])
    scene.place(scene.starts[0])
    pictures = Results().pictures(PortraitInputs.of(scene))
    assert pictures.alongside
    assert starts_of_thin(pictures) == [1] + [2, 1] * len(pictures.alongside)
    assert len(starts_of_thin(pictures)) == len(pictures.thin)
