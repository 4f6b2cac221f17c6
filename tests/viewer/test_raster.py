# SPDX-License-Identifier: BSD-3-Clause
"""Pixels of triangles, and what hides what."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import Array

from gelenk.viewer.drawing.raster import Line, Raster, fragments

WIDTH, HEIGHT = 40, 30
WHITE = np.ones(3)


def inside(corners: Array) -> set[int]:
    """Numbers of the pixels whose centers are on the same side of all three edges."""
    x, y = (a.ravel() + 0.5 for a in np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)))
    sides = []
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        sides.append((bx - ax) * (y - ay) - (by - ay) * (x - ax))
    signs = np.sign(sides)
    return {int(k) for k in np.flatnonzero(np.abs(signs.sum(axis=0)) == 3)}


@pytest.mark.parametrize("seed", range(30))
def test_pixels_are_those_with_their_centers_inside(seed: int) -> None:
    """Also of triangles that reach beyond the picture."""
    corners = np.random.default_rng(seed).uniform([-15, -15], [WIDTH + 15, HEIGHT + 15], (1, 3, 2))
    _, pixels = fragments(corners, WIDTH, HEIGHT)
    assert len(pixels) == len(set(pixels.tolist()))
    assert set(pixels.tolist()) == inside(corners[0])


@pytest.mark.parametrize("shift", [0.0, 0.5, 0.3])  # edges through centers of pixels, and beside them
def test_triangles_with_a_common_edge_share_no_pixel_and_leave_no_gap(shift: float) -> None:
    a, b, c, d = np.array([(5, 5), (25, 5), (25, 20), (5, 20)]) + shift
    triangle, pixels = fragments(np.array([[a, b, c], [a, c, d]]), WIDTH, HEIGHT)
    assert len(set(pixels.tolist())) == len(pixels) == 20 * 15
    assert set(triangle.tolist()) == {0, 1}


def test_triangles_without_area_or_outside_have_no_pixels() -> None:
    line = [(3.0, 3), (20, 20), (10, 10)]
    outside = [(-9.0, 3), (-1, 3), (-5, 20)]
    lost = [(np.nan, np.nan), (1, 1), (30, 1)]
    raster = Raster(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    corners = np.dstack([np.array([line, outside]), np.ones((2, 3))])
    raster.draw(corners, np.ones((2, 3)), np.ones((2, 3)))
    raster.draw_lines([Line(np.array([(*p, 1.0) for p in lost[:2]]), WHITE)], 2.0)
    assert not raster.colors.any()


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("together", [True, False])
def test_the_nearer_of_two_crossing_triangles_is_seen(order: tuple[int, int], together: bool) -> None:
    """Both cover the same pixels; one is nearer on the left, the other on the right of x = 20."""
    flat = [(0.0, 0.0), (40.0, 0.0), (20.0, 30.0)]
    falling = np.array([(x, y, 40 - x) for x, y in flat])
    rising = np.array([(x, y, x) for x, y in flat])
    corners = np.array([falling, rising])[[*order]]
    colors = np.array([(1.0, 0, 0), (0, 1.0, 0)])[[*order]]
    raster = Raster(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    for part in (slice(None),) if together else (slice(0, 1), slice(1, 2)):
        raster.draw(corners[part], np.ones((len(corners[part]), 3)), colors[part])
    row = raster.colors.reshape(HEIGHT, WIDTH, 3)[8]
    assert (row[6:20, 0] == 255).all()
    assert (row[20:34, 1] == 255).all()
    assert not row[6:20, 1].any()
    assert not row[20:34, 0].any()


def test_light_is_linear_between_the_corners_and_opacity_mixes() -> None:
    corners = np.array([[(0.0, 0, 1), (40, 0, 1), (0, 30, 1)]])
    raster = Raster(np.full((HEIGHT, WIDTH, 3), 100, np.uint8))
    raster.draw(corners, np.array([[0.0, 1, 0]]), WHITE[None], alpha=0.5)
    row = raster.colors.reshape(HEIGHT, WIDTH, 3)[0, :38, 0]
    expected = 0.5 * 255 * (np.arange(38) + 0.5) / 40 + 50
    assert row == pytest.approx(expected, abs=0.5 + 1e-9)  # rounded to integers


def test_a_line_has_its_width() -> None:
    raster = Raster(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    raster.draw_lines([Line(np.array([(5.0, 10, 1), (35, 10, 1)]), WHITE)], 4.0)
    seen = raster.colors.reshape(HEIGHT, WIDTH, 3)[:, :, 0] > 0
    assert seen.sum() == 30 * 4
    assert seen[8:12, 5:35].all()
