"""What Panel runs once in each process of the server (``--setup``), so that the first visitor need not wait.

The imports, which take seconds, are made before the server listens. The first picture, for which integrators are
compiled or loaded, is computed in a thread; a visitor who comes meanwhile shares the result.
"""

from __future__ import annotations

from threading import Thread

from pwsviz.page.explorer import RESULTS
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import PortraitInputs
from pwsviz.scene.scene import Scene


def compute_first_scene() -> None:
    """Compute what a new page shows, into the cache that all visitors share."""
    scene = Scene()
    runs = run_inputs(scene)
    RESULTS.pictures(PortraitInputs.of(scene))
    RESULTS.error_curves(runs)


if __name__ == "panel_setup_module":
    Thread(target=compute_first_scene, name="pwsviz-preload", daemon=True).start()
