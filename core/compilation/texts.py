"""Texts of the modules that a run needs; each is written once for a system, whichever modes and methods share it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from sympy import Expr

from core.codegen.functions import (
    evaluate_switching_text,
    jump_text,
    levels_texts,
    module_text,
)
from core.codegen.projection import project_to_surface_text
from core.codegen.step import StepCode
from core.codegen.taylor_series import event_series_text
from core.compilation.guards import guard_table
from core.methods import Method
from core.methods.taylor_step import prepare_step_text
from core.symbolic.laws import Laws

__all__ = ["rows_of_events", "texts_of_events", "texts_of_modes"]

#: Texts of each kind kept in memory: writing those of a simple mode takes a tenth of a second.
_kept = lru_cache(maxsize=400)


def texts_of_modes(
    laws: Laws, method: Method, levels: bool, numbers: tuple[int, ...]
) -> Iterator[tuple[list[int], str]]:
    """Texts of modules, each with the rows of its functions; those that take longest to compile come first.

    Parameters
    ----------
    levels
        Whether ψ is evaluated where the method does not conserve it, too.
    numbers
        Numbers of the modes.
    """
    first = guard_table(laws).first_rows.tolist()
    modes = [(first[number], number) for number in numbers]
    yield from (([row], _step(laws, method, number)) for row, number in modes)
    if method.adaptive:
        yield from (([row], _prepare_step(laws, number)) for row, number in modes)
    guarded = [(row + k, number, k) for row, number in modes for k in range(len(laws.mode(number).guards))]
    yield from (([row], _project_to_surface(laws, method.conservative, number, k)) for row, number, k in guarded)
    if method.conservative or levels:
        yield from (([row], _levels(laws, number)) for row, number in modes)
    yield from _texts_at_surfaces(laws, numbers, first)


def _texts_at_surfaces(laws: Laws, numbers: tuple[int, ...], first: list[int]) -> Iterator[tuple[list[int], str]]:
    """Texts of what is evaluated where guards vanish; regions share it where they share the surface."""
    shared: dict[str, list[int]] = {}
    wanted = [(mode, k) for mode in numbers if mode < len(laws.regions) for k in range(len(laws.ways[mode]))]
    for mode in numbers:
        if mode >= len(laws.regions):  # where sliding ends, the surface is evaluated with the fields of both regions
            low, high, surface = laws.pairs[mode - len(laws.regions)]
            both = ((region, k) for region in (low, high) for k in range(len(laws.ways[region])))
            wanted += [(region, k) for region, k in both if laws.ways[region][k].surface == surface]
            for k, guard in enumerate(laws.mode(mode).written.guards):
                shared.setdefault(_evaluate_switching(laws, guard, mode), []).append(first[mode] + k)
    for region, k in dict.fromkeys(wanted):
        way = laws.ways[region][k]
        beside = region if way.to is None or way.back is None else way.to
        text = _at_surface(laws, way.surface, (region, beside) if way.sign < 0 else (beside, region), way.jump)
        shared.setdefault(text, []).append(first[region] + k)
    yield from ((rows, text) for text, rows in shared.items())


def rows_of_events(laws: Laws, mode: int, events: tuple[Expr, ...]) -> range:
    """Rows of the event functions in a mode."""
    first = len(guard_table(laws).guards) + mode * len(events)
    return range(first, first + len(events))


def texts_of_events(
    laws: Laws, method: Method, modes: tuple[int, ...], events: tuple[Expr, ...]
) -> Iterator[tuple[list[int], str]]:
    """Texts of event functions, which are evaluated as guards are; modes share their Taylor series."""
    for mode in modes:
        for row, function in zip(rows_of_events(laws, mode, events), events, strict=True):
            yield [row], _evaluate_switching(laws, function, mode)
    for k, function in enumerate(events if method.adaptive else ()):
        rows = [rows_of_events(laws, mode, events)[k] for mode in modes]
        yield rows, module_text([event_series_text(laws, function)])


@_kept
def _step(laws: Laws, method: Method, number: int) -> str:
    mode = laws.mode(number).written
    code = StepCode(laws, mode)
    return module_text([code.text(method.scheme.write(mode, code))])


@_kept
def _prepare_step(laws: Laws, number: int) -> str:
    return module_text([prepare_step_text(laws, laws.mode(number))])


@_kept
def _project_to_surface(laws: Laws, conservative: bool, number: int, guard: int) -> str:
    return module_text([project_to_surface_text(laws, laws.mode(number).written, conservative, guard)])


@_kept
def _levels(laws: Laws, number: int) -> str:
    return module_text(levels_texts(laws, laws.mode(number)))


@_kept
def _evaluate_switching(laws: Laws, function: Expr, number: int) -> str:
    return module_text([evaluate_switching_text(laws, function, [laws.mode(number).written])])


@_kept
def _at_surface(laws: Laws, surface: int, regions: tuple[int, int], jump: tuple[Expr, ...] | None) -> str:
    """Text of a surface with the fields of the regions where it is negative and positive, and of the jump there."""
    texts = [
        evaluate_switching_text(laws, laws.surfaces[surface], [laws.regions[region].written for region in regions])
    ]
    texts += [] if jump is None else [jump_text(laws, jump)]
    return module_text(texts)
