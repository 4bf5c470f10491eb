"""Pictures are saved as they are seen."""

import base64

import pytest
from bokeh.embed import file_html
from bokeh.models import Button, CustomJS
from bokeh.resources import INLINE

from pwsviz.export.pictures import png_callback
from pwsviz.figures.style import plain_figure

PIXELS = """async address => {
    const image = new Image()
    image.src = address
    await image.decode()
    const canvas = document.createElement("canvas")
    canvas.width = image.width
    canvas.height = image.height
    const pen = canvas.getContext("2d")
    pen.drawImage(image, 0, 0)
    return {width: image.width, corner: [...pen.getImageData(1, 1, 1, 1).data],
            shades: new Set(new Uint32Array(pen.getImageData(0, 0, image.width, image.height).data.buffer)).size}
}"""


@pytest.mark.browser
@pytest.mark.parametrize(("scale", "ground"), [(1, [250, 250, 250, 255]), (2, [17, 18, 19, 255])])
def test_a_picture_is_saved_at_the_resolution_of_the_device_on_the_ground_of_the_page(chromium, scale, ground):
    plot = plain_figure("A line", sizing_mode="fixed", width=400, height=300, border_fill_color=None)
    plot.line([0, 1, 2], [0, 1, 0])
    button = Button(label="PNG")
    button.js_on_click(CustomJS(args={"name": "pwsviz-line.png"}, code=png_callback(plot)))
    page_text = file_html([button, plot], INLINE)
    window = chromium.new_context(device_scale_factor=scale)
    page = window.new_page()
    page.set_content(page_text)
    page.add_style_tag(content=f"body {{ background: rgb({', '.join(map(str, ground[:3]))}) }}")
    page.wait_for_function("Bokeh.documents.length && Bokeh.documents[0].is_idle")
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG").click()
    assert download.value.suggested_filename == "pwsviz-line.png"
    saved = base64.b64encode(download.value.path().read_bytes()).decode()
    picture = page.evaluate(PIXELS, f"data:image/png;base64,{saved}")
    window.close()
    assert picture["width"] == 400 * scale
    assert picture["corner"] == ground
    assert picture["shades"] > 10
