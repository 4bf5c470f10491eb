"""A field for a number, with a slider if the number has bounds, and the reason if a text is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar

import panel as pn
import param

from pwsviz.text.numbers import printed, shortest
from pwsviz.widgets.fields import FIELD_CSS

SLIDER_DIGITS = 3
"""Significant digits of the numbers a slider gives."""

WIDEST_NOTE, NOTE_DIGITS = 12, 7
"""Characters up to which a value is told to the last digit beside its formula, and digits of a longer one."""

SLIDER_RESTS = 5
"""Milliseconds that Panel waits for further moves before it reports one; its 50 can be changed by no public option."""


Later = Callable[[Callable[[], None]], object]
"""Takes a function and calls it, at once or a little later."""


def at_once(show: Callable[[], None]) -> None:
    """Call a function now."""
    show()


class NumberEntry(pn.custom.JSComponent):
    """What the browser shows of a number: a text entry, and beside it a slider, which tells the number.

    The server alone sets `text`; what a person types comes as a message with a number. So the browser knows to which
    text an answer belongs, and a late one does not replace what was typed since.
    """

    label = param.String(default="", doc="Name shown.")
    description = param.String(default="", doc="What the number is, shown when the field is pointed at or entered.")
    text = param.String(default="", doc="The text of the entry, once all that was typed is answered.")
    answered = param.Integer(default=0, doc="Number of the last typed text that was accepted or refused.")
    said = param.String(default="", doc="The number as it is printed, which the slider tells.")
    note = param.String(default="", doc="The value of the text, where it is not a plain number.")
    complaint = param.String(default="", doc="Why the text is refused.")
    disabled = param.Boolean(default=False, doc="Whether the number has no effect at present.")
    ends = param.Tuple(default=None, length=2, allow_None=True, doc="Ends of the slider; None for no slider.")
    place = param.Number(default=0.0, doc="Place of the slider, between its ends.")
    bounds = param.Tuple(default=None, length=2, allow_None=True, doc="The numbers at the ends of the slider.")
    value = param.Number(default=0.0, doc="The number.")

    _debounce = SLIDER_RESTS
    _busy__ignore: ClassVar[list[str]] = ["place"]  # Panel's list of what it is busy with is shown nowhere
    _bundle = "number_entry.js"  # fetched once by the browser, and not sent with every field
    _stylesheets: ClassVar[list[str]] = [FIELD_CSS]


class NumberField(pn.viewable.Viewer):
    """Text entry and optional slider for one number of the scene.

    Parameters
    ----------
    label : str
        Name shown.
    read : callable
        Returns the number in the scene.
    accept : callable
        Applies a number or a text; raises ValueError with a message for the user.
    bounds : pair of float, optional
        Ends of the slider; without them there is none.
    logarithmic : bool
        Whether the slider is logarithmic.
    description : str
        What the number is.
    later : callable, optional
        Takes a function that shows the number to which the slider was moved, and calls it.
    written : callable, optional
        Returns what is written for the number in the scene, with the number beside it; empty for the number itself.
    """

    def __init__(
        self,
        label: str,
        read: Callable[[], float],
        accept: Callable[[object], None],
        bounds: tuple[float, float] | None = None,
        logarithmic: bool = False,
        description: str = "",
        later: Later = at_once,
        written: Callable[[], str] = str,
    ) -> None:
        super().__init__()
        self._read, self._accept, self._later, self._written = read, accept, later, written
        self._log = logarithmic
        self._syncing = False
        self._shown, self._shown_as, self._in_force = math.nan, "", ""
        self.entry = NumberEntry(
            label=label, description=description, sizing_mode="stretch_width", margin=0, **self._track(bounds, read())
        )
        self.sync()
        self.entry.on_msg(lambda event: self._hear(**event.data))
        self.entry.param.watch(lambda event: self._slide(event.new), "place")

    def _track(self, bounds: tuple[float, float] | None, value: float) -> dict[str, Any]:
        """Return ends and place of the slider for these bounds, at a value."""
        if bounds is None:
            return {"ends": None, "place": 0.0, "bounds": None}
        low, high = (self._to_slider(bound) for bound in bounds)
        return {"ends": (low, high), "place": min(max(self._to_slider(value), low), high), "bounds": bounds}

    def rebind(
        self,
        label: str,
        read: Callable[[], float],
        accept: Callable[[object], None],
        bounds: tuple[float, float] | None = None,
        description: str = "",
    ) -> None:
        """Rebind to another number: ten times as fast as a new field."""
        self._read, self._accept = read, accept
        self._shown = value = read()
        told = _told(value)
        self._in_force = told["text"]
        self._tell(label=label, description=description, **told, **self._track(bounds, value))

    def _tell(self, **changes: Any) -> None:
        """Change what the browser shows, each setting once: of two changes at once it may restore the first."""
        changes = {name: value for name, value in changes.items() if getattr(self.entry, name) != value}
        if not changes:
            return
        self._syncing = True
        try:
            self.entry.param.update(**changes)
        finally:
            self._syncing = False

    def _to_slider(self, value: float) -> float:
        return math.log10(value) if self._log else value

    def _from_slider(self, place: float) -> float:
        value = 10.0**place if self._log else place
        return float(f"{value:.{SLIDER_DIGITS}g}")

    def _hear(self, text: str, number: int) -> None:
        self.type(text)
        self.entry.answered = number

    def type(self, text: str) -> None:
        """Take a text as if it were typed into the entry."""
        try:
            self._accept(text)
        except ValueError as reason:
            self._tell(text=text, complaint=self._refusal(reason), note="")
        else:
            self._show(self._read(), typed=text)

    def _refusal(self, reason: ValueError) -> str:
        """Return why a text is refused, and the number that is used still."""
        return f"{printed(str(reason)).rstrip('.')}. Still in use: {printed(self._in_force)}."

    def _slide(self, place: float) -> None:
        if self._syncing:
            return
        try:
            self._accept(self._from_slider(place))
        except ValueError as reason:
            self._tell(complaint=self._refusal(reason), note="")
        else:
            self._later(self._show_present)

    def _show_present(self) -> None:
        self._show(self._read())

    def sync(self) -> None:
        """Show the number in the scene, if it has changed; else a refused text stays, with the reason."""
        value, written = self._read(), self._written()
        if value != self._shown or written != self._shown_as:
            self._show(value)

    def _show(self, value: float, typed: str = "") -> None:
        """Show a number, as it was typed if that is a formula."""
        self._shown, self._shown_as = value, self._written()
        changes: dict[str, Any] = _told(value, typed or self._shown_as)
        self._in_force = changes["text"]
        if self.entry.ends is not None and self._from_slider(self.entry.place) != value:
            low, high = self.entry.ends
            changes["place"] = min(max(self._to_slider(value), low), high)
        self._tell(**changes)

    def show_if(self, wanted: bool) -> None:
        """Show or hide the field and its slider."""
        self.entry.visible = wanted

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the field, and the slider beside it."""
        return self.entry


def _told(value: float, typed: str = "") -> dict[str, Any]:
    """Return what the field says of a number: a formula that was typed, or a ratio, with its value beside."""
    text = typed.strip() if typed and not _is_decimal(typed) else shortest(value)
    said = printed(repr(value).removesuffix(".0"))
    value_told = f"= {said}" if len(said) <= WIDEST_NOTE else f"≈ {printed(f'{value:.{NOTE_DIGITS}g}')}"
    note = "" if _is_decimal(text) or text == said else value_told
    return {"text": text, "said": said, "note": note, "complaint": "", "value": value}


def _is_decimal(text: str) -> bool:
    try:
        float(text.replace("−", "-"))
    except ValueError:
        return False
    return True
