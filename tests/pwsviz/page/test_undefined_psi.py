"""A run that starts where ψ is not defined is drawn without ψ, and the page says so; no view fails over it."""

import numpy as np
import pytest

import core
from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene

#: ψ is a function of a stream function u, whose field is defined in the whole plane: x' = u_y, y' = −u_x.
SYSTEMS = {
    function: core.PiecewiseSystem(
        name=function, variables=("x", "y"), f_minus=("x", "-y"), f_plus=("2*y", "-1"), g="y - 2",
        psi_minus=(function.replace("u", "(x*y)"),), psi_plus=(function.replace("u", "(x + y**2)"),), x0=(1.0, 1.0),
    )
    for function in ("log(u)", "sqrt(u)", "1/u", "u*log(u)")
}  # fmt: skip
OUTSIDE = ((-1.0, 1.0), (0.0, 1.0))


def opened(system, **settings):
    scene = Scene()
    scene.use(system)
    scene.param.update(**settings)
    page = Explorer(scene, Results())
    page.refresh()
    assert page.settle(120)
    return page


@pytest.mark.parametrize("function", SYSTEMS)
@pytest.mark.parametrize("outside", OUTSIDE)
def test_every_view_of_a_run_outside_the_domain_of_psi_speaks(function, outside):
    system = SYSTEMS[function]
    page = opened(system, starts=(system.x0, outside), selected=1, t_end=2.0, tau=0.05)
    panel = page.portrait_panel
    assert panel.trouble.object == ""
    assert len(panel.shown.orbits) == len(panel.shown.others) == 2
    undefined = not np.isfinite(system.conserved("-", 0.0, outside)).all()
    assert undefined == ("ψ is not defined at start 2" in panel.status.object)
    for view in ("conserved", "state", "section", "scheme"):
        page.scene.view = view
        page.refresh()
        assert page.settle(120)
        assert "failed" not in page.view.words.object
        assert "Computing" not in page.view.words.object
    assert undefined == ("ψ is not defined along the run of rk2" in page.views["conserved"].words.object)
    page.close()


def test_a_start_outside_the_domain_of_psi_leaves_the_others_as_they_were():
    predators = core.CATALOGUE["predator_prey"]
    page = opened(predators, starts=((0.5, 1.0), (-0.5, 1.0)), methods=["rk2"])
    first, panel = page.portrait_panel.shown.orbits[0], page.portrait_panel
    assert first.levels == Results().orbit(panel.shown.inputs.selected[0]).levels
    assert all(values for _, values in first.levels)
    assert "ψ is not defined at start 2: no level set passes through it" in panel.status.object
    page.close()


def test_psi_that_ceases_to_be_defined_on_the_way_is_told_from_then_on():
    circle = core.PiecewiseSystem(
        name="Circle", variables=("x", "y"), f_minus=("y", "-x"), f_plus=("y", "-x"), g="y - 5",
        psi_minus=("log(1.1 - x**2 - y**2)",), psi_plus=("x**2 + y**2",), x0=(1.0, 0.0),
    )  # fmt: skip
    page = opened(circle, methods=["rk2"], t_end=5.0, tau=0.5)
    last = int(np.log(1.1) / np.log1p(0.5**4 / 4))  # each step of rk2 makes x² + y² greater by the factor 1 + τ⁴/4
    told = page.views["conserved"].words.object
    assert f"ψ is not defined along the run of rk2 from t = {0.5 * (last + 1):g} on" in told
    assert "not defined" not in page.portrait_panel.status.object
    page.close()
