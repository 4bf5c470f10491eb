"""Tables as files: CSV and NPZ.

A table is a mapping of names to columns of one length. The data of a picture are one table, or several, by name.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import zipfile
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pwsviz.export.columns import is_count, meanings
from pwsviz.scene.checks import OWN
from pwsviz.scene.permalink import digest
from pwsviz.scene.scene import Scene

__all__ = ["ROWS", "Table", "Tables", "csv_bytes", "file_name", "npz_bytes"]

Table = Mapping[str, ArrayLike]
"""Columns (n,) of numbers or words, by name."""

Tables = Mapping[str, Callable[[], Table]]
"""The data of a picture: each table is made when it is asked for; one that stands alone may be called “”."""

_SIGNS = re.compile("[-+0]+")
"""The key of a region, or of sliding."""

ROWS = 50_000
"""Rows formatted at a time, so that a long run is never held as text."""


def csv_bytes(table: Table, about: Mapping[str, str] | None = None) -> bytes:
    """Return a table as comma-separated values in UTF-8, with floats to the last digit.

    Lines that begin with “#” precede it: what `about` says, and the meaning and unit of each column. Words that a
    spreadsheet would take for formulas are marked as text.

    Parameters
    ----------
    table : mapping of name to (n,) array
        Columns of one length.
    about : mapping of name to str
        Origin of the numbers: the scene and how it was integrated.
    """
    columns = _columns(table)
    text = io.StringIO(newline="")
    for name, said in _header(columns, about).items():
        text.write(f"# {_on_one_line(name)}: {_on_one_line(said)}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_harmless, columns))
    file = io.BytesIO()
    for start in range(0, max(map(len, columns.values()), default=0), ROWS):
        cells = (_cells(name, column[start : start + ROWS]) for name, column in columns.items())
        writer.writerows(zip(*cells, strict=True))
        file.write(text.getvalue().encode())
        text.seek(0)
        text.truncate()
    file.write(text.getvalue().encode())
    return file.getvalue()


def npz_bytes(tables: Mapping[str, Table], about: Mapping[str, str] | None = None) -> bytes:
    """Return tables as an NPZ that `numpy.load` reads without pickle.

    A column is called “table.column”, or “column” in a table without a name. The text “about” is JSON: what `about`
    says, and the meaning and unit of each column.

    Parameters
    ----------
    tables : mapping of name to table
        The data of a picture.
    about
        As in `csv_bytes`.
    """
    arrays: dict[str, NDArray[Any]] = {}
    for title, table in tables.items():
        arrays |= {f"{title}.{name}" if title else name: column for name, column in _columns(table).items()}
    named = {name.rpartition(".")[2]: column for name, column in arrays.items()}
    arrays["about"] = np.array(json.dumps(_header(named, about), ensure_ascii=False))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:  # not numpy.savez, which refuses a column named file
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, array, allow_pickle=False)
    return file.getvalue()


def file_name(scene: Scene, what: str, ending: str) -> str:
    """Return a name such as “pwsviz-elliptic_curve-order-1a2b3c.csv”: ASCII letters, digits, “-”, “_” and one dot.

    The last part before the dot tells the files of one scene from those of another; their header has it, too.
    """
    system = scene.declaration.name if scene.system == OWN else scene.system
    words = filter(None, map(_plain, ("pwsviz", system, what, digest(scene))))
    return f"{'-'.join(words)}.{_plain(ending)}"


def _plain(text: str) -> str:
    return re.sub("[^A-Za-z0-9_]+", "-", text)[:40].strip("-").lower()


def _header(columns: Mapping[str, NDArray[Any]], about: Mapping[str, str] | None) -> dict[str, str]:
    said = meanings(columns)
    gaps = any(column.dtype.kind == "f" and np.isnan(column).any() for column in columns.values())
    header = dict(about or {}) | ({"columns": said} if said else {})
    return header | ({"nan": "a gap in a curve, or a value that is not known"} if gaps else {})


def _columns(table: Table) -> dict[str, NDArray[Any]]:
    columns = {name: np.asarray(column) for name, column in table.items()}
    for name, column in columns.items():
        if column.ndim != 1 or column.dtype.kind not in "biufU":
            raise ValueError(f"column {name!r} is not a list of numbers or words: {column.ndim} axes of {column.dtype}")
    if len({len(column) for column in columns.values()}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in columns.items())
        raise ValueError(f"the columns of a table have one length; there are {lengths}")
    return columns


def _cells(name: str, column: NDArray[Any]) -> Iterable[object]:
    cells: list[Any] = column.tolist()  # the writer gives floats to the last digit
    if column.dtype.kind == "f" and is_count(name):
        return [int(count) if math.isfinite(count) else count for count in cells]
    return map(_harmless, cells) if column.dtype.kind == "U" else cells


def _harmless(cell: object) -> str:
    """Return a word on one line that no spreadsheet takes for a formula (OWASP, “CSV injection”).

    The signs of a region, as “+-”, stay as they are: there is no formula of signs and zeros that does anything.
    """
    text = _on_one_line(str(cell))
    return f"'{text}" if text.lstrip().startswith(("=", "+", "-", "@")) and not _SIGNS.fullmatch(text) else text


def _on_one_line(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)
