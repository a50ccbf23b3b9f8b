"""Rectangles of pixels, and the 16x16 screen tiles they meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.render.errors import SceneError

TILE_PX = 16
"""Side of a screen tile in pixels (Kerbl et al. 2023, reference implementation)."""


@dataclass(frozen=True, slots=True)
class Crop:
    """A rectangle of an image: first column `x0`, first row `y0`, size in pixels."""

    x0: int
    y0: int
    width: int
    height: int

    def __str__(self) -> str:
        return f"{self.width}x{self.height} at ({self.x0}, {self.y0})"

    @property
    def pixels(self) -> int:
        """Number of pixels."""
        return self.width * self.height

    def rows_and_columns_in(self, outer: Crop) -> tuple[slice, slice]:
        """Return where this crop lies in an array [outer.height, outer.width, ...]."""
        top, left = self.y0 - outer.y0, self.x0 - outer.x0
        return slice(top, top + self.height), slice(left, left + self.width)


def check_inside(crop: Crop, width: int, height: int) -> None:
    """Raise `SceneError` unless `crop` is a non-empty part of a `width` x `height` image."""
    fits_columns = crop.x0 >= 0 and crop.x0 + crop.width <= width
    fits_rows = crop.y0 >= 0 and crop.y0 + crop.height <= height
    if crop.width < 1 or crop.height < 1 or not fits_columns or not fits_rows:
        raise SceneError(
            f"the crop {crop} is not a part of the {width}x{height} image",
            hint="a crop is x0, y0, width, height in pixels, row 0 on top",
        )


def tiles_meeting(crop: Crop) -> Iterator[tuple[int, int, Crop]]:
    """Yield tile column, tile row and the common part of every tile that meets `crop`, by rows."""
    right, bottom = crop.x0 + crop.width, crop.y0 + crop.height
    for tile_y in range(crop.y0 // TILE_PX, -(-bottom // TILE_PX)):
        for tile_x in range(crop.x0 // TILE_PX, -(-right // TILE_PX)):
            x0, y0 = max(crop.x0, tile_x * TILE_PX), max(crop.y0, tile_y * TILE_PX)
            x1 = min(right, (tile_x + 1) * TILE_PX)
            y1 = min(bottom, (tile_y + 1) * TILE_PX)
            yield tile_x, tile_y, Crop(x0, y0, x1 - x0, y1 - y0)
