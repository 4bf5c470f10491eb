"""python -m pwsviz report: every figure of the paper, as computed here, on one page that needs no server."""

from __future__ import annotations

from pwsviz.report.write import PAGE, Unwritable, figures_of_paper, write_report

__all__ = ["PAGE", "Unwritable", "figures_of_paper", "write_report"]
