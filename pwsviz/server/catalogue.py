"""Compile beside the server, once on a machine, what the first pictures need: they then only load it from disk.

First come the loops of all systems: the server itself compiles that of the first picture meanwhile. Then the catalogue.

``python -m pwsviz.server.catalogue`` does it in the process that runs it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from threading import Thread

import numpy as np

import core
from core.integration import LOOPS_BESIDE
from pwsviz.geometry.bends import bent_pieces
from pwsviz.geometry.polyline_reduction import longest_side, painted_first, screen_path
from pwsviz.results.requests import sliding_of
from pwsviz.scene.scene import Scene

__all__ = ["compile_beside_once", "compile_catalogue", "compile_loops", "declare_beside_once"]

LEAST_PRIORITY = 19
"""Niceness of the process that compiles: it takes only the time that nobody else wants."""


@cache
def compile_beside_once() -> subprocess.Popen[bytes]:
    """Start a process that compiles loops and catalogue and ends; later calls in the same process start no other."""
    command = [sys.executable, "-m", "pwsviz.server.catalogue"]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)  # noqa: S603  (our own)


@cache
def declare_beside_once() -> Thread:
    """Start a thread that declares the catalogue, whose names the list of systems shows; later calls start no other."""
    thread = Thread(target=lambda: list(core.CATALOGUE.values()), name="pwsviz-catalogue", daemon=True)
    thread.start()
    return thread


def compile_loops() -> None:
    """Compile what a picture needs besides the time loop, and then what other views do."""
    LOOPS_BESIDE[0]()
    _draw_a_circle()
    for loop in LOOPS_BESIDE[1:]:
        loop()


def _draw_a_circle() -> None:
    """Call what is compiled to draw a curve."""
    t = np.linspace(0.0, 6.0, 100)
    points = np.column_stack((np.cos(t), np.sin(t)))
    kinks = np.zeros(len(t), dtype=bool)
    bent_pieces(t, points, kinks, longest_side(points) / 1000)
    painted_first(points, 0.01)
    screen_path(points, kinks)


def compile_catalogue(names: Iterable[str]) -> None:
    """Compile what systems of the catalogue are first shown with, in this order: their runs enter all their modes."""
    for name in names:
        scene = Scene(system=name)
        for method in scene.used:
            sliding = sliding_of(scene.slides)
            span = (0.0, scene.t_end)
            core.integrate(scene.build(), span, method=method, tau=scene.tau, sliding=sliding).change_of_psi()


if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(LEAST_PRIORITY)
    compile_loops()
    compile_catalogue(core.CATALOGUE)
