"""A field for a number, with a slider if the number has bounds, and the reason if a text is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import panel as pn
import panel_material_ui as pmui

SLIDER_DIGITS = 3
"""Significant digits of the numbers a slider gives."""

SPOKEN_LABEL_SX = {
    ".MuiFormLabel-root": {
        "position": "absolute",
        "width": "1px",
        "height": "1px",
        "overflow": "hidden",
        "clipPath": "inset(50%)",
    }
}
"""Of a slider: its name is hidden from view but not from screen readers; the field above it shows the name."""

SLIDER_RESTS = 5
"""Milliseconds that Panel waits for further moves before it reports one; its 50 can be changed by no public option."""


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
        Help text of the field.
    """

    def __init__(
        self,
        label: str,
        read: Callable[[], float],
        accept: Callable[[object], None],
        bounds: tuple[float, float] | None = None,
        logarithmic: bool = False,
        description: str = "",
    ) -> None:
        super().__init__()
        self._read, self._accept = read, accept
        self._log = logarithmic
        self._syncing = False
        self._shown = math.nan
        self.text = pmui.TextInput(
            label=label, size="small", margin=(9, 0, 2, 0), sizing_mode="stretch_width", description=description
        )
        self.slider = None if bounds is None else self._make_slider(label, bounds)
        self.sync()
        self.text.param.watch(lambda event: self._take(event.new), "value")
        if self.slider is not None:
            self.slider.param.watch(lambda event: self._take(self._from_slider(event.new)), "value")

    def _make_slider(self, label: str, bounds: tuple[float, float]) -> Any:
        slider: Any = pmui.FloatSlider(
            **self._track(label, bounds, self._read()), show_value=False, tooltips=False, size="small",
            margin=(0, 10, 0, 10), sizing_mode="stretch_width", sx=SPOKEN_LABEL_SX,
        )  # fmt: skip
        slider._debounce = SLIDER_RESTS
        return slider

    def _track(self, label: str, bounds: tuple[float, float], value: float) -> dict[str, Any]:
        """Return the settings of a slider with these ends, at a value."""
        low, high = (math.log10(bound) for bound in bounds) if self._log else bounds
        place = min(max(math.log10(value) if self._log else value, low), high)
        return {"start": low, "end": high, "value": place, "step": (high - low) / 400, "label": f"{label}, slider"}

    def rebind(
        self,
        label: str,
        read: Callable[[], float],
        accept: Callable[[object], None],
        bounds: tuple[float, float] | None = None,
        description: str = "",
    ) -> None:
        """Rebind to another number, with bounds if and only if there is a slider; ten times as fast as a new field."""
        self._read, self._accept = read, accept
        self._shown = value = read()
        self._syncing = True
        try:  # change each once: of two changes in quick succession, the browser may restore the first
            told = {"value": repr(value), "error_state": False, "helper_text": ""}
            self.text.param.update(label=label, description=description, **told)
            if self.slider is not None and bounds is not None:
                self.slider.param.update(**self._track(label, bounds, value))
        finally:
            self._syncing = False

    def _from_slider(self, place: float) -> float:
        value = 10.0**place if self._log else place
        return float(f"{value:.{SLIDER_DIGITS}g}")

    def _take(self, value: object) -> None:
        if self._syncing:
            return
        try:
            self._accept(value)
        except ValueError as reason:
            self.text.param.update(error_state=True, helper_text=str(reason))
        else:
            self._show(self._read())

    def sync(self) -> None:
        """Show the number in the scene, if it has changed; else a refused text stays, with the reason."""
        value = self._read()
        if value != self._shown:
            self._show(value)

    def _show(self, value: float) -> None:
        self._shown = value
        self._syncing = True
        try:
            self.text.param.update(value=repr(value), error_state=False, helper_text="")
            if self.slider is not None:
                place = math.log10(value) if self._log else value
                if self._from_slider(self.slider.value) != value:
                    self.slider.value = min(max(place, self.slider.start), self.slider.end)
        finally:
            self._syncing = False

    def show_if(self, wanted: bool) -> None:
        """Show or hide the field and its slider."""
        for part in (self.text, self.slider):
            if part is not None:
                part.visible = wanted

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the field, and the slider below it."""
        parts = [self.text] if self.slider is None else [self.text, self.slider]
        return pn.Column(*parts, margin=0, sizing_mode="stretch_width")
