"""python -m pwsviz serve: the page on a port, by way of `panel serve` with settings that suit it."""

from __future__ import annotations

import errno
import os
import runpy
import socket
import sys
from collections.abc import Sequence
from pathlib import Path

__all__ = ["PANEL_SETTINGS", "Unavailable", "panel_arguments", "require_port", "serve"]

LOCAL = ("localhost", "127.0.0.1", "::1")
"""Addresses that only this machine reaches."""

PANEL_SETTINGS = (
    # Milliseconds between checks for sessions without a browser, which hold memory; Panel's default is 17 s.
    "--check-unused-sessions", "5000",
    # Milliseconds for which such a session is kept: long enough for a broken connection to come back.
    "--unused-session-lifetime", "15000",
    # Seconds within which a page has to open its session: it may load slowly, and the default is five minutes.
    "--session-token-expiration", "3600",
    # Milliseconds between pings: proxies close connections that are silent for 30 or 60 s.
    "--keep-alive", "25000",
)  # fmt: skip
"""Options of `panel serve`. --num-threads is not among them, as the page computes in threads of its own."""


class Unavailable(Exception):  # noqa: N818  (its text is shown to the user)
    """The server cannot listen on the port; the text says why, and what to do."""


def serve(
    port: int,
    address: str,
    show: bool = True,
    num_procs: int = 1,
    origins: Sequence[str] = (),
    more: Sequence[str] = (),
) -> None:
    """Serve the page until interrupted.

    Parameters
    ----------
    port, address
        Where to listen; port 0 takes any free port.
    show : bool
        Whether to open a browser.
    num_procs : int
        Processes to serve visitors; 0 is one for each processor. Each has its own cache of results.
    origins : sequence of str
        Further names, HOST or HOST:PORT, by which visitors reach the page.
    more : sequence of str
        Further options of `panel serve`.

    Raises
    ------
    Unavailable
        If the server cannot listen on the port.
    """
    require_port(port, address)
    if address not in LOCAL and not origins:
        print(
            f"Visitors who open the page by another name than localhost:{port} will be refused: "
            f"allow that name by --allow-websocket-origin NAME:{port}.",
            file=sys.stderr,
        )
    sys.argv = ["panel", *panel_arguments(port, address, show, num_procs, origins, more)]
    runpy.run_module("panel", run_name="__main__", alter_sys=True)  # in this process, so that signals reach it


def panel_arguments(
    port: int, address: str, show: bool, num_procs: int, origins: Sequence[str], more: Sequence[str] = ()
) -> list[str]:
    """Return the command-line arguments for `panel`."""
    here = Path(__file__).parent
    count = num_procs or os.cpu_count() or 1  # counted here: with --num-procs 0 Panel would preload before it forks
    names = (
        [f"localhost:{port}", *origins] if origins else []
    )  # once others are given, localhost is not allowed by default
    return [
        "serve", str(here.parents[1] / "app.py"), "--port", str(port), "--address", address,
        "--num-procs", str(count), "--setup", str(here / "preload.py"),
        *PANEL_SETTINGS,
        *(word for name in names for word in ("--allow-websocket-origin", name)),
        *(["--show"] if show else []),
        *more,
    ]  # fmt: skip


def require_port(port: int, address: str) -> None:
    """Check that the server can listen on a port.

    Raises
    ------
    Unavailable
        If the port is taken or not permitted, or the address is not one of this machine.
    """
    reason = _refusal(port, address)
    if reason is None:
        return
    if reason == errno.EADDRINUSE:
        other = next((p for p in range(port + 1, min(port + 100, 2**16)) if _refusal(p, address) is None), 0)
        raise Unavailable(
            f"Port {port} of {address} is taken, perhaps by an explorer that is already running: look at "
            f"http://{address}:{port}, or take another port, as in --port {other}."
        )
    if reason == errno.EACCES:
        raise Unavailable(f"Port {port} is not permitted to you: take one from 1024 on, as in --port 5006.")
    raise Unavailable(
        f"{address} is not an address of this machine: use --address localhost, or 0.0.0.0 to be reached from others."
    )


def _refusal(port: int, address: str) -> int | None:
    """Return the error number of trying to listen on a port; None if that works."""
    try:
        found = socket.getaddrinfo(address, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except socket.gaierror:
        return errno.EADDRNOTAVAIL
    refusals = [_bind(family, where) for family, _, _, _, where in found]
    if all(refusals):  # IPv4 may be available without IPv6, or the reverse
        return refusals[0]
    return errno.EADDRINUSE if errno.EADDRINUSE in refusals else None


def _bind(family: int, where: tuple[object, ...]) -> int | None:
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        if os.name == "posix":  # as the server does, so that a port that was just closed counts as free
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(where)
        except OSError as why:
            return why.errno
    return None
