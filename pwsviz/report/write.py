"""Compute the figures one after another, report progress, and write the files."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TextIO

from pwsviz.bench import QUICK, STANDARD, sections
from pwsviz.bench.machine import machine_lines
from pwsviz.export.about import release
from pwsviz.export.files import Table, csv_bytes
from pwsviz.report.page import Bench, Figure, page_html
from pwsviz.report.panels import Panel, draw_panel
from pwsviz.results.results import Results
from pwsviz.scene.presets import PRESETS, Preset

__all__ = ["FIGURES", "PAGE", "Unwritable", "figures_of_paper", "write_report"]

#: File name of the page.
PAGE = "report.html"

FIGURES = {
    "fig:vftypes": "Four kinds of vector field at the surface",
    "fig:portraits": "Trajectories of the two systems",
    "fig:harmonic_timeError": "Oscillator: error of the crossing time",
    "fig:harmonic_transition": "Oscillator: order across the surface",
    "fig:CQ_harmonic": "Oscillator: error of the energy",
    "fig:elliptic_time": "Elliptic curve: error of the crossing time",
    "fig:elliptic_transition": "Elliptic curve: order across the surface",
    "fig:CQ_elliptic": "Elliptic curve: error of the conserved quantity",
}
"""Label -> title of the figures of the paper, in its order."""


class Unwritable(Exception):  # noqa: N818  (not an error of the program)
    """A file cannot be written; the text says which, and why."""


def figures_of_paper() -> dict[str, tuple[Preset, ...]]:
    """Return the presets that make up each figure of the paper, by its label, in the paper's order."""
    return {label: tuple(one for one in PRESETS.values() if one.figure == label) for label in FIGURES}


def write_report(
    folder: Path,
    say: TextIO,
    files: list[Path],
    only: Sequence[str] = (),
    bench: bool = True,
    quick: bool = False,
) -> None:
    """Write the page, and a CSV for each panel and each table of the benchmark.

    If the work is interrupted by Ctrl+C or fails, what has been computed is written, and the page says what is
    missing.

    Parameters
    ----------
    folder : Path
        Where the files are written; it is created if it does not exist. Files of the same name are replaced.
    say : text file
        Where progress is printed, a line for each figure.
    files : list of Path
        Extended by each file that is written.
    only : sequence of str
        Labels of the figures to write; all by default.
    bench, quick : bool
        Whether to run the benchmark too, and whether with runs too short for numbers to state.

    Raises
    ------
    Unwritable
        If the folder, or a file, cannot be written.
    ValueError
        On an unknown label.
    """
    wanted = _checked_labels(only)
    work = _Report(_checked_folder(folder), say, files)
    steps: dict[str, Callable[[], None]] = {
        f"{label}  {FIGURES[label]}": partial(work.add_figure, label, presets) for label, presets in wanted.items()
    }
    if bench:
        steps["Benchmark"] = partial(work.add_bench, quick)
    done: list[str] = []
    try:
        for number, (name, step) in enumerate(steps.items(), start=1):
            print(f"[{number}/{len(steps)}] {name} … ", end="", file=say, flush=True)
            started = time.perf_counter()
            step()
            print(f"{time.perf_counter() - started:.1f} s", file=say, flush=True)
            done.append(name)
    finally:
        lacking = [name.split("  ")[0] for name in steps if name not in done]
        if done:
            work.write_page(f"Given up before the end; missing: {', '.join(lacking)}." if lacking else "")


def _checked_folder(folder: Path) -> Path:
    """Create the folder, and test that a file can be written there, before minutes of work."""
    probe = folder / ".pwsviz-report"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as why:
        raise Unwritable(f"cannot write to {folder}: {why.strerror or why}. Choose another folder by --out.") from None
    return folder


def _checked_labels(only: Sequence[str]) -> Mapping[str, tuple[Preset, ...]]:
    figures = figures_of_paper()
    for label in only:
        if label not in figures:
            raise ValueError(f"{label!r} is not a figure of the paper; there are {', '.join(figures)}")
    return {label: presets for label, presets in figures.items() if not only or label in only}


class _Report:
    """The figures and the benchmark computed so far, and their files."""

    def __init__(self, folder: Path, say: TextIO, files: list[Path]) -> None:
        self._folder, self._say, self._files = folder, say, files
        self._results = Results()
        self._figures: list[Figure] = []
        self._bench: Bench | None = None

    def add_figure(self, label: str, presets: Sequence[Preset]) -> None:
        """Compute a figure of the paper, and write its data."""
        started = time.perf_counter()
        panels = tuple(draw_panel(preset, self._results) for preset in presets)
        seconds = time.perf_counter() - started
        files = tuple(self._write_tables(panel) for panel in panels)
        self._figures.append(Figure(label, panels, files, seconds))

    def add_bench(self, quick: bool) -> None:
        """Run the benchmark, and write what it printed and its tables."""
        print("some minutes" if not quick else "a minute", end="", file=self._say, flush=True)
        texts, files = ["\n".join(machine_lines())], []
        for table in sections(QUICK if quick else STANDARD):
            print(f"; {table.title}", end="", file=self._say, flush=True)
            texts.append(table.text)
            files.append(self._write_table(f"bench-{table.title.lower().replace(' ', '-')}", table.columns))
        print(": ", end="", file=self._say)
        text = "\n\n".join(texts) + "\n"
        self._write("bench.txt", text.encode())
        self._bench = Bench(text, ("bench.txt", *files), quick)

    def write_page(self, missing: str) -> None:
        """Write the page with all that has been computed."""
        page = page_html(self._figures, FIGURES, _about(), self._bench, missing)
        self._write(PAGE, page.encode())

    def _write_tables(self, panel: Panel) -> tuple[str, ...]:
        """Write the tables of a panel, and return the names of the files."""
        key, tables = panel.preset.key, panel.tables.items()
        return tuple(self._write_table(f"{key}-{name}", table(), panel.about) for name, table in tables)

    def _write_table(self, name: str, table: Table, about: Mapping[str, str] | None = None) -> str:
        file = f"{name}.csv"
        self._write(file, csv_bytes(table, about))
        return file

    def _write(self, name: str, content: bytes) -> None:
        path = self._folder / name
        try:
            path.write_bytes(content)
        except OSError as why:
            raise Unwritable(f"cannot write {path}: {why.strerror or why}") from None
        self._files.append(path)


def _about() -> list[str]:
    return [f"{release()}, {datetime.now(UTC):%Y-%m-%d}; Bokeh {version('bokeh')}", *machine_lines()]
