"""The entry of `panel serve app.py`."""

import sys

import panel as pn

from pwsviz.page.explorer import Explorer

# Work runs in threads beside the event loop. By Python's usual 5 ms a slider would wait for dozens of turns.
sys.setswitchinterval(5e-4)
pn.extension(respect_explicit_sizing=True)
Explorer().page().servable()
