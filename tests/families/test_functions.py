"""Every function of the whitelist, nested and mixed, in f, g, ψ and jump of every method: written, compiled, and right.

The oracle is Python's own `eval` of the declared texts, integrated by SciPy's DOP853.
"""

import ast
import builtins
from itertools import count

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import core
from core.codegen.functions import (
    evaluate_switching_text,
    jump_text,
    levels_texts,
    module_text,
)
from core.codegen.projection import project_to_surface_text
from core.codegen.step import StepCode
from core.methods.taylor_step import prepare_step_text
from core.symbolic.expressions import parse
from core.symbolic.source_text import to_text
from tests.families.drawn_functions import drawn_expression, evaluated

PARAMETERS = {"k": core.Parameter("k", 1.3, (0.5, 2.5))}
K = {"k": 1.3}
#: Times of a run and its crossing; not from 0, where sqrt(t**2) has no derivative.
START, MIDDLE, END = 0.1, 0.3, 0.5
_FLOOR = 1e-10  #: of an error that the oracle can tell


def texts_of(system, method):
    """Texts of all that is compiled for a system and a method."""
    laws = system.laws
    for side in laws.modes.values():
        code = StepCode(laws, side)
        yield code.text(method.scheme.write(side, code))
        yield from levels_texts(laws, side)
        yield project_to_surface_text(laws, side, method.conservative)
        if method.adaptive:
            yield prepare_step_text(laws, side)
    yield evaluate_switching_text(laws, laws.g, laws.regions)
    yield from (evaluate_switching_text(laws, guard, [laws.sliding]) for guard in laws.sliding.guards[:2])
    yield jump_text(laws, laws.jump or laws.x)


def unknown_names(text):
    """Names that a module of generated text uses without having them."""
    nodes = list(ast.walk(ast.parse(module_text([text]))))
    known = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    known |= {a.name for n in nodes if isinstance(n, ast.Import | ast.ImportFrom) for a in n.names}
    known |= {a.arg for n in nodes if isinstance(n, ast.arguments) for a in n.args} | {"CALL", *dir(builtins)}
    return {n.id for n in nodes if isinstance(n, ast.Name)} - known


def drawn_readable(rng, variables, depth):
    """Text of an expression that can be read: no log(y - y)."""
    while True:
        text = drawn_expression(rng, variables, depth)
        try:
            parse(text, (*variables, *K))
        except ValueError:
            continue
        return text


def drawn_psi(rng, variables, depth):
    return f"{drawn_readable(rng, variables, depth)}{''.join(f' + {v}**2' for v in variables)}"


def field_of(psi, variables):
    """A field that keeps ψ: ∇ψ turned in the first two variables, less what ψ gains in time."""
    expression = parse(psi, (*variables, *K))
    gradient = [expression.diff(sympy.Symbol(v)) for v in variables]
    gain, square = expression.diff(sympy.Symbol("t")), sum(g**2 for g in gradient)
    field = [-gain * g / square for g in gradient]
    return tuple(to_text(f) for f in (field[0] + gradient[1], field[1] - gradient[0], *field[2:]))


def drawn_declaration(rng, depth):
    """Texts by name; half of them with ψ."""
    variables = ("x", "y", "z")[: rng.integers(2, 4)]
    given = {"variables": variables, "g": drawn_readable(rng, variables, depth)}
    for word in ("minus", "plus"):
        if rng.random() < 0.5:
            given[f"f_{word}"] = tuple(drawn_readable(rng, variables, depth) for _ in variables)
        else:
            given[f"psi_{word}"] = (drawn_psi(rng, variables, depth),)
            given[f"f_{word}"] = field_of(given[f"psi_{word}"][0], variables)
    return given


@pytest.mark.parametrize(
    "g", ["exp(x) - 2", "2**x - 1.5", "x*exp(-t) - 0.1", "log(1 + exp(x)) - 1", "x**k - t", "x**x"]
)
def test_a_surface_with_exponentials_is_written(g):
    laws = core.PiecewiseSystem("g", ("x",), ("1",), ("2",), g, parameters=PARAMETERS).laws
    assert not unknown_names(evaluate_switching_text(laws, laws.g, laws.regions))


@pytest.mark.deep
def test_whatever_is_declared_is_written_for_every_method_in_names_that_are_known(draws):
    for k, rng in enumerate(draws(len(core.METHODS))):
        given = drawn_declaration(rng, depth=int(rng.integers(1, 4)))
        given["jump"] = tuple(drawn_expression(rng, given["variables"], 2) for _ in given["variables"])
        given["g"] += f" - {given['variables'][0]}/7"
        try:
            system = core.PiecewiseSystem(name="drawn", **given, parameters=PARAMETERS)
        except ValueError:
            continue
        method = list(core.METHODS.values())[k % len(core.METHODS)]
        for text in texts_of(system, method):
            assert not unknown_names(text), (given, method.name)


def values(texts, variables, t, x):
    """Values of texts at a state."""
    point = {**K, "t": float(t), **dict(zip(variables, map(float, x), strict=True))}
    return np.array([evaluated(text, point) for text in texts])


KINK = 1e-2
"""Part of the usual step to which steps shrink at a kink: 10⁻⁵ or less; of 120 smooth draws none shrank below 0.3."""

MOST_EVALUATIONS = 5000
"""Of a field along its solution: several times what the 60 steps take that are the most of a moderate one."""


def flow(field, variables, t, x, end):
    """Solution with dense output, None where it is not moderate."""
    codes = [compile(text, "drawn", "eval") for text in field]
    if not np.abs(values(codes, variables, t, x)).max() < 8:
        return None
    spent = count()

    def rates(s, y):
        if next(spent) > MOST_EVALUATIONS:  # a stiff field, as few draws are
            raise TimeoutError
        return values(codes, variables, s, y)

    try:
        solution = solve_ivp(rates, (t, end), x, "DOP853", dense_output=True, rtol=1e-13, atol=1e-13)
    except TimeoutError:
        return None
    moderate = solution.success and len(solution.t) < 60 and np.abs(solution.y).max() < 8
    return solution if moderate and not meets_a_kink(solution.t) else None


def meets_a_kink(times):
    """Whether steps shrink on the way by far, as where u of a drawn √u² changes sign: such a field is not smooth."""
    steps = np.abs(np.diff(times))
    return len(steps) > 3 and bool(steps[1:-1].min() < KINK * np.median(steps))


def drawn_crossing(rng, depth=2):
    """A declaration whose run crosses g = 0 in the middle, once; its start, and the states there and at the end."""
    while True:
        given = drawn_declaration(rng, depth)
        x0 = rng.uniform(0.3, 0.9, size=len(given["variables"]))
        found = crossing_of(given, x0)
        if found is not None:
            return given, x0, *found


def crossing_of(given, x0):
    """Shift g so that it is zero where the flow is in the middle of the run, if it rises, or falls, all the way."""
    g, variables = given["g"], given["variables"]
    if not any(v in parse(g, (*variables, *K)).free_symbols for v in map(sympy.Symbol, variables)):
        return None

    def rises(solution, towards):
        times = np.linspace(solution.t[0], solution.t[-1], 9)
        heights = [values([g], variables, t, solution.sol(t))[0] for t in times]
        return bool((np.diff(heights) * towards > 5e-3).all())

    for word, other, towards in (("minus", "plus", 1), ("plus", "minus", -1)):
        first = flow(given[f"f_{word}"], variables, START, x0, MIDDLE)
        if first is None or not rises(first, towards):
            continue
        middle = first.y[:, -1]
        second = flow(given[f"f_{other}"], variables, MIDDLE, middle, END)
        if second is not None and rises(second, towards):
            given["g"] = f"{g} - ({float(values([g], variables, MIDDLE, middle)[0])!r})"
            return middle, second.y[:, -1]
    return None


def run_of(system, method, steps):
    size = {"tolerance": 1e-13} if method.adaptive else {"tau": (END - START) / steps}
    return core.integrate(system, (START, END), method=method.name, **size)


def methods_for(system):
    conserved = system.psi_minus and system.psi_plus
    return [method for method in core.METHODS.values() if conserved or not method.needs_conserved]


def test_crossings_and_states_are_where_scipy_has_them(draws):
    for k, rng in enumerate(draws(4)):
        given, x0, middle, end = drawn_crossing(rng)
        system = core.PiecewiseSystem(name="drawn", **given, parameters=PARAMETERS, x0=x0)
        method = methods_for(system)[k % len(methods_for(system))]
        runs = [run_of(system, method, steps) for steps in (32, 64)]  # from 8 to 16 rk8 may not show its order yet
        case = (given, x0.tolist(), method.name, [run.message for run in runs])
        assert all(run.status is core.Status.COMPLETED and len(run.crossings) == 1 for run in runs), case
        errors = [np.abs(run.x[-1] - end).max() + abs(run.crossings.t[0] - MIDDLE) for run in runs]
        allowed = 0.0 if method.adaptive else errors[0] * 2.0 ** (1.5 - method.order)
        assert errors[1] < max(allowed, _FLOOR), (case, errors)
        assert np.abs(runs[1].crossings.x[0] - middle).max() < 10 * errors[0] + _FLOOR, case


def test_after_a_jump_the_state_is_what_the_text_says(draws):
    for k, rng in enumerate(draws(2)):
        given, x0, middle, _ = drawn_crossing(rng)
        jump = tuple(f"{v} + 0.05*tanh({drawn_readable(rng, given['variables'], 2)})" for v in given["variables"])
        system = core.PiecewiseSystem(name="drawn", **given, parameters=PARAMETERS, x0=x0, jump=jump)
        run = run_of(system, methods_for(system)[-1 - k % len(methods_for(system))], 16)
        case = (given, jump, x0.tolist(), run.message)
        assert isinstance(run.status, core.Status), case
        assert np.abs(run.crossings.x[0] - middle).max() < 1e-2, case
        expected = values(jump, given["variables"], run.crossings.t[0], run.crossings.x[0])
        np.testing.assert_allclose(run.crossings.x_after[0], expected, rtol=0, atol=1e-12, err_msg=str(case))
