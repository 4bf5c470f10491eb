"""The dialog of the export: the link, a Python program, the numbers and the pictures."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from html import escape
from typing import Any, NamedTuple

import panel as pn
import panel_material_ui as pmui
from bokeh.plotting import figure

from pwsviz.export.about import about, release
from pwsviz.export.caption import caption, short_caption
from pwsviz.export.files import Table, Tables, csv_bytes, file_name, npz_bytes
from pwsviz.export.latex import latex_file
from pwsviz.export.pictures import CHOICES, KINDS, OTHER, WIDTHS, picture_callback, pixels
from pwsviz.export.script import snippet
from pwsviz.figures.colours import PRINTED_OPACITY
from pwsviz.scene.permalink import query
from pwsviz.scene.scene import Scene
from pwsviz.text.numbers import printed
from pwsviz.widgets.dialog import dialog
from pwsviz.widgets.named_row import NamedRow
from pwsviz.widgets.panes import PLAIN_SX, TEXT_CSS, heading
from pwsviz.widgets.setting_buttons import BUTTONS_SX

PROGRAM_CSS = """
pre { max-height: 40vh; overflow: auto; padding: 8px 12px; margin: 0; border-radius: 4px; font-size: 0.8rem;
      background: color-mix(in srgb, currentColor 7%, transparent); }
"""


COPY = {
    "words": "words",
    "field": "words.data.value",
    "pane": """
[0, 0].reduce(text => new DOMParser().parseFromString(text, "text/html").body.textContent, words.text)""",
}
"""JavaScript of a text to copy: given as it is, of a field, and of a pane, whose markup arrives escaped twice."""

_COPY = """
const tell = words => button.data.setv({ label: words }, { sync: false })
navigator.clipboard.writeText(WORDS).then(() => tell("Copied"), () => tell("Not copied: the browser forbids it"))
setTimeout(() => tell(label), 3000)
"""


TITLE = "Export & share"

OPEN_AT_ONCE = """
const models = [...source.document._all_models.values()]
models.find(model => model.data?.title == TITLE && "open" in model.data)?.data.setv({ open: true })
""".replace("TITLE", repr(TITLE))
"""JavaScript of the button, its `source`, that opens the dialog: its frame is there before the server has answered."""

NOT_YET = "not computed yet, or not to its end: its files will be offered here when it is."
"""Words in place of the files of a view."""

NO_PICTURE = "this view has no figure."
"""Words in place of pictures where there is nothing to be seen."""


class Piece(NamedTuple):
    """Something to export: what a view shows."""

    title: str
    tables: Tables
    """What is drawn; nothing of it, and no figure, where that is yet to be computed."""
    figures: Sequence[figure]
    """Saved as one picture, one below the other."""
    how: str = ""
    """How a study was made; empty if it shows runs of the scene."""
    every_start: bool = True
    """Whether it shows runs from all starts, or from the selected one alone."""
    met: bool = True
    """Whether one of the runs meets a surface."""
    slid: bool = True
    """Whether one of the runs slides."""
    free: str = ""
    """The parameter, or the variable at the start, that has many values in it, if one has."""
    meaning: str = ""
    """What its axes and lines mean, where their names do not say it."""
    key: str = ""
    """What of that a short caption cannot do without."""
    endings: str = ""
    """Which of the runs of the scene ended before the end time."""
    heading: str = ""
    """What a caption says that it shows; the title if it is empty."""
    note: str = ""
    """What its files do not have, if that is to be told."""
    lack: str = NO_PICTURE
    """Why there is no figure, if there is none."""

    @property
    def origin(self) -> dict[str, Any]:
        """What `about` and `caption` are told of it."""
        names = ("how", "every_start", "met", "slid", "endings", "free")
        return {name: getattr(self, name) for name in names}


class ExportDialog(pn.viewable.Viewer):
    """The dialog behind “Export & share”; its contents are made when it is opened.

    Parameters
    ----------
    pieces : callable
        Returns what is visible.
    program : callable
        Returns the lines of Python of the view that is open.
    """

    def __init__(self, scene: Scene, pieces: Callable[[], Sequence[Piece]], program: Callable[[], str]) -> None:
        super().__init__()
        self.scene, self._pieces, self._program = scene, pieces, program
        self.link = pmui.TextInput(label="Link to this scene", sizing_mode="stretch_width", margin=(10, 0, 4, 0))
        self.program = pn.pane.HTML("", sizing_mode="stretch_width", margin=0, stylesheets=[TEXT_CSS, PROGRAM_CSS])
        self._choices: dict[str, Any] = {}
        least, most = WIDTHS
        self._typed_width = pmui.TextInput(
            label=f"{least} to {most} mm", value="130", width=130, size="small", margin=(4, 12, 4, 0), visible=False
        )
        self.numbers = pn.Column(margin=0, sizing_mode="stretch_width")
        self.not_saved, self.not_written = _complaint(), _complaint()  # said by the browser, and by the server
        self.complaints = pn.Column(margin=0)
        self.contents = pn.Column(margin=0, sizing_mode="stretch_width")  # receives clicks on widgets added later
        self.preparing = pmui.Typography("Preparing …", margin=(8, 0), color="text.secondary")
        self.dialog = dialog(TITLE, self.preparing, self.contents)
        self._reveal(False)
        self.dialog.param.watch(self._drop_files, "open")
        self._address = ""

    def _drop_files(self, event: Any) -> None:
        """Drop the files once the dialog is closed: they may be large."""
        if not event.new:
            self._reveal(False)
            self.numbers.objects = []

    def _reveal(self, ready: bool) -> None:
        """Show the contents, or that they are yet to come: a browser opens the dialog before the server knows."""
        self.contents.visible, self.preparing.visible = ready, not ready

    def open(self, address: str) -> None:
        """Open the dialog on the present scene.

        Parameters
        ----------
        address : str
            Address of the page, without a query.
        """
        self._address = address
        try:
            self.link.param.update(
                value=f"{address}?{query(self.scene, typed=False)}", error_state=False, helper_text=""
            )
        except ValueError as reason:
            self.link.param.update(value="", error_state=True, helper_text=str(reason))
        program = escape(snippet(self.scene, self._program()))
        self.program.object = f'<pre tabindex="0" aria-label="Python program">{program}</pre>'
        self.contents.objects = self.contents.objects or self._make_contents()
        self.not_written.object = ""
        self.dialog.open = True
        self.refresh()
        self._reveal(True)

    def refresh(self) -> None:
        """Offer the files of what is visible by now, while the dialog is open."""
        if self.dialog.open:
            self.not_saved = _complaint()
            self.complaints.objects = [self.not_saved, self.not_written]  # first: the buttons of pictures refer to it
            pieces = self._pieces()
            self.numbers.objects = [*map(self._row, pieces), self._equations(pieces[0])]

    def _make_contents(self) -> list[Any]:
        """Make the widgets at the first opening, so that the page itself loads sooner."""
        return [
            self.link, self._copy("Copy the link", "field", self.link),
            heading("Data and figures"), self._make_choices(), self.numbers, self.complaints,
            heading("Python"), self.program, self._copy("Copy the program", "pane", self.program),
        ]  # fmt: skip

    @staticmethod
    def _copy(label: str, kind: str, words: Any) -> Any:
        """Return a button that copies a text, of one of the kinds of `COPY`, without the server."""
        button = pmui.Button(label=label, icon="content_copy", variant="text", size="small", margin=(4, 4), sx=PLAIN_SX)
        given = {"words": words, "button": button, "label": label}
        button.js_on_click(args=given, code=_COPY.replace("WORDS", COPY[kind]))
        return button

    def _row(self, piece: Piece) -> NamedRow:
        buttons = [
            self._download(f"CSV {name}".strip(), f"{piece.title} {name}", "csv", partial(_write_csv, table), piece)
            for name, table in piece.tables.items()
        ]
        if piece.tables:
            buttons.append(self._download("NPZ", piece.title, "npz", partial(_write_npz, piece.tables), piece))
        if piece.figures:
            buttons += [self._picture(piece, kind) for kind in KINDS]
            buttons.append(self._copy("Copy caption", "words", _caption(self.scene, piece)))
        else:
            buttons.append(pmui.Typography(piece.lack, margin=(8, 8), variant="body2"))
        notes = [pmui.Typography(piece.note, margin=(0, 4), variant="body2", sizing_mode="stretch_width")] * bool(
            piece.note
        )
        return NamedRow(_title(piece.title), *notes, *buttons, group=piece.title, margin=0, sizing_mode="stretch_width")

    def _make_choices(self) -> Any:
        """Return the choices about pictures."""
        self._choices = {
            name: pmui.RadioButtonGroup(
                options=list(options), value=options[usual], label=title, size="small", margin=(4, 12, 4, 0),
                sx=BUTTONS_SX,
            )
            for name, (title, options, usual) in CHOICES.items()
        }  # fmt: skip
        width, dpi, typed = self._choices["width"], self._choices["dpi"], self._typed_width
        wide = pmui.Typography(pixels(width.value, dpi.value), margin=(28, 12, 8, -4), variant="body2")

        def tell(_: Any) -> None:
            typed.visible = width.value == OTHER
            wide.object = pixels(typed.value if typed.visible else width.value, dpi.value)

        for one in (width, dpi, typed):
            one.param.watch(tell, "value")
        beside: dict[str, list[Any]] = {"width": [typed], "dpi": [wide]}
        shown = (one for name, choice in self._choices.items() for one in (choice, *beside.get(name, [])))
        return pn.FlexBox(*shown, margin=0, sizing_mode="stretch_width")

    def _picture(self, piece: Piece, kind: str) -> Any:
        """Return a button that saves figures as a picture, without the server."""
        button = pmui.Button(label=kind.upper(), icon="image", color="primary", size="small", margin=(4, 4))
        captions = {"short": _short_caption(self.scene, piece), "full": _caption(self.scene, piece)}
        named = {"name": file_name(self.scene, piece.title, kind), "title": piece.title, "captions": captions}
        wish = {"kind": kind, **named, "shades": PRINTED_OPACITY, "widths": WIDTHS}
        given = {"wish": wish, "trouble": self.not_saved, "typed": self._typed_width, **self._choices}
        button.js_on_click(args=given, code=picture_callback(piece.figures))
        return button

    def _equations(self, piece: Piece) -> NamedRow:
        """Return the row of the equations in LaTeX, of the scene of a piece."""
        file = self._download("TEX", "Equations", "tex", partial(latex_file, self.scene), piece)
        return NamedRow(_title("Equations"), file, group="Equations", margin=0, sizing_mode="stretch_width")

    def _download(
        self, label: str, what: str, ending: str, write: Callable[[Mapping[str, str]], bytes], piece: Piece
    ) -> Any:
        origin = about(self.scene, self._address, **piece.origin)

        async def data() -> io.BytesIO:
            """Write the file in a thread: a million rows take seconds, which must not block other sessions.

            The browser saves a file only if its data differ from the last. The time is therefore written, too, so that
            a second click saves a second file. (Clearing the data in between made the browser save some files twice.)
            """
            written = origin | {"written": datetime.now(UTC).isoformat()}
            self.not_written.object = ""
            try:
                return await asyncio.to_thread(lambda: io.BytesIO(write(written)))
            except Exception as reason:
                self.not_written.object = f"{label} could not be written: {reason or type(reason).__name__}"
                raise

        return pmui.FileDownload(
            callback=data,
            filename=file_name(self.scene, what, ending),
            label=label,
            auto=True,
            size="small",
            margin=(4, 4),
        )

    def __panel__(self) -> pn.viewable.Viewable:
        """The dialog, closed until it is opened."""
        return self.dialog


def _title(words: str) -> pmui.Typography:
    """Return the title of a row, on a line of its own."""
    return pmui.Typography(words, margin=(8, 4, 0, 4), sizing_mode="stretch_width")


def _complaint() -> pmui.Typography:
    return pmui.Typography("", color="error", variant="body2", margin=(4, 8))


def _caption(scene: Scene, piece: Piece) -> str:
    """Return a caption in full; its last line, after what the browser adds, says with what it was computed."""
    words = caption(scene, piece.heading or piece.title, **piece.origin)
    return f"{words} {printed(piece.meaning)}".strip() + f"\nComputed with {release()}."


def _short_caption(scene: Scene, piece: Piece) -> str:
    words = short_caption(scene, piece.heading or piece.title, **piece.origin)
    return f"{words} {printed(piece.key)}".strip()


def _write_csv(table: Callable[[], Table], origin: Mapping[str, str]) -> bytes:
    return csv_bytes(table(), origin)


def _write_npz(tables: Tables, origin: Mapping[str, str]) -> bytes:
    return npz_bytes({name: table() for name, table in tables.items()}, origin)
