"""The application that `panel serve app.py` runs."""

import sys

import panel as pn

from pwsviz.page.explorer import Explorer
from pwsviz.server.catalogue import compile_beside_once

# Seconds between thread switches. Computations run in threads beside the event loop; at Python's default of 5 ms a
# slider would wait for dozens of switches.
sys.setswitchinterval(5e-4)
# A page is sent at once, and its session made while the browser loads the scripts: what a session shows does not depend
# on the page, which holds no part of a scene.
pn.extension(respect_explicit_sizing=True, reuse_sessions=True)
Explorer().page().servable()
pn.state.onload(compile_beside_once)
