"""The report as one self-contained page of HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bokeh.embed import file_html
from bokeh.resources import INLINE, Resources
from jinja2 import Environment, FileSystemLoader

from pwsviz.report.panels import Panel
from pwsviz.text.numbers import printed

__all__ = ["Bench", "Figure", "page_html"]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper: its panels, the data files of each, and the seconds it took."""

    label: str
    panels: tuple[Panel, ...]
    files: tuple[tuple[str, ...], ...]
    seconds: float


@dataclass(frozen=True)
class Bench:
    """The text that the benchmark printed, and its files."""

    text: str
    files: tuple[str, ...]
    quick: bool


_TEMPLATES = Environment(loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True)
_TEMPLATES.filters["printed"] = printed


def page_html(
    figures: Sequence[Figure],
    titles: Mapping[str, str],
    about: Sequence[str],
    bench: Bench | None = None,
    missing: str = "",
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    figures : sequence of Figure
        The figures to show; a Bokeh figure can be on one page only.
    titles : mapping of label to str
        Titles of the paper's figures.
    about : sequence of str
        Lines on versions and the machine.
    bench : Bench, optional
        The benchmark, if it was run.
    missing : str
        Sentence on what is missing; empty if nothing is.
    """
    # Bokeh's own choice would link to files of Panel's models where Panel is loaded.
    libraries = Resources(mode="inline", components=["bokeh"]).js_raw
    return file_html(
        [panel.plot for drawn in figures for panel in drawn.panels],
        INLINE,
        "pwsviz: figures of the paper",
        template=_TEMPLATES.get_template("report.html"),
        template_variables={
            "libraries": libraries, "figures": figures, "titles": titles, "about": about, "bench": bench,
            "missing": missing,
        },
        suppress_callback_warning=True,  # about callbacks of the explorer, which have no server here
    )  # fmt: skip
