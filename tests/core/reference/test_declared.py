"""reference_solution(): the right oracle for a declared system."""

import math

import numpy as np
import pytest

import core


def test_the_papers_systems_have_exact_solutions():
    t, x = core.reference_solution(core.CATALOGUE["elliptic_curve"]).crossing(30)
    assert t == pytest.approx(28.125879443188465221, abs=2e-14)
    assert x == pytest.approx([-0.44504186791262880858, -0.89550976309855955276], abs=4e-15) or x == pytest.approx(
        [-0.44504186791262880858, 0.89550976309855955276], abs=4e-15
    )
    t, _ = core.reference_solution(core.CATALOGUE["harmonic_oscillator"]).crossing(3)
    assert t == pytest.approx(np.pi / 4 + np.pi / np.sqrt(3) + np.pi, rel=4e-16)


def test_parameter_values_are_those_of_the_system():
    system = core.CATALOGUE["harmonic_oscillator"].with_parameters(omega2_plus=4.0)
    t, _ = core.reference_solution(system, (1.0, 0.5)).crossing(1)
    # x = cos 2t + sin 2t / 4: y vanishes where tan 2t = 1/4
    assert t == pytest.approx(np.arctan2(0.25, 1.0) / 2, rel=1e-15)


FORCED = core.PiecewiseSystem("forced", ("x", "y"), ("y", "-x + sin(t)"), ("y", "-x"), "x", x0=(1.0, 0.1))


def test_others_are_integrated_by_taylor_or_when_asked_by_scipy_and_say_so():
    ours, peer = core.reference_solution(FORCED), core.reference_solution(FORCED, independent=True)
    assert "Taylor" in ours.name
    assert "SciPy" in peer.name
    for k in (1, 5, 10):
        assert ours.crossing(k)[0] == pytest.approx(peer.crossing(k)[0], abs=1e-11)
        assert ours.crossing(k)[1] == pytest.approx(peer.crossing(k)[1], abs=1e-11)
    for t in (0.0, 0.3, 20.0, 5.0):  # in any order
        assert ours.state(t) == pytest.approx(peer.state(t), abs=1e-11)
        assert ours.side(t) == peer.side(t)


def test_exact_solutions_have_a_bound_below_round_off_and_the_others_an_estimate():
    exact = core.reference_solution(core.CATALOGUE["elliptic_curve"])
    exact.crossing(20)
    assert exact.exact
    assert 0.0 < exact.error < 1e-17
    peer = core.reference_solution(FORCED, independent=True)
    assert peer.error == pytest.approx(1e-12, rel=1e-9, abs=0)  # 10 × rtol 1e-13 × |x0| = 1
    ours = core.reference_solution(core.CATALOGUE["kepler"])
    ours.crossing(20)
    assert 0.0 < ours.error < 1e-10


def test_a_solution_that_ends_says_where_and_why():
    with pytest.raises(ValueError, match=r"ends at t = 0, .* reach|ends at t = 0, .*slides"):
        core.reference_solution(
            core.PiecewiseSystem("slide", ("x", "y"), ("1 + x**3", "1"), ("-1 - x**3", "1"), "x", x0=(0.0, 0.0))
        )


def test_pendulum_beside_an_oscillator_and_rigid_bodies_are_exact():
    pendulum = core.PiecewiseSystem("half", ("q", "p"), ("p", "-k*q"), ("p", "-k*sin(q)"), "q", parameters={"k": 9.8})
    assert core.reference_solution(pendulum, (0.3, 0.2)).name == "exact (Jacobi am, linear flow)"
    turn = ("a*y*z", "-z*x", "-x*y*0.5")
    body = core.PiecewiseSystem("body", ("x", "y", "z"), turn, turn, "x - 0.3", parameters={"a": 1.5})
    assert core.reference_solution(body, (0.0, 1.0, 1.2)).name == "exact (Jacobi sn, cn, dn)"


def test_a_system_that_jumps_is_exact_where_its_fields_are_and_else_an_estimate():
    declared = {"variables": ("y", "v"), "g": "y", "x0": (1.0, 0.0), "jump": ("0", "-r*v"), "parameters": {"r": 0.5}}
    ball = core.PiecewiseSystem("ball", f_minus=("v", "-9.8"), f_plus=("v", "-9.8"), **declared)
    solution = core.reference_solution(ball)
    assert solution.name == "exact (linear flow)"
    assert solution.after(1) == pytest.approx([0, np.sqrt(2 * 9.8) / 2], abs=4e-16)
    dragged = core.PiecewiseSystem("drag", f_minus=("v", "-9.8 + v**2"), f_plus=("v", "-9.8 + v**2"), **declared)
    solution = core.reference_solution(dragged)
    assert "Taylor" in solution.name
    # falls as v = −√g tanh(√g t), y = 1 − log cosh(√g t): it lands at cosh(√g t) = e
    t, x = solution.crossing(1)
    assert t == pytest.approx(np.arccosh(np.e) / np.sqrt(9.8), rel=1e-12)
    assert solution.after(1) == pytest.approx([0, -x[1] / 2], rel=1e-12)


@pytest.mark.parametrize("power", [90, 120, 1000, 1074])
def test_a_coordinate_far_below_the_others_grows_from_what_it_is(power):
    laws = {"f_minus": ("a", "-b"), "f_plus": ("0", "-1"), "g": "a - b - 1"}
    system = core.PiecewiseSystem("Saddle", ("a", "b"), **laws, x0=(2.0**-power, 1.0))
    solution, t = core.reference_solution(system), power * np.log(2.0) - 1.0
    assert solution.state(t)[0] == pytest.approx(np.exp(-1.0), rel=4e-16 * t)
    assert solution.exact
    assert solution.crossing(1)[0] == pytest.approx(t + 1.0, rel=1e-15)


def test_a_constant_far_below_the_others_counts():
    laws = {"f_minus": ("a + 1e-36*b", "-b"), "f_plus": ("0", "-1"), "g": "a - b - 1"}
    solution = core.reference_solution(core.PiecewiseSystem("Saddle", ("a", "b"), **laws, x0=(0.0, 1.0)))
    t = 83.0
    assert solution.state(t)[0] == pytest.approx(1e-36 * np.sinh(t), rel=1e-13)
    assert solution.exact


def test_a_solution_has_the_crossings_it_passes_before_it_ends():
    """It slides along y = 0 into the corner, where sliding ends; the field is linear up to a small forcing."""
    signs = {"--": ("1", "1"), "+-": ("-1", "1"), "-+": ("1", "-1"), "++": ("-1", "-1")}
    regions = {key: core.Region(f=(f[0], f"{f[1]} + 0.01*x*sin(t)")) for key, f in signs.items()}
    system = core.PiecewiseSystem("Cross", ("x", "y"), surfaces=("x", "y"), regions=regions, x0=(-2.0, -1.0))
    solution = core.reference_solution(system, sliding="continue")
    run = core.integrate(system, (0.0, 3.0), method="taylor", sliding="continue")
    assert run.crossings.kind.tolist() == ["sliding", "corner"]
    assert solution.crossing(1)[0] == pytest.approx(run.crossings.t[0], rel=1e-12)
    with pytest.raises(ValueError, match=r"before crossing 2: several surfaces are met .* neither does sliding"):
        solution.crossing(2)


@pytest.mark.parametrize(
    ("g", "pole"),
    [
        ("tan(x) - 1/2", math.pi / 2), ("2 + tan(x)/100", math.pi / 2), ("tan(t) + x**2 + 1", math.pi / 2),
        ("tan(2*x - 0.3) - y", math.pi / 4 + 0.15), ("1/(x - 1) + 2", 1.0), ("3 - 1/(x - 1)**3", 1.0),
        ("x - 3 + log(5 - t)", 5.0), ("1/(2*t - 5) - x - 1", 2.5),
        ("7/8 - 29*tan(11*x/8 - 1/8)/16 + 13*t/8", (math.pi / 2 + 1 / 8) * 8 / 11),  # crossed at 0.7001 before
    ],
)  # fmt: skip
def test_a_surface_with_a_pole_on_the_way_is_not_gone_beyond(g, pole):
    # The field is the same on both sides, so that x = t; beside a pole g rises, or falls, without a zero.
    system = core.PiecewiseSystem("pole", ("x", "y"), ("1", "0"), ("1", "0"), g, x0=(0.0, 0.0))
    reference = core.reference_solution(system)
    assert reference.state(0.9 * pole) == pytest.approx([0.9 * pole, 0.0])
    with pytest.raises(ValueError, match="g is not defined after t = ") as why:
        reference.state(1.001 * pole)
    assert float(str(why.value).rpartition(" ")[2]) == pytest.approx(pole, abs=1e-12)
