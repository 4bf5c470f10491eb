"""The kinds of panes on the page, with their style."""

from __future__ import annotations

from html import escape
from typing import Any

import panel as pn
from bokeh.plotting import figure

from pwsviz.text.maths_font import FORMULAS
from pwsviz.text.words import as_text
from pwsviz.widgets.widths import NARROW

FADED = {"opacity": "0.35"}
"""Additional styles of a pane that shows an outdated result."""

PLAIN = {"opacity": "var(--past, 1)", "visibility": "inherit"}
"""The same of one that does not: the browser keeps a style that is merely left out. It sets `--past` as soon as another
system is chosen, half a second before the server has prepared for it."""

EMPTY = {"visibility": "hidden"}
"""The same of one that shows nothing yet: an empty frame would tell of a picture that is not there."""

PLAIN_SX = {"textTransform": "none", "whiteSpace": "nowrap"}
"""Of buttons: no capitals and no line breaks."""

TEXT_CSS = (
    """
:host { font-size: 0.875rem; line-height: 1.45; color: var(--mui-palette-text-primary); }
p { margin: 0 0 2px 0; }
.heading { font-size: 0.75rem; font-weight: 600; letter-spacing: 0.08em; text-transform: uppercase;
           color: var(--mui-palette-text-secondary); margin: var(--heading, 14px 0 2px 0); }
.about, .which { color: var(--mui-palette-text-secondary); margin: 2px 0 6px 0; }
.about { display: var(--usual, block); }
.law { margin: 0 0 0 1.5em; text-indent: -1.5em; }
.law sup { line-height: 0; }
@media (width >= 1150px) { .law { display: var(--law, block); } }
.error { color: var(--mui-palette-error-main); }
.stopped { border-left: 3px solid var(--mui-palette-warning-main); padding-left: 8px; margin: 4px 0; }
.stopped { height: var(--line, auto); }
.stopped > span { display: block; background: var(--mui-palette-background-default); }
.stopped:not(:hover) > span { white-space: var(--warned, normal); overflow: hidden; text-overflow: ellipsis; }
.stopped:hover > span { position: relative; z-index: 2; }
.more { display: none; font: inherit; color: var(--mui-palette-primary-main); background: none; border: none;
        padding: 2px 6px; margin: 0; cursor: pointer; text-decoration: underline; }
.more::before { content: attr(aria-label); }
@media (width < NARROWpx) {
  .more { display: inline; }
  .more:not([aria-expanded=true]) + .others { display: none; }
}
.numbers { overflow-x: auto; margin: 2px 0 8px 0; }
.numbers table { border-collapse: collapse; font-size: 0.8125rem; }
.numbers caption { text-align: left; color: var(--mui-palette-text-secondary); padding-bottom: 2px;
                   display: var(--usual, table-caption); }
.numbers :is(th, td) { text-align: left; font-weight: 400; padding: 1px 14px 1px 0; vertical-align: baseline; }
.numbers thead th { color: var(--mui-palette-text-secondary); border-bottom: 1px solid var(--mui-palette-divider); }
@media (height < 900px) { .numbers ~ .numbers { display: var(--usual, block); } }
.run { display: flex; align-items: baseline; gap: 8px; }
.run svg { flex: none; align-self: center; }
.run b { font-weight: 600; }
""".replace("NARROW", str(NARROW))
    + FORMULAS
)


WHOLE_CSS = ":host { --warned: normal; --line: auto; }"
"""Of words that scroll, so that a lecture in a small window has room for whole warnings, too."""

BESIDE_HEADING_CSS = ":host { --heading: 0; }"
"""Of a row that begins with a heading: the margin is that of the row."""


class Text(pn.pane.HTML):
    """Markup that changes; Panel would work out all properties and style sheets of the pane at each change."""

    def _update(self, ref: str, model: Any) -> None:
        model.update(**self._process_param_change({"object": self.object}))


def text_pane(words: str, kind: str = "", style: str = "") -> pn.pane.HTML:
    """Return a pane for text; to change it, assign `as_text` of other words to its `object`."""
    return _html(as_text(words, kind), *filter(None, [style]))


def markup_pane(style: str) -> pn.pane.HTML:
    """Return an empty pane for trusted markup, with an additional style sheet."""
    return Text("", stylesheets=[TEXT_CSS, style], margin=0, sizing_mode="stretch_width")


def heading(words: str) -> pn.pane.HTML:
    """Return a small title for a group of controls."""
    return _html(f'<div class="heading" role="heading" aria-level="2">{escape(words)}</div>')


def heading_with(words: str, *controls: Any) -> pn.FlexBox:
    """Return a small title for a group of controls, some of which stand beside it in a row that wraps."""
    title = heading(words)
    title.sizing_mode = None
    return pn.FlexBox(
        title, *controls, align_items="center", gap="0 8px", margin=(6, 0, 0, 0), stylesheets=[BESIDE_HEADING_CSS]
    )


def plot_pane(plot: figure, **options: Any) -> pn.pane.Bokeh:
    """Return a pane for a figure, which is not seen until `fade` says that there is something to see."""
    pane = pn.pane.Bokeh(plot, margin=0, sizing_mode="stretch_width", **options)
    empty(pane)  # given to the constructor, the styles would not reach the figure
    return pane


def empty(pane: pn.pane.Bokeh) -> None:
    """Let a figure not be seen until `fade` shows it plainly."""
    pane.styles = {**pane.object.styles, **EMPTY}


def is_seen(pane: pn.pane.Bokeh) -> bool:
    """Return whether a figure shows anything, be it outdated."""
    return bool(pane.styles.get("visibility") != EMPTY["visibility"])


def leave_out(pane: pn.pane.Bokeh, out: bool = True) -> None:
    """Let a figure take no room, or again take it.

    The figure is told first: the pane takes each property that has its default, such as being visible, from there.
    """
    pane.object.visible = pane.visible = not out


def fade(pane: pn.pane.Bokeh, past: bool) -> None:
    """Fade a figure that shows an outdated result, if it shows any, or show it plainly.

    The styles of a pane replace those of its figure, so all of them are given each time.
    """
    if not past or is_seen(pane):
        pane.styles = {**pane.object.styles, **PLAIN, **(FADED if past else {})}


def _html(markup: str, *styles: str) -> pn.pane.HTML:
    return Text(markup, stylesheets=[TEXT_CSS, *styles], margin=0, sizing_mode="stretch_width")
