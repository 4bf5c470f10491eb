"""Several surfaces, walls and one-way transitions, against solutions of affine pieces in 30 digits."""

import math
import pickle
import re
from functools import cache
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import core
from core import Status
from core.system import Parameter, PiecewiseSystem, Region, Transition

EPS = np.finfo(float).eps
CHUA = core.CATALOGUE["chua"]
BRIDGE, GENES, THERMOSTAT = (core.CATALOGUE[name] for name in ("diode_bridge", "gene_ring", "thermostat"))
#: x' = v, v' = −x between walls at −1 and 1, at which 0.9 of the speed is kept.
WALLS = core.CATALOGUE["two_walls"].with_parameters(restitution=0.9)
#: One temperature: heated towards 30 degrees up to 22, cooling towards 10 degrees down to 18.
ROOM = PiecewiseSystem(
    "room", ("T",), regions={"on": Region(f=("30 - T",)), "off": Region(f=("10 - T",))},
    transitions=(Transition("on", "22 - T", "off"), Transition("off", "T - 18", "on")), x0=(20.0,),
)  # fmt: skip


# Solutions of affine pieces ------------------------------------------------------------------------------------------

#: Grid on which the exact solution is searched for zeros of its guards; their rates keep their signs far longer.
GRID = 2.0**-7
mp = mpmath.mp.clone()
mp.dps = 30


def chua_pieces(alpha, beta, a, b):
    """Region -> matrix, constant, and guards (row, offset, region that follows): a guard is row·x + offset."""

    def law(slope, offset):
        return [[-alpha * (1 + slope), alpha, 0], [1, -1, 1], [0, -beta, 0]], [-alpha * offset, 0, 0]

    return {
        "--": (*law(b, b - a), [([-1, 0, 0], -1, "+-")]),
        "+-": (*law(a, 0), [([1, 0, 0], 1, "--"), ([-1, 0, 0], 1, "++")]),
        "++": (*law(b, a - b), [([1, 0, 0], -1, "+-")]),
    }


def gene_pieces(supply, threshold):
    """Each protein decays, and is made where the one before it is below the threshold."""
    signs = [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    unit, name = np.eye(3).tolist(), {s: "".join("-+"[v > 0] for v in s) for s in signs}
    return {
        name[s]: (
            (-np.eye(3)).tolist(), [supply if s[i - 1] < 0 else 0 for i in range(3)],
            [
                ([s[i] * v for v in unit[i]], -s[i] * threshold, name[*s[:i], -s[i], *s[i + 1 :]])
                for i in range(3)
            ],
        )
        for s in signs
    }  # fmt: skip


def thermostat_pieces(band, power, cold, loss, storage):
    """Room and radiator; T and r are measured from the temperature set."""
    matrix = [[-1 - loss, 1], [storage, -storage]]
    return {
        "on": (matrix, [-loss * cold, power], [([-1, 0], band, "off")]),
        "off": (matrix, [-loss * cold, 0], [([1, 0], band, "on")]),
    }


def bridge_pieces(omega, resistance, capacitance, load):
    """Voltage of the source, of the capacitor, and of the source a quarter period later."""

    def matrix(sign):
        current = [sign / resistance, -abs(sign) / resistance, 0]
        return [[0, 0, omega], [c / capacitance for c in current], [-omega, 0, 0]], -1 / (load * capacitance)

    pieces = {}
    for name, sign in (("--", -1), ("-+", 0), ("++", 1)):
        rows, leak = matrix(sign)
        rows[1][1] += leak
        guards = [([sign, -1, 0], 0, "-+")] if sign else [([-1, 1, 0], 0, "++"), ([1, 1, 0], 0, "--")]
        pieces[name] = rows, [0, 0, 0], guards
    return pieces


class Affine:
    """x' = A x + c by the exponential of [[A, c], [0, 0]], in 30 digits and, to find where to look, in doubles."""

    def __init__(self, matrix, constant):
        d = len(constant)
        self.matrix = mp.matrix([[*row, c] for row, c in zip(matrix, constant, strict=True)] + [[0] * (d + 1)])
        self.step = expm(np.array(self.matrix.tolist(), dtype=float) * GRID)

    def __call__(self, s, x):
        """State after a time s, from a state x; both have a last coordinate 1."""
        return mp.expm(self.matrix * s) * x


def exact(pieces, region, x0, end):
    """Crossings (t, state, region entered), and the state at the end: in 30 digits."""
    laws = {name: Affine(*piece[:2]) for name, piece in pieces.items()}
    t, x, met = mp.mpf(0), mp.matrix([*map(mp.mpf, x0), 1]), []
    while True:
        law, rows = laws[region], [(mp.matrix([[*row, c]]), to) for row, c, to in pieces[region][2]]
        heights = np.array([row.tolist()[0] for row, _ in rows], dtype=float)
        s, place = 0.0, law.step @ np.array(x.tolist(), dtype=float)[:, 0]
        while float(t) + s < end and (heights @ place > 0).all():
            s, place = s + GRID, law.step @ place
        found = None
        if float(t) + s < end:
            row, to = rows[int(np.argmin(heights @ place))]
            start = (mp.mpf(s), mp.mpf(s + GRID))
            found = mp.findroot(lambda u, row=row, x=x, law=law: (row * law(u, x))[0], start, solver="anderson")
        if found is None or t + found > end:
            final = law(end - t, x)
            return met, np.array(final.tolist()[:-1], dtype=float)[:, 0]
        t, x, region = t + found, law(found, x), to
        met.append((float(t), np.array(x.tolist()[:-1], dtype=float)[:, 0], to))


@cache
def solution(name, end):
    """Exact crossings and final state of a system of the catalogue from its own start."""
    pieces, region = {
        "chua": (chua_pieces, "+-"), "gene_ring": (gene_pieces, "---"), "thermostat": (thermostat_pieces, "on"),
        "diode_bridge": (bridge_pieces, "-+"),
    }[name]  # fmt: skip
    system = core.CATALOGUE[name]
    return exact(pieces(**{k: mp.mpf(v) for k, v in system.values.items()}), region, system.x0, end)


def regions_of(run):
    return [run.system.modes[k].name for k in run.crossings.mode]


# Against exact solutions ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["chua", "gene_ring", "thermostat", "diode_bridge"])
def test_taylor_meets_the_exact_crossings_of_affine_pieces_in_their_order(name):
    met, final = solution(name, 20.0)
    run = core.integrate(name, (0.0, 20.0), method="taylor", tolerance=1e-15)
    assert run.status is Status.COMPLETED
    assert regions_of(run) == [region for _, _, region in met]
    assert len(met) > 4
    # Chua's circuit alone is chaotic: over 20 units of time, a rounding grows by a factor of 2000.
    bound = 1e-11 if name == "chua" else 1e-13
    assert np.abs(run.crossings.t - [t for t, _, _ in met]).max() < bound
    assert np.abs(run.crossings.x - [x for _, x, _ in met]).max() < bound
    assert np.abs(run.x[-1] - final).max() < bound


def test_chua_agrees_with_dop853_restarted_at_events():
    alpha, beta, a, b = CHUA.values.values()
    slopes = {-1: (b, b - a), 0: (a, 0.0), 1: (b, a - b)}

    def field(_, u, place):
        slope, offset = slopes[place]
        return alpha * (u[1] - u[0] - slope * u[0] - offset), u[0] - u[1] + u[2], -beta * u[1]

    ways = [lambda _, u, __: u[0] + 1, lambda _, u, __: u[0] - 1]
    for way in ways:
        way.terminal = True
    t, x, place = 0.0, np.array(CHUA.x0), 0
    while t < 20.0:
        mine = ways if place == 0 else ways[:1] if place < 0 else ways[1:]
        found = solve_ivp(field, (t, 20.0), x, "DOP853", events=mine, args=(place,), rtol=1e-13, atol=1e-15)
        t, x = found.t[-1], found.y[:, -1]
        if found.status == 1:
            place = (-1 if found.t_events[0].size else 1) if place == 0 else 0
            while t < 20.0 and abs(abs(x[0]) - 1) < 1e-6:  # off the surface, so that the event is not met again
                rest = solve_ivp(field, (t, t + 1e-3), x, "DOP853", args=(place,), rtol=1e-13, atol=1e-15)
                t, x = rest.t[-1], rest.y[:, -1]
    run = core.integrate(CHUA, (0.0, 20.0), method="taylor", tolerance=1e-15)
    assert np.abs(run.x[-1] - x).max() < 1e-9  # an error of 1e-13 of DOP853 grows by a factor of 2000


#: Method -> finest and coarsest step size, and how far the slope may be from the order.
WINDOWS = {"rk2": (5e-4, 8e-3, 0.1), "rk4": (2e-3, 2e-2, 0.1), "gauss4": (2e-3, 2e-2, 0.1), "rk8": (0.06, 0.15, 0.5)}
#: After the first five crossings of Chua's circuit, and the first 22 of the ring of genes.
LATER = 10.0


def slope_of(name, method, finest, coarsest, **more):
    """Slope of the error of the state at the end, over some twelve step sizes that divide the time span."""
    met, final = solution(name, LATER)
    taus = LATER / np.unique(np.geomspace(LATER / coarsest, LATER / finest, 12).astype(int))
    runs = [core.integrate(name, (0.0, LATER), tau=tau, method=method, record="end", **more) for tau in taus]
    assert all(run.crossing_count == len(met) >= 5 for run in runs)
    errors = [np.abs(run.x[-1] - final).max() for run in runs]
    return np.polyfit(np.log(taus), np.log(errors), 1)[0]


@pytest.mark.parametrize("method", WINDOWS)
def test_the_order_is_kept_through_several_surfaces(method):
    finest, coarsest, margin = WINDOWS[method]
    assert abs(slope_of("chua", method, finest, coarsest) - core.METHODS[method].order) < margin


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_perturbation_of_every_crossing_lowers_the_order_to_its_own(order):
    assert abs(slope_of("gene_ring", "rk4", 1e-4, 1e-3, perturbation_order=order) - order) < 0.1


@pytest.mark.parametrize("order", [1, 2, 3])
def test_where_the_field_is_continuous_a_perturbation_lowers_the_order_to_twice_its_own(order):
    # For a time of size tau**p the field of the side left acts, which differs by as much from that of the other side.
    assert abs(slope_of("chua", "rk4", 1e-3, 1e-2, perturbation_order=order) - min(4, 2 * order)) < 0.1


def test_the_thermostat_of_one_temperature_switches_at_its_closed_form():
    heating, cooling = math.log(12 / 8), math.log(12 / 8)
    first = math.log(10 / 8)
    times = first + np.cumsum([0.0, *[cooling, heating] * 8])
    for method, settings in (("taylor", {"tolerance": 1e-15}), ("rk8", {"tau": 0.01}), ("gauss4", {"tau": 1e-3})):
        run = core.integrate(ROOM, (0.0, 7.0), method=method, **settings)
        assert run.status is Status.COMPLETED
        assert len(run.crossings) == len(times)
        assert run.crossings.t == pytest.approx(times, abs=1e-13)
        assert (run.crossings.mode == [1, 0] * 8 + [1]).all()


@pytest.mark.parametrize("load", [4.0, 0.4])
@pytest.mark.parametrize("method", ["rk8", "taylor"])
def test_a_bridge_behind_a_coil_by_modes_agrees_with_sliding_at_zero_current(method, load):
    # It conducts from where the guard i of that mode is zero and its rate is zero, too. With the smaller load the
    # current soon goes from one pair of diodes to the other at once.
    values = {"E": 1.5, "L": 0.3, "R": 0.1, "C": 1.0, "load": load}
    plus = ("(E*sin(t) - R*i - u)/L", "(i - u/load)/C")
    minus = ("(E*sin(t) - R*i + u)/L", "(-i - u/load)/C")
    modes = declared(
        variables=("i", "u"), parameters=values, x0=(0.0, 0.3),
        regions={"blocked": Region(("0", "-u/(load*C)")), "plus": Region(plus), "minus": Region(minus)},
        transitions=(
            Transition("blocked", "u - E*sin(t)", "plus"), Transition("blocked", "u + E*sin(t)", "minus"),
            Transition("plus", "i", "blocked"), Transition("minus", "-i", "blocked"),
        ),
    )  # fmt: skip
    sides = declared(variables=("i", "u"), f_minus=minus, f_plus=plus, g="i", parameters=values, x0=(0.0, 0.3))
    how = {"method": method, "tau": None if method == "taylor" else 0.01}
    by_modes = core.integrate(modes, (0.0, 50.0), **how)
    by_sliding = core.integrate(sides, (0.0, 50.0), sliding="continue", **how)
    assert by_modes.status is by_sliding.status is Status.COMPLETED
    assert np.abs(by_modes.x[-1] - by_sliding.x[-1]).max() < 1e-11


# Walls ---------------------------------------------------------------------------------------------------------------


def impacts(count, speed=2.0, kept=0.9):
    """Times of impacts, alternately at 1 and −1, of x'' = −x from x = 0, and the speeds after them."""
    t, v = math.asin(1 / speed), kept * math.sqrt(speed**2 - 1)
    times, speeds = [t], [v]
    for _ in range(count - 1):
        t += 2 * math.atan2(1.0, v)  # from one wall to the other: cos s − v sin s = −1
        v *= kept
        times.append(t)
        speeds.append(v)
    return np.array(times), np.array(speeds)


@pytest.mark.parametrize("method", ["dmm2", "dmm4", "prk8", "taylor"])
def test_between_impacts_the_energy_is_conserved_and_impacts_take_place_in_time(method):
    tau = 0.01
    how = {"tolerance": 1e-15} if method == "taylor" else {"tau": tau}
    run = core.integrate(WALLS, (0.0, 20.0), method=method, **how)
    times, speeds = impacts(len(run.crossings))
    assert run.status is Status.COMPLETED
    assert len(times) == 12
    assert set(run.crossings.kind) == {"jump"}
    assert np.abs(run.conserved_error()).max() <= 4 * EPS * 2.0  # the energy of the start
    late = run.crossings.t - times
    if method == "dmm2":  # turns by 2 atan(tau/2) a step, too little by tau²/12 of it
        assert (late > 0).all()
        assert (late <= 1.01 * tau**2 / 12 * times).all()
    else:
        assert np.abs(late).max() < (1e-9 if method == "dmm4" else 1e-13)
    assert np.abs(run.crossings.x[:, 0] - [1.0, -1.0] * 6).max() <= EPS
    assert np.abs(np.abs(run.crossings.x_after[:, 1]) - speeds).max() <= 64 * EPS


@pytest.mark.parametrize("method", ["dmm2", "prk8", "taylor"])
def test_elastic_walls_keep_the_energy_through_two_hundred_impacts(method):
    run = core.integrate(WALLS.with_parameters(restitution=1.0), (0.0, 200.0), method=method)
    assert run.crossing_count > 185
    energy = (run.x**2).sum(axis=1) / 2
    assert np.abs(energy - 2.0).max() <= 64 * EPS * 2.0


def test_beyond_a_surface_without_a_jump_and_without_a_law_the_run_stops():
    open_end = PiecewiseSystem(
        "open", ("x", "v"), surfaces=("x + 1", "x - 1"), regions={"+-": Region(f=("v", "-x"))}, jumps={0: ("x", "-v")},
        x0=(0.0, -2.0),
    )  # fmt: skip
    run = core.integrate(open_end, (0.0, 5.0), method="rk8")
    assert run.status is Status.UNDECLARED
    assert run.crossings.kind.tolist() == ["jump", "transversal"]
    assert run.t[-1] == pytest.approx(math.pi / 6 + math.pi / 3, abs=1e-12)  # asin(1/2), and as far to either side


# A run as a whole ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["taylor", "rk4", "gauss4"])
def test_a_run_back_from_the_end_reaches_the_start_by_the_same_crossings(method):
    # Run back, rounding grows by exp(3.94 t): the field beyond a surface has an eigenvalue of −3.94.
    settings, end = {"tolerance": 1e-15} if method == "taylor" else {"tau": 1e-3}, 4.0
    bound = 16 * EPS * math.exp(3.94 * end)
    on = core.integrate(CHUA, (0.0, end), x0=(1.5, 0.1, -2.0), method=method, **settings)
    back = core.integrate(CHUA, (end, 0.0), x0=on.x[-1], method=method, **settings)
    assert len(on.crossings) == 2
    assert np.abs(back.x[-1] - on.x[0]).max() < bound
    assert np.abs(back.crossings.t[::-1] - on.crossings.t).max() < bound
    assert (back.crossings.surface_met[::-1] == on.crossings.surface_met).all()
    assert regions_of(back)[::-1] == [on.system.modes[on.mode[0]].name, *regions_of(on)[:-1]]


@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_all_ways_to_record_agree_to_the_last_bit(method):
    settings = {"method": method} if method == "taylor" else {"method": method, "tau": 0.01}
    span = (0.0, 20.0)
    steps = core.integrate(CHUA, span, **settings)
    crossings, end = (core.integrate(CHUA, span, record=what, **settings) for what in ("crossings", "end"))
    assert (crossings.x[-1] == steps.x[-1]).all()
    assert (end.x[-1] == steps.x[-1]).all()
    assert end.crossing_count == crossings.crossing_count == len(steps.crossings) == 9
    for name in ("t", "x", "x_after", "mode", "side", "g", "kind", "surface_met", "rate_before", "rate_after"):
        assert (getattr(crossings.crossings, name) == getattr(steps.crossings, name)).all()
    times = np.linspace(0.0, 20.0, 301)
    sampled = core.integrate(CHUA, span, t_eval=times, **settings)
    assert (sampled.at(times) == steps.at(times)).all()
    assert (steps.at(steps.t) == steps.x).all()


def test_states_between_steps_have_the_order_of_the_method():
    _, final = solution("chua", LATER)
    run = core.integrate(CHUA, (0.0, LATER + 0.7), method="taylor", tolerance=1e-15)
    assert np.abs(run.at(LATER) - final).max() < 1e-12
    met, _ = solution("chua", LATER)
    for (t, x, _), (later, _, _) in pairwise(met):
        assert np.abs(run.at(t) - x).max() < 1e-12
        assert np.abs(run.at([t, (t + later) / 2])).max() < 4.0


def test_a_run_tells_region_sides_and_surfaces_by_the_states():
    run = core.integrate(CHUA, (0.0, 20.0), method="taylor")
    assert run.side.shape == (len(run.t), 2)
    assert run.crossings.side.shape == (len(run.crossings), 2)
    heights = run.x[:, :1] + [1.0, -1.0]
    inside = np.abs(heights).min(axis=1) > 1e-14
    assert (run.side[inside] == np.sign(heights[inside])).all()
    names = [mode.name for mode in CHUA.modes]
    assert names[:3] == ["--", "+-", "++"]
    assert [names[k] for k in run.mode] == ["".join("-+"[s > 0] for s in side) for side in run.side.tolist()]
    met = run.crossings
    assert (np.abs(met.x[:, 0] + np.array([1.0, -1.0])[met.surface_met]) <= EPS).all()
    assert (np.abs(met.g) <= EPS).all()


def test_where_regions_have_names_there_are_modes_and_no_sides():
    run = core.integrate(THERMOSTAT, (0.0, 20.0), method="taylor")
    assert run.side.shape == (len(run.t), 0)
    assert [mode.name for mode in THERMOSTAT.modes][:2] == ["on", "off"]
    band = THERMOSTAT.values["band"]
    where = run.crossings.x[:, 0]
    assert (np.abs(where - np.where(run.crossings.mode == 1, band, -band)) <= EPS).all()


def test_with_hysteresis_a_run_begins_in_the_first_region_all_of_whose_guards_are_positive():
    assert [core.integrate(ROOM, (0.0, 0.1), x0=(x,), method="rk4").mode[0] for x in (20.0, 23.0, 15.0)] == [0, 1, 0]


@pytest.mark.parametrize("system", [CHUA, WALLS, THERMOSTAT, GENES, BRIDGE, ROOM], ids=lambda s: s.name)
def test_a_pickled_system_gives_the_same_run(system):
    again = pickle.loads(pickle.dumps(system))  # noqa: S301 - our own
    assert again == system
    assert list(again.regions) == list(system.regions)
    first, second = (core.integrate(one, (0.0, 10.0), method="taylor") for one in (system, again))
    assert (first.x == second.x).all()
    assert (first.crossings.t == second.crossings.t).all()


def test_other_parameter_values_are_those_of_the_system_declared_with_them():
    other = CHUA.with_parameters(alpha=8.5, a=-1.13)
    values = other.values
    pieces = chua_pieces(**{k: mp.mpf(v) for k, v in values.items()})
    met, final = exact(pieces, "+-", CHUA.x0, 10.0)
    run = core.integrate(other, (0.0, 10.0), method="taylor", tolerance=1e-15)
    assert other.laws is CHUA.laws
    assert regions_of(run) == [region for _, _, region in met]
    assert np.abs(run.x[-1] - final).max() < 1e-12


# Declarations --------------------------------------------------------------------------------------------------------

_TURN = Region(f=("v", "-x"))
_TWO = {"variables": ("x", "v"), "surfaces": ("x + 1", "x - 1"), "regions": {"+-": _TURN}}
_NAMED = {"variables": ("x", "v"), "regions": {"on": _TURN, "off": _TURN}}
_WAYS = (Transition("on", "1 - x", "off"), Transition("off", "x + 1", "on"))


def declared(**parts):
    return PiecewiseSystem("test", **parts)


@pytest.mark.parametrize("key", ["+", "+-+", "+0", "inside", "", 1])
def test_a_key_that_is_not_one_sign_a_surface_is_refused(key):
    with pytest.raises(ValueError, match=re.escape(f"{key!r} is not ")):
        declared(**{**_TWO, "regions": {key: _TURN}})


def test_psi_has_to_be_conserved_in_its_own_region_only():
    field, energy = ("v", "-sqrt(x**2)"), ("x**2 + v**2",)  # v' = −|x| conserves it where x > 0
    kept = declared(**{**_TWO, "regions": {"++": Region(field, energy)}})
    assert kept.regions["++"].psi == energy
    for key in ("+-", "--"):
        with pytest.raises(ValueError, match=r"'x\*\*2 \+ v\*\*2' is (not )?conserved by"):
            declared(**{**_TWO, "regions": {key: Region(field, energy)}})
    with pytest.raises(ValueError, match=r"'x\*\*2 \+ 2\*v\*\*2' is not conserved by regions\['\+-'\]"):
        declared(**{**_TWO, "regions": {"+-": Region(("v", "-x"), ("x**2 + 2*v**2",))}})


@pytest.mark.parametrize("way", [Transition("on", "1 - x", "of"), Transition("of", "1 - x", "on")])
def test_a_transition_from_or_to_an_unknown_region_is_refused(way):
    with pytest.raises(ValueError, match=r"transition 2: 'of' is not a region; there are 'on', 'off'"):
        declared(**_NAMED, transitions=(*_WAYS, way))


@pytest.mark.parametrize("twice", ["x + 1", "-x - 1", "1 + x + 0", "2*x + 2", "x**2 - 1"])
def test_a_surface_given_twice_is_refused(twice):
    with pytest.raises(ValueError, match=r"is zero where surfaces\[0\] is") as refused:
        declared(**{**_TWO, "surfaces": ("x + 1", twice)})
    assert repr(twice) in str(refused.value)


@pytest.mark.parametrize("number", [2, -1])
def test_a_jump_at_a_surface_that_is_not_there_is_refused(number):
    with pytest.raises(ValueError, match=rf"{number} is not a surface: they have the numbers 0 to 1"):
        declared(**_TWO, jumps={number: ("x", "-v")})


def test_a_wall_in_time_is_refused():
    laws = {"regions": {"+-": core.Region(("1",)), "++": core.Region(("2",))}, "jumps": {0: ("x + 1",)}}
    with pytest.raises(ValueError, match="no jump leads back from where it is 0: declare a law of region '--'"):
        core.PiecewiseSystem("wall in time", ("x",), surfaces=("3 - t", "x"), **laws)


def test_a_jump_of_another_dimension_is_refused():
    with pytest.raises(ValueError, match=r"jumps\[1\] = \('x',\): 1 expression given, 2 needed"):
        declared(**_TWO, jumps={1: ("x",)})


def test_two_forms_of_a_declaration_are_not_mixed():
    with pytest.raises(ValueError, match="give either f_minus, f_plus, g"):
        declared(**_TWO, f_minus=("v", "-x"), f_plus=("v", "-x"), g="x")
    with pytest.raises(ValueError, match="give either transitions, or surfaces"):
        declared(**{**_TWO, "regions": _NAMED["regions"]}, transitions=_WAYS)
    with pytest.raises(ValueError, match="give either transitions, or surfaces and jumps"):
        declared(**_NAMED, transitions=_WAYS, jumps={0: ("x", "-v")})


def test_a_region_that_cannot_be_left_is_refused_where_regions_have_names():
    with pytest.raises(ValueError, match="region 'off' has no guard"):
        declared(**_NAMED, transitions=_WAYS[:1])


def test_a_start_in_a_region_without_a_law_is_refused():
    with pytest.raises(ValueError, match=r"x0 = \(1.5, 0.0\) lies in a region for which no law is declared"):
        core.integrate(WALLS, (0.0, 1.0), x0=(1.5, 0.0), method="rk4")


@pytest.mark.parametrize("count", [0, 7])
def test_one_to_six_surfaces_are_possible(count):
    with pytest.raises(ValueError, match=f"{count} surfaces: from 1 to 6 are possible"):
        declared(variables=("x", "v"), surfaces=[f"x - {k}" for k in range(count)], regions={"+" * count: _TURN})


def test_a_system_with_one_surface_is_the_same_by_sides_and_by_regions():
    sides = declared(variables=("x", "v"), f_minus=("v", "-4*x"), f_plus=("v", "-k*x"), g="x",
                     parameters=(Parameter("k", 1.0),), x0=(1.0, 0.0))  # fmt: skip
    regions = declared(variables=("x", "v"), surfaces=("x",), parameters=(Parameter("k", 1.0),), x0=(1.0, 0.0),
                       regions={"+": Region(("v", "-k*x")), "-": Region(("v", "-4*x"))})  # fmt: skip
    assert regions == sides
    assert regions.two_sided
    first, second = (core.integrate(one, (0.0, 10.0), method="taylor") for one in (sides, regions))
    assert (first.x == second.x).all()
