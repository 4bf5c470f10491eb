"""The form in which a user types a system; it typesets and checks the expressions meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.editor.draft import FIELDS, Draft
from pwsviz.editor.examples import EXAMPLES
from pwsviz.editor.naming import proposed_name
from pwsviz.editor.regions import REGION_FIELDS
from pwsviz.editor.validation import Checked, Finding, check
from pwsviz.tasks.event_loop import Delivery
from pwsviz.tasks.latest_wins import Job, Lane
from pwsviz.text.words import as_text, complaint, listed
from pwsviz.widgets.disclosure import Disclosure
from pwsviz.widgets.panes import TEXT_CSS, heading

__all__ = ["SystemEditor"]

QUIET = 0.25
"""Seconds without a change before the fields are checked."""

CURRENT = "The system on the page"
KEPT = f"These fields keep what you typed before; “Start from: {CURRENT}” replaces it."
"""Menu entry that fills in the present system."""

BLANK = "Nothing: empty fields"
COPIED = "A copy of “{}”, to be changed; “Start from” offers others, and empty fields."
"""Menu entry that empties all fields."""

MATHS_CSS = """
.maths { overflow-x: auto; overflow-y: hidden; padding: 2px 0 6px 14px; }
math { display: block; width: fit-content; font-size: 1.05rem; padding: 4px 0; }
.finding { color: var(--mui-palette-text-secondary); padding: 0 14px 4px 14px; }
.kept { color: var(--mui-palette-success-main); }
"""

PAIR_CSS = ":host { flex-wrap: wrap; gap: 0 12px; } :host > * { flex: 1 1 220px !important; min-width: 0; }"
"""Side by side where each has at least 220 px, else one below the other."""

FIELD_SX = {"& .MuiInputBase-input": {"fontFamily": "ui-monospace, Menlo, Consolas, monospace", "fontSize": "0.9rem"}}

_LINES = {
    "parameters": 2, "f": 2, "psi": 1, "f_minus": 2, "f_plus": 2, "psi_minus": 1, "psi_plus": 1, "jump": 1,
    "surfaces": 2, "regions": 3, "quantities": 2, "resets": 1, "transitions": 2,
}  # fmt: skip
"""Fields of several lines, and the number of lines shown when empty."""

_HINTS = {
    "name": "",
    "variables": "x, y",
    "parameters": "k = 3 in [0.1, 10]",
    "f": "",
    "psi": "",
    "f_minus": "y\n-k*x",
    "f_plus": "y\n-x",
    "g": "y",
    "psi_minus": "",
    "psi_plus": "",
    "x0": "1, 1",
    "jump": "",
    "surfaces": "x + 1\nx - 1",
    "regions": "--: v, -x\n+-: v, 0",
    "quantities": "+-: v^2/2",
    "resets": "g1 => x, -r*v",
    "transitions": "on -> off: 1 - x\noff -> on: x + 1",
}

_HELP = {
    "variables": "Time is t.",
    "parameters": "One per line. The range of the slider is optional.",
    "f": "Alternatively, a single field in place of g, f₋, f₊. Example for x, v: v; -x - k*max(x - 1, 0). The "
    "surfaces are found from it.",
    "psi": "Of the field f. Optional. One per line.",
    "f_minus": "The time derivative of each variable, one per line.",
    "f_plus": "The time derivative of each variable, one per line.",
    "g": "The field changes where g = 0.",
    "psi_minus": "Optional. One per line.",
    "psi_plus": "Optional. One per line.",
    "x0": "One number per variable.",
    "jump": "For impacts: the value of each variable after the state reaches g = 0. Leave empty for none.",
    "surfaces": "One per line, up to six. Leave empty if the regions have names.",
    "regions": "In place of g, f₋ and f₊. One per line: the signs of g1, g2, … or a name, a colon, and the time "
    "derivatives. A region that is left out has no law.",
    "quantities": "Optional. One region per line.",
    "resets": "One surface per line, and the value of each variable after it is reached. A wall is a surface with a "
    "reset and no law beyond it.",
    "transitions": "For hysteresis. A region ends where its guard, positive inside, falls to 0. If the state jumps "
    "there, add => and the value of each variable after it.",
}

MORE = "Several surfaces, walls, hysteresis"
"""Title of the fields that few need."""

Deliver = Callable[[Callable[[Any], None], Any], None]
"""Calls a function with its argument in the event loop of the page."""


class SystemEditor(pn.viewable.Viewer):
    """Fields for a system, checked in a thread while the user types. They are empty at first.

    Parameters
    ----------
    on_use : callable
        Called with the system when the user applies it; may raise ValueError with a message for the user.
    deliver : callable, optional
        Called from a thread with a function and its argument, which it calls in the event loop; by default in that of
        the page being served, or at once if there is none.
    current : callable, optional
        Returns the system on the page, to start from.
    on_ready : callable, optional
        Called in the event loop with each valid system, to prepare for its use.
    """

    def __init__(
        self,
        on_use: Callable[[core.PiecewiseSystem], None],
        deliver: Deliver | None = None,
        current: Callable[[], core.PiecewiseSystem] | None = None,
        on_ready: Callable[[core.PiecewiseSystem], None] = lambda _: None,
    ) -> None:
        super().__init__()
        self._on_use, self._current, self._on_ready = on_use, current, on_ready
        self._deliver = deliver or Delivery()
        self._lane = Lane()
        self._filling = False
        self._loaded = False  # whether the fields were filled in with a system, not with an example
        self._named = False  # whether the name was typed
        self._outcome: Checked | None = None  # None while the fields are being checked
        self._wanted = False
        self.draft = self._begun = Draft()  # what the fields hold, and what they were filled in with
        self.texts = {name: self._make_text(name) for name in FIELDS}
        self.kept = _markup_pane()
        self.maths = {name: _markup_pane() for name in FIELDS}
        self.status = _markup_pane()
        titles = [*([CURRENT] if current else []), BLANK, *EXAMPLES, *_built_in()]
        self.menu = pmui.MenuButton(
            label="Start from",
            items=[{"label": title} for title in titles],
            size="small",
            variant="outlined",
            margin=(0, 0, 6, 0),
        )
        self.menu.on_click(self._choose)
        self.more = pmui.Button(label=MORE, icon="expand_more", variant="text", size="small", margin=(6, 0))
        self.more.on_click(lambda _: self._open(not self.several.visible))
        self.several = pn.Column(
            self._field("surfaces"), self._field("regions"), self._field("quantities"),
            self._pair("resets", "transitions"), visible=False, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self.use = pmui.Button(label="Use this system", color="primary", variant="contained", margin=(6, 0))
        self.use.on_click(lambda _: self._use())

    def _make_text(self, name: str) -> Any:
        options: dict[str, Any] = {
            "label": FIELDS[name], "placeholder": _HINTS[name], "size": "small", "margin": (10, 0, 2, 0),
            "sizing_mode": "stretch_width", "helper_text": _HELP.get(name, ""), "sx": FIELD_SX,
        }  # fmt: skip
        if name in _LINES:
            options |= {"rows": _LINES[name], "max_rows": 8, "auto_grow": True, "size": "medium"}
        text: Any = (pmui.TextAreaInput if name in _LINES else pmui.TextInput)(**options)
        for told in ("value_input", "value"):  # at each key, and when the field is left
            text.param.watch(partial(self._take, name), told)
        return text

    @property
    def system(self) -> core.PiecewiseSystem | None:
        """The system that the fields define; None if they define none, or while they are being checked."""
        return self._outcome.system if self._outcome is not None else None

    def start(self) -> None:
        """Fill in the system on the page; say so where it cannot be written in these fields."""
        if self._current is None:
            return
        system = self._current()
        try:
            self.load(system)
            self.kept.object = as_text(COPIED.format(system.name))
        except ValueError as reason:
            self.status.object = complaint(reason)

    def resume(self) -> None:
        """Fill in the system on the page, unless something else was typed before: then say that it is still there."""
        if self._current is None:
            return
        if self.draft == self._begun and (self._loaded or self.draft == Draft()):
            self.start()
            return
        typed = self.system
        self.kept.object = "" if typed is not None and typed.laws is self._current().laws else as_text(KEPT)

    # Filling it in ---------------------------------------------------------------------------------------------------

    def load(self, system: core.PiecewiseSystem) -> None:
        """Fill in a system, and check it at once."""
        self.fill(Draft.of(system))
        self._loaded = True

    def fill(self, draft: Draft) -> None:
        """Fill in a draft, and check it at once."""
        self._begun, self._loaded, self._named, self.kept.object = draft, False, False, ""
        self._write(draft, FIELDS)
        self._open(any(getattr(draft, name) for name in REGION_FIELDS))
        self._check(draft, quiet=0.0)

    def _write(self, draft: Draft, names: Iterable[str]) -> None:
        """Show texts of a draft in their fields."""
        self._filling = True
        try:
            for name in names:
                text = getattr(draft, name)
                self.texts[name].param.update(value=text, value_input=text)
        finally:
            self._filling = False

    def _open(self, wanted: bool) -> None:
        """Show the fields that few need, or hide them."""
        self.several.visible = wanted
        self.more.icon = "expand_less" if wanted else "expand_more"

    def _choose(self, item: Any) -> None:
        title = item["label"]
        if title in EXAMPLES or title == BLANK:
            self.fill(EXAMPLES.get(title, Draft()))
        elif title in (built_in := _built_in()):
            self.load(built_in[title])
        else:
            self.start()

    def _take(self, name: str, event: Any) -> None:
        changed: dict[str, Any] = {name: str(event.new or "")}
        draft = replace(self.draft, **changed)
        if draft == self.draft or self._filling:
            return
        self._named |= name == "name"
        if not self._named:
            draft = replace(draft, name=proposed_name(self._begun, draft, self._listed()))
            self._write(draft, ["name"])
        self._check(draft, quiet=QUIET)

    def _listed(self) -> set[str]:
        """Return the names that a changed system must not have: those of the menu, and of the system on the page."""
        own = {self._begun.name} if self._loaded else set()
        return {*_built_in(), *own}

    # Checking it -----------------------------------------------------------------------------------------------------

    def _check(self, draft: Draft, quiet: float) -> None:
        self.draft = draft
        self._outcome, self._wanted = None, False
        self._lane.submit(Job(lambda _: check(draft), partial(self._deliver, partial(self._show, draft)), quiet=quiet))

    def _show(self, draft: Draft, outcome: Checked | Exception) -> None:
        """Show the outcome of a check, unless the fields have changed since."""
        if draft != self.draft:
            return
        if isinstance(outcome, Exception):
            self.status.object = complaint(outcome)
            return
        for name, text in self.texts.items():
            self._show_complaint(text, outcome.complaints.get(name), _HELP.get(name, ""))
            self.maths[name].object = _maths(outcome.maths.get(name, ""))
        for name in ("psi", "psi_minus", "psi_plus", "quantities"):
            self.maths[name].object += "".join(map(_finding, outcome.conserved.get(name, ())))
        self._outcome = outcome
        self.status.object = _verdict(outcome)
        if outcome.system is not None:
            self.maths["parameters"].object += _about_unused(outcome.system)
            self._on_ready(outcome.system)
        if self._wanted:
            self._use()

    def _show_complaint(self, text: Any, words: str | None, usual: str) -> None:
        wanted = {"error_state": words is not None, "helper_text": usual if words is None else _without_icons(words)}
        changed = {name: value for name, value in wanted.items() if getattr(text, name) != value}
        text.param.update(**changed)

    def _use(self) -> None:
        """Apply the system, as soon as it is checked unless the fields change; go to the first field in error."""
        self._wanted = self._outcome is None
        if self._outcome is None:
            return
        if self._outcome.system is None:
            wrong = [text for name, text in self.texts.items() if name in self._outcome.complaints]
            if wrong:
                wrong[0].focus()
            return
        try:
            self._on_use(self._outcome.system)
        except ValueError as reason:
            self.status.object = complaint(reason)

    def settle(self, timeout: float) -> bool:
        """Wait at most `timeout` seconds; return whether all checks are done. For use without a server."""
        return self._lane.join(timeout)

    def close(self) -> None:
        """Cancel all checks: the session has ended."""
        self._lane.cancel()

    # Its look --------------------------------------------------------------------------------------------------------

    def _field(self, name: str) -> pn.Column:
        return pn.Column(self.texts[name], self.maths[name], margin=0, sizing_mode="stretch_width")

    def _pair(self, *names: str) -> pn.Row:
        return pn.Row(*map(self._field, names), margin=0, sizing_mode="stretch_width", stylesheets=[PAIR_CSS])

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the fields in a column, in the order in which one writes a system down."""
        return pn.Column(
            self.menu,
            self.kept,
            self._pair("name", "variables"),
            self._field("parameters"),
            heading("Laws"),
            self._field("g"),
            self._pair("f_minus", "f_plus"),
            self._field("jump"),
            self._field("f"),
            self.more,
            Disclosure(self.more, self.several),
            self.several,
            heading("Conserved quantities"),
            self._pair("psi_minus", "psi_plus"),
            self._field("psi"),
            heading("Start"),
            self._field("x0"),
            self.status,
            self.use,
            margin=(4, 12),
            sizing_mode="stretch_width",
        )


def _markup_pane() -> pn.pane.HTML:
    return pn.pane.HTML("", stylesheets=[TEXT_CSS, MATHS_CSS], margin=0, sizing_mode="stretch_width")


def _maths(markup: str) -> str:
    return f'<div class="maths">{markup}</div>' if markup else ""


def _finding(finding: Finding) -> str:
    return as_text(finding.words, "finding kept" if finding.conserved else "finding") + _maths(finding.maths)


def _verdict(outcome: Checked) -> str:
    if outcome.system is not None:
        return '<p role="status">This system is ready.</p>'
    if "system" in outcome.complaints:
        return as_text(outcome.complaints["system"], "error")
    titles = "; ".join(FIELDS[name] for name in FIELDS if name in outcome.complaints)
    return as_text(f"The definition is not valid yet. Please check: {titles}.", "error")


def _about_unused(system: core.PiecewiseSystem) -> str:
    """Return a note that names the parameters on which nothing depends; empty if there are none."""
    laws = system.laws
    said = [*laws.surfaces, *(part for mode in laws.regions for part in (*mode.field, *mode.conserved))]
    said += [part for ways in laws.ways for way in ways for part in way.jump or ()]
    used = {symbol.name for one in said for symbol in one.free_symbols}
    unused = [f"“{parameter.name}”" for parameter in system.parameters if parameter.name not in used]
    return as_text(f"No law contains {listed(unused)}." * bool(unused), "finding")


def _without_icons(words: str) -> str:
    """Return a text in which fields do not replace ``:material/name:`` by an icon."""
    return words.replace(":material/", ":\u2060material/")


def _built_in() -> dict[str, core.PiecewiseSystem]:
    """Return the systems of the catalogue by the names that the menu shows; to declare all of them takes seconds."""
    return {system.name: system for system in core.CATALOGUE.values()}
