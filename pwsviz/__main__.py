"""The command line: python -m pwsviz serve | report | bench."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

__all__ = ["main"]

Command = Callable[[argparse.Namespace], int]

GIVEN_UP = 130
"""Exit status after Ctrl+C: 128 + SIGINT (2), the convention of shells."""

_EPILOG = """\
examples:
  python -m pwsviz serve                   open the explorer in a browser
  python -m pwsviz report --out figures    every figure of the paper, and the benchmark, into a folder
  python -m pwsviz bench                   every figure that the README states, measured here
  python -m pwsviz COMMAND --help          more about a command

environment:
  PWSVIZ_CACHE   folder for compiled integrators, writable by you alone; by default pwsviz in the user's cache.
                 The time loop is compiled once on a machine, in some ten seconds, and then loaded from there.
"""

_SERVE = """\
examples:
  python -m pwsviz serve
  python -m pwsviz serve --port 8080 --no-show
  python -m pwsviz serve --address 0.0.0.0 --port 80 --allow-websocket-origin pws.example.org --num-procs 4 --no-show
  python -m pwsviz serve -- --prefix /explorer        what follows -- is passed on to `panel serve`

If the page is reached by another name than localhost (a proxy, a tunnel, another machine), allow that name by
--allow-websocket-origin: the server refuses browsers that opened the page by a name it does not know.

A process computes a picture once for all its visitors. Several processes (--num-procs N) serve more visitors at a
time, but each has its own cache: the same picture may be computed, and held, N times. Compiled integrators are shared.
Windows cannot fork, so there is only one process there. Ctrl+C ends all processes; a signal from elsewhere has to be
sent to the whole process group.
The first scene is computed while the server starts, so that the first visitor need not wait.

environment:
  PWSVIZ_CACHE   folder for compiled integrators, writable by you alone; by default pwsviz in the user's cache
"""

_REPORT = """\
Writes report.html, a page that holds all it needs (some 2 MB, most of it BokehJS) and opens from the file system, and
beside it the data of every figure as CSV (some 30 MB in all, at the integrators' own steps). Files of these names are
replaced. The figures take less than a minute, the benchmark some minutes. Ctrl+C keeps what was written so far.

examples:
  python -m pwsviz report --out figures
  python -m pwsviz report --out figures --no-bench
  python -m pwsviz report --out figures --no-bench --only fig:CQ_elliptic --only fig:elliptic_time

figures: fig:vftypes fig:portraits fig:harmonic_timeError fig:harmonic_transition fig:CQ_harmonic fig:elliptic_time
  fig:elliptic_transition fig:CQ_elliptic

environment:
  PWSVIZ_CACHE   folder for compiled integrators, writable by you alone; by default pwsviz in the user's cache
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status."""
    given = _parser().parse_args(arguments)
    command: Command = given.command
    try:
        return command(given)
    except KeyboardInterrupt:
        print("\nInterrupted.", file=sys.stderr)
        return GIVEN_UP


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog="python -m pwsviz",
        description="See, trust and use numerical integration of systems whose law changes on a surface.",
        epilog=_EPILOG,
        formatter_class=raw,
    )
    commands = parser.add_subparsers(required=True, metavar="serve | report | bench")

    def add(
        name: str, command: Callable[[argparse.Namespace], int], words: str, epilog: str
    ) -> argparse.ArgumentParser:
        sentence = f"{words[0].upper()}{words[1:]}."
        added = commands.add_parser(name, help=words, description=sentence, epilog=epilog, formatter_class=raw)
        added.set_defaults(command=command)
        return added

    _add_serve_options(add("serve", _serve, "open the explorer", _SERVE))
    words = "write every figure of the paper, and the benchmark, to a page and CSV files"
    _add_report_options(add("report", _report, words, _REPORT))
    words = "measure speed (against SciPy and heyoka), conservation and order here"
    _add_bench_options(add("bench", _bench, words, ""))
    return parser


def _add_serve_options(serve: argparse.ArgumentParser) -> None:
    serve.add_argument("--port", type=_port, default=5006, help="port to listen on, 0 for any free one (default: 5006)")
    serve.add_argument("--address", default="localhost", help="address to listen on (default: localhost)")
    serve.add_argument("--no-show", action="store_true", help="do not open a browser")
    serve.add_argument(
        "--num-procs", type=_count, default=1, metavar="N", help="processes to serve visitors; 0: one a processor "
        "(default: 1)",
    )  # fmt: skip
    serve.add_argument(
        "--allow-websocket-origin", action="append", default=[], metavar="HOST[:PORT]",
        help="a further name by which the page is reached; may be repeated",
    )  # fmt: skip
    serve.add_argument("panel", nargs="*", metavar="-- OPTION", help="further options of `panel serve`")


def _add_report_options(report: argparse.ArgumentParser) -> None:
    report.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write to; made if need be")
    report.add_argument("--only", action="append", default=[], metavar="FIGURE", help="this figure; may be repeated")
    report.add_argument("--no-bench", action="store_true", help="leave the benchmark out")
    report.add_argument("--quick", action="store_true", help="a benchmark with figures too small to state")


def _add_bench_options(bench: argparse.ArgumentParser) -> None:
    size = bench.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="every section, with figures too small to state")
    size.add_argument("--long", action="store_true", help="runs of 10^8 steps too")


def _port(text: str) -> int:
    return _whole(text, 65535)


def _count(text: str) -> int:
    return _whole(text, 1024)


def _whole(text: str, most: int) -> int:
    if not text.isdecimal() or int(text) > most:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 to {most}")
    return int(text)


# Each command imports what it needs when it runs: the help then appears at once, and `serve` may fork, which is unsafe
# in a process that has loaded compiled code and started threads.


def _serve(given: argparse.Namespace) -> int:
    from pwsviz.server.serving import Unavailable, serve

    try:
        serve(given.port, given.address, not given.no_show, given.num_procs, given.allow_websocket_origin, given.panel)
    except Unavailable as why:
        print(why, file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # the usual way to stop the server
        pass
    return 0


def _report(given: argparse.Namespace) -> int:
    from pwsviz.report import Unwritable, figures_of_paper, write_report

    unknown = [label for label in given.only if label not in figures_of_paper()]
    if unknown:
        print(
            f"{unknown[0]!r} is not a figure of the paper; there are {', '.join(figures_of_paper())}.", file=sys.stderr
        )
        return 2
    started = time.perf_counter()
    files: list[Path] = []
    try:
        write_report(given.out, sys.stdout, files, given.only, not given.no_bench, given.quick)
    except Unwritable as why:
        print(f"\n{why}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"\nInterrupted; {_written(files, given.out)}", file=sys.stderr)
        return GIVEN_UP
    print(f"{_written(files, given.out)} {time.perf_counter() - started:.0f} s in all.")
    return 0


def _written(files: list[Path], folder: Path) -> str:
    if not files:
        return "nothing is written."
    size = sum(file.stat().st_size for file in files) / 1e6
    page = next((file for file in files if file.suffix == ".html"), None)
    opened = f"; open {page}" if page else ""
    return f"{len(files)} files are written to {folder} ({size:.1f} MB){opened}."


def _bench(given: argparse.Namespace) -> int:
    from pwsviz.bench import LONG, QUICK, STANDARD, sections
    from pwsviz.bench.machine import machine_lines

    print(*machine_lines(), sep="\n")
    for table in sections(QUICK if given.quick else LONG if given.long else STANDARD):
        print(f"\n{table.text}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
