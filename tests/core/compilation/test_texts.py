"""Texts of modules: each is written once."""

import core
from core.codegen.functions import function_text
from core.compilation.texts import texts_of_modes


def test_a_further_mode_and_a_further_method_write_only_what_is_new(monkeypatch):
    system = core.PiecewiseSystem(
        name="Slides",
        variables=("x", "y"),
        g="y",
        x0=(1.0, 1.0),
        f_minus=("y", "2.75 - x"),
        f_plus=("1", "-0.375"),
        psi_minus=("(x - 2.75)**2 + y**2",),
        psi_plus=("3*x + 8*y",),
    )
    dmm2, rk2, written = core.METHODS["dmm2"], core.METHODS["rk2"], []
    for module in ("functions", "projection", "step"):
        monkeypatch.setattr(
            f"core.codegen.{module}.function_text", lambda *a: written.append(a[0]) or function_text(*a)
        )

    def new(*arguments):
        written.clear()
        assert list(texts_of_modes(system.laws, *arguments))
        return sorted(written)

    regions = ["evaluate_switching", *2 * ["level_residual", "project_to_surface", "set_levels", "step"]]
    assert new(dmm2, False, (0, 1)) == sorted(regions)
    assert new(dmm2, True, (0, 1)) == []
    assert new(rk2, True, (0, 1)) == 2 * ["project_to_surface"] + 2 * ["step"]
    assert new(dmm2, False, (0, 1, 2)).count("step") == 1
    assert new(dmm2, True, (0, 2)) == []
