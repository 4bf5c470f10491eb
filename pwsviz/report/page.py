"""The report as one page of HTML, with everything it needs inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bokeh.embed import file_html
from bokeh.resources import INLINE, Resources

from pwsviz.report.panels import Panel

__all__ = ["Bench", "Figure", "page_html"]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper: its panels, and the file of each."""

    label: str
    panels: tuple[Panel, ...]
    files: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class Bench:
    """What the benchmark printed, and its files."""

    text: str
    files: tuple[str, ...]
    quick: bool


STYLE = """
:root { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1c1c1c; background: #fff; }
body { max-width: 44rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.7rem; margin: .5rem 0; } h2 { font-size: 1.25rem; margin: 2.5rem 0 .5rem; } h3 { font-size: 1rem; }
code { overflow-wrap: anywhere; }
h2 code { font-size: .8em; font-weight: normal; color: #595959; margin-left: .4em; }
nav ul, #bench ul { columns: 2 16rem; padding-left: 1.2rem; }
#bench ul { font-size: .85rem; }
figure { margin: 0 0 1rem; break-inside: avoid; }
figcaption { font-size: .9rem; } figcaption p { margin: .4rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; margin: .5rem 0; }
th, td { text-align: right; padding: .15rem .6rem; border-bottom: 1px solid #ddd; vertical-align: top; }
th, td { white-space: nowrap; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
th { font-weight: 600; border-bottom-color: #777; }
.small, .summary { color: #595959; font-size: .85rem; }
pre { font-size: .72rem; line-height: 1.35; overflow-x: auto; }
.bench { width: min(96vw, 78rem); margin-left: 50%; transform: translateX(-50%); }
a { color: #0b57a4; }
@media print {
  @page { margin: 14mm; }
  body { max-width: none; padding: 0; }
  nav { display: none; }
  .bench { width: auto; margin: 0; transform: none; }
  pre { font-size: 5.4pt; white-space: pre; overflow: visible; }
  .wide { overflow: visible; }
  table { font-size: 7.5pt; }
}
"""

TEMPLATE = """
{% macro numbers(table) %}
<div class="wide"><table>
<thead><tr>{% for cell in table.header %}<th scope="col">{{ cell | e }}</th>{% endfor %}</tr></thead>
<tbody>{% for row in table.rows %}
<tr>{% for cell in row %}<td>{{ cell | e }}</td>{% endfor %}</tr>{% endfor %}
</tbody></table></div>
{% if table.note %}<p class="small">{{ table.note | e }}</p>{% endif %}
{% endmacro %}
{% block preamble %}<meta name="viewport" content="width=device-width, initial-scale=1">
<script>/* Pixels enough for paper. */
if (devicePixelRatio < 2) Object.defineProperty(window, "devicePixelRatio", {value: 2})</script>{% endblock %}
{% block css_resources %}{% endblock %}
{% block js_resources %}{% for script in scripts %}<script>{{ script }}</script>{% endfor %}{% endblock %}
{% block postamble %}<style>{{ style }}</style>{% endblock %}
{% block contents %}
<header>
<h1>{{ title | e }}</h1>
<p>The figures of Hirani, Wan, Wojtalewicz, <i>Conservative integrators for piecewise smooth systems with transversal
dynamics</i>, computed anew, each with what was measured for it and the data as CSV. Curves are reduced to what a screen
can show; the CSV files are not.</p>
{% if missing %}<p role="alert"><strong>Not complete.</strong> {{ missing | e }}</p>{% endif %}
<p class="small">{% for line in about %}{{ line | e }}{{ "<br>" if not loop.last }}{% endfor %}</p>
</header>
<nav aria-label="Figures"><ul>
{% for drawn in figures %}<li><a href="#{{ drawn.label | e }}">{{ drawn.label | e }}</a></li>
{% endfor %}{% if bench %}<li><a href="#bench">Benchmark</a></li>{% endif %}
</ul></nav>
<main>
{% for drawn in figures %}
<section id="{{ drawn.label | e }}">
<h2>{{ titles[drawn.label] | e }} <code>{{ drawn.label | e }}</code></h2>
{% for panel in drawn.panels %}
<figure>
{% if drawn.panels | length > 1 %}<h3>{{ panel.preset.title | e }}</h3>{% endif %}
{{ embed(roots[panel.preset.key]) }}
<figcaption>
<p>{{ panel.preset.look | e }}</p>
<p class="summary">{{ panel.summary | e }}</p>
{{ numbers(panel.numbers) }}
<p class="small">Data: <a href="{{ drawn.files[loop.index0] | e }}" download>{{ drawn.files[loop.index0] | e }}</a>.<br>
The end of its address in the explorer: <code>?{{ panel.link | e }}</code></p>
</figcaption>
</figure>
{% endfor %}
<p class="small">Computed in {{ "%.1f" | format(drawn.seconds) }} s, all in all.</p>
</section>
{% endfor %}
{% if bench %}
<section id="bench">
<h2>Benchmark</h2>
<p>As <code>python -m pwsviz bench{{ " --quick" if bench.quick }}</code> printed it, in a process of its own.
{% if bench.quick %}<strong>The runs were short, and these times are too small to state.</strong>{% endif %}
Its text and tables are files too:</p>
<ul>{% for name in bench.files %}
<li><a href="{{ name | e }}" download>{{ name | e }}</a></li>{% endfor %}
</ul>
<div class="bench"><pre tabindex="0">{{ bench.text | e }}</pre></div>
</section>
{% endif %}
</main>
{% endblock %}
"""


def page_html(
    figures: Sequence[Figure],
    titles: Mapping[str, str],
    about: Sequence[str],
    bench: Bench | None = None,
    missing: str = "",
) -> str:
    """Return the page.

    Parameters
    ----------
    figures : sequence of Figure
        What was drawn; a figure can be on one page only.
    titles : mapping of label to str
        What the paper's figures show.
    about : sequence of str
        Lines on versions and the machine.
    bench : Bench, optional
        Where it was run.
    missing : str
        What there was no time for.
    """
    # Not what Bokeh would put in their place: where Panel is loaded, that links to files of Panel's models.
    scripts = Resources(mode="inline", components=["bokeh"]).js_raw
    given = {
        "scripts": scripts, "style": STYLE, "figures": figures, "titles": titles, "about": about, "bench": bench,
        "missing": missing,
    }  # fmt: skip
    return file_html(
        [panel.plot for drawn in figures for panel in drawn.panels],
        INLINE,
        "pwsviz: figures of the paper",
        template=TEMPLATE,
        template_variables=given,
        suppress_callback_warning=True,  # of the page's own callbacks; here nobody answers them
    )
