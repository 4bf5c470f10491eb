"""Pictures of a figure as it is seen, made in the browser."""

from __future__ import annotations

from bokeh.plotting import figure

__all__ = ["png_callback"]

_SAVE_PICTURE = """
const view = Bokeh.index.find_one_by_id("ID")
if (view != null) {
  let ground = null
  for (let node = view.el; node != null && ground == null; node = node.parentElement ?? node.getRootNode().host) {
    const colour = getComputedStyle(node).backgroundColor
    if (!/^transparent$|, 0\\)$/.test(colour)) ground = colour
  }
  const {canvas} = view.export("png")
  const picture = document.createElement("canvas")
  picture.width = canvas.width
  picture.height = canvas.height
  const pen = picture.getContext("2d")
  pen.fillStyle = ground ?? "white"
  pen.fillRect(0, 0, picture.width, picture.height)
  pen.drawImage(canvas, 0, 0)
  picture.toBlob(blob => {
    const link = document.createElement("a")
    link.href = URL.createObjectURL(blob)
    link.download = name
    link.click()
    setTimeout(() => URL.revokeObjectURL(link.href), 60000)
  }, "image/png")
}
"""


def png_callback(plot: figure) -> str:
    """Return JavaScript that saves a figure as seen, at the resolution of the device, on the background of the page.

    It takes the name of the file from an argument ``name``, and is meant for `js_on_click` of a button:
    ``button.js_on_click(args={"name": "portrait.png"}, code=png_callback(plot))``.
    """
    return _SAVE_PICTURE.replace("ID", plot.id)
