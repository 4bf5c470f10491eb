"""The controls: which have an effect."""

import pytest

import core
from pwsviz.page.sidebar import NO_SLIDE_AT_INSTANTS, NO_SLIDE_AT_JUMPS, Sidebar
from pwsviz.scene.names import LABELS
from pwsviz.scene.scene import Scene
from tests.pwsviz.own_systems import KICKED, OWN_SYSTEMS, SQUARE_WAVE


def test_sliding_is_not_offered_where_the_law_changes_at_instants_only_or_the_state_jumps():
    scene = Scene()
    sidebar = Sidebar(scene, lambda: None)
    assert sidebar.at_surface.barred == {}
    for system in (SQUARE_WAVE, KICKED):
        scene.use(system)
        assert sidebar.at_surface.barred == {LABELS["slide"]: NO_SLIDE_AT_INSTANTS}
    scene.accept("system", "bouncing_ball")
    assert sidebar.at_surface.barred == {LABELS["slide"]: NO_SLIDE_AT_JUMPS}
    scene.accept("system", "coulomb_friction")
    assert sidebar.at_surface.barred == {}


@pytest.mark.parametrize("system", [*core.CATALOGUE.values(), *OWN_SYSTEMS.values()], ids=lambda one: one.name)
def test_sliding_is_offered_wherever_runs_take_it(system):
    scene = Scene()
    scene.use(system)
    offered = not Sidebar(scene, lambda: None).at_surface.barred
    assert offered == scene.slides
