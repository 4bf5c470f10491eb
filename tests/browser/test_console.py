"""No script complains: not in any example and view, and not while a source has rows without colours."""

import pytest

from pwsviz.scene.presets import PRESETS
from tests.browser.looking import await_painted
from tests.browser.test_portrait import FIGURE

pytestmark = pytest.mark.browser

#: Gives the crossings of the portrait more rows, the last one of another kind, and changes the layout before the
#: browser has the colours of these rows; returns what is said, and the figure's number of rows after a while.
HALF = f"""async () => {{
    const {{view}} = ({FIGURE})("Phase portrait"), said = []
    const of_crossings = ({{glyph, data_source: {{data}}}}) =>
        "kind" in data && "number" in data && glyph.line_color?.field
    const renderer = view.model.renderers.find(of_crossings), source = renderer.data_source
    const count = 50 * source.length
    const longer = Object.fromEntries(Object.entries(source.data).map(([name, column]) =>
        [name, Array.from({{length: count}}, (_, k) => column[k % column.length])]))
    longer.label[count - 1] = "corner"
    try {{
        source.setv({{data: longer}}, {{sync: false}})
        view.model.setv({{min_border_left: view.model.min_border_left + 40}}, {{sync: false}})
    }} catch (error) {{
        said.push(String(error))
    }}
    await new Promise(resolve => setTimeout(resolve, 500))
    const painted = renderer.view.filter.indices.length  // of those that lie on one another, one is
    return [said, painted > 0 && view.views.find_one(renderer).glyph.line_color.length == painted]
}}"""


def test_a_figure_is_not_painted_while_its_rows_have_no_colours(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    assert page.evaluate(HALF) == [[], True]


@pytest.mark.deep
@pytest.mark.parametrize("part", range(3))
def test_no_example_and_no_view_of_it_makes_a_script_complain(visit, part):
    """Each example in three of nine views, in turn: every view is seen with many examples."""
    page = visit()
    examples, views = page.get_by_role("combobox", name="Examples"), page.get_by_role("tab").all()
    for k, preset in enumerate(PRESETS.values()):
        if k % 3 == part:
            examples.select_option(label=preset.title)
            for view in views[k // 3 % 3 :: 3]:
                view.click()
                page.wait_for_timeout(200)
