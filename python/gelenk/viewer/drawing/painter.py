# SPDX-License-Identifier: BSD-3-Clause
"""Paints frames: the light, the ground, the mechanism, its trails and the time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.extras import extra
from gelenk.viewer.drawing.camera import FOLLOWING_MARGIN, Camera
from gelenk.viewer.drawing.colors import DARK_THEME, LIGHT, Color, color_of
from gelenk.viewer.drawing.model import Model
from gelenk.viewer.drawing.options import PictureOptions
from gelenk.viewer.drawing.raster import Line, Raster

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

type Array = NDArray[np.float64]

OVERSAMPLING = 3  # pixels of the raster for each of the picture, in both directions
# Light falls from the sky and from over the viewer's shoulder, as on the page.
SKY, SOIL = 0.62, 0.62 * 0.56
LAMP, LAMP_POSITION = 0.5, (-0.5, 0.8, 2.0)  # to the right, upwards, towards the viewer
GRID_REACH, GRID_LINES = 3.0, 24  # in sizes of the mechanism; of the whole grid
GRID_WIDTH, GRID_OPACITY, TRAIL_WIDTH = 1.0, 0.7, 1.4  # pixels, 1, pixels
TRANSLUCENT = 0.35  # opacity of a second run
TEXT_HEIGHT = 1 / 24  # of the picture


class Painter:
    """Paints frames of a run."""

    def __init__(self, data: Mapping[str, Any], options: PictureOptions) -> None:
        """Prepare pictures of `gelenk.viewer.data.page_data`. Raises UsageError."""
        extra("PIL", "pictures are drawn with Pillow")
        self._options = options
        self._theme = DARK_THEME if options.dark else LIGHT
        self.model = Model(data, color_of(self._theme.background))
        self._caption = data.get("caption", "")
        self._second = self._second_model(data)
        width, height = options.size
        size = (OVERSAMPLING * width, OVERSAMPLING * height)
        self.camera = Camera(data["up"], data["towards"], flat=data["flat"], size=size)
        self.camera.set_view(options.camera)
        self._follows = self.model.travels
        start = self.model.poses(self.model.time[0])
        if self._follows:
            self.camera.fit(self.model.reached_at(start), FOLLOWING_MARGIN)
        else:
            clouds = [self.model.cloud] + ([self._second.cloud] if self._second else [])
            self.camera.fit(np.vstack(clouds))
        self._offset = self.camera.target - start[:, :3].mean(axis=0)
        self._backdrop: NDArray[np.uint8] | None = None
        # As many digits as distinguish the frames of the run.
        frame = np.ptp(self.model.time) / max(1, len(self.model.time) - 1)
        self._digits = 2 if not frame else int(np.clip(np.ceil(-np.log10(frame) - 1e-9), 2, 9))
        self._trails = self.model.trails() if options.trails else []

    def frame(self, time: float) -> Picture:
        """Return the picture at a time [s]."""
        from PIL import Image

        poses = self.model.poses(time)
        if self._follows:
            self.camera.target = poses[:, :3].mean(axis=0) + self._offset
            self._backdrop = None
        if self._backdrop is None:
            self._backdrop = self._ground()
        raster = Raster(self._backdrop)
        self._draw(raster, time)
        shape = (self.camera.height, self.camera.width, 3)
        image = Image.fromarray(raster.colors.reshape(shape)).reduce(OVERSAMPLING)
        if self._caption:
            self._write(image, self._caption)
        elif self._options.time_stamp:
            self._write(image, f"t = {time:.{self._digits}f} s")
        return image

    def _second_model(self, data: Mapping[str, Any]) -> Model | None:
        if "second" not in data:
            return None
        return Model({**data["second"], "time": data["time"]}, color_of(self._theme.background))

    def _draw(self, raster: Raster, time: float) -> None:
        self._draw_solids(raster, self.model, time)
        trails = [Line(self.camera.project(path), color) for path, color in self._trails]
        raster.draw_lines(trails, TRAIL_WIDTH * OVERSAMPLING)
        if self._second:
            self._draw_solids(raster, self._second, time, TRANSLUCENT)

    def _draw_solids(self, raster: Raster, model: Model, time: float, alpha: float = 1.0) -> None:
        points, normals, triangles, colors = model.solids(model.poses(time))
        corners = self.camera.project(points)[triangles]
        (ax, ay), (bx, by) = ((corners[:, k, :2] - corners[:, 0, :2]).T for k in (1, 2))
        facing = ax * by - ay * bx < 0  # y is downwards in the picture
        raster.draw(corners[facing], self._light(normals)[triangles[facing]], colors[facing], alpha)

    def _light(self, normals: Array) -> Array:
        """Return the light that surfaces with these normals reflect."""
        lamp = np.array(LAMP_POSITION) / np.linalg.norm(LAMP_POSITION) @ self.camera.axes
        sky = SOIL + (SKY - SOIL) * (1 + normals @ self.camera.up) / 2
        out: Array = sky + LAMP * np.maximum(normals @ lamp, 0)
        return out

    def _ground(self) -> NDArray[np.uint8]:
        """Return the background with a grid below everything that the mechanism reaches."""
        camera = self.camera
        background = (255 * color_of(self._theme.background)).round().astype(np.uint8)
        colors = np.tile(background, (camera.height, camera.width, 1))
        if camera.flat or camera.axes[2] @ camera.up < 0:
            return colors
        raster = Raster(colors)
        grid = color_of(self._theme.grid)
        lines = [
            Line(camera.project(path), grid, GRID_OPACITY * fading) for path, fading in self._grid_lines()
        ]
        raster.draw_lines(lines, GRID_WIDTH * OVERSAMPLING)
        return raster.colors.reshape(colors.shape)

    def _grid_lines(self) -> list[tuple[Array, Array]]:
        """Return the lines of the grid, with the opacity of their segments, which fades with the distance."""
        camera, model = self.camera, self.model
        step = round_step(2 * GRID_REACH * model.radius, GRID_LINES)
        count = int(np.ceil(GRID_REACH * model.radius / step))
        height = float((model.cloud @ camera.up).min()) - 0.01 * model.radius
        center = (model.cloud.min(axis=0) + model.cloud.max(axis=0)) / 2
        axes = np.array([camera.horizontal, camera.away])
        middle = np.round(axes @ center / step) * step @ axes + height * camera.up
        k = np.arange(-count, count + 1)
        lines = []
        for i in k:
            distance = np.hypot(i, np.minimum(np.abs(k[:-1]), np.abs(k[1:])))
            fading = np.maximum(0, 1 - distance / count)
            alphas = fading * np.minimum(1, 0.35 + fading)
            for along, across in (axes, axes[::-1]):
                lines.append((middle + step * (i * across + k[:, None] * along), alphas))
        return lines

    def _write(self, image: Picture, text: str) -> None:
        from PIL import ImageDraw, ImageFont

        draw = ImageDraw.Draw(image)
        height = max(11.0, TEXT_HEIGHT * image.height)
        width = 1.4 * height + draw.textlength(text, ImageFont.load_default(height))
        height *= min(1.0, image.width / width)  # otherwise it would be cut off at the edge
        font = ImageFont.load_default(height)
        color: Color = color_of(self._theme.text)
        place = (0.7 * height, image.height - 0.7 * height)
        draw.text(place, text, tuple((255 * color).astype(int)), font, anchor="ls")


def round_step(span: float, count: int) -> float:
    """Return 1, 2 or 5 times a power of ten, so that about `count` steps are a span."""
    rough = span / count
    power = 10.0 ** np.floor(np.log10(rough))
    digit = rough / power
    return float(power * (1 if digit < 1.5 else 2 if digit < 3.5 else 5 if digit < 7.5 else 10))
