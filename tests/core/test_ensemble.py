"""Ensembles: each member comes out as `integrate` brings it there, on any executor."""

import threading
import time

import numpy as np
import pytest

import core
from core import Status
from core.integration import members
from tests.levels import deep_but

#: Systems of each kind: two sides; jumps, which accumulate; sliding; several regions; hysteresis; walls; corners.
SYSTEMS = (
    "elliptic_curve", "bouncing_ball", "relay_feedback", "chua", "thermostat", "stick_slip", "two_walls", "gene_ring",
    "damped_oscillator", "henon_heiles",
)  # fmt: skip
SETTINGS = (
    {"method": "taylor", "tolerance": 1e-9},
    {"method": "rk4", "tau": 0.03},
    {"method": "rk4", "tau": 0.03, "sliding": "continue"},
    {"method": "rk2", "tau": 0.05, "transition": "none"},
    {"method": "rk4", "tau": 0.05, "perturbation_order": 2, "max_crossings": 7},
    {"method": "rk4", "tau": 0.05, "max_steps": 30},
)
T = 8.0


def drawn(name, rng, count):
    """Members around the system's own start, with parameters of their own."""
    system = core.CATALOGUE[name]
    x0 = np.array(system.x0) * (1.0 + 0.3 * rng.uniform(-1, 1, (count, system.dimension)))
    parameters = {
        q.name: q.default * (1.0 + 0.01 * rng.uniform(-1, 1, count)) for q in system.parameters if not q.bounds
    }
    return system, x0, parameters


def differs(found, k, run):
    """What of a member is not that of a run, bit by bit."""
    own, kept = found.crossings, slice(*found.crossings.offsets[k : k + 2])
    pairs = {
        "t": (found.t[k], run.t[-1]), "x": (found.x[k], run.x[-1]), "status": (found.status[k], run.status),
        "mode": (found.mode[k], run.mode[-1]), "steps": (found.steps[k], run.steps),
        "evaluations": (found.evaluations[k], run.evaluations), "count": (found.crossing_count[k], run.crossing_count),
    }  # fmt: skip
    for name in ("t", "x", "x_after", "mode", "side", "kind", "surface_met"):
        pairs[name + " of crossings"] = getattr(own, name)[kept], getattr(run.crossings, name)
    return [name for name, (ours, theirs) in pairs.items() if not np.array_equal(ours, theirs)]


@pytest.mark.parametrize("name", deep_but(("relay_feedback", "two_walls"), SYSTEMS))
def test_each_member_is_the_run_that_integrate_gives_bit_by_bit(name, draws):
    for rng in draws(3):
        system, x0, parameters = drawn(name, rng, 20)
        for settings in SETTINGS:
            settings = {"max_crossings": 300, **settings}
            found = core.ensemble(system, (0.0, T), x0, parameters, record="crossings", **settings)
            for k in range(20):
                one = system.with_parameters(**{q: float(values[k]) for q, values in parameters.items()})
                run = core.integrate(one, (0.0, T), x0[k], record="crossings", **settings)
                assert not differs(found, k, run), (name, settings, x0[k])


@pytest.mark.parametrize("settings", [{}, {"perturbation_order": 2}, {"events": "y", "max_events": 90}])
def test_members_may_differ_in_step_size(settings):
    taus, x0 = np.geomspace(0.003, 0.3, 7), (-1.0, -0.9)
    settings = {"record": "crossings", "method": "rk4", "max_crossings": 90, **settings}
    found = core.ensemble("elliptic_curve", (0.0, T), x0, tau=taus, **settings)
    for k, tau in enumerate(taus):
        run = core.integrate("elliptic_curve", (0.0, T), x0, tau, **settings)
        assert not differs(found, k, run)


@pytest.mark.parametrize(("name", "method"), [("elliptic_curve", "dmm2"), ("kepler", "rk4")])
def test_why_steps_fail_is_what_integrate_finds(name, method):
    system, count = core.CATALOGUE[name], 150
    taus = np.geomspace(0.02, 9.0, count)
    x0 = np.tile(system.x0, (count, 1))
    x0[:, 0] = np.resize(np.linspace(-2.0, 2.0, 8), count)
    settings = {"method": method, "record": "crossings", "max_crossings": 90}
    found = core.ensemble(system, (0.0, 20.0), x0, tau=taus, **settings)
    for k, tau in enumerate(taus):
        assert not differs(found, k, core.integrate(system, (0.0, 20.0), x0[k], tau, **settings))
    failed = {Status.ESCAPED, Status.UNSTABLE, Status.NO_CONVERGENCE, Status.SINGULAR} & set(found.outcomes)
    assert sum(found.outcomes[status] for status in failed) > 10, found.outcomes


def test_time_may_run_back_or_not_at_all():
    x0 = [[-1.0, -1.0], [-1.1, -0.9]]
    for end in (-7.0, 0.0):
        found = core.ensemble("elliptic_curve", (0.0, end), x0, tau=0.02, record="crossings", max_crossings=50)
        for k, start in enumerate(x0):
            run = core.integrate("elliptic_curve", (0.0, end), start, tau=0.02, record="crossings")
            assert not differs(found, k, run)


def test_a_start_at_a_corner_or_a_tangency_is_that_of_integrate():
    lines = core.PiecewiseSystem(
        "Corner", ("x", "y"), surfaces=("x", "y"), x0=(-1.0, -1.0),
        regions={key: core.Region(f=("1", "2")) for key in ("--", "-+", "+-", "++")},
    )  # fmt: skip
    fold = core.PiecewiseSystem("Fold", ("x", "y"), g="y", f_minus=("1", "x"), f_plus=("1", "x"), x0=(0.0, 0.0))
    for system, x0 in ((lines, [[0.0, 0.0], [-1.0, -2.0], [-1.0, -1.0]]), (fold, [[0.0, 0.0], [-1.0, 0.5]])):
        found = core.ensemble(system, (0.0, 3.0), x0, method="rk4", tau=0.1, record="crossings", max_crossings=9)
        for k, start in enumerate(x0):
            assert not differs(found, k, core.integrate(system, (0.0, 3.0), start, method="rk4", tau=0.1))


@pytest.mark.parametrize("name", ["chua", "elliptic_curve"])
def test_a_start_on_one_surface_needs_no_run_of_its_own(name, monkeypatch):
    """As is common in a section: the loop takes it, and comes to the same."""
    system = core.CATALOGUE[name]
    met = core.integrate(system, (0.0, 20.0), method="taylor").crossings.crossed
    alone = []
    integrate_one = members._Run._integrate_one
    monkeypatch.setattr(members._Run, "_integrate_one", lambda run, k: (alone.append(k), integrate_one(run, k)))
    found = core.ensemble(system, (0.0, 5.0), met.x_after, method="taylor", record="crossings", max_crossings=99)
    assert len(alone) <= len(system.regions), "those in which a region is entered first"
    for k, start in enumerate(met.x_after):
        assert not differs(found, k, core.integrate(system, (0.0, 5.0), start, method="taylor"))


@pytest.mark.parametrize("discard", [0, 3, 1000])
def test_the_first_crossings_are_discarded_and_the_others_kept_however_many(discard):
    """Ten thousand crossings of a member are more than the loop's buffer has room for."""
    x0 = [[1.0, 1.0], [0.5, 0.5], [2.0, 0.1]]
    most = 10_000
    settings = {"method": "rk4", "tau": 0.5, "max_crossings": most}
    found = core.ensemble("harmonic_oscillator", (0.0, 1e9), x0, record="crossings", discard=discard, **settings)
    assert (found.status == Status.CROSSING_LIMIT).all()
    assert found.crossings.offsets.tolist() == [k * (most - discard) for k in range(4)]
    assert np.array_equal(found.crossings.member, np.repeat([0, 1, 2], most - discard))
    for k, start in enumerate(x0):
        run = core.integrate("harmonic_oscillator", (0.0, 1e9), start, record="crossings", **settings)
        kept = slice(*found.crossings.offsets[k : k + 2])
        assert np.array_equal(found.crossings.t[kept], run.crossings.t[discard:])
        assert np.array_equal(found.crossings.x[kept], run.crossings.x[discard:])


def test_parameters_and_states_may_be_common_to_all():
    many = core.ensemble("pendulum", (0.0, 3.0), parameters={"k_plus": np.linspace(1.0, 2.0, 5)}, tau=0.05)
    assert len(many) == 5
    assert len(np.unique(many.x[:, 0])) == 5
    one = core.ensemble("pendulum", (0.0, 3.0), tau=0.05)
    assert len(one) == 1
    assert np.array_equal(one.x[0], core.integrate("pendulum", (0.0, 3.0), tau=0.05).x[-1])
    assert len(core.ensemble("pendulum", (0.0, 3.0), np.empty((0, 2)))) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"x0": [[1.0, 2.0, 3.0]]}, r"x0 has shape \(1, 3\)"),
        ({"x0": [[1.0, np.nan]]}, "finite numbers are needed"),
        ({"x0": [[1.0, 1.0]] * 3, "parameters": {"k_plus": [1.0, 2.0]}}, "2 and 3 members"),
        ({"parameters": {"q": [1.0]}}, "unknown parameter 'q'; known are k_minus"),
        ({"parameters": {"k_plus": [[1.0]]}}, r"parameter k_plus has shape \(1, 1\)"),
        ({"parameters": {"k_plus": [1.0, -7.0]}}, "parameter k_plus = -7.0 is outside"),
        ({"record": "steps"}, "choose from end, crossings"),
        ({"record": "crossings"}, "needs max_crossings"),
        ({"discard": -1}, "discard = -1"),
        ({"discard": 0.5}, "discard = 0.5"),
        ({"tau": -1.0}, "must be positive"),
        ({"tau": [0.1, 0.0]}, "must be positive"),
        ({"tau": [[0.1]]}, r"tau has shape \(1, 1\)"),
        ({"x0": [[1.0, 1.0]] * 3, "tau": [0.1, 0.2]}, "2 and 3 members"),
        ({"t_span": (0.0, np.inf)}, "end time"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_what_makes_no_sense_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        core.ensemble("pendulum", **{"t_span": (0.0, 1.0), **arguments})


def test_a_member_that_cannot_begin_is_named():
    system = core.PiecewiseSystem("Root", ("x",), g="x - 9", f_minus=("sqrt(x)",), f_plus=("1",), x0=(1.0,))
    with pytest.raises(ValueError, match=r"member 2: x0 = \(-1.0,\): the field has no finite value there"):
        core.ensemble(system, (0.0, 1.0), [[1.0], [2.0], [-1.0]], method="rk4")


def test_progress_rises_to_one_and_a_cancelled_member_is_where_it_began():
    heard = []
    core.ensemble("pendulum", (0.0, 1.0), np.full((500, 2), 0.5), progress=heard.append)
    assert heard == sorted(heard)
    assert heard[-1] == 1.0
    begun = time.monotonic()
    asked = lambda: time.monotonic() > begun + 0.3  # noqa: E731
    found = core.ensemble("harmonic_oscillator", (0.0, 1e7), np.full((50, 2), 0.5), tau=1e-3, cancel=asked)
    assert time.monotonic() - begun < 60.0  # all steps take an hour
    assert found.outcomes == {Status.CANCELLED: 50}
    assert np.array_equal(found.x, np.full((50, 2), 0.5))
    ends = time.monotonic() + 60.0
    while any(thread.name.startswith("ThreadPoolExecutor") for thread in threading.enumerate()):
        assert time.monotonic() < ends, "the threads go on for nobody"
        time.sleep(0.01)


def test_members_that_end_before_any_crossing_take_no_memory_for_crossings():
    """Room was doubled for every one."""
    found = core.ensemble(
        "elliptic_curve", (0.0, 5.0), np.tile([1.5, 2.0], (60, 1)), tau=0.01, record="crossings", max_crossings=5
    )
    assert found.outcomes == {Status.ESCAPED: 60}
    assert len(found.crossings) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"record": "events", "max_events": 3}, 'record="events": it needs events'),
        ({"max_events": 3}, "max_events = 3: it needs events"),
        (
            {"record": "events", "events": "x", "max_events": 3, "discard": 4},
            "discard = 4: a member has 3 events at most",
        ),
        ({"record": "crossings", "max_crossings": 3, "discard": 4}, "discard = 4: a member has 3 crossings at most"),
    ],
)
def test_limits_that_leave_nothing_to_record_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        core.ensemble("harmonic_oscillator", (0.0, 1.0), **arguments)
