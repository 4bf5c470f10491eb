"""Style sheets of the header, the tabs and the columns of the page."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from pwsviz.page.cover import COLUMNS, LEAST
from pwsviz.widgets.more_tabs import MORE_TABS_SX
from pwsviz.widgets.panes import PLAIN_SX
from pwsviz.widgets.widths import LOW, NARROW

__all__ = [
    "ABOUT_CSS",
    "FOR_TOUCH",
    "GRID_CSS",
    "HEADER_SX",
    "NOT_IN_LECTURES",
    "NOT_ON_PHONES",
    "STACK_CSS",
    "TAGLINE_CSS",
    "tabs_sx",
]

GRID_CSS = f"""
:host {{ {COLUMNS} height: auto !important; max-height: none !important; container-type: inline-size; }}
@media (width < {NARROW}px) {{ :host {{ row-gap: 2px; }} }}
@media (height < {LOW}px) {{ :host {{ --column: {LEAST}px; }} }}
@container (min-width: 880px) {{ .portrait {{ position: sticky; top: 0; }} }}
"""
"""Beside a long view that scrolls, the portrait stays in sight; above one it does not."""

HEADER_SX = {
    **PLAIN_SX, "&&&": {"color": "inherit !important"},
    "@media (width < 480px)": {
        "fontSize": 0, "minWidth": "34px", "--pmui-starticon-mr": "0px !important",
        ".MuiButton-startIcon": {"marginX": 0}, ".MuiIcon-root": {"fontSize": "20px !important"},
    },
}  # fmt: skip
"""Of a button in the header, whose theme assumes a coloured bar and sets white text; on a phone its icon is seen."""

#: Titles as narrow as possible: all are seen from 1280 pixels of screen on, before that their row scrolls sideways.
_TABS_SX = {
    ".MuiTab-root": {
        "textTransform": "none", "minWidth": 0, "minHeight": 40, "paddingX": "4px", "letterSpacing": 0,
        "fontSize": "min(0.775rem, max(12.4px, 1.25cqi))",  # what is larger in lecture mode keeps to one row, too
    },
    f"@media (height < {LOW}px)": {".MuiTab-root": {"minHeight": 30, "paddingY": "4px"}},
    "@container (925px <= width < 1060px)": {
        ".MuiTab-root": {"paddingX": "2.4px", "fontSize": "12px", "letterSpacing": "-0.01em"},
    },
    "@container (1060px <= width < 1350px)": {".MuiTab-root": {"fontSize": "min(0.775rem, 1.12cqi)"}},  # of a lecture
    "@container (width >= 1500px)": {
        ".MuiTab-root": {
            "paddingX": "clamp(4px, calc(24px - 1rem), 8px)", "fontSize": "max(14px, min(0.775rem, 1.25cqi))",
        },  # the type of a lecture needs the room
    },
    **MORE_TABS_SX,
    f"@media (width < {NARROW}px)": {
        ".MuiTabs-list, .MuiTabs-flexContainer": {"width": "max-content"},
    },
    ".MuiTabs-indicator": {"display": "none"},  # the shadow is there from the first paint on
    ".MuiTab-root.Mui-selected": {"boxShadow": "inset 0 -2px currentColor"},
    "@media (forced-colors: active)": {".MuiTab-root.Mui-selected": {"borderBottom": "3px solid Highlight"}},
}  # fmt: skip


def tabs_sx(subjects: list[str]) -> dict[str, Any]:
    """Return the style of tabs with these subjects: a line stands where the subject changes."""
    first = [place for place, (one, other) in enumerate(pairwise(subjects), start=2) if one != other]
    gap = "clamp(3px, calc(5cqi - 49px), 10px)"
    line = {"content": '""', "position": "absolute", "left": f"calc({gap} / -2)", "height": "1.1em"}
    return {
        **_TABS_SX,
        ", ".join(f".MuiTab-root:nth-of-type({place})" for place in first): {
            "marginLeft": gap, "overflow": "visible",
            "&::before": {**line, "borderLeft": "1px solid var(--mui-palette-divider)"},
        },
    }  # fmt: skip


ABOUT_CSS = """
footer { border-top: 1px solid var(--mui-palette-divider); margin-top: 6px; padding: 4px 0; font-size: 0.8125rem;
         color: var(--mui-palette-text-secondary); display: var(--usual, block); }
footer a { color: inherit; }
@media (width < NARROWpx) or (width >= 1150px) { .about { display: none; } }
""".replace("NARROW", str(NARROW))

TAGLINE_CSS = """
p, .lecture { font-size: 0.8125rem; line-height: 1.3; margin: 0 0 0 12px; }
p { max-width: 64ch; color: var(--mui-palette-text-secondary); display: var(--usual, block); }
.lecture { color: var(--mui-palette-text-primary); display: var(--lecture, none); align-items: baseline;
    font-size: min(1rem, max(0.8125rem, 1.1vw)); padding: 4px 0; }
.lecture b { flex: none; max-width: 30%; }
.lecture .law { display: inline-block; font-size: min(1em, 1vw); color: inherit; max-width: none;
    margin: 0 0 0 1.2em; text-indent: 0; }
.lecture .short { font-size: 1em; }
.lecture sup { line-height: 0; font-size: 0.75em; }
@media (width < 1150px) { p, .lecture { display: none; } }
"""
"""What the page is, in its header; where that has no room, in the footer, or above a narrow portrait. A lecture sets
`--usual` and `--lecture`; `--law` once the header tells the laws."""

NOT_IN_LECTURES = {"&&": {"display": "var(--usual, inline-flex)"}}
"""Of a button that a lecture does without."""

FOR_FINGERS = {f"@media (360px <= width < {NARROW}px)": {"minWidth": 40, "minHeight": 40, "margin": 0}}
"""Of a button in the header of a phone, unless that is too small for all of them."""

FOR_TOUCH = {"@media (pointer: coarse)": {"minWidth": 40, "minHeight": 40}}
"""Of a button beside a figure."""

NOT_ON_PHONES = {"&&": {f"@media (width < {NARROW}px)": {"display": "none"}}}
"""Of a button for which the header of a phone has no room."""

STACK_CSS = ":host { height: auto !important; max-height: none !important; } :host > * { flex: none !important; }"
