"""Arrays of a run are made when they are first asked for, and no run sees what another has left in its memory."""

import pickle
import threading

import numpy as np
import pytest

import core
from core.integration.recorded import Once

SYSTEMS = ("elliptic_curve", "bouncing_ball", "chua")


def parts(run):
    """All that a run has recorded."""
    return run.t, run.x, run.mode, run.segment, run.entered_t, run.entered_x, run.crossings.x_after, run.samples


def same(a, b):
    return all(np.array_equal(one, other) for one, other in zip(parts(a), parts(b), strict=True))


def test_a_value_is_worked_out_once_and_what_it_is_made_of_is_dropped():
    calls = []

    def work(number):
        calls.append(number)
        return 2 * number

    value = Once(work, 21)
    assert calls == []
    assert (value(), value()) == (42, 42)
    assert calls == [21]
    assert value._work is None


@pytest.mark.parametrize("record", ["end", "crossings", "steps"])
def test_no_array_is_made_before_it_is_asked_for(record):
    run = core.integrate("elliptic_curve", (0.0, 3.0), tau=1e-2, record=record)
    assert not {"t", "x", "mode", "segment", "crossings", "entered_t", "entered_x"} & set(vars(run))
    assert run.x.shape == (len(run.t), 2)
    assert "x" in vars(run)


@pytest.mark.parametrize("record", ["end", "crossings", "steps"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_run_that_is_read_late_is_that_which_is_read_at_once(name, record):
    early = core.integrate(name, (0.0, 3.0), method="rk4", tau=1e-2, record=record)
    assert parts(early)
    late = core.integrate(name, (0.0, 3.0), method="rk4", tau=1e-2, record=record)
    other = core.CATALOGUE[name]
    for k in range(3):  # from other states, in the memory that the run has left
        core.integrate(other, (0.0, 2.0 + k), x0=tuple(0.9 * u for u in other.x0), method="rk4", tau=1e-2)
    assert same(early, late)


def test_a_run_within_the_callback_of_another_leaves_it_alone():
    def once():
        return core.integrate("elliptic_curve", (0.0, 300.0), tau=1e-3, record="crossings")

    alone, inner = once(), []
    outer = core.integrate(
        "elliptic_curve", (0.0, 300.0), tau=1e-3, record="crossings", progress=lambda _: inner.append(once())
    )
    assert len(inner) > 1
    assert same(alone, outer)
    assert all(same(alone, run) for run in inner)


def test_runs_in_threads_do_not_share_memory():
    starts = [(-1.0, -1.0 + k / 64) for k in range(16)]

    def run(start):
        return core.integrate("elliptic_curve", (0.0, 200.0), x0=start, tau=1e-2, record="crossings")

    alone, found = [run(start) for start in starts], {}

    def work(k):
        found[k] = [run(start) for start in starts]

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(*pair) for runs in found.values() for pair in zip(alone, runs, strict=True))


def test_a_run_that_is_given_up_by_an_exception_leaves_no_trace():
    def stop(_):
        raise KeyboardInterrupt

    before = core.integrate("elliptic_curve", (0.0, 10.0), tau=1e-2)
    with pytest.raises(KeyboardInterrupt):
        core.integrate("elliptic_curve", (0.0, 7.0), x0=(-1.0, -0.5), tau=1e-2, progress=stop)
    assert same(before, core.integrate("elliptic_curve", (0.0, 10.0), tau=1e-2))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_pickled_run_is_the_same_run(name):
    run = core.integrate(name, (0.0, 3.0), method="rk4", tau=1e-2)
    again = pickle.loads(pickle.dumps(run))  # noqa: S301 - our own
    assert same(run, again)
    assert again.message == run.message


def test_an_end_alone_holds_each_segment_once():
    still = core.integrate("elliptic_curve", (0.0, 1e-3), tau=1e-3, record="end")
    assert still.entered_t.tolist() == [0.0]
    assert still.segment.tolist() == [0, 0]
    run = core.integrate("elliptic_curve", (0.0, 3.0), tau=1e-2, record="end", t_eval=[0.5, 2.9])
    kept = core.integrate("elliptic_curve", (0.0, 3.0), tau=1e-2, record="crossings", t_eval=[0.5, 2.9])
    assert np.array_equal(run.entered_t[run.segment], kept.entered_t[kept.segment])
    assert np.array_equal(run.entered_x[run.segment], kept.entered_x[kept.segment])


@pytest.mark.parametrize(
    "start", [(-1, -1), [-1, -1.0], np.array([-1, -1]), np.array([-1.0, -1.0]), (np.float64(-1), -1)]
)
def test_a_start_may_be_given_as_any_sequence_of_numbers(start):
    assert same(core.integrate("elliptic_curve", (0, 1), start), core.integrate("elliptic_curve", (0, 1), (-1.0, -1.0)))


@pytest.mark.parametrize(
    "start", [(10**400, 1), (True, 1), ("1", 1), (np.nan, 1), np.array([True, False]), np.array(1.0)]
)
def test_a_start_that_is_none_is_refused(start):
    with pytest.raises(ValueError, match="x0"):
        core.integrate("elliptic_curve", (0, 1), start)
