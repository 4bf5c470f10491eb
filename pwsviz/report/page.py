"""The report as one page of HTML, with everything it needs inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bokeh.embed import file_html
from bokeh.resources import INLINE, Resources
from jinja2 import Environment, FileSystemLoader

from pwsviz.report.panels import Panel

__all__ = ["Bench", "Figure", "page_html"]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper: its panels, and the file of each."""

    label: str
    panels: tuple[Panel, ...]
    files: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class Bench:
    """What the benchmark printed, and its files."""

    text: str
    files: tuple[str, ...]
    quick: bool


_TEMPLATES = Environment(loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True)


def page_html(
    figures: Sequence[Figure],
    titles: Mapping[str, str],
    about: Sequence[str],
    bench: Bench | None = None,
    missing: str = "",
) -> str:
    """Return the page.

    Parameters
    ----------
    figures : sequence of Figure
        What was drawn; a figure can be on one page only.
    titles : mapping of label to str
        What the paper's figures show.
    about : sequence of str
        Lines on versions and the machine.
    bench : Bench, optional
        Where it was run.
    missing : str
        What there was no time for.
    """
    # Not what Bokeh would put in their place: where Panel is loaded, that links to files of Panel's models.
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
        suppress_callback_warning=True,  # of the page's own callbacks; here nobody answers them
    )  # fmt: skip
