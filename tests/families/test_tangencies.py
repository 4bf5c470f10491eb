"""The start, place and time of a touch are those of drawn oscillators, whose amplitude then reaches the surface."""

import numpy as np

import core

STARTS = 8
"""Starts of each oscillator, a few units in the last place apart: of these, some run of some oscillator touches."""


def drawn_oscillator(rng):
    """An oscillator beside x = c, beyond which a further force acts; its ω, c and the velocity at the start."""
    rate, place, push = rng.uniform(0.6, 2.5), rng.uniform(0.5, 1.5), rng.uniform(0.5, 3.0)
    velocity = rng.choice([-1, 1]) * rng.uniform(0.2, 0.6) * rate * place
    free, pushed = ("v", f"-{rate!r}**2*x"), ("v", f"-{rate!r}**2*x - {push!r}")
    given = (free, pushed, f"x - {place!r}") if rng.random() < 0.5 else (pushed, free, f"{place!r} - x")
    system = core.PiecewiseSystem("drawn", ("x", "v"), *given, x0=(0.2 * place, velocity))
    return system, rate, place, velocity


def test_touches_are_where_the_amplitude_of_a_drawn_oscillator_reaches_the_surface(draws):
    for rng in draws(3):
        system, rate, place, velocity = drawn_oscillator(rng)
        turn, values = 2 * np.pi / rate, np.linspace(0.0, 0.995 * place, 12)
        found = core.stability_study(
            system, (0.0, 1.3 * turn), methods=("rk4",), parts=("grazing",), values=values, sliding="continue"
        ).grazing
        start = np.sqrt(place**2 - (velocity / rate) ** 2)
        time = np.arctan2(velocity / rate, start) / rate % turn
        case = (system.g, rate, place, velocity)
        assert found.found, case
        assert abs(found.value - start) < 1e-12, case
        assert np.abs(found.state - [place, 0.0]).max() < 1e-7, case
        assert abs(found.time - time) < 1e-7, case


def test_a_touch_is_no_crossing_before_it_either(draws):
    touches = 0
    for rng in draws(60):
        _, rate, place, velocity = drawn_oscillator(rng)
        drift = 0.0 if rng.random() < 0.5 else float(rng.uniform(-0.5, 0.5))  # of the surface, and of all with it
        force, push = f"-{rate!r}**2*(x - {drift!r}*t)", f"{rng.uniform(0.5, 3.0)!r}*(x - {drift!r}*t - {place!r})"
        f = (f"v + {drift!r}", force), (f"v + {drift!r}", f"{force} - {push}")
        system = core.PiecewiseSystem("drawn", ("x", "v"), *f, f"x - {drift!r}*t - {place!r}")
        span, tau, method = (
            (0.0, rng.choice([-6.0, 6.0]) / rate),
            rng.choice([0.01, 0.05, 0.1]),
            rng.choice(["rk8", "gauss4", "taylor"]),
        )
        given = {"tau": tau, "method": method, "sliding": rng.choice(["stop", "continue"])}
        for last in rng.integers(-12, 13, STARTS):
            x0 = (np.sqrt(place**2 - (velocity / rate) ** 2) + int(last) * 2.0**-53, velocity)
            cold, warm = (core.integrate(system, span, x0, **given) for _ in range(2))
            many = core.ensemble(system, span, [x0] * 2, **given)
            case = (rate, place, x0, drift, span, given)
            assert list(cold.crossings.kind) == list(warm.crossings.kind), case
            assert (many.crossing_count == warm.crossing_count).all(), case
            assert (many.status == warm.status).all(), case
            if warm.status is core.Status.GRAZING:
                touches += 1
                assert list(warm.crossings.kind) == ["grazing"], case
                assert (warm.mode == 0).all(), case
                # Rounding the height by 64 units moves the place where the rate is zero by the root of that.
                rounded = np.sqrt(2.0 * rate**2 * abs(place) * 64 * np.finfo(float).eps * (abs(place) + abs(span[1])))
                assert abs(warm.crossings.rate_before[0]) <= rounded, case
    assert touches
