"""Studies on a cluster: a real one, of two processes on this machine, gives what threads give."""

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

import core
from core.interface.tasks import as_completed

distributed = pytest.importorskip("distributed", reason="the extra 'cluster' (dask.distributed) is not installed")

HARMONIC = core.CATALOGUE["harmonic_oscillator"]


@pytest.fixture(scope="module")
def executor():
    options = {"n_workers": 2, "processes": True, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        yield client.get_executor()


def test_results_come_back_with_their_numbers(executor):
    assert sorted(as_completed(pow, [(k, 2) for k in range(20)], executor)) == [(k, k**2) for k in range(20)]


def test_an_exception_on_the_cluster_is_raised_here(executor):
    with pytest.raises(ZeroDivisionError):
        list(as_completed(divmod, [(1, 1), (1, 0)], executor))


@pytest.mark.deep
def test_a_cancelled_study_leaves_the_cluster_usable(executor):
    told = []
    study = _work_precision(executor, progress=lambda *news: told.append(news), cancel=lambda: bool(told))
    assert not study.complete
    assert list(as_completed(abs, [-1], executor)) == [(0, 1)]


@pytest.mark.deep
def test_run_time_against_error_is_the_same_on_threads_and_on_a_cluster(executor):
    here, there = _work_precision(None), _work_precision(executor)
    assert there.complete
    assert _results(there) == _results(here)
    assert all(np.isfinite(curve.seconds).all() for curve in there.curves)


def test_an_ensemble_is_the_same_on_threads_and_on_a_cluster_bit_by_bit(executor):
    x0 = np.random.default_rng(5).uniform(-1.2, -0.8, (100, 2))
    settings = {"tau": 0.05, "record": "crossings", "max_crossings": 40}
    here, there = (core.ensemble("elliptic_curve", (0.0, 20.0), x0, executor=e, **settings) for e in (None, executor))
    for name in ("t", "x", "status", "steps", "evaluations"):
        assert np.array_equal(getattr(here, name), getattr(there, name))
    for name in ("t", "x", "mode", "kind", "offsets"):
        assert np.array_equal(getattr(here.crossings, name), getattr(there.crossings, name))


def _work_precision(executor, **options):
    settings = {"dmm2": (0.1, 0.01), "taylor": (1e-6, 1e-12), "scipy": (1e-4, 1e-8)}
    methods = ("dmm2", "taylor")
    return core.work_precision(
        HARMONIC, (0.0, 20.0), methods=methods, settings=settings, repeats=1, executor=executor, **options
    )


def test_a_stability_study_is_the_same_on_threads_and_on_a_cluster(executor):
    here, there = _stability(None), _stability(executor)
    assert there.complete
    assert _results(there) == _results(here)


def _stability(executor):
    options = {"taus": np.geomspace(0.02, 2.0, 4), "values": np.linspace(0.5, 1.5, 4), "steps": 10_000}
    parts = ("largest_tau", "map", "drift")
    return core.stability_study(HARMONIC, (0.0, 10.0), parts=parts, executor=executor, **options)


def _results(study):
    """Everything a study holds but times."""
    return {path: value for path, value in _leaves(study) if not path.endswith("seconds")}


def _leaves(value, path=""):
    """Everything it holds, arrays as their bytes: equal to the bit, and nan equals nan."""
    if is_dataclass(value):
        for one in fields(value):
            yield from _leaves(getattr(value, one.name), f"{path}.{one.name}")
    elif isinstance(value, tuple | list):
        for k, one in enumerate(value):
            yield from _leaves(one, f"{path}[{k}]")
    elif isinstance(value, np.ndarray) and value.dtype != object:
        yield path, (value.shape, value.dtype, value.tobytes())
    else:
        yield path, repr(value)
