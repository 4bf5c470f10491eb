"""Points are counted in the pixels in which numpy's histogram has them, and an image tells how many of which kind."""

import numpy as np
import pytest

from pwsviz.geometry.point_counts import LEVELS, PointCounts, Portion, extent_of
from pwsviz.geometry.window import Window

WINDOW = Window(-1.0, 2.0, 0.5, 1.5)
ROWS, COLUMNS, KINDS = 30, 40, 3


def drawn(seed, count):
    rng = np.random.default_rng(seed)
    kind = rng.integers(0, KINDS, count).astype(np.uint8)
    return Portion(rng.uniform(-1.5, 2.5, count), rng.uniform(0.0, 2.0, count), kind)


@pytest.mark.parametrize("sizes", [(5000,), (7, 5000), (1, 2, 3)])
def test_pixels_hold_what_the_histogram_of_numpy_holds(sizes):
    counted, inside = PointCounts(WINDOW, (ROWS, COLUMNS), KINDS), 0
    portions = [drawn(seed, size) for seed, size in enumerate(sizes)]
    portions += [Portion(*drawn(7, size)[:2], 2) for size in sizes]
    for portion in portions:
        inside += counted.add(portion)
    x, y = (np.concatenate(columns) for columns in list(zip(*portions, strict=True))[:2])
    kind = np.concatenate([np.broadcast_to(one.kind, one.x.shape) for one in portions])
    for k in range(KINDS):
        mine = kind == k
        wanted, _, _ = np.histogram2d(y[mine], x[mine], (ROWS, COLUMNS), (WINDOW[2:], WINDOW[:2]))
        assert np.array_equal(counted.counts[k], wanted)
    assert inside == counted.counts.sum()


def test_few_points_in_one_pixel_are_all_counted():
    counted = PointCounts(WINDOW, (ROWS, COLUMNS), KINDS)
    counted.add(Portion(np.full(5, 0.1), np.full(5, 0.6), 1))
    assert counted.counts.max() == counted.counts[1].sum() == 5


def test_points_on_the_border_are_inside_and_others_without_a_place_are_nowhere():
    counted = PointCounts(WINDOW, (ROWS, COLUMNS), 1)
    place = np.array([-1.0, 2.0, np.nan, 0.0, np.inf]), np.array([0.5, 1.5, 1.0, np.nan, 1.0])
    assert counted.add(Portion(*place, 0)) == 2
    assert counted.counts[0, 0, 0] == counted.counts[0, -1, -1] == 1
    assert extent_of([Portion(*place, 0), drawn(0, 0)]) == (-1.0, 2.0, 0.5, 1.5)
    assert extent_of([]) is None


def test_an_image_shows_the_kind_with_most_points_and_shades_by_their_number():
    counted = PointCounts(Window(0.0, 10.0, 0.0, 1.0), (1, 10), KINDS)
    columns = [0] * 1000 + [1] + [2, 2, 2] + [3] * 30 + [4] * 30
    kinds = [2] * 1000 + [1] + [0, 2, 2] + [1] * 30 + [0] * 30
    counted.add(Portion(np.array(columns) + 0.5, np.full(len(columns), 0.5), np.array(kinds, dtype=np.uint8)))
    code = counted.image()[0].astype(int)
    kind, shade = np.divmod(code[:5] - 1, LEVELS)
    assert kind.tolist() == [2, 1, 2, 1, 0]
    assert shade[1] == 0 < shade[2] < shade[3] == shade[4] < shade[0] == LEVELS - 1
    assert (code[5:] == 0).all()


def test_few_points_in_a_large_image_are_two_pixels_wide_and_hide_no_other():
    counted = PointCounts(Window(0.0, 100.0, 0.0, 100.0), (100, 100), 2)
    counted.add(Portion(np.array([10.5, 11.5]), np.array([20.5, 20.5]), np.array([0, 1], dtype=np.uint8)))
    image = counted.image()
    assert np.argwhere(image).tolist() == [[20, 10], [20, 11], [20, 12], [21, 10], [21, 11], [21, 12]]
    assert image[20, 10] <= LEVELS < image[20, 11]
