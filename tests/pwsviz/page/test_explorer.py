"""The page without a browser: what it computes when, and what it shows."""

import gc
import weakref
from types import SimpleNamespace

import panel as pn
import pytest
from bokeh.core.validation.check import check_integrity
from bokeh.document import Document
from bokeh.models import Plot
from panel.io.document import _cleanup_doc
from panel.io.state import set_curdoc

import core
from pwsviz.figures.style import described
from pwsviz.page.explorer import ADDRESS_RESTS, WINDOW_RESTS, Explorer
from pwsviz.page.export_dialog import NOT_YET
from pwsviz.page.help import CHANGED
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query, read
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS, View
from pwsviz.tabs import Tab


def counts(explorer):
    return dict(explorer.results.computed)


def test_first_picture_computes_what_is_visible_and_no_more(explorer):
    once = {"backdrop": 1, "landmarks": 1, "plane": 1}
    assert counts(explorer) == {"run": 2, "orbit": 2, "error": 2, "summary": 2, "curve": 2, "warning": 2, **once}


def test_of_stability_the_part_shown_is_offered_as_a_picture_and_none_without_a_tangency(explorer):
    explorer.scene.use(core.CATALOGUE["damped_oscillator"])
    explorer.scene.param.update(t_end=2.0, methods=["rk4"], stability_part="drift", view="stability")
    assert explorer.settle(60)
    tab = explorer.views["stability"]
    assert explorer._pieces()[1].figures == [tab.view.figure("drift")]
    explorer.scene.stability_part = "grazing"
    assert explorer.settle(60)
    piece = explorer._pieces()[1]
    assert (piece.figures, piece.tables, piece.lack) == ([], {}, "this view has no figure.")


def test_what_only_looks_different_is_not_computed_anew(explorer):
    explorer.scene.param.update(peers=[], t_end=5.0, view="cost")
    assert explorer.settle(60)
    label = explorer.views["cost"].view.figure.yaxis[0].axis_label
    explorer.scene.cost_up = "invariant"
    assert explorer.settle(60)
    assert counts(explorer)["cost"] == 1
    assert explorer.views["cost"].view.figure.yaxis[0].axis_label != label


def test_tab_and_scene_agree(explorer):
    explorer.tabs.active = list(VIEWS).index("time")
    assert explorer.scene.view == "time"


def test_a_change_repaints_by_data_not_by_new_figures(explorer):
    figures = [explorer.portrait_panel.portrait.figure, explorer.views["conserved"].view.figure]
    models = [figure.references() for figure in figures]
    before = explorer.portrait_panel.portrait.orbits.data["xs"][0]
    explorer.scene.accept("tau", 0.05)
    explorer.scene.system = next(key for key in core.CATALOGUE if key != explorer.scene.system)
    explorer.settle(60)
    assert [figure.references() for figure in figures] == models
    assert explorer.portrait_panel.portrait.orbits.data["xs"][0] is not before


def test_bad_input_is_told_beside_the_field_and_the_picture_stays(explorer):
    shown = explorer.portrait_panel.portrait.orbits.data
    field = explorer.sidebar.tau
    field.type("minus one")
    explorer.settle(60)
    assert field.entry.complaint
    assert "not a number" in field.entry.complaint
    assert explorer.portrait_panel.portrait.orbits.data is shown
    field.type("0.02")
    assert not field.entry.complaint
    assert explorer.scene.tau == 0.02


def test_the_slider_and_the_entry_follow_each_other(explorer):
    field = explorer.sidebar.tau
    field.entry.place = -3.0
    assert explorer.scene.tau == 1e-3
    assert field.entry.text == "0.001"
    field.type("0.1")
    assert field.entry.place == pytest.approx(-1.0)


def test_no_integrator_chosen_is_refused_in_words(explorer):
    explorer.sidebar.methods.value = []
    assert "at least one" in explorer.sidebar.methods_message.object
    assert explorer.scene.methods == ["dmm2", "rk2"]


def test_another_system_brings_its_own_fields(explorer):
    explorer.scene.system = "harmonic_oscillator"
    names = [p.name for p in core.CATALOGUE["harmonic_oscillator"].parameters]
    assert list(explorer.sidebar.fields) == [*(f"values.{name}" for name in names), "x0.0", "x0.1"]


def test_the_fields_of_one_system_become_those_of_the_next(explorer):
    sidebar = explorer.sidebar
    before = dict(sidebar.fields)
    complained = before["values.a_plus"]
    complained.type("?")
    explorer.scene.system = "pendulum"
    assert list(sidebar.fields.values()) == list(before.values())  # three parameters and two coordinates, as before
    assert not complained.entry.complaint
    field = sidebar.fields["values.k_plus"]
    assert (field.entry.label, field.entry.text) == ("k₊", "9.8")
    assert (*field.entry.ends, field.entry.place) == (0.1, 30.0, 9.8)
    field.entry.place = 4.0
    assert explorer.scene.values["k_plus"] == 4.0
    explorer.scene.system = "gene_switch"
    assert sidebar.fields["x0.2"].entry.label == "initial z"
    explorer.scene.system = "elliptic_curve"
    assert list(sidebar.fields.values()) == list(before.values())
    assert explorer.scene.values == core.CATALOGUE["elliptic_curve"].values


def test_the_address_follows_a_zoom_sooner_than_a_slider(explorer, monkeypatch):
    delays = []
    monkeypatch.setattr(explorer.scheduler, "call_later", lambda delay, call, _: delays.append((delay, call)))
    explorer.scene.tau = 2e-3
    explorer.scene.window = (-1.0, 1.0, -1.0, 1.0)
    written = [delay for delay, call in delays if call == explorer._write_address]
    assert written == [ADDRESS_RESTS, WINDOW_RESTS]


def test_undo_brings_back_what_was_there(explorer):
    before = explorer.scene.settings()
    explorer.portrait_panel.starts.place(-0.5, 0.5)
    explorer.history.undo()
    explorer.settle(60)
    assert explorer.scene.settings() == before
    assert list(explorer.portrait_panel.portrait.starts.data["x"]) == [-1.0]


def test_a_preset_is_loaded_and_says_what_to_look_at(explorer):
    explorer.sidebar.presets.value = "vf_sliding"
    assert explorer.settle(60)
    assert explorer.scene.system == "type_sliding"
    assert "every run reaches" in explorer.sidebar.preset_note.object


def test_a_changed_example_is_said_to_be_changed_until_it_is_its_own_again(explorer):
    sidebar = explorer.sidebar
    sidebar.presets.value = "vf_sliding"
    explorer.settle(60)
    explorer.scene.view = "scheme"
    assert (sidebar.presets.value, CHANGED in sidebar.preset_note.object) == ("vf_sliding", False)
    explorer.scene.tau = 0.125
    assert (sidebar.presets.value, CHANGED in sidebar.preset_note.object) == ("", True)
    explorer.scene.tau = PRESETS["vf_sliding"].settings["tau"]
    assert (sidebar.presets.value, CHANGED in sidebar.preset_note.object) == ("vf_sliding", False)
    explorer.scene.system = "kepler"
    assert (sidebar.presets.value, sidebar.preset_note.object) == ("", "")


def test_a_system_of_ones_own_is_used_like_any_other(explorer):
    own = core.PiecewiseSystem(
        "<b>mine</b>", ("u", "v"), ("v", "-k*u"), ("v", "-u"), "v", parameters={"k": 3.0}, x0=(1.0, 1.0)
    )
    explorer._use(own)
    assert explorer.settle(60)
    assert explorer.portrait_panel.trouble.object == ""
    assert "Yours: <b>mine</b>" in explorer.sidebar.system.options
    explorer.sidebar.fields["values.k"].type("2")
    for view in VIEWS:
        explorer.scene.param.update(view=view, t_end=5.0, peers=[])
        assert explorer.settle(60)
        assert 'class="error"' not in explorer.view.words.object or view in ("order", "time")
    assert "<b>mine" not in explorer.portrait_panel.note.object + explorer.view.mathematics.object


def test_a_typed_system_is_computed_before_it_is_wanted(explorer):
    explorer.settle(60)
    explorer.edit()
    explorer.editor.texts["g"].value_input = "x + 0.125"
    assert explorer.editor.settle(60)
    assert explorer.settle(60)
    computed = explorer.results.computed["run"]
    assert explorer.scene.system == "elliptic_curve"
    explorer.editor.use.clicks += 1
    assert explorer.settle(60)
    assert explorer.scene.declaration.g == "x + 0.125"
    assert "crossings" in explorer.portrait_panel.status.object
    assert explorer.results.computed["run"] == computed


def test_a_link_is_adopted_and_what_is_wrong_with_it_is_told(explorer):
    explorer.adopt("?v=1&system=pendulum&tau=0.125&t_end=never&<script>=1")
    assert (explorer.scene.system, explorer.scene.tau) == ("pendulum", 0.125)
    assert "never" in explorer.notice.object
    assert "<script>" not in explorer.notice.object
    assert explorer.settle(60)


def test_the_first_hint_fits_mouse_and_finger(explorer):
    assert "click or tap in the portrait" in explorer.sidebar.preset_note.object


def test_a_complaint_about_a_link_goes_with_the_first_change_of_its_scene(explorer):
    explorer.adopt("?v=2&tau=2")
    assert "Step size" in explorer.notice.object
    explorer.scene.view = "order"
    explorer.scene.window = (-2.0, 2.0, -2.0, 2.0)
    assert "Step size" in explorer.notice.object
    explorer.scene.t_end = 5.0
    assert explorer.notice.object == ""


def test_what_is_taken_away_is_what_is_shown(explorer):
    explorer.scene.view = "order"
    explorer.settle(60)
    portrait, order = explorer._pieces()
    assert len(portrait.tables["curves"]()["t"]) == 2 * 2001
    assert portrait.figures == [explorer.portrait_panel.portrait.figure]
    for name in ("ψ = ψ(trajectory)", "S attracts", "S repels"):
        assert f"“{name}”" in portrait.meaning
    assert len(order.tables["errors"]()["error"]) > 20
    explorer.export.open("http://here/app")
    assert explorer.export.link.value.startswith("http://here/app?v=2")
    assert "core.integrate" in explorer.export.program.object


def test_the_export_says_that_a_view_is_not_computed_and_offers_its_files_when_it_is(explorer):
    explorer.scene.view = "order"
    explorer.scheduler.cancel("view")
    explorer.export.open("")
    _, row, _ = explorer.export.numbers
    assert [part.object for part in row] == ["Order", NOT_YET]
    explorer._again()
    assert explorer.settle(60)
    _, row, _ = explorer.export.numbers
    labels = [part.label for part in row[1:] if hasattr(part, "label")]  # beside a note that one of two is saved
    assert labels[:2] == ["CSV errors", "CSV fits"]
    explorer.scene.accept("values.a_minus", -2.5)  # of which nothing is computed: what is drawn is of other values
    assert explorer._pieces()[1].tables == {}


def test_all_panels_of_the_state_are_saved_as_one_picture(explorer):
    explorer.scene.accept("system", "relay_feedback")
    explorer.settle(60)
    assert explorer.scene.view == "state"
    _, state = explorer._pieces()
    assert [plot.yaxis.axis_label for plot in state.figures] == ["x", "v"]
    said = [described(plot) for plot in state.figures]
    assert [words.partition(" against time, ")[0] for words in said] == ["Coordinate x", "Coordinate v"]
    assert "v from" not in said[0], "each panel tells of its own coordinate"
    assert "x from" not in said[1]


def test_of_a_view_that_has_no_figure_no_picture_is_offered(explorer):
    explorer.scene.accept("system", "relay_feedback")
    explorer.scene.param.update(view="conserved", slide=False)  # it has no ψ, and no |Δg| of sliding
    assert explorer.settle(60)
    _, conserved = explorer._pieces()
    assert list(conserved.figures) == []


#: In two dimensions, in three, without ψ, with jumps, with two surfaces.
QUICK = ("elliptic_curve", "rigid_body", "gene_switch", "bouncing_ball", "two_walls")


def test_a_system_without_conserved_quantities_offers_what_can_be_used(explorer):
    explorer.scene.system = "relay_feedback"
    explorer.settle(60)
    assert explorer.sidebar.methods.options == ["rk2", "rk4", "rk8", "gauss4", "taylor"]
    assert explorer.sidebar.methods.value == ["rk2"]
    assert "need a conserved quantity" in explorer.sidebar.methods_note.object
    explorer.scene.system = "elliptic_curve"
    assert explorer.sidebar.methods.options == list(core.METHODS)
    assert explorer.sidebar.methods.value == ["dmm2", "rk2"]
    assert "need a conserved quantity" not in explorer.sidebar.methods_note.object


def test_the_tolerance_is_shown_with_an_integrator_that_has_one(explorer):
    field = explorer.sidebar.tolerance
    assert not field.entry.visible
    explorer.sidebar.methods.value = ["dmm2", "taylor"]
    assert field.entry.visible
    assert field.entry.ends is not None
    field.entry.place = -9.0
    assert explorer.scene.tolerance == 1e-9
    explorer.sidebar.methods.value = ["dmm2"]
    assert not field.entry.visible


def visit_and_leave():
    document = Document()
    with set_curdoc(document):
        explorer = Explorer(Scene(), Results())
        explorer.page().server_doc(document)
        explorer.settle(60)
    for callback in document.session_destroyed_callbacks:
        callback(SimpleNamespace(id="one", _document=document))
    _cleanup_doc(document)
    return weakref.ref(explorer)


def test_a_page_that_is_left_is_let_go():
    left = visit_and_leave()
    gc.collect()
    assert left() is None


def test_a_page_begins_with_the_portrait_alone(monkeypatch):
    furnish = []
    monkeypatch.setattr(type(pn.state), "onload", lambda _state, callback, **_options: furnish.append(callback))
    explorer = Explorer(Scene(), Results())
    document = Document()
    document.add_root(explorer.page().get_root(document))
    explorer.settle(60)
    assert list(document.select({"type": Plot})) == [explorer.portrait_panel.portrait.figure]
    for callback in furnish:
        callback()
    assert len(list(document.select({"type": Plot}))) == 2


def test_the_page_passes_the_checks_of_bokeh_that_the_server_leaves_out():
    explorer = Explorer(Scene(), Results())
    explorer.settle(60)
    document = Document()
    document.add_root(explorer.page().get_root(document))
    assert check_integrity(document.models).error == []


class StepSizeTab(Tab):
    """A view of one number, as somebody else might add it."""

    def inputs(self):
        """The step size is all that it shows."""
        return self.scene.tau

    def compute(self, inputs, cancel, report):
        """Nothing is left to compute."""
        return inputs

    def build(self):
        """No figure."""
        return []

    def draw(self, outcome):
        """Say it."""
        return f"The step size is {outcome:g}."

    def table(self):
        """One number."""
        return {"tau": [self.outcome]}

    def program(self):
        """Print it."""
        return f"print('tau', {self.scene.tau})"


def test_a_view_added_from_outside_is_in_the_page_in_links_and_in_the_export(monkeypatch):
    monkeypatch.setitem(VIEWS, "step", View("Step size", "run", f"{__name__}:StepSizeTab"))
    explorer = Explorer(Scene(t_end=1.0), Results())
    explorer.tabs.active = list(VIEWS).index("step")
    assert explorer.settle(60)
    assert "The step size is 0.01." in explorer.view.words.object
    assert read(query(explorer.scene)) == (explorer.scene.settings(), [])
    assert "Scheme, Step" in "".join(read("view=nonsense")[1])
    explorer.export.open("")
    assert "print(&#x27;tau&#x27;, 0.01)" in explorer.export.program.object
    assert [row[0].object for row in explorer.export.numbers] == ["Phase portrait", "Step size", "Equations"]
    explorer.close()


@pytest.mark.parametrize("view", ["order", "cost", "stability", "section"])
def test_what_a_study_does_at_crossings_stands_in_its_caption(explorer, view):
    explorer.scene.param.update(t_end=1.0, peers=[], perturbation_order=1, perturbation_scale=2.0, view=view)
    assert explorer.settle(60)
    how = explorer._pieces()[1].how
    assert "crossings located by Mannshardt’s transition scheme" in how
    assert ("sliding solution is followed" in how) == (view in ("stability", "section")), "no run of the others slides"
    assert ("their times perturbed by 2·τ" in how) == (view == "order"), "others do not perturb"
