"""Small tables of figures, for the page and for the report."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from html import escape

from pwsviz.text.numbers import printed

__all__ = ["Numbers", "table_markup"]


@dataclass(frozen=True)
class Numbers:
    """A table of text cells; the first cell of a row names it."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    """What holds for the whole table."""
    caption: str = ""

    def worded(self, words: Callable[[str], str]) -> Numbers:
        """Return the table with each of its texts as `words` says it."""
        rows = tuple(tuple(map(words, row)) for row in self.rows)
        return Numbers(tuple(map(words, self.header)), rows, words(self.note), words(self.caption))


def table_markup(table: Numbers) -> str:
    """Return a table as HTML, with its caption and with headers that screen readers announce; empty without rows."""
    if not table.rows:
        return ""
    head = _row(f'<th scope="col">{escape(cell)}</th>' for cell in table.header)
    body = "".join(
        _row([f'<th scope="row">{_words(first)}</th>', *(f"<td>{_words(cell)}</td>" for cell in rest)])
        for first, *rest in table.rows
    )
    caption = f"<caption>{escape(printed(table.caption))}</caption>" if table.caption else ""
    return f'<div class="numbers"><table>{caption}<thead>{head}</thead><tbody>{body}</tbody></table></div>'


def _words(cell: str) -> str:
    """Return a cell as markup, in which no equation is broken, as “τ = 0.01”."""
    return escape(printed(cell)).replace(" = ", "&nbsp;=&nbsp;")


def _row(cells: Iterable[str]) -> str:
    return f"<tr>{''.join(cells)}</tr>"
