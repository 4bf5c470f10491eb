"""The entry of `panel serve app.py`."""

import panel as pn

from pwsviz.explorer import Explorer

pn.extension(respect_explicit_sizing=True)
Explorer().page().servable()
