"""The constants of the theory of the paper for a run, as a table in HTML."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import core
from core.diagnostics import stand_in
from core.kernels import Floats
from pwsviz.scene.names import tally_of
from pwsviz.text.advice import on_page
from pwsviz.text.math_names import name_markup
from pwsviz.text.numbers import printed

__all__ = ["constants_markup", "table"]


class _Constant(NamedTuple):
    """A row of the table."""

    symbol: str
    field: str  # of the diagnosis
    label: str  # name and number in the paper
    meaning: str
    greatest: bool = False
    bounds_tau: bool = False

    def worst(self, diagnosis: core.Diagnosis) -> float:
        values: Floats = getattr(diagnosis, self.field)
        known = values[~np.isnan(values)]
        if not known.size:
            return math.nan
        return float(known.max() if self.greatest else known.min())


_CONSTANTS = (
    _Constant(r"\alpha_{S}^{2}", "alpha2", "transversality (1.2)", "smallest |dg/dt| at which the solution crosses"),
    _Constant(
        r"\hat{\alpha}_{S}^{2}", "alpha_hat2", "discrete transversality (3.6)",
        "its counterpart for the scheme’s steps to and from the surface; has to be positive",
    ),
    _Constant(
        "M", "M", "(3.2)", "half the largest d²g/dt² along the flow in a step of this τ: ½ sup |d²g/dt²|",
        greatest=True,
    ),
    _Constant(
        r"\hat{M}", "M_hat", "(3.9)",
        "its counterpart for the scheme: ½ sup |f^τ·H f^τ|, H the Hessian of g; if g depends on t, (t, x) and (1, f^τ)",
        greatest=True,
    ),
    _Constant(
        r"\tau^{*}_{-}", "tau_minus", "Lemma A.3", "up to this τ the step to the surface has a unique solution",
        bounds_tau=True,
    ),
    _Constant(
        r"\tau^{*}_{+}", "tau_plus", "Lemma A.4", "up to this τ the step on from it has a unique solution",
        bounds_tau=True,
    ),
    _Constant(
        r"\alpha_{S}^{2} / M", "window", "monotonicity (B.2)",
        "if τ is below this, the solution does not meet the surface again within a step (M is that of this τ)",
        bounds_tau=True,
    ),
    _Constant(
        r"\hat{\alpha}_{S}^{2} / \hat{M}", "window_hat", "discrete monotonicity (B.6)",
        "if τ is below this, the scheme does not meet the surface again within a step (M̂ is that of this τ)",
        bounds_tau=True,
    ),
)  # fmt: skip


def constants_markup(method: str, diagnosis: core.Diagnosis | None, run: core.Trajectory | None) -> str:
    """Return the constants of a run as a table, and a warning for each bound that its τ exceeds.

    Parameters
    ----------
    method
        A key of `core.METHODS`.
    diagnosis
        The constants, as from `core.diagnose`; None if they are not known.
    run
        The run along which they are evaluated.

    Returns
    -------
    str
        HTML without scripts.
    """
    if diagnosis is None or run is None:
        return "<p>They are computed from a run; there is none yet.</p>"
    across = ~np.isnan(diagnosis.alpha2)
    if not len(across):
        return f"<p>{escape(diagnosis.summary)} The constants are defined at crossings.</p>"
    if not across.any() and not diagnosis.warnings:
        met = f"The run has no transversal crossing, but {tally_of(run)}"
        return f"<p>{met}: the theory’s constants and bounds do not apply.</p>"
    judged = run.status is not core.Status.ZENO and not core.METHODS[method].adaptive
    rows = [_constant_row(constant, diagnosis, judged) for constant in _CONSTANTS]
    whose = f"{run.method} from ({', '.join(f'{v:g}' for v in run.x[0])})"
    caption = f"The worst values over {tally_of(run)} of {whose}, {_at(diagnosis.tau, method)}."
    worst = table(["constant", "value", "meaning", "paper"], rows, caption)
    return _verdict(diagnosis, run, across) + worst + _stand_in(method)


def _at(tau: float, method: str) -> str:
    return f"at τ {'≤' if core.METHODS[method].adaptive else '='} {tau:.3g}"


def _constant_row(constant: _Constant, diagnosis: core.Diagnosis, judged: bool) -> list[str]:
    value = constant.worst(diagnosis)
    number = f'<span class="number">{_shown(value, constant.bounds_tau)}</span>'
    if constant.bounds_tau and judged and _is_exceeded(value, diagnosis):
        number = f'<span class="number exceeded">{_shown(value, True)} &lt; τ</span>'
    symbol = "".join(map(name_markup, constant.symbol.split()))
    return [f"<math>{symbol}</math>", number, prose(constant.meaning), escape(constant.label)]


def _is_exceeded(value: float, diagnosis: core.Diagnosis) -> bool:
    """Whether τ exceeds a bound; one of 0 tells that there is none, unless the discrete transversality fails."""
    fails = bool((diagnosis.alpha_hat2 <= 0.0).any())
    return value < diagnosis.tau and (value > 0.0 or fails)


def _verdict(diagnosis: core.Diagnosis, run: core.Trajectory, across: NDArray[np.bool_]) -> str:
    """Say which bounds τ exceeds; `across` tells which of the times at the surface are transversal crossings."""
    if run.status is core.Status.ZENO:
        return (
            "<p>The crossings accumulate: they come closer than any step, and no τ satisfies the bounds throughout.</p>"
        )
    if core.METHODS[run.method].adaptive:
        return f"<p>{escape(run.method)} chooses its own steps: bounds on a fixed τ do not apply to them.</p>"
    warnings = diagnosis.warnings or tuple(filter(None, [run.warning.removesuffix(".")]))
    if not warnings:
        bounds = [getattr(diagnosis, one.field)[across] for one in _CONSTANTS if one.bounds_tau]
        known = "" if not np.isnan(bounds).any() else " that are known"
        known += ", as estimated below" if stand_in(run.method).name != run.method else ""
        elsewhere = "" if across.all() else " Where the surface is not crossed transversally they do not apply."
        if not np.isfinite(diagnosis.M[across]).all():
            known, elsewhere = " that exist", f" The second derivative of g is not bounded at a crossing.{elsewhere}"
        return f"<p>τ satisfies all bounds{known}.{elsewhere}</p>"
    items = "".join(f"<li>{escape(printed(on_page(words)))}.</li>" for words in warnings)
    return f'<ul class="warnings" role="alert">{items}</ul>'


def _stand_in(method: str) -> str:
    """Say which method's steps the discrete constants are of, if not those of this method."""
    whole = stand_in(method)
    if whole.name == method:
        return ""
    whose = f"one step of {whole.name}" if whole.conservative else "one classical Runge–Kutta step"
    return f"<p>For {escape(method)}, the constants of the scheme are estimated by those of {whose}.</p>"


def _shown(value: float, bounds_tau: bool) -> str:
    if math.isnan(value):
        return "not known"
    if math.isinf(value):
        return "no bound" if bounds_tau else "∞"
    return printed(f"{value:.3g}")


def prose(words: str) -> str:
    """Return words as markup, escaped, with the exponent τ raised, as in formulas: Λ^τ is the multiplier."""
    return escape(printed(words)).replace("^τ", "<sup>τ</sup>")


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """Return a table whose first column holds the row headers; all cells are markup, so escape plain text."""
    top = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>{"".join(f"<td>{cell}</td>" for cell in row[1:])}</tr>' for row in rows
    )
    name = f"<caption>{escape(printed(caption))}</caption>" if caption else ""
    return f"<table>{name}<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
