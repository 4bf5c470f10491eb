"""Exact solutions of several regions: against matrix exponentials in 30 digits, and against what is found by hand."""

from itertools import product

import mpmath as mp
import numpy as np
import pytest

import core
from core import Region, Transition

DIGITS = 30
#: Distance between the times at which the oracle looks at guards: none changes its sign twice within it here.
SPACING = mp.mpf(1) / 32


class Piecewise:
    """z' = M z with z = (x, 1), in each mode another M; a mode ends where one of its normals n has n·z = 0.

    Modes map names to (M, [(n, the mode that follows, the matrix of the jump or None)]). No code of core is used.
    """

    def __init__(self, modes, mode, x0, end):
        with mp.workdps(DIGITS):
            self.modes = {name: (mp.matrix(m), [(mp.matrix([n]), *rest) for n, *rest in guards])
                          for name, (m, guards) in modes.items()}  # fmt: skip
            self.arcs = [(mp.mpf(0), mp.matrix([*map(mp.mpf, x0), 1]), mode)]
            while (found := self._next(*self.arcs[-1], mp.mpf(end))) is not None:
                self.arcs.append(found)

    def _next(self, t, z, mode, end):
        matrix, guards = self.modes[mode]
        step, h, y = mp.expm(matrix * SPACING), mp.mpf(0), z
        while t + h < end:
            y, h, before = step * y, h + SPACING, y
            for n, to, jump in guards:
                if (n * y)[0] < 0:
                    s, place = _root(n, matrix, before)
                    s += h - SPACING
                    return (t + s, place if jump is None else mp.matrix(jump) * place, to) if t + s < end else None
        return None

    def state(self, t):
        """State (d,) at time t."""
        with mp.workdps(DIGITS):
            begun, z, mode = next(arc for arc in reversed(self.arcs) if arc[0] <= t)
            return np.array([float(u) for u in (mp.expm(self.modes[mode][0] * (t - begun)) * z)[:-1]])


def _root(n, matrix, z):
    """Time after z at which n·z vanishes, by Newton's method, and z there."""
    s = mp.mpf(0)
    for _ in range(8):
        place = mp.expm(matrix * s) * z
        s -= (n * place)[0] / (n * matrix * place)[0]
    return s, mp.expm(matrix * s) * z


def chua():
    alpha, beta, a, b = 9, mp.mpf(100 / 7), mp.mpf(-8 / 7), mp.mpf(-5 / 7)

    def law(slope, offset):
        return [[-alpha * (1 + slope), alpha, 0, -alpha * offset], [1, -1, 1, 0], [0, -beta, 0, 0], [0] * 4]

    low, high = [1, 0, 0, 1], [1, 0, 0, -1]
    return Piecewise({
        "--": (law(b, b - a), [([-1, 0, 0, -1], "+-", None)]),
        "+-": (law(a, 0), [(low, "--", None), ([-1, 0, 0, 1], "++", None)]),
        "++": (law(b, a - b), [(high, "+-", None)]),
    }, "+-", (0.1, 0.1, 0), 20)  # fmt: skip


def thermostat():
    loss, storage = mp.mpf(0.2), mp.mpf(0.5)

    def law(power):
        return [[-1 - loss, 1, -10 * loss], [storage, -storage, power], [0] * 3]

    on, off = [-1, 0, 1], [1, 0, 1]
    return Piecewise({"on": (law(4), [(on, "off", None)]), "off": (law(0), [(off, "on", None)])}, "on", (-2, 0), 20)


def two_walls():
    jump = [[1, 0, 0], [0, -mp.mpf(0.95), 0], [0, 0, 1]]
    guards = [([1, 0, 1], "+-", jump), ([-1, 0, 1], "+-", jump)]
    return Piecewise({"+-": ([[0, 1, 0], [-1, 0, 0], [0] * 3], guards)}, "+-", (0, 2), 12)


def gene_ring():
    modes = {}
    for signs in product("-+", repeat=3):
        rows = [[0] * 4 for _ in range(4)]
        guards = []
        for k in range(3):
            rows[k][k], rows[k][3] = -1, 2 if signs[k - 1] == "-" else 0
            s = 1 if signs[k] == "+" else -1
            to = "".join("-+"[s < 0] if i == k else v for i, v in enumerate(signs))
            guards.append(([s * (i == k) for i in range(3)] + [-s], to, None))
        modes["".join(signs)] = (rows, guards)
    return Piecewise(modes, "---", (0, 0.3, 0.6), 5)


@pytest.mark.parametrize("oracle", [chua, thermostat, two_walls, gene_ring], ids=lambda make: make.__name__)
def test_linear_regions_of_the_catalogue_are_exact_in_every_mode(oracle):
    system, expected = core.CATALOGUE[oracle.__name__], oracle()
    solution = core.reference_solution(system)
    for k, (t, z, mode) in enumerate(expected.arcs[1:], start=1):
        assert abs(solution.crossing(k)[0] - t) <= np.spacing(float(t))
        assert np.abs(solution.after(k) - np.array(z[:-1], dtype=float)).max() <= 1e-15 * float(max(map(abs, z)))
        assert system.laws.name(solution.entered(k)) == mode
        assert solution.side(float(t) + 1e-9) == solution.entered(k)
    ends = [float(arc[0]) for arc in expected.arcs]
    for t in (np.array(ends[1:]) + ends[:-1]) / 2:
        assert np.abs(solution.state(t) - expected.state(t)).max() <= 1e-15 * np.abs(expected.state(t)).max()
    assert len(ends) > 5
    assert solution.name == "exact (linear flow)"
    assert solution.exact
    assert 0.0 < solution.error < 1e-17


def plane(regions, **declared):
    return core.PiecewiseSystem("plane", ("x", "y"), surfaces=("x", "y"), regions=regions, **declared)


def all_round(**fields):
    """Constant fields in the four quadrants."""
    return plane({key: Region(f=f) for key, f in fields.items()}, x0=(-1.0, -2.0))


FLOW = dict.fromkeys(("--", "-+", "+-", "++"), ("1", "2"))


def test_a_corner_is_passed_where_all_fields_around_lead_the_same_way_out():
    solution = core.reference_solution(all_round(**FLOW))
    assert solution.crossing(1)[0] == 1.0
    assert solution.entered(1) == 3
    assert np.array_equal(solution.state(3.0), [2.0, 4.0])
    assert solution.exact


def test_at_a_corner_without_a_way_out_the_solution_ends_in_words():
    solution = core.reference_solution(all_round(**{**FLOW, "+-": ("1", "-2")}))
    with pytest.raises(ValueError, match=r"ends at t = 1,.*several surfaces at once, and .* more than one way"):
        solution.crossing(1)
    repelled = core.reference_solution(all_round(**{**FLOW, "++": ("-1", "-2"), "-+": ("-1", "-2"), "+-": ("-1", "1")}))
    with pytest.raises(ValueError, match=r"ends at t = 1,.*several surfaces at once, and"):
        repelled.crossing(1)


def test_a_corner_left_along_one_of_its_surfaces_is_passed_by_sliding():
    # "++" points back to x = 0, "-+" on to it: from the corner it slides up x = 0, by Filippov's weights at rate 2.
    system = all_round(**{**FLOW, "++": ("-1", "2")})
    with pytest.raises(ValueError, match=r"ends at t = 1,.*slides along the surface"):
        core.reference_solution(system).crossing(1)
    solution = core.reference_solution(system, sliding="continue")
    assert system.laws.name(solution.entered(1)) == "0+"
    assert np.array_equal(solution.state(3.0), [0.0, 4.0])


@pytest.mark.parametrize("miss", [1e-3, 1e-9, 2.0**-52])
def test_a_corner_missed_by_a_little_is_two_crossings(miss):
    solution = core.reference_solution(all_round(**FLOW), (-1.0, -2.0 + 2 * miss))
    assert [solution.entered(k) for k in (1, 2)] == [1, 3]
    assert [solution.crossing(k)[0] for k in (1, 2)] == [1.0 - miss, 1.0]


def test_a_start_on_a_corner_follows_the_fields():
    solution = core.reference_solution(all_round(**FLOW), (0.0, 0.0))
    assert np.array_equal(solution.state(2.0), [2.0, 4.0])


def test_the_end_of_declared_laws_ends_the_solution_in_words():
    system = plane({"--": Region(f=("1", "0")), "+-": Region(f=("1", "1"))}, x0=(-1.0, -2.0))
    solution = core.reference_solution(system)
    assert solution.crossing(1)[0] == 1.0
    with pytest.raises(ValueError, match=r"ends at t = 3,.*no law is declared"):
        solution.state(4.0)
    with pytest.raises(ValueError, match="no law is declared"):
        core.reference_solution(system, (1.0, 1.0))


def test_a_jump_may_lead_across_another_surface():
    # from x < 0 to x = 1, y = 2.5: beyond both surfaces
    jumps = {0: ("x + 1", "y + 3")}
    system = plane({key: Region(f=("1", "0")) for key in FLOW}, jumps=jumps, x0=(-1.0, -0.5))
    solution = core.reference_solution(system)
    assert solution.entered(1) == 3
    assert np.array_equal(solution.after(1), [1.0, 2.5])
    assert np.array_equal(solution.state(2.0), [2.0, 2.5])


def test_a_mode_that_begins_beyond_its_guard_ends_at_once():
    climb, fall = Region(f=("1",)), Region(f=("-1",))
    switches = (Transition("up", "1 - x", "over"), Transition("over", "1/2 - x", "down"),
                Transition("down", "x + 1", "up"))  # fmt: skip
    system = core.PiecewiseSystem("relay", ("x",), regions={"up": climb, "over": fall, "down": fall},
                                  transitions=switches, x0=(0.0,))  # fmt: skip
    solution = core.reference_solution(system)
    assert [solution.crossing(k)[0] for k in (1, 2, 3)] == [1.0, 1.0, 3.0]
    assert [system.laws.name(solution.entered(k)) for k in (1, 2, 3)] == ["over", "down", "up"]
    assert solution.state(2.5) == [-0.5]


def test_motion_along_a_surface_nearer_than_round_off_of_doubles_is_no_tangency():
    regions = dict.fromkeys(FLOW, Region(f=("1", "1")))
    system = core.PiecewiseSystem(
        "along", ("x", "y"), surfaces=("x - y", "y"), regions=regions, x0=(2.0**-50 - 1, -1.0)
    )
    solution = core.reference_solution(system)
    assert solution.crossing(1)[0] == 1.0
    assert np.array_equal(solution.state(2.0), [1 + 2.0**-50, 1.0])


@pytest.mark.parametrize("slowest", ["1e-6", "1e-10", "1e-30", "1e-45"])
def test_a_crossing_is_none_the_less_one_for_being_slow(slowest):
    # x = (1 + s) exp(-t) - s falls at rate 1 first, and through 0 at rate s; beyond it goes on at that rate.
    s = mp.mpf(slowest)
    system = core.PiecewiseSystem(
        "slow", ("x",), f_minus=(f"-{slowest}",), f_plus=(f"-x - {slowest}",), g="x", x0=(1.0,)
    )
    solution = core.reference_solution(system)
    assert solution.crossing(1)[0] == float(mp.log(1 + 1 / s))
    assert solution.entered(1) == -1
    assert solution.exact


def test_a_touch_stays_one_in_more_digits():
    system = core.PiecewiseSystem(
        "touch", ("x", "y"), f_minus=("y", "-x"), f_plus=("y", "-x"), g="x - 1", x0=(-1.0, 0.0)
    )
    solution = core.reference_solution(system)
    with pytest.raises(ValueError, match=r"ends at t = 3\.14159265358979.*touches the surface tangentially"):
        solution.crossing(1)
    assert solution.exact
