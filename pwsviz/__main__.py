"""python -m pwsviz serve | bench."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

__all__ = ["main"]

_EPILOG = """\
examples:
  python -m pwsviz serve              open the explorer in a browser
  python -m pwsviz serve --port 8080 --no-show
  python -m pwsviz bench              every figure that the README states, measured here, with SciPy and heyoka
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="pwsviz",
        description="See, trust and use numerical integration of systems whose law changes on a surface.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="serve | bench")
    serve = commands.add_parser("serve", help="open the explorer")
    serve.add_argument("--port", type=int, default=5006, help="port to listen on (default: 5006)")
    serve.add_argument("--address", default="localhost", help="address to listen on (default: localhost)")
    serve.add_argument("--no-show", action="store_true", help="do not open a browser")
    bench = commands.add_parser("bench", help="measure speed (against SciPy and heyoka), conservation and order here")
    size = bench.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="every section, with figures too small to state")
    size.add_argument("--long", action="store_true", help="runs of 10^8 steps too")
    given = parser.parse_args(arguments)
    if given.command == "serve":
        return _serve(given.port, given.address, not given.no_show)
    from pwsviz.bench import LONG, QUICK, STANDARD, report  # here: `serve` has no need of it

    report(sys.stdout, QUICK if given.quick else LONG if given.long else STANDARD)
    return 0


def _serve(port: int, address: str, show: bool) -> int:
    app = Path(__file__).parents[1] / "app.py"
    command = [sys.executable, "-m", "panel", "serve", str(app), "--port", str(port), "--address", address]
    try:
        return subprocess.call([*command, *(["--show"] if show else [])])  # noqa: S603 - our own app
    except KeyboardInterrupt:
        return 0


if __name__ == "__main__":
    sys.exit(main())
