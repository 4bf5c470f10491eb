"""The frame of the page: its template, its look, and what the browser loads before the page is there."""

from __future__ import annotations

from typing import Any

import param
from bokeh.document import Document
from panel.io.resources import get_dist_path
from panel.util.parameters import edit_readonly
from panel_material_ui.template.base import Page

from pwsviz.figures.style import TIP_CSS
from pwsviz.page.cover import SIDEBAR_WIDTH, Cover
from pwsviz.text.maths_font import FACE
from pwsviz.widgets.browser import FIND

__all__ = ["THE_PAGE", "make_frame"]

THE_PAGE = "cb_obj.document.roots().find(root => 'sidebar_open' in (root.data ?? {})).data"
"""JavaScript of the data of the page. Of a model passed as an argument, Panel visits all parts at each change."""

#: The icon of the button of the theme shows what a click brings, as its name says; that of the template what there is.
_MOON, _SUN = "dark_mode", "light_mode"
_OF_THEME = {
    f'button[aria-label="{theme} theme"]': {
        "& > svg": {"display": "none"},
        "&::before": {"content": f'"{icon}"', "font": "24px/1 'Material Icons'", "fontFeatureSettings": '"liga"'},
    }
    for theme, icon in (("Dark", _MOON), ("Light", _SUN))
}  # fmt: skip

PAGE_SX = {
    **_OF_THEME,
    ".MuiAppBar-root": {
        "backgroundColor": "background.paper", "color": "text.primary", "boxShadow": "none",
        "borderBottom": "1px solid", "borderColor": "divider", "backgroundImage": "none",
    },
    ".MuiAppBar-root .title": {"color": "text.primary", "fontSize": "1.35rem", "letterSpacing": "0.01em"},
    ".MuiToolbar-root": {"minHeight": "48px !important"},
    ".MuiToolbar-root a": {"minHeight": "24px"},
    "&& :is(.main, .sidebar) .MuiToolbar-root": {"height": "var(--header, 48px)", "flexShrink": 0},  # room for it
    "@media (width < 480px)": {
        ".MuiAppBar-root > .MuiToolbar-root": {"paddingX": "12px"},
        ".MuiToolbar-root > .MuiIconButton-edgeStart": {"marginRight": "4px"},
    },
    ".MuiToolbar-root > h5, .MuiAppBar-root > .MuiLinearProgress-root": {"display": "none"},  # have no name and no use
}  # fmt: skip

SHEET = {
    "top": "auto !important", "bottom": 0, "width": "100%", "height": "55dvh", "position": "absolute",
    "borderTop": "1px solid", "borderColor": "var(--mui-palette-divider)", "& > .MuiToolbar-root": {"display": "none"},
}  # fmt: skip
"""The controls on a narrow screen, where they lie over the page: at its lower end, with the portrait in sight above."""

THEME = {
    "components": {
        # Only the title of the page is set in the style h3; it is the heading of all others.
        "MuiTypography": {"defaultProps": {"variantMapping": {"h3": "h1"}}},
        "MuiButtonBase": {  # whose own sign of the focus is a slight shade
            "styleOverrides": {"root": {"&.Mui-focusVisible": {"outline": "2px solid", "outlineOffset": "-2px"}}}
        },
        "MuiButton": {  # on whose own shade under the pointer blue words have a contrast of 4.4, too little
            "styleOverrides": {"text": {"&:hover": {"backgroundColor": "transparent", "textDecoration": "underline"}}}
        },
        "MuiTooltip": {"styleOverrides": {"tooltip": {"width": "max-content"}}},
        "MuiDrawer": {
            "defaultProps": {"slotProps": {"paper": {"aria-label": "Controls"}}},
            "styleOverrides": {
                "paper": {  # as the names on frames
                    "backgroundColor": "var(--mui-palette-background-default)", "backgroundImage": "none"
                },
                "root": {
                    "&.MuiDrawer-modal .MuiDrawer-paper.sidebar": SHEET,
                    "&.MuiDrawer-modal .MuiBackdrop-root": {"backgroundColor": "transparent"},
                }
            }
        },
    }
}  # fmt: skip
"""Styles and elements of parts of the page that are drawn beside it in the document."""

SKIP = """
<style>
#skip { position: fixed; top: 8px; left: 8px; z-index: 2000; padding: 8px 14px; border-radius: 4px; color: white;
        background: #0b57a0; font: 16px Roboto, Helvetica, Arial, sans-serif; }
#skip:not(:focus) { transform: translateY(-60px); }
</style>
<nav aria-label="Skip"><a id="skip" href="#portrait">Skip to the portrait</a></nav>
<div id="portrait" tabindex="-1"></div>
<script>{
  FIND
  document.getElementById("portrait").addEventListener("focus", () => find(document, "[role=application]")?.focus())
  document.getElementById("skip").addEventListener("click", event => {  // the address bar holds the scene alone
    event.preventDefault()
    document.getElementById("portrait").focus()
  })
}</script>
""".replace("FIND", FIND)
"""The first stop of the Tab key: to the portrait, past the header and some thirty controls."""

UNSTYLED = """
<script>
// A style sheet might set any property of a figure, so Bokeh asks the browser for each, again and again. None does.
Bokeh.loader["core/visuals/visual"].VisualProperties.prototype._get_css_value = () => ""
</script>
"""
"""JavaScript that saves 8 % of what the browser computes until the page is built, some of each painting, too."""

TEMPLATE = (
    """{% extends "base.html" %}
{% block custom_css %}<style>FACE</style>{% endblock %}
{% block postamble %}{{ super() }}
<link rel="modulepreload" href="{{ components }}">
<script>
self.esmsInitOptions = { shimMode: false }
import("{{ components }}")
</script>
{% endblock %}
{% block loader_css %}{{ super() }}
#loader:not(.error) { background: none; cursor: progress; }
{% endblock %}
{% block js_resources %}{% endblock %}
{% block loader %}SKIP{{ cover.markup() }}{{ bokeh_js }}UNSTYLED
<script>importShim.addImportMap = () => {}</script>
{{ super() }}{% endblock %}""".replace("FACE", FACE + TIP_CSS)
    .replace("SKIP", SKIP)
    .replace("UNSTYLED", UNSTYLED)
)
"""The browser imports the code of the components while it waits for the page: loading it only then takes half a second
more. It is one module, which imports nothing: the browser needs no es-module-shims, which would parse it first, and no
map of imports, which Panel adds. Scripts come after the cover, which is painted while they load. While the page is
built, what is already there is visible but takes no input, which Panel would lose."""


class _NeverBusy(param.Parameterized):
    busy = param.Boolean(default=False)


class Frame(Page):
    """Panel's page, whose template knows its cover, and where the code of its components is."""

    def __init__(self, cover: Cover, **settings: Any) -> None:
        super().__init__(**settings)
        self._cover = cover

    def get_root(self, doc: Document | None = None, comm: Any = None, preprocess: bool = True) -> Any:
        if doc is not None:  # of a session made after its page was sent, Panel would take the styles from afar
            doc.template_variables.setdefault("dist_url", get_dist_path())
        root: Any = super().get_root(doc, comm, preprocess)
        if doc is not None:
            doc.template_variables.update(components=root.esm, cover=self._cover)
        return root


def make_frame(title: str, header: list[Any], sidebar: list[Any], main: list[Any], cover: Cover) -> Page:
    """Return a page.

    Parameters
    ----------
    title : str
        Of the page.
    header : list
        What stands beside the title.
    sidebar : list
        What stands in the sidebar; it has no place where this is empty.
    main : list
        What it shows beside the sidebar.
    cover : Cover
        What is seen until it is built.
    """
    page = Frame(
        cover,
        title=title,
        header=header,
        sidebar=sidebar,
        main=main,
        sidebar_width=SIDEBAR_WIDTH,
        sidebar_resizable=False,
        theme_config=THEME,
        busy_indicator=None,
        sx=PAGE_SX,
        template=TEMPLATE,
    )
    with edit_readonly(page):
        # In place of the server's: each change of that one visits all pages, and it would keep this page in memory.
        page.busy = _NeverBusy().param.busy
    return page
