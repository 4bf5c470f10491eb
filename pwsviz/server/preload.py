"""What Panel runs once in each process of the server (``--setup``), so that the first visitor need not wait.

The imports, which take seconds, are made before the server listens. The first picture, for which integrators are
compiled or loaded, is computed in a thread; a visitor who comes meanwhile shares the result.
"""

from __future__ import annotations

import gc
from threading import Thread

import scipy.integrate  # noqa: F401  (a run that escapes needs it: a fifth of a second at the first)
from bokeh.settings import settings

from pwsviz.page.explorer import COVER, RESULTS
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import PortraitInputs
from pwsviz.scene.first import first_scene
from pwsviz.server.catalogue import compile_beside_once, declare_beside_once


def compute_first_scene() -> None:
    """Compute what a new page shows, into the cache that all visitors share."""
    scene = first_scene()
    runs = run_inputs(scene)
    RESULTS.pictures(PortraitInputs.of(scene))
    RESULTS.error_curves(runs)
    RESULTS.diagnosis(runs[0])  # the message of a run that stops early needs what this prepares


BETWEEN_COLLECTIONS = 50_000
"""New objects after which the collector of garbage looks for cycles; each message makes one for each model of a page,
so that with Python's default of 700 it would look several times a message."""

BETWEEN_FULL_COLLECTIONS = 100
"""Collections of the younger objects between two of all. One of all takes 1 s beside the pages of 25 people, who wait
meanwhile; with Python's default of 10 it came each 15 s, and what it freed was some 200 objects a message."""


def prepare() -> None:
    """Compute the first scene while another process compiles what it needs next, and keep what there is by then.

    The collector of garbage stops all to go through it.
    """
    compile_beside_once()
    compute_first_scene()
    COVER.draw()
    declare_beside_once().join()
    gc.freeze()
    gc.set_threshold(BETWEEN_COLLECTIONS, 10, BETWEEN_FULL_COLLECTIONS)


if __name__ == "panel_setup_module":
    settings.simple_ids = True  # the default, which Bokeh else looks up in the environment for each id
    settings.perform_document_validation = False  # it visits all models of each page; a test does it once
    Thread(target=prepare, name="pwsviz-preload", daemon=True).start()
