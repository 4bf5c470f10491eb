"""What a person takes away: the link, a Python program, the numbers and the pictures."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Callable, Sequence
from html import escape
from typing import Any, NamedTuple

import panel as pn
import panel_material_ui as pmui
from bokeh.plotting import figure

from pwsviz.link import query
from pwsviz.panes import TEXT_CSS, heading
from pwsviz.scene import Scene
from pwsviz.snippet import snippet
from pwsviz.takeaway import Table, csv_bytes, file_name, npz_bytes, png_callback

PROGRAM_CSS = """
pre { max-height: 40vh; overflow: auto; padding: 8px 12px; margin: 0; border-radius: 4px; font-size: 0.8rem;
      background: color-mix(in srgb, currentColor 7%, transparent); }
"""


class Piece(NamedTuple):
    """Something to take away: what a view shows."""

    title: str
    table: Callable[[], Table | None]
    """Returns its numbers; None while there are none."""
    figure: figure | None


class Share(pn.viewable.Viewer):
    """The dialog “Take away”; what it holds is made when it is opened.

    Parameters
    ----------
    pieces : callable
        Returns what is visible.
    """

    def __init__(self, scene: Scene, pieces: Callable[[], Sequence[Piece]]) -> None:
        super().__init__()
        self.scene, self._pieces = scene, pieces
        self.link = pmui.TextInput(label="Link to this very scene", sizing_mode="stretch_width", margin=(4, 0))
        self.program = pn.pane.HTML("", sizing_mode="stretch_width", margin=0, stylesheets=[TEXT_CSS, PROGRAM_CSS])
        self.numbers = pn.Column(margin=0, sizing_mode="stretch_width")
        self.dialog = pmui.Dialog(
            self.link, heading("Python"), self.program, heading("Numbers and pictures"), self.numbers,
            title="Take away", title_variant="h6", width_option="md", close_on_click=True, show_close_button=True,
        )  # fmt: skip

    def open(self, address: str) -> None:
        """Show everything as it is now.

        Parameters
        ----------
        address : str
            Of the page, without a query.
        """
        try:
            self.link.param.update(value=f"{address}?{query(self.scene)}", error_state=False, helper_text="")
        except ValueError as reason:
            self.link.param.update(value="", error_state=True, helper_text=str(reason))
        self.program.object = f'<pre tabindex="0" aria-label="Python program">{escape(snippet(self.scene))}</pre>'
        self.numbers.objects = [self._row(piece) for piece in self._pieces()]
        self.dialog.open = True

    def _row(self, piece: Piece) -> pn.Row:
        buttons = [self._download(piece, "csv", csv_bytes), self._download(piece, "npz", npz_bytes)]
        if piece.figure is not None:
            image = pmui.Button(label="PNG", icon="image", variant="outlined", size="small", margin=(4, 4))
            image.js_on_click(args={"name": file_name(self.scene, piece.title, "png")}, code=png_callback(piece.figure))
            buttons.append(image)
        return pn.Row(pmui.Typography(piece.title, margin=(8, 8), width=170), *buttons, margin=0)

    def _download(self, piece: Piece, ending: str, write: Callable[[Table, str], bytes]) -> Any:
        scene_link = self.link.value.partition("?")[2]

        async def data() -> io.BytesIO:
            """Write it in a thread: a million rows take seconds, and other people's sliders do not wait."""
            return await asyncio.to_thread(lambda: io.BytesIO(write(piece.table() or {}, scene_link)))

        return pmui.FileDownload(
            callback=data,
            filename=file_name(self.scene, piece.title, ending), label=ending.upper(), auto=True,
            size="small", margin=(4, 4),
        )  # fmt: skip

    def __panel__(self) -> pn.viewable.Viewable:
        """The dialog, closed until it is opened."""
        return self.dialog
