"""What the browser tests share: how a picture is awaited and a field is found."""

import re

COLOURS = """canvas => {
    const {width, height} = canvas
    const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, width, height).data.buffer)
    return new Set(pixels).size
}"""


def canvas(page, figure):
    return page.get_by_role("img", name=re.compile(figure)).locator("canvas").first


def await_painted(page, figure, colours=30):
    """Wait until a figure has lines on it, told by the many shades that smooth lines bring."""
    drawing = canvas(page, figure)
    drawing.wait_for()
    for _ in range(200):
        if drawing.evaluate(COLOURS) >= colours:
            return drawing
        page.wait_for_timeout(50)
    raise AssertionError(f"{figure}: nothing was painted")


def await_built(page):
    """Wait until the page takes what a mouse does: a sheet lies over it while it is built."""
    page.locator("#loader").wait_for(state="hidden")


def picture(drawing):
    return drawing.evaluate("canvas => canvas.toDataURL()")


def await_other_picture(page, drawing, before):
    for _ in range(200):
        if picture(drawing) != before:
            return
        page.wait_for_timeout(50)
    raise AssertionError("the picture did not change")


def field(page, label):
    """The text entry of a name, and not its slider, which is called after it."""
    return page.get_by_role("textbox", name=label)


def type_into(page, label, text):
    entry = field(page, label)
    entry.fill(text)
    entry.press("Enter")
