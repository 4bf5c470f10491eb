"""The colours of the figures, on light and on dark ground, and of the regions."""

from __future__ import annotations

from typing import Any

# Of light ground. Each has 3:1 or more on every shade of a figure, and 4.5:1 on the page itself, so that none is pale;
# any two differ in the common kinds of colour blindness, too.
BLUE = "#0064A6"
VERMILION = "#A23400"
GREEN = "#00885A"
ORANGE = "#B26800"
SKY = "#69769F"
CALM = "#C3D0EE"  # of areas that recede: lighter than every other colour, in print too
MILD = "#98C29E"  # of areas that recede, but not as far
PURPLE = "#994F71"
VIOLET = "#9006F0"
OCHRE = "#837738"
BROWN = "#6D512D"
BERRY = "#752355"
AMBER = "#7F5300"  # of marks alone
LAKE = "#2B7CA8"  # of level sets, with sand
SAND = "#776B52"
GREY = "#4A4A4A"
PALE_GREY = "#767676"
GROUND = "#FEFEFE"  # behind names among curves: a white that is another one in the dark

RULE = "#7A7A7A"
"""Grey of what Bokeh draws beside the glyphs, which keeps its colour: as far from light as from dark ground."""

ON_DARK = {
    BLUE: "#2D81C7", VERMILION: "#D55E01", GREEN: "#19A87B", ORANGE: "#E9A005", SKY: "#65BEF3", PURPLE: "#E18DBC",
    VIOLET: "#BD31FF", OCHRE: "#BDA55D", BROWN: "#947947", BERRY: "#B7608F", AMBER: "#C98A10", LAKE: "#5DB3E6",
    SAND: "#B5A88F", CALM: "#34507A", MILD: "#4A7553", GREY: "#A8A8A8", PALE_GREY: "#CFCFCF", GROUND: "#121212",
}  # fmt: skip
"""The same on dark ground, where the browser paints these in their place (see `widgets.browser`)."""

SHADES = {-1: "#56B4E9", 1: "#D9B84A", 2: "#D55E00", 3: "#9000F0", 0: "#009E73"}
"""Colour of each shade of ground, painted transparently, on light and on dark."""

SIDES = {-1: LAKE, 1: SAND}
"""Colour of lines on each side of the surface; of several, in the first two shades of regions."""

OCCUPIED = {
    shade: (name, SHADES[shade]) for shade, name in {-1: "g < 0", 1: "g > 0", 2: "", 3: "", 0: "sliding"}.items()
}
"""Name, of one surface, and colour of where a run is, by its shade: on a side, in a further region, or sliding."""

SURFACE: dict[str, Any] = {"line_color": PURPLE, "line_cap": "square"}
"""Look of the lines of surfaces; pictures know these by their ends."""

TINT = 0.13
"""Opacity of the first shade in the portrait, beneath arrows and level sets."""

OPACITY = {-1: 0.19, 1: 0.14, 2: 0.2, 3: 0.14, 0: 0.19}
"""Opacity of each shade behind curves against time."""

PRINTED_OPACITY = {SHADES[shade]: opacity for shade, opacity in {-1: 0.24, 1: 0.1, 2: 0.26, 3: 0.28, 0: 0.48}.items()}
"""Opacity in print of each colour of `SHADES`, in every figure: light, and without colours, too, they differ."""


def on_either_ground(colour: str) -> str:
    """Return the CSS of a colour, which is that of `ON_DARK` on a dark page."""
    return f"light-dark({colour}, {ON_DARK[colour]})"
