"""Rectangles and the screen tiles they meet."""

from __future__ import annotations

import pytest

from vividc.render import Crop, SceneError
from vividc.render.crop import check_inside, tiles_meeting


def test_tiles_meeting_a_crop_across_tile_edges() -> None:
    assert list(tiles_meeting(Crop(14, 30, 4, 3))) == [
        (0, 1, Crop(14, 30, 2, 2)),
        (1, 1, Crop(16, 30, 2, 2)),
        (0, 2, Crop(14, 32, 2, 1)),
        (1, 2, Crop(16, 32, 2, 1)),
    ]


def test_a_whole_tile_meets_itself_only() -> None:
    assert list(tiles_meeting(Crop(16, 32, 16, 16))) == [(1, 2, Crop(16, 32, 16, 16))]


@pytest.mark.parametrize(
    "crop",
    [Crop(-1, 0, 4, 4), Crop(0, 0, 0, 4), Crop(0, 0, 4, -1), Crop(5, 0, 4, 4), Crop(0, 7, 4, 2)],
)
def test_crops_outside_the_image(crop: Crop) -> None:
    with pytest.raises(SceneError, match="not a part of the 8x8 image"):
        check_inside(crop, 8, 8)
