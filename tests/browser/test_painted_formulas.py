"""Formulas as a browser paints them."""

import pytest

from tests.browser.looking import await_painted

pytestmark = [pytest.mark.browser, pytest.mark.deep]

#: Of each root that is shown: its height and that of what is under it, and whether its sign is drawn left of that.
ROOTS = """page => {
    const found = []
    const search = node => {
        for (const root of node.querySelectorAll("msqrt")) {
            const inner = root.firstElementChild.getBoundingClientRect(), whole = root.getBoundingClientRect()
            if (!whole.width) continue
            found.push({sign: inner.left - whole.left, over: inner.top - whole.top, size: inner.height})
        }
        for (const part of node.querySelectorAll("*")) if (part.shadowRoot) search(part.shadowRoot)
    }
    search(document)
    return found
}"""


def test_roots_are_drawn_in_a_font_that_the_page_brings(visit):
    page = visit(query="v=1&system=kepler&t_end=1&view=scheme")
    await_painted(page, "Phase portrait")
    page.locator("msqrt").first.wait_for()
    page.wait_for_function("document.fonts.check('16px \"pwsviz maths\"', '√')")
    roots = page.evaluate(ROOTS)
    assert roots
    assert all(root["sign"] > root["size"] / 3 and root["over"] > 0 for root in roots)
    assert page.evaluate("performance.getEntriesByType('resource').some(one => one.name.includes('maths.woff2'))")
