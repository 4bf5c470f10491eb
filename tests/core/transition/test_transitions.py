"""Ways between regions that have names: a mode ends at once where it is entered beyond its guard; chains end."""

import itertools

import pytest

import core
from core import Region, Status, Transition

CHAIN = {
    jump: core.PiecewiseSystem(
        "chain", ("x",), regions={"A": Region(f=("1",)), "B": Region(f=("b",)), "C": Region(f=("c",))},
        transitions=(
            Transition("A", "1 - x", "B", ("x + 1",) if jump else None), Transition("B", "h - x", "C"),
            Transition("C", "x + 100", "A"),
        ),
        parameters={"b": 1.0, "c": 0.5, "h": 0.5}, x0=(0.0,),
    )
    for jump in (False, True)
}  # fmt: skip


@pytest.mark.parametrize("jump", [False, True])
@pytest.mark.parametrize("method", ["taylor", "rk4"])
def test_a_mode_entered_beyond_its_guard_ends_at_once_wherever_its_field_leads(jump, method):
    for b, c, h in itertools.product((1.0, -1.0, 0.0), (0.5, -0.5), (0.5, 0.99, 1 - 1e-9, 1 - 1e-12, -3.0)):
        run = core.integrate(CHAIN[jump].with_parameters(b=b, c=c, h=h), (0.0, 3.0), method=method)
        assert run.status is Status.COMPLETED, run.message
        assert [CHAIN[jump].modes[k].name for k in run.crossings.mode] == ["B", "C"]
        assert run.crossings.t == pytest.approx([1.0, 1.0], abs=1e-12)
        assert run.x[-1, 0] == pytest.approx((2.0 if jump else 1.0) + 2.0 * c, abs=1e-12)


def test_a_chain_of_modes_that_end_where_they_begin_is_zeno():
    endless = core.PiecewiseSystem(
        "endless", ("x",), regions={"A": Region(f=("1",)), "B": Region(f=("1",)), "C": Region(f=("1",))},
        transitions=(Transition("A", "1 - x", "B"), Transition("B", "-x", "C"), Transition("C", "-x", "B")),
    )  # fmt: skip
    run = core.integrate(endless, (0.0, 3.0), method="rk4")
    assert run.status is Status.ZENO
    assert run.t[-1] == pytest.approx(1.0, abs=1e-12)
    assert "from region to region here in no time: each one entered ends at once" in run.message
    assert "accumulate" not in run.message, "no crossing comes before the others"


def test_a_transition_may_lead_back_to_its_own_region():
    sawtooth = core.PiecewiseSystem(
        "sawtooth", ("x",), regions={"up": Region(f=("1",))}, transitions=(Transition("up", "1 - x", "up", ("x - 1",)),)
    )
    run = core.integrate(sawtooth, (0.0, 5.5), method="rk4", tau=0.3)
    assert run.status is Status.COMPLETED
    assert run.crossings.t == pytest.approx([1, 2, 3, 4, 5], abs=1e-12)
    assert run.x[-1, 0] == pytest.approx(0.5, abs=1e-12)


def test_stepping_over_two_surfaces_in_one_step_switches_at_both():
    stairs = core.PiecewiseSystem(
        "stairs", ("x",), surfaces=("x - 1", "x - 1.1"),
        regions={"--": Region(f=("1",)), "+-": Region(f=("2",)), "++": Region(f=("4",))},
    )  # fmt: skip
    run = core.integrate(stairs, (0.0, 2.0), (0.0,), method="rk4", tau=0.4, transition="none")
    assert run.status is Status.COMPLETED
    assert run.crossings.mode.tolist() == [1, 2]
    assert run.x[-1, 0] == pytest.approx(1.2 + 4 * 0.8, abs=1e-12)  # the third step ends at 1.2, beyond both
