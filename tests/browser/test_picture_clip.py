"""Curves cut to a rectangle: all of them within it, and nothing else."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import pwsviz.export

pytestmark = pytest.mark.browser

CODE = Path(pwsviz.export.__file__).with_name("picture_clip.js").read_text()
BOX = {"left": -1.0, "right": 2.0, "top": -0.5, "bottom": 1.5}


@pytest.fixture(scope="module")
def cut(chromium):
    """The function of the module in a page of its own."""
    page = chromium.new_page()
    body = "\n".join(line.removeprefix("export ") for line in CODE.splitlines() if not line.startswith("import "))
    # What is not a number arrives as null, and so does it leave.
    page.evaluate(f"""() => {{ {body}
        window.cut = (path, box) => cut(path.map(place => place.map(one => one ?? NaN)), box)
            .map(place => Number.isNaN(place[0]) ? null : place) }}""")
    yield lambda path: page.evaluate(
        "([path, box]) => window.cut(path, box)",
        [[[x if np.isfinite(x) else None for x in place] for place in path.tolist()], BOX],
    )
    page.close()


def samples(pieces):
    """Points along polylines, so close to one another that none is farther than 0.01 from a point of its line."""
    found = [np.empty((0, 2))]
    for piece in pieces:
        for start, end in pairwise(piece):
            count = 2 + int(np.hypot(*(end - start)) / 0.01)
            found.append(start + np.linspace(0, 1, count)[:, None] * (end - start))
    return np.concatenate(found)


def pieces_of(path):
    """The parts of a polyline between places that are no numbers."""
    there, pieces = np.isfinite(path).all(axis=1), [[]]
    for place, holds in zip(path, there, strict=True):
        if holds:
            pieces[-1].append(place)
        else:
            pieces.append([])
    return [np.array(piece) for piece in pieces if len(piece) > 1]


def far_from(points, others):
    """The largest distance of points from the nearest of others."""
    if not len(points):
        return 0.0
    return max(np.hypot(*(others - point).T).min(initial=np.inf) for point in points)


def test_a_cut_curve_is_what_of_it_lies_within(cut, draws):
    """Against samples of the whole curve: of any size, with gaps, through corners and along edges."""
    for rng in draws(60):
        path = rng.normal(0, 10.0 ** rng.uniform(-1, 1), (int(rng.integers(2, 9)), 2))
        for k in range(1, len(path)):  # some pieces are parallel to an axis
            axis = int(rng.integers(2))
            path[k, axis] = path[k - 1, axis] if rng.random() < 0.3 else path[k, axis]
        path[rng.random(len(path)) < 0.15] = np.nan
        path[rng.random(len(path)) < 0.15] = (BOX["right"], BOX["bottom"])
        path[rng.random(len(path)) < 0.15, 0] = BOX["left"]
        got = np.array([[np.nan, np.nan] if place is None else place for place in cut(path)]).reshape(-1, 2)
        whole, kept = samples(pieces_of(path)), samples(pieces_of(got))
        low, high = np.array([BOX["left"], BOX["top"]]), np.array([BOX["right"], BOX["bottom"]])
        assert ((kept >= low - 1e-9) & (kept <= high + 1e-9)).all()
        inside = whole[((whole > low + 0.02) & (whole < high - 0.02)).all(axis=1)]
        assert far_from(inside, kept) < 0.02
        assert far_from(kept, whole) < 0.02
