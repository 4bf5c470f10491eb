"""A cloud is drawn as marks while few points are in sight, and as an image of their numbers when many are."""

import numpy as np
import pytest

from pwsviz.figures.point_cloud import FEW, LARGE_MARK, MARK, PointCloud, Portion
from pwsviz.figures.style import plain_figure
from pwsviz.geometry.point_counts import PointCounts
from pwsviz.geometry.window import Window


@pytest.fixture
def cloud():
    return PointCloud(plain_figure("points"), ("#0072B2", "#D55E00"))


def square(count, kind=0, seed=0):
    x, y = np.random.default_rng(seed).random((2, count))
    return Portion(x, y, kind)


def marks(cloud):
    """The coordinates of all marks, kind by kind."""
    data = [one.data_source.data for one in cloud.marks]
    return np.concatenate([np.column_stack([one["x"], one["y"]]) for one in data])


def looked_at(cloud, left, right, bottom, top, rows=100, columns=200):
    """Tell what a browser tells."""
    cloud._seen.data = {"value": [left, right, bottom, top, rows, columns, *cloud._followed()]}


def test_few_points_are_marks_of_their_colour_and_many_an_image(cloud):
    first, second = square(FEW - 1), square(1, 1, 5)
    cloud.show([first, second])
    assert np.array_equal(marks(cloud)[:, 0], [*first.x, *second.x])
    assert [len(one.data_source.data["x"]) for one in cloud.marks] == [FEW - 1, 1]
    assert [one.glyph.fill_color for one in cloud.marks] == ["#0072B2", "#D55E00"]
    assert len(cloud.image.data_source.data["image"]) == 0
    cloud.show([first, second, square(1, 1, 6)])
    (image,) = cloud.image.data_source.data["image"]
    assert image.any()
    assert len(marks(cloud)) == 0


def test_points_that_lie_in_few_places_have_large_marks(cloud):
    once = Portion(np.array([0.0, 1.0, 0.0] * 300), np.array([0.0, 1.0, 1.0] * 300), 0)
    cloud.show([once])
    assert {one.glyph.size for one in cloud.marks} == {LARGE_MARK}
    cloud.show([once, square(2000)])
    assert {one.glyph.size for one in cloud.marks} == {MARK}


def test_what_a_browser_told_before_it_had_the_points_paints_nothing(cloud):
    told = [0.0, 1.0, 0.0, 1.0, 100, 200, *cloud._followed()]  # of the figure without points
    x, y = np.random.default_rng(1).uniform(-2.0, 2.0, (2, 3 * FEW))
    cloud.show([Portion(x, y, 0)])
    before = cloud.image.data_source.data["image"][0]
    cloud._seen.data = {"value": told}
    data = cloud.image.data_source.data
    assert data["image"][0] is before
    assert data["x"][0] < x.min()
    assert data["x"][0] + data["dw"][0] > x.max()
    assert cloud.window is None


def test_what_a_browser_told_before_it_showed_all_points_again_paints_nothing(cloud):
    cloud.show([square(100_000)])
    told = [0.2, 0.3, 0.1, 0.2, 100, 200, *cloud._followed()]
    cloud.fit()
    cloud._seen.data = {"value": told}
    assert cloud.window is None


def test_further_points_are_counted_without_counting_those_before_anew(cloud, monkeypatch):
    counted = []
    add = PointCounts.add
    monkeypatch.setattr(PointCounts, "add", lambda self, one: counted.append(len(one.x)) or add(self, one))
    corners = Portion(np.array([0.0, 1.0]), np.array([0.0, 1.0]), 0)
    first, second = square(5000), square(6000, seed=1)
    cloud.show([corners, first])
    cloud.show([corners, first, second])
    assert counted == [2, 5000, 6000]
    whole = PointCloud(plain_figure("points"), cloud.colours)
    whole.show([corners, first, second])
    pictures = [one.image.data_source.data["image"][0] for one in (cloud, whole)]
    assert np.array_equal(*pictures)
    assert cloud.count == 11_002


def test_other_points_take_the_place_of_those_before(cloud):
    cloud.show([square(10)])
    cloud.show([square(7, seed=2)])
    assert len(marks(cloud)) == 7
    cloud.show([])
    assert len(marks(cloud)) == 0


def test_a_zoom_brings_an_image_of_the_window_in_the_pixels_of_the_browser_and_marks_where_few_are_left(cloud):
    seen = []
    cloud._on_window = seen.append
    points = square(100_000)
    cloud.show([points])
    looked_at(cloud, 0.2, 0.7, 0.1, 0.9)
    data = cloud.image.data_source.data
    assert data["image"][0].shape == (100, 200)
    assert [data[name][0] for name in ("x", "y", "dw", "dh")] == pytest.approx([0.2, 0.1, 0.5, 0.8])
    looked_at(cloud, 0.2, 0.3, 0.1, 0.2)
    inside = (points.x >= 0.2) & (points.x <= 0.3) & (points.y >= 0.1) & (points.y <= 0.2)
    assert sorted(marks(cloud)[:, 0]) == sorted(points.x[inside])
    assert seen == [Window(0.2, 0.7, 0.1, 0.9), Window(0.2, 0.3, 0.1, 0.2)]


@pytest.mark.parametrize("told", [(0.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, np.nan), (0.0, 1.0, 0.0, 1.0, 10**6, 10**6)])
def test_what_no_browser_shows_is_passed_over(cloud, told):
    cloud.show([square(5000)])
    before = cloud.image.data_source.data["image"][0]
    looked_at(cloud, *told)
    assert cloud.image.data_source.data["image"][0] is before


def test_the_ranges_follow_the_points_with_some_room(cloud):
    cloud.show([Portion(np.array([2.0, 4.0]), np.array([-1.0, 0.0]), 0)])
    (left, right), (bottom, top) = cloud.corners.data["x"], cloud.corners.data["y"]
    assert 1.8 < left < 2.0 < 4.0 < right < 4.2
    assert -1.1 < bottom < -1.0 < 0.0 < top < 0.1
    cloud.show([Portion(np.array([7.0]), np.array([3.0]), 0)])
    (left, right), (bottom, top) = cloud.corners.data["x"], cloud.corners.data["y"]
    assert left < 7.0 < right
    assert bottom < 3.0 < top


def test_round_off_is_drawn_on_a_line(cloud):
    x = 1e-17 * np.arange(10.0)
    cloud.show([Portion(x, np.arange(10.0), 0)], 1e-15)
    left, right = cloud.corners.data["x"]
    assert left < -0.01 < 0.01 < right
    cloud.show([Portion(x, np.arange(10.0), 0)], 0.0)
    assert cloud.corners.data["x"][1] < 1e-15


def test_a_picture_for_print_has_finer_pixels_until_the_next_look(cloud):
    cloud.show([square(100_000)])
    looked_at(cloud, 0.2, 0.7, 0.1, 0.9)
    cloud.sharpen()
    assert cloud.image.data_source.data["image"][0].shape == (400, 800)
    looked_at(cloud, 0.2, 0.8, 0.1, 0.9)
    assert cloud.image.data_source.data["image"][0].shape == (100, 200)
