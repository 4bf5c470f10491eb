"""The application that `panel serve app.py` runs."""

import sys

import panel as pn

from pwsviz.page.explorer import Explorer
from pwsviz.server.catalogue import compile_beside_once, declare_beside_once
from pwsviz.server.sessions import send_every_message, send_messages_at_once, send_pages_at_once

# Seconds between thread switches. Computations run in threads beside the event loop; at Python's default of 5 ms a
# slider would wait for dozens of switches.
sys.setswitchinterval(5e-4)
pn.extension(respect_explicit_sizing=True)
send_pages_at_once()
send_messages_at_once()
send_every_message()
Explorer().page().servable()
declare_beside_once()
pn.state.onload(compile_beside_once)
