"""What the browser tests share: how a picture is awaited and a field is found."""

import re
import time

PATIENCE = 60_000
"""Milliseconds to wait for what comes in one or two on a quiet machine: tests run beside one another."""

INTERVAL = 50
"""Milliseconds between two looks."""

THEME = re.compile("^(Dark|Light) theme$")
"""Name of the button of the theme, which tells what a click does."""

COLOURS = """canvas => {
    const {width, height} = canvas
    const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, width, height).data.buffer)
    return new Set(pixels).size
}"""

GROUND = """canvas => {
    const {width, height} = canvas
    const counts = new Map()
    for (const pixel of new Uint32Array(canvas.getContext("2d").getImageData(0, 0, width, height).data.buffer))
        counts.set(pixel, (counts.get(pixel) ?? 0) + 1)
    return [...counts].reduce((most, other) => other[1] > most[1] ? other : most)[0]
}"""


BLANK_KEYS = """() => [...Bokeh.index.query(view => view.model.type == "Legend")].flatMap(({entries}) => entries
    .filter(({el, glyph: {canvas}}) => {
        if (!(el.offsetWidth > 0)) { return false }
        const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
        return pixels.every(value => value == 0)
    })
    .map(entry => entry.label))"""
"""The entries of legends that are shown beside which no key is painted."""

UNPRINTED = """() => {
    const found = []
    const look = node => {
        for (const part of [...node.childNodes, ...(node.shadowRoot?.childNodes ?? [])]) {
            const words = part.nodeType == Node.TEXT_NODE ? part.data.replace(/“[^”]*”/g, "") : ""
            if (/\\de[-+]?\\d|(^|[\\s(=≤])-\\.?\\d/.test(words)) { found.push(words) }
            if (!/^(STYLE|SCRIPT|PRE|CODE|OPTION)$/.test(part.nodeName)) { look(part) }
        }
    }
    look(document.body)
    return found
}"""
"""The texts of the page that have a number as programs write it, such as 1e-6 or -3."""

TIP = """() => [...document.querySelectorAll(".bk-Tooltip")].filter(tip => tip.getBoundingClientRect().width > 0)
    .map(tip => [tip.shadowRoot.querySelector(".bk-tooltip-content").textContent, getComputedStyle(tip).color,
                 getComputedStyle(tip).backgroundColor])[0]"""
"""Text and colours of what tells of the place under the pointer."""


def moments(page):
    """Yield again and again until patience ends, a moment apart."""
    end = time.monotonic() + PATIENCE / 1000
    while time.monotonic() < end:  # a look itself may take seconds
        yield
        page.wait_for_timeout(INTERVAL)


def becomes(page, holds):
    """Whether something holds before patience ends; a machine at work on something else paints late."""
    return any(holds() for _ in moments(page))


def canvas(page, figure):
    return page.get_by_role("application", name=re.compile(figure)).locator("canvas").first


RUN = re.compile(r"\d steps?, ")
"""In the figures of a run, which are shown with its curve; field, surface and starts may be there before."""


def await_painted(page, figure, colours=30):
    """Wait until runs are shown and a figure has lines on it, told by the many shades that smooth lines bring."""
    drawing = canvas(page, figure)
    drawing.wait_for()
    page.get_by_text(RUN).first.wait_for()
    for _ in moments(page):
        if drawing.evaluate(COLOURS) >= colours:
            return drawing
    raise AssertionError(f"{figure}: nothing was painted")


def await_built(page):
    """Wait until the page takes what a mouse does, and what follows the first portrait is there; the tabs are last."""
    page.locator("#loader").wait_for(state="hidden")
    page.get_by_role("tab").last.wait_for()


def picture(drawing):
    return drawing.evaluate("canvas => canvas.toDataURL()")


def settled_picture(page, drawing):
    """Wait until a picture stays as it is for a moment: its legend may come after its lines."""
    before, since = picture(drawing), 0
    for _ in moments(page):
        now = picture(drawing)
        before, since = now, since + 1 if now == before else 0
        if since == 12:
            return now
    raise AssertionError("the picture never came to rest")


def await_other_picture(page, drawing, before):
    for _ in moments(page):
        if picture(drawing) != before:
            return
    raise AssertionError("the picture did not change")


def await_ground(page, drawing, is_wanted):
    """Wait until most of a figure has a colour that is wanted; its lines and legend may come later."""
    for _ in moments(page):
        ground = drawing.evaluate(GROUND)
        if is_wanted(ground):
            return ground
    raise AssertionError(f"most of the figure has the colour {ground:#010x}")


def field(page, label):
    """The text entry of a name, and not its slider, which is called after it."""
    return page.get_by_role("textbox", name=label)


def type_into(page, label, text):
    entry = field(page, label)
    entry.fill(text)
    entry.press("Enter")
