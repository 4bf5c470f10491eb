"""A ball with dry friction on a floor: jumps that lead across another surface, against the closed form."""

import numpy as np
import pytest

import core
from tests.levels import deep_but

FRICTION = {"+" + side: core.Region(f=("v", f"-1 {sign} mu")) for side, sign in (("+", "-"), ("-", "+"))}
BELOW = {"-" + side: core.Region(f=("v", f"1 {sign} mu")) for side, sign in (("+", "-"), ("-", "+"))}
#: A wall, and a surface with laws on both sides from which the jump leads back.
BALLS = {
    name: core.PiecewiseSystem(
        name, ("x", "v"), surfaces=("x", "v"), regions=regions, jumps={0: ("x", "-r*v")},
        parameters={"mu": 0.3, "r": 0.5}, x0=(0.5, 0.0),
    )
    for name, regions in {"wall": FRICTION, "surface": {**FRICTION, **BELOW}}.items()
}  # fmt: skip
METHODS = {"taylor": {}, "rk2": {"tau": 0.05}, "gauss4": {"tau": 0.2}, "dmm2": {"tau": 0.1}, "prk8": {"tau": 0.4}}


def events(mu, r, x, v, count):
    """Times of turning points and impacts: between them the ball falls freely with a constant deceleration."""
    t, times = 0.0, []
    while len(times) < count:
        if v > 0:
            t, x, v = t + v / (1 + mu), x + v * v / 2 / (1 + mu), 0.0
            times.append(t)
        speed = np.sqrt(v * v + 2 * (1 - mu) * x)
        t, x, v = t + (v + speed) / (1 - mu), 0.0, r * speed
        times.append(t)
    return np.array(times[:count])


def drawn(rng, least):
    return {"mu": float(rng.uniform(0.05, 0.9)), "r": float(rng.uniform(*least))}, (
        float(rng.uniform(0.1, 1.0)), float(rng.normal()),
    )  # fmt: skip


QUICK = [("taylor", "wall"), ("rk2", "wall"), ("taylor", "surface")]
ALL = [(method, name) for name in BALLS for method in METHODS]


@pytest.mark.parametrize(("method", "name"), deep_but(QUICK, ALL))
def test_the_ball_turns_and_bounces_when_it_should(method, name, draws):
    for rng in draws(45):
        values, x0 = drawn(rng, (0.6, 1.0))
        expected = events(values["mu"], values["r"], *x0, 9)
        end = (expected[-1] + expected[-2]) / 2
        ball = BALLS[name].with_parameters(**values)
        run = core.integrate(ball, (0.0, float(end)), x0, method=method, **METHODS[method])
        assert (run.status.name, run.crossing_count) == ("COMPLETED", 8), (values, x0, run.message)
        assert np.abs(run.crossings.t - expected[:8]).max() < 1e-12 * (1 + end), (values, x0)


@pytest.mark.parametrize("method", deep_but(("taylor", "rk2"), METHODS))
def test_bounces_accumulate_though_turning_points_lie_between_them(method, draws):
    for rng in draws(30):
        values, x0 = drawn(rng, (0.3, 0.7))
        last = events(values["mu"], values["r"], *x0, 400)[-1]
        ball = BALLS["wall"].with_parameters(**values)
        run = core.integrate(ball, (0.0, 30.0), x0, method=method, **METHODS[method])
        assert run.status is core.Status.ZENO, (values, x0, run.message)
        assert run.t[-1] == pytest.approx(last, rel=1e-9)
