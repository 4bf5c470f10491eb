"""Export of a view: its numbers as CSV or NPZ, its picture as PNG.

A table is a mapping of names to columns, whose lengths may differ: a run has more steps than crossings.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from itertools import zip_longest
from typing import Any

import numpy as np
from bokeh.plotting import figure
from numpy.typing import ArrayLike, NDArray

import core
from pwsviz.scene.scene import OWN, Scene

Table = Mapping[str, ArrayLike]
"""Columns (n,) of numbers or words, by name."""

CHANGE = "change_of_psi"
"""Name of the column of |Δψ|; in ASCII, as it names a file in an NPZ."""

ROWS = 50_000
"""Rows formatted at a time, so that a long run is never held as text."""

_OURS = {"about", "method", "start", "side", CHANGE, "kind", "number"}
"""Names of columns that are not variables; those of crossings begin with “crossing_”."""


# Files ---------------------------------------------------------------------------------------------------------------


def csv_bytes(table: Table, about: str = "") -> bytes:
    """Return a table as comma-separated values in UTF-8, with floats to the last digit.

    The first line is a comment: this package, its version and `about`. Short columns end in empty cells.
    Words that a spreadsheet would take for formulas are marked as text.

    Parameters
    ----------
    table : mapping of name to (n,) array
        Columns.
    about : str
        Origin of the numbers, such as the link of the scene.
    """
    columns = _columns(table)
    text = io.StringIO(newline="")
    text.write(f"# {_origin(about)}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_harmless, columns))
    file = io.BytesIO()
    for start in range(0, max(map(len, columns.values()), default=0), ROWS):
        writer.writerows(zip_longest(*(_cells(column[start : start + ROWS]) for column in columns.values())))
        file.write(text.getvalue().encode())
        text.seek(0)
        text.truncate()
    file.write(text.getvalue().encode())
    return file.getvalue()


def npz_bytes(table: Table, about: str = "") -> bytes:
    """Return a table as an NPZ that `numpy.load` reads without pickle: the columns, and a text “about”.

    Parameters
    ----------
    table, about
        As in `csv_bytes`.
    """
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:  # not numpy.savez, which refuses a column named file
        for name, column in {**_columns(table), "about": np.array(_origin(about))}.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, column, allow_pickle=False)
    return file.getvalue()


def file_name(scene: Scene, what: str, ending: str) -> str:
    """Return a name such as “pwsviz-elliptic_curve-order.csv”: ASCII letters, digits, “-”, “_” and one dot."""
    system = scene.declaration.name if scene.system == OWN else scene.system
    words = filter(None, map(_plain, ("pwsviz", system, what)))
    return f"{'-'.join(words)}.{_plain(ending)}"


def _plain(text: str) -> str:
    return re.sub("[^A-Za-z0-9_]+", "-", text)[:40].strip("-").lower()


def _origin(about: str) -> str:
    """Return one line on the origin of a file."""
    try:
        release = version("pwsviz")
    except PackageNotFoundError:  # not installed
        release = "from source"
    return _on_one_line(f"pwsviz {release} {about}".strip())


def _columns(table: Table) -> dict[str, NDArray[Any]]:
    columns = {name: np.asarray(column) for name, column in table.items()}
    for name, column in columns.items():
        if column.ndim != 1 or column.dtype.kind not in "biufU":
            raise ValueError(f"column {name!r} is no list of numbers or words: {column.ndim} axes of {column.dtype}")
    return columns


def _cells(column: NDArray[Any]) -> Iterable[object]:
    cells: list[object] = column.tolist()  # the writer gives floats to the last digit
    return map(_harmless, cells) if column.dtype.kind == "U" else cells


def _harmless(cell: object) -> str:
    """Return a word on one line that no spreadsheet takes for a formula (OWASP, “CSV injection”)."""
    text = _on_one_line(str(cell))
    return f"'{text}" if text.lstrip().startswith(("=", "+", "-", "@")) else text


def _on_one_line(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


# Tables --------------------------------------------------------------------------------------------------------------


def run_table(run: core.Trajectory) -> dict[str, NDArray[Any]]:
    """Return a run at the integrator's own steps, and its crossings.

    Columns
    -------
    t, the variables by name, side, change_of_psi (|Δψ| since the start); crossing_t, crossing_<variable>,
    crossing_side (the side entered, 0 if the run stopped there), crossing_kind.
    """
    crossings = run.crossings
    return {
        "t": run.t,
        **_by_name(run.system.variables, run.x),
        "side": run.side,
        CHANGE: run.change_of_psi(),
        "crossing_t": crossings.t,
        **{f"crossing_{name}": column for name, column in _by_name(run.system.variables, crossings.x).items()},
        "crossing_side": crossings.side,
        "crossing_kind": crossings.kind,
    }


def runs_table(runs: Mapping[str, core.Trajectory]) -> dict[str, NDArray[Any]]:
    """Return several runs side by side, with the title of the run before each column name: “dmm2.t”."""
    return {f"{title}.{name}": column for title, run in runs.items() for name, column in run_table(run).items()}


def order_table(study: core.OrderStudy) -> dict[str, NDArray[Any]]:
    """Return both errors of an order study over its step sizes, and the fitted orders.

    Columns
    -------
    tau, state_error_after_<k>, time_error_<k> for crossing number k (0: before the first); after (the numbers k),
    compared_at (times at which states are compared), state_slope, time_slope (NaN before the first), each with the
    least and the greatest step size of its fit; method, floor and reference of the study, once each.
    """
    after = (0, *study.crossings)
    gap = np.full((1, 2), np.nan)
    windows = {"state": study.window, "time": np.concatenate([gap, study.time_window])}
    slopes = {"state": study.state_slope, "time": np.concatenate([gap[0, :1], study.time_slope])}
    table: dict[str, NDArray[Any]] = {"tau": study.taus}
    table |= {f"state_error_after_{k}": row for k, row in zip(after, study.state_error, strict=True)}
    table |= {f"time_error_{k}": row for k, row in zip(study.crossings, study.time_error, strict=True)}
    table |= {"after": np.array(after), "compared_at": study.times}
    for error, slope in slopes.items():
        table |= {f"{error}_slope": slope, f"{error}_fit_from": windows[error][:, 0]}
        table[f"{error}_fit_to"] = windows[error][:, 1]
    once = {"method": study.method, "floor": study.floor, "reference": study.reference}
    return table | {name: np.array([value]) for name, value in once.items()}


def _by_name(variables: Sequence[str], states: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return the columns of states (n, d) by variable, with a prefix where a column of ours has the same name."""
    clash = {name for name in variables if name in _OURS or name.startswith("crossing_")}
    names = [f"variable_{name}" if name in clash else name for name in variables]
    return dict(zip(names, states.T, strict=True))


# Pictures ------------------------------------------------------------------------------------------------------------

_SAVE_PICTURE = """
const view = Bokeh.index.find_one_by_id("ID")
if (view != null) {
  let ground = null
  for (let node = view.el; node != null && ground == null; node = node.parentElement ?? node.getRootNode().host) {
    const colour = getComputedStyle(node).backgroundColor
    if (!/^transparent$|, 0\\)$/.test(colour)) ground = colour
  }
  const {canvas} = view.export("png")
  const picture = document.createElement("canvas")
  picture.width = canvas.width
  picture.height = canvas.height
  const pen = picture.getContext("2d")
  pen.fillStyle = ground ?? "white"
  pen.fillRect(0, 0, picture.width, picture.height)
  pen.drawImage(canvas, 0, 0)
  picture.toBlob(blob => {
    const link = document.createElement("a")
    link.href = URL.createObjectURL(blob)
    link.download = name
    link.click()
    setTimeout(() => URL.revokeObjectURL(link.href), 60000)
  }, "image/png")
}
"""


def png_callback(plot: figure) -> str:
    """Return JavaScript that saves a figure as seen, at the resolution of the device, on the background of the page.

    It takes the name of the file from an argument ``name``, and is meant for `js_on_click` of a button:
    ``button.js_on_click(args={"name": "portrait.png"}, code=png_callback(plot))``.
    """
    return _SAVE_PICTURE.replace("ID", plot.id)
