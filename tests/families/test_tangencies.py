"""The start, place and time of a touch are those of drawn oscillators, whose amplitude then reaches the surface."""

import numpy as np

import core


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
