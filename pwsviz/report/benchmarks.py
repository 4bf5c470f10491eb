"""The benchmark, run beside the report, and its tables read back out of the text."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["bench_tables", "run_bench"]

_BETWEEN = re.compile(r" {3,}")
_SECTIONS = re.compile(r"\n\n(?! )")
_THOUSANDS = re.compile(r"\d{1,3}(,\d{3})+")


def run_bench(quick: bool, heard: Callable[[str], object]) -> str:
    """Run ``python -m pwsviz bench`` and return what it printed.

    In a process of its own: it measures memory and first calls, which the figures before it would spoil.

    Parameters
    ----------
    quick : bool
        With figures too small to state.
    heard : callable
        Told the title of each section that has begun.

    Raises
    ------
    subprocess.CalledProcessError
        Where it failed; it has then said why.
    """
    command = [sys.executable, "-m", "pwsviz", "bench", *(["--quick"] if quick else [])]
    lines: list[str] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, encoding="utf-8") as child:  # noqa: S603 - our own
        try:
            for line in child.stdout or ():
                if lines and lines[-1] == "\n" and not line.startswith(" "):
                    heard(_title(line))
                lines.append(line)
        except BaseException:  # whoever gives up must not leave it running
            child.terminate()
            raise
    if child.returncode:
        raise subprocess.CalledProcessError(child.returncode, command)
    return "".join(lines)


def bench_tables(text: str) -> dict[str, dict[str, NDArray[np.str_]]]:
    """Return the tables in the text of a benchmark: columns of words, by the title of the section."""
    found: dict[str, dict[str, NDArray[np.str_]]] = {}
    for block in _SECTIONS.split(text)[1:]:
        title = re.sub("[^a-z0-9]+", "-", _title(block).lower()).strip("-")
        tables = list(_tables(block.splitlines()))
        for number, (header, *rows) in enumerate(tables, start=1):
            columns = {name: np.array(cells) for name, *cells in zip(_distinct(header), *rows, strict=True)}
            found[title if len(tables) == 1 else f"{title}-{number}"] = columns
    return found


def _title(block: str) -> str:
    """Return the first words of a section, up to a colon, comma or number."""
    return re.split(r"[:,\n]| \d", block, maxsplit=1)[0]


def _tables(lines: Sequence[str]) -> Iterator[list[list[str]]]:
    """Yield runs of lines of several cells, as many in each; where some are left empty, columns are not certain."""
    table: list[list[str]] = []
    for line in [*lines, ""]:
        cells = [_cell(cell) for cell in _BETWEEN.split(line[2:])] if line.startswith("  ") else []
        if len(cells) > 1:
            table.append(cells)
            continue
        if len(table) > 1 and len({len(row) for row in table}) == 1:
            yield table
        table = []


def _cell(text: str) -> str:
    """Return a number as programs read it; nothing for the dash of what was not reached."""
    return "" if text == "-" else text.replace(",", "") if _THOUSANDS.fullmatch(text) else text


def _distinct(names: Sequence[str]) -> list[str]:
    """Number the names that have come before."""
    counts = [names[: k + 1].count(name) for k, name in enumerate(names)]
    return [f"{name} {count}".strip() if count > 1 else name for name, count in zip(names, counts, strict=True)]
