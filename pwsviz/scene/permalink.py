"""The link: a scene as the query of an address (the part after “?”), and back.

A link names only the settings that what is shown depends on and that differ from the defaults of its system, in words
and exact decimals. On reading, `Scene.accept` checks each value by itself: a value that is refused is reported to the
user and replaced, the others are kept.
"""

from __future__ import annotations

import hashlib
import logging
import re
from typing import Any
from urllib.parse import quote, unquote

import core
from pwsviz.scene.checks import MAX_STARTS, OWN, Start
from pwsviz.scene.names import EXTERNAL_SOLVERS, LABELS, choice_name, short_name
from pwsviz.scene.scene import Scene
from pwsviz.scene.serialization import packed, shown, unpacked, visible
from pwsviz.scene.sweeping import COUNTS
from pwsviz.scene.times import END_TIME, STEP_SIZE
from pwsviz.scene.validation import MAX_STEPS, require_few_steps
from pwsviz.scene.views import VIEWS
from pwsviz.text.advice import on_page
from pwsviz.text.numbers import shortest

VERSION = 2
"""Of the format; a link of an unknown version is read as this one, with a complaint."""
STOPPING = "1"
"""The version whose runs stopped where they would slide: they still do."""
MAX_LENGTH = 32_000
"""Characters of a link that are read: more than `query` ever writes."""
MAX_OWN = 8_000
"""Characters of a link that a user's own system may take."""
MAX_VALUE = 400
"""Characters of a value that is a word, a number or a short list."""
MAX_COMPLAINTS = 20
"""Complaints about one link that are shown; the rest are counted."""
MAX_REASON = 400
"""Characters shown of the reason why a value is refused."""
MAX_DIGITS = 40
"""Characters of a number: a float written exactly needs at most 24."""

_FIRST = ("methods", "own", "system")
"""Applied first: the methods, before a system that cannot use all of them and would keep its unused ones chosen; then
the system, which sets the defaults of the other settings."""
_OF_VIEWS = tuple(dict.fromkeys(name for view in VIEWS.values() for name in view.settings))
_LAST = (
    "selected", "axes", "window", "tolerance", "locate", "slide", "perturbation_order", "perturbation_scale", "view",
    *_OF_VIEWS,
)  # fmt: skip
_SETTINGS = (*_FIRST, "starts", "tau", "t_end", *_LAST)
_LISTS = {"methods": core.METHODS, "peers": EXTERNAL_SOLVERS}

logger = logging.getLogger(__name__)
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


# Writing -------------------------------------------------------------------------------------------------------------


def query(scene: Scene, *, typed: bool = True) -> str:
    """Return the link of a scene, without the “?”.

    Parameters
    ----------
    typed
        Whether it keeps a system of the user's own beside another one that is shown: a reload would lose it.

    Raises
    ------
    ValueError
        If the user's own system takes more than `MAX_OWN` characters.
    """
    usual, pieces = Scene(), [_piece("v", str(VERSION))]

    def differs(key: str) -> bool:
        if key in ("tau", "t_end") and scene.system == OWN:
            return True  # what a reader would propose may change
        kept = (typed and key == "own") or _matters(scene, key)
        return kept and _text(scene, key) != _text(usual, key)

    for key in filter(differs, _FIRST):  # lazily: the defaults depend on the settings before
        pieces.append(_piece(key, _text(scene, key)))
        if key == "own" and len(pieces[-1]) > MAX_OWN:
            raise ValueError(f"Your own system is too long for a link: it may take {MAX_OWN:,} characters there.")
        _take(usual, key, _text(scene, key))
    for name, value in scene.values.items():
        if _decimal(value) != _decimal(usual.values[name]):  # as text: -0.0 is not 0.0
            pieces.append(_piece(_parameter_key(name), _decimal(value)))
    pieces += [_piece(key, _text(scene, key)) for key in filter(differs, _SETTINGS[len(_FIRST) :])]
    return "&".join(pieces)


def digest(scene: Scene) -> str:
    """Return six letters and digits that tell a scene from others, those too large for a link, too."""
    settings = [f"{key}={_text(scene, key)}" for key in _SETTINGS if _matters(scene, key)]
    settings += [f"{name}={_decimal(value)}" for name, value in scene.values.items()]
    return hashlib.sha256("&".join(settings).encode()).hexdigest()[:6]


def _matters(scene: Scene, key: str) -> bool:
    """Whether what the page shows depends on a setting, and not only what another view or system would show."""
    match key:
        case "own":
            return bool(scene.system == OWN)
        case "tolerance":
            return any(core.METHODS[name].adaptive for name in scene.used)
        case "perturbation_scale":
            return scene.perturbation_order is not None
    return key not in _OF_VIEWS or key in VIEWS[scene.view].settings


def _piece(key: str, text: str) -> str:
    return f"{key}={quote(text, safe=',;:*/()')}"


def _parameter_key(name: str) -> str:
    """Return the key of a parameter, with a prefix where a setting has the same name."""
    return f"value.{name}" if name in ("v", *_SETTINGS) else name


def _text(scene: Scene, key: str) -> str:
    """Return a setting as it is written in a link, before quoting."""
    value, variables = getattr(scene, key), scene.declaration.variables
    match key:
        case "own":
            return "" if value is None else packed(value)
        case "starts":
            return ";".join(",".join(map(_decimal, start)) for start in value)
        case "axes":
            return "auto" if value is None else ",".join(variables[k] for k in value)
        case "window" | "sweep_range":
            return "auto" if value is None else ",".join(map(_decimal, value))
        case "stability_around":
            return "auto" if value is None else _decimal(value)
        case "sweep_discard":
            return "auto" if value is None else str(value)
        case "stability_coordinate":
            return str(variables[value])
        case "locate" | "slide" | "order_all" | "section_map":
            return "on" if value else "off"
        case "section_axes":
            return "auto" if value is None else ",".join((*variables, "t")[k] for k in value)
        case "methods" | "peers":
            return ",".join(value)
        case "perturbation_order":
            return str(value or "none")
    return _decimal(value) if isinstance(value, float) else str(value)


def _shown_text(scene: Scene, key: str) -> str:
    """Return a setting as the page shows it."""
    value = getattr(scene, key)
    if key == "own" and not value:
        return str(scene.declaration.name)
    if isinstance(value, str):
        return choice_name(key, value)
    if isinstance(value, list):
        return ", ".join(choice_name(key, one) for one in value) or "none"
    if isinstance(value, float):
        return shortest(value)
    return _text(scene, key).replace(",", ", ") or "none"


def _decimal(value: float) -> str:
    """Return the shortest exact decimal of a float, without the “+” that some URL parsers read as a space."""
    return repr(float(value)).replace("e+", "e")


# Reading -------------------------------------------------------------------------------------------------------------


def read(text: str) -> tuple[dict[str, Any], list[str]]:
    """Return the settings that a link describes, and complaints about it; never raises.

    Parameters
    ----------
    text : str
        The query of an address, with or without the “?”.

    Returns
    -------
    settings : dict
        For `Scene.restore`. Settings the link does not name have the defaults of its system.
    complaints : list of str
        For each value that is unknown, refused or repeated: the value, the reason, and what is used instead. Plain
        text without control characters; escape it before it goes into a page.
    """
    reader = _Reader(text)
    return reader.scene.settings(), reader.complaints()


def adopt(scene: Scene, text: str) -> list[str]:
    """Set a scene to what a link describes, and return the complaints about the link."""
    settings, complaints = read(text)
    scene.restore(settings)
    return complaints


class _Reader:
    """Reads a link into a new scene, and collects complaints."""

    def __init__(self, text: str) -> None:
        self.scene = Scene()
        # Each complaint with either its remedy in words, or a setting whose final value is the remedy.
        self._wrong: list[tuple[str, str]] = []
        self._given = self._split(text)
        named = "methods" in self._given
        for key in _FIRST:
            self._take_setting(key)
        if named and not set(self.scene.methods) & set(self.scene.offered):
            self._complain_of_methods()
        if self.scene.system == OWN:  # a link of a system of one's own names them, unless it is old: they were these
            self.scene.param.update(tau=STEP_SIZE, t_end=END_TIME)
        self._take_parameters()
        self._take_starts()
        self._take_times()
        for key in _LAST:
            self._take_setting(key)
        for key in self._given:
            system = shown(self.scene.declaration.name)
            self._complain(f"“{shown(key)}” is neither a setting of this page nor a parameter of {system}.")

    def complaints(self) -> list[str]:
        """Return at most `MAX_COMPLAINTS` sentences, and one that counts the rest."""
        said = [visible(f"{wrong} {self._instead(what)}") for wrong, what in self._wrong[:MAX_COMPLAINTS]]
        more = len(self._wrong) - len(said)
        return [*said, f"And so on: {more:,} more parts of the link are wrong."] if more else said

    def _instead(self, what: str) -> str:
        return f"Used instead: {_shown_text(self.scene, what)}." if what in _SETTINGS else what

    def _complain(self, wrong: str, instead: str = "It is left out.") -> None:
        self._wrong.append((wrong, instead))

    def _complain_of(self, key: str, reason: ValueError) -> None:
        self._complain(f"“{LABELS[key]}” in the link: {shown(str(reason).rstrip('.'), MAX_REASON)}.", key)

    def _split(self, text: str) -> dict[str, str]:
        """Return the value of each key; a repeated key keeps its first value."""
        given: dict[str, str] = {}
        text = text.removeprefix("?")
        if len(text) > MAX_LENGTH:
            self._complain(f"The link is {len(text):,} characters long.", f"It is cut at {MAX_LENGTH:,}.")
            text = text[:MAX_LENGTH].rpartition("&")[0]  # a number cut short would be another number
        for piece in filter(None, text.split("&")):
            key, equals, value = piece.partition("=")
            key = unquote(key)
            if not equals:
                self._complain(f"“{shown(key)}” in the link has no value: it takes key=value.")
            elif key in given:
                self._complain(f"“{shown(key)}” stands in the link again.", "The first is used.")
            else:
                given[key] = unquote(value)
        version = given.pop("v", str(VERSION))
        if version == STOPPING:
            given.setdefault("slide", "off")
        elif version != str(VERSION):
            wrong = f"The link is of version “{shown(version)}”, which this page does not know."
            self._complain(wrong, f"It is read as version {VERSION}.")
        return given

    def _complain_of_methods(self) -> None:
        """Say that none of the integrators of the link can be used with its system."""
        names, system = ", ".join(self.scene.methods), shown(self.scene.declaration.name)
        wrong = f"“{LABELS['methods']}” in the link: {names} cannot be used with {system}."
        self._complain(wrong, f"Used instead: {', '.join(self.scene.used)}.")

    def _take_setting(self, key: str) -> None:
        if key in _LISTS:
            self._leave_out_unknown(key)
        if key in self._given:
            try:
                _take(self.scene, key, self._given.pop(key))
            except ValueError as reason:
                self._complain_of(key, reason)

    def _leave_out_unknown(self, key: str) -> None:
        """Keep the known names of a list; a list without any is left for `accept` to refuse."""
        names, known = self._given.get(key, "").split(","), _LISTS[key]
        if kept := [name for name in names if name in known]:
            self._given[key] = ",".join(dict.fromkeys(kept))
            for name in [name for name in names if name not in known]:
                offered = ", ".join(choice_name(key, one) for one in known)
                self._complain(f"“{LABELS[key]}” in the link: “{shown(name)}” is not one of {offered}.")

    def _take_parameters(self) -> None:
        for parameter in self.scene.declaration.parameters:
            name, key = parameter.name, _parameter_key(parameter.name)
            if key in self._given:
                try:
                    self.scene.accept(f"values.{name}", _number(self._given.pop(key)))
                except ValueError as reason:
                    instead = f"Used instead: {shortest(self.scene.values[name])}."
                    self._complain(f"“{short_name(parameter)}” in the link: {reason}", instead)

    def _take_starts(self) -> None:
        """Apply the starts; each that is refused is replaced by the default start of the system."""
        if "starts" not in self._given:
            return
        parts, usual = self._given.pop("starts").split(";"), self.scene.starts
        if len(parts) > MAX_STARTS:
            self._complain(f"The link has {len(parts):,} starts.", f"The first {MAX_STARTS} are used.")
        starts = tuple(self._possible(number, part) for number, part in enumerate(parts[:MAX_STARTS], 1))
        self.scene.param.update(starts=usual)
        try:
            self.scene.accept("starts", starts)
        except ValueError as reason:  # with these parameters the default start is refused, too
            self._complain_of("starts", ValueError(on_page(str(reason))))

    def _possible(self, number: int, part: str) -> Start:
        """Return one start, or the default one if it is refused."""
        usual = self.scene.declaration.x0
        try:
            _take(self.scene, "starts", part)
        except ValueError as reason:
            instead = f"Used instead: {', '.join(map(shortest, usual))}."
            self._complain(f"Start {number} in the link: {on_page(str(reason)).rstrip('.')}.", instead)
            return usual
        return self.scene.x0

    def _take_times(self) -> None:
        """Apply step size and end time together: either one with the default of the other may need too many steps.

        If one of them is refused, its replacement suits the other. If the two together need more than `MAX_STEPS`
        steps, the end time is reduced.
        """
        times = {"tau": self.scene.tau, "t_end": self.scene.t_end}
        broken = {key for key in times if key in self._given and not self._time(key, times)}
        try:
            require_few_steps(times["t_end"], times["tau"])
        except ValueError as reason:
            if "tau" in broken:
                times["tau"] = times["t_end"] / MAX_STEPS
            else:
                times["t_end"] = times["tau"] * MAX_STEPS
                if "t_end" not in broken:
                    self._complain_of("t_end", reason)
        self.scene.param.update(**times)

    def _time(self, key: str, times: dict[str, float]) -> bool:
        """Read the step size or the end time into `times`; return whether it was accepted."""
        try:
            times[key] = self.scene.checked_time(key, _number(_short(key, self._given.pop(key))))
        except ValueError as reason:
            self._complain_of(key, reason)
            return False
        return True


def _take(scene: Scene, key: str, text: str) -> None:
    """Apply one setting from a link; ValueError if it is refused."""
    value: object = _short(key, text)
    variables = scene.declaration.variables
    match key:
        case "own":
            _use(scene, text)
            return
        case "starts":
            value = tuple(tuple(map(_number, part.split(","))) for part in text.split(";"))
        case "axes":
            value = None if text == "auto" else tuple(_index(name, variables) for name in text.split(","))
        case "window" | "sweep_range":
            value = None if text == "auto" else tuple(map(_number, text.split(",")))
        case "stability_around":
            value = _number(text)
        case "stability_coordinate":
            value = _index(text, variables)
        case "section_axes":
            value = None if text == "auto" else tuple(_index(name, (*variables, "t")) for name in text.split(","))
        case "section_direction" | "sweep_direction":
            value = int(text) if text in ("-1", "0", "1") else text
        case "selected":
            value = int(text) if re.fullmatch("[0-9]{1,3}", text) else text
        case "locate" | "slide" | "order_all" | "section_map":
            value = {"on": True, "off": False}.get(text, text)
        case "methods" | "peers":
            value = text.split(",") if text else []
        case "perturbation_order":
            value = {str(order or "none"): order for order in scene.param[key].objects}.get(text, text)
        case "tolerance" | "perturbation_scale" | "section_points" | "section_discard" | "sweep_end":
            value = _number(text)
        case "sweep_discard" if text == "auto":
            value = None
        case _ if key in COUNTS:
            value = None if text == "auto" else _number(text)
    scene.accept(key, value)


def _short(key: str, text: str) -> str:
    """Return the text of a value; ValueError if it is too long."""
    limit = {"own": MAX_OWN, "starts": MAX_LENGTH}.get(key, MAX_VALUE)
    if len(text) > limit:
        raise ValueError(f"“{shown(text)}” is {len(text):,} characters long; at most {limit:,} can be read.")
    return text


def _use(scene: Scene, text: str) -> None:
    """Apply a user's own system; ValueError if it is refused, or if the analysis of its expressions fails."""
    try:
        scene.use(unpacked(text))
    except ValueError:
        raise
    except Exception as failure:  # sympy or NumPy may fail on arbitrary text, and the page has to open
        logger.exception("a system in a link cannot be used: %r", text)
        raise ValueError(f"this system cannot be used ({type(failure).__name__})") from failure


def _number(text: str) -> str:
    """Return the text of a plain decimal number; ValueError for others that `float` accepts, such as 1_0 or nan."""
    if len(text) > MAX_DIGITS or not _NUMBER.fullmatch(text):
        raise ValueError(f"“{shown(text)}” is not a number. Write one such as “0.01” or “1e-3”.")
    return text


def _index(name: str, variables: tuple[str, ...]) -> int:
    if name not in variables:
        raise ValueError(f"“{shown(name)}” is not a variable of this system; it has {', '.join(variables)}.")
    return variables.index(name)
